//! A straight plate of one strip in prescribed heave and pitch, for all comparisons with plane theory.

use foldwing::aero::AirLoads;
use foldwing::aero::flow::{Flow, Gust};
use foldwing::aero::strip::{StripOptions, StripState, Strips};
use foldwing::aero::surface::{ChordLine, Profile, Surface};
use foldwing::load::{SectionMotion, Wrench};
use nalgebra::{Rotation3, Vector3};

/// Span in m, different from 1 so that values per span and per strip cannot be confused.
const SPAN_M: f64 = 3.0;

/// Plate with its leading edge towards +y in a wind along −y; lift is along +z, nose-up is a rotation about +x.
#[derive(Debug, Clone)]
pub struct Plate {
    pub semi_chord_m: f64,
    /// Axis of pitch in semi-chords behind half chord.
    pub axis: f64,
    pub speed_m_s: f64,
    pub density_kg_m3: f64,
    pub profile: Profile,
    pub options: StripOptions,
}

impl Default for Plate {
    fn default() -> Self {
        Self {
            semi_chord_m: 0.7,
            axis: 0.0,
            speed_m_s: 13.0,
            density_kg_m3: 1.2,
            profile: Profile::THIN,
            options: StripOptions::default(),
        }
    }
}

/// Heave (positive down, m), pitch (nose-up, rad) and their rates.
#[derive(Debug, Clone, Copy, Default)]
pub struct Motion {
    pub heave_m: f64,
    pub heave_m_s: f64,
    pub pitch_rad: f64,
    pub pitch_rad_s: f64,
}

/// Force and nose-up moment about the axis, per span.
#[derive(Debug, Clone, Copy, Default)]
pub struct Loads {
    pub lift_n_m: f64,
    /// Forward force, into the wind.
    pub thrust_n_m: f64,
    pub moment_n: f64,
}

impl Plate {
    pub fn surface(&self) -> Surface {
        let b = self.semi_chord_m;
        let chord = ChordLine {
            leading_m: Vector3::y() * b * (1.0 + self.axis),
            trailing_m: -Vector3::y() * b * (1.0 - self.axis),
        };
        Surface { sections: 0..2, chords: vec![chord; 2], chord_panels: 1, profile: self.profile.clone() }
    }

    pub fn sections(motion: Motion) -> [SectionMotion; 2] {
        [0.0, SPAN_M].map(|x| SectionMotion {
            rotation: Rotation3::from_axis_angle(&Vector3::x_axis(), motion.pitch_rad).into_inner(),
            position_m: Vector3::new(x, 0.0, -motion.heave_m),
            velocity_m_s: Vector3::new(0.0, 0.0, -motion.heave_m_s),
            spin_rad_s: Vector3::x() * motion.pitch_rad_s,
        })
    }

    pub fn flow<'a>(&self, time_s: f64, gusts: &'a [Gust]) -> Flow<'a> {
        Flow {
            time_s,
            density_kg_m3: self.density_kg_m3,
            wind_m_s: -Vector3::y() * self.speed_m_s,
            spin_rad_s: Vector3::zeros(),
            gusts,
        }
    }

    /// Time in which the plate travels a semi-chord, s.
    pub fn semi_chord_s(&self) -> f64 {
        self.semi_chord_m / self.speed_m_s
    }

    /// Circulatory and impulsive loads per span.
    pub fn per_span(loads: &AirLoads) -> [Loads; 2] {
        [per_span(&loads.circulatory), per_span(&loads.impulsive)]
    }

    /// Circulatory and impulsive loads at the start and after each of `steps` steps (impulsive loads are means over the step that ends
    /// there).
    pub fn march(
        &self,
        motion: impl Fn(f64) -> Motion,
        gusts: &[Gust],
        established: bool,
        step_s: f64,
        steps: usize,
    ) -> Vec<[Loads; 2]> {
        let mut strips = Strips::new(vec![self.surface()], self.options);
        let (mut from, mut to): (StripState, StripState) = (strips.blank_state(), strips.blank_state());
        let mut loads = AirLoads::still(2);
        strips.start(&Self::sections(motion(0.0)), &self.flow(0.0, gusts), established, &mut from, &mut loads);
        let mut history = vec![Self::per_span(&loads)];
        for step in 1..=steps {
            let time_s = step as f64 * step_s;
            let (sections, flow) = (Self::sections(motion(time_s)), self.flow(time_s, gusts));
            strips.convect(&from, &flow, step_s, &mut to);
            strips.solve(&from, &sections, &flow, step_s, &mut to, &mut loads);
            from.copy_from(&to);
            history.push(Self::per_span(&loads));
        }
        history
    }
}

fn per_span(wrenches: &[Wrench]) -> Loads {
    // sections are perpendicular to the axis, so their moments about x add up
    let force_n: Vector3<f64> = wrenches.iter().map(|wrench| wrench.force_n).sum();
    let moment_n_m: f64 = wrenches.iter().map(|wrench| wrench.moment_n_m.x).sum();
    Loads { lift_n_m: force_n.z / SPAN_M, thrust_n_m: force_n.y / SPAN_M, moment_n: moment_n_m / SPAN_M }
}
