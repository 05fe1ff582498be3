//! Type of the single degree of freedom of a joint: rotation or translation. All differences between revolute and prismatic joints in
//! words, units and names are in this file; the numerics are the same for both.

use crate::force::spring::Spring;
use crate::machine::{Motor, UNLIMITED};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

/// Type of the coordinate of a joint with one degree of freedom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Travel {
    /// An angle in rad about the axis; the generalised forces are torques in N·m.
    Rotation,
    /// A displacement in m along the axis; the generalised forces are forces in N.
    Translation,
}

/// Words for a rotation and their replacements for a prismatic joint, applied in order: a word that contains another comes before it.
const WORDS: &[(&str, &str)] = &[
    // fields and keys
    ("start_angle_rad", "start_position_m"),
    ("start_angle_deg", "start_position_m"),
    ("rest_angle_rad", "rest_position_m"),
    ("rest_angle_deg", "rest_position_m"),
    ("latch_angle_deg", "latch_position_m"),
    ("angle_rad", "position_m"),
    ("start_rate_rad_s", "start_rate_m_s"),
    ("rate_limit_rad_s", "rate_limit_m_s"),
    ("stiffness_n_m_rad", "stiffness_n_m"),
    ("damping_n_m_s_rad", "damping_n_s_m"),
    ("torque_limit_n_m", "force_limit_n"),
    ("torque_constant_n_m_a", "force_constant_n_a"),
    ("inertia_kg_m2", "mass_kg"),
    ("command_rad", "command_m"),
    ("slip_rad_s", "slip_m_s"),
    ("to_rad", "to_m"),
    ("rate_rad_s", "rate_m_s"),
    ("capture_rad", "capture_m"),
    ("capture_deg", "capture_m"),
    ("lower_rad", "lower_m"),
    ("lower_deg", "lower_m"),
    ("upper_rad", "upper_m"),
    ("upper_deg", "upper_m"),
    ("torque_n_m", "force_n"),
    ("torque_N_m", "force_N"),
    // units
    ("N·m·s/rad", "N·s/m"),
    ("N.m.s/rad", "N.s/m"),
    ("N·m/rad", "N/m"),
    ("N.m/rad", "N/m"),
    ("N·m", "N"),
    ("N.m", "N"),
    ("rad/s", "m/s"),
    ("[time in s, angle in rad]", "[time in s, position in m]"),
    ("coefficients in rad and s", "coefficients in m and s"),
    // phrases
    (", by the right-hand rule about the hinge axis", " along the joint's axis"),
    ("about the hinge axis", "along the joint's axis"),
    ("on the outer body", "on the joint's body"),
    ("fold angle", "position"),
    ("fold rate", "velocity"),
    ("smaller angles", "smaller positions"),
    ("angle", "position"),
    ("torque", "force"),
    ("joint may turn", "joint may slide"),
    ("revolute", "prismatic"),
];

impl Travel {
    /// Name of the joint type in files and messages.
    pub fn joint_type(self) -> &'static str {
        match self {
            Self::Rotation => "revolute",
            Self::Translation => "prismatic",
        }
    }

    /// Name of the coordinate: `angle` or `position`.
    pub fn coordinate(self) -> &'static str {
        match self {
            Self::Rotation => "angle",
            Self::Translation => "position",
        }
    }

    /// Units of the coordinate and its rate.
    pub fn units(self) -> [&'static str; 2] {
        match self {
            Self::Rotation => ["rad", "rad/s"],
            Self::Translation => ["m", "m/s"],
        }
    }

    /// Unit of the generalised force.
    pub fn effort_unit(self) -> &'static str {
        match self {
            Self::Rotation => "N.m",
            Self::Translation => "N",
        }
    }

    /// The coordinate in the unit of messages: in degrees, or in m.
    pub fn shown(self, coordinate: f64) -> f64 {
        match self {
            Self::Rotation => coordinate.to_degrees(),
            Self::Translation => coordinate,
        }
    }

    /// Unit of [`Self::shown`].
    pub fn shown_unit(self) -> &'static str {
        match self {
            Self::Rotation => "deg",
            Self::Translation => "m",
        }
    }

    /// Name, value and unit of the coordinate for messages: `angle 3.000 deg`, `position 0.100000 m`.
    pub fn told(self, coordinate: f64) -> String {
        let digits = if self == Self::Rotation { 3 } else { 6 };
        format!("{} {:.digits$} {}", self.coordinate(), self.shown(coordinate), self.shown_unit())
    }

    /// Velocity in m/s and angular velocity in rad/s of the body for a rate of the coordinate, in the frame of its parent.
    pub fn moving(self, axis: &Vector3<f64>, rate: f64) -> [Vector3<f64>; 2] {
        match self {
            Self::Rotation => [Vector3::zeros(), axis * rate],
            Self::Translation => [axis * rate, Vector3::zeros()],
        }
    }

    /// A name or a sentence about a revolute joint, in the terms of this joint type.
    pub fn words(self, of_rotation: &str) -> String {
        match self {
            Self::Rotation => of_rotation.to_owned(),
            Self::Translation => {
                WORDS.iter().fold(of_rotation.to_owned(), |text, (turns, slides)| text.replace(turns, slides))
            }
        }
    }

    /// Declared real type of a variable whose type is `of_rotation` for a revolute joint.
    pub fn declared(self, of_rotation: &'static str) -> &'static str {
        match (self, of_rotation) {
            (Self::Rotation, _) => of_rotation,
            (Self::Translation, "Angle") => "Position",
            (Self::Translation, "AngularVelocity") => "Velocity",
            (Self::Translation, "Moment") => "Force",
            (Self::Translation, "AngularImpulse") => "Impulse",
            (Self::Translation, "RotationalStiffness") => "TranslationalStiffness",
            (Self::Translation, "RotationalDamping") => "TranslationalDamping",
            (Self::Translation, _) => of_rotation,
        }
    }

    /// Displacement in m and rotation of the body due to the joint, in the frame of its parent.
    pub fn moved(self, axis: &Vector3<f64>, coordinate: f64) -> (Vector3<f64>, Matrix3<f64>) {
        match self {
            Self::Rotation => {
                let turn = Rotation3::from_axis_angle(&Unit::new_normalize(*axis), coordinate);
                (Vector3::zeros(), turn.into_inner())
            }
            Self::Translation => (axis * coordinate, Matrix3::identity()),
        }
    }
}

/// Motor of a prismatic joint, corresponding to [`Motor`]: force on the joint's body along the axis.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearMotor {
    /// Spring stiffness `k` in N/m.
    pub stiffness_n_m: f64,
    /// Damping `c` in N·s/m.
    pub damping_n_s_m: f64,
    /// Constant force in N, in the direction of smaller positions.
    pub constant_force_n: f64,
    /// Largest magnitude of the motor's force in N; [`UNLIMITED`] without a limit.
    pub force_limit_n: f64,
    /// Largest slew rate of the neutral position in m/s; [`UNLIMITED`] without a limit.
    pub rate_limit_m_s: f64,
    /// Mass that moves with the position only, in kg.
    pub mass_kg: f64,
    /// Start value of the command input in m.
    pub command_m: f64,
}

impl Default for LinearMotor {
    /// No motor: no force, no limits, no mass.
    fn default() -> Self {
        Self {
            stiffness_n_m: 0.0,
            damping_n_s_m: 0.0,
            constant_force_n: 0.0,
            force_limit_n: UNLIMITED,
            rate_limit_m_s: UNLIMITED,
            mass_kg: 0.0,
            command_m: 0.0,
        }
    }
}

impl From<LinearMotor> for Motor {
    fn from(motor: LinearMotor) -> Self {
        Self {
            stiffness_n_m_rad: motor.stiffness_n_m,
            damping_n_m_s_rad: motor.damping_n_s_m,
            constant_torque_n_m: motor.constant_force_n,
            torque_limit_n_m: motor.force_limit_n,
            rate_limit_rad_s: motor.rate_limit_m_s,
            inertia_kg_m2: motor.mass_kg,
            gear_ratio: None,
            command_rad: motor.command_m,
        }
    }
}

/// Spring and damper of a prismatic joint, corresponding to [`Spring`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LinearSpring {
    /// Stiffness in N/m.
    pub stiffness_n_m: f64,
    /// Damping in N·s/m.
    pub damping_n_s_m: f64,
    /// Position in m at which the spring force is zero.
    pub rest_position_m: f64,
}

impl From<LinearSpring> for Spring {
    fn from(spring: LinearSpring) -> Self {
        Self {
            stiffness_n_m_rad: spring.stiffness_n_m,
            damping_n_m_s_rad: spring.damping_n_s_m,
            rest_angle_rad: spring.rest_position_m,
        }
    }
}
