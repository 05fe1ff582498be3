//! An independent static rod: the spatial equilibrium equations, solved by shooting. Shares no code with the engine.
//!
//! `r' = (1+εx) R e_x`, `R' = R [κ]×`, `n' = −ρA g`, `m' = −r' × n`; `n`, `m`: of the outer part on the inner one.

use foldwing::beam::section::Section;
use nalgebra::{Matrix3, Matrix4, Matrix6, Vector3, Vector4, Vector6};

/// Force and moment at a position of a segment; dead in the root frame or following the section.
pub struct Load {
    pub position_m: f64,
    pub force_n: Vector3<f64>,
    pub moment_n_m: Vector3<f64>,
    pub follower: bool,
}

/// Spring hinge about `y` at the inner end of a segment; its moment is `stiffness·θ + constant`.
#[derive(Clone, Copy)]
pub struct Joint {
    pub stiffness_n_m_rad: f64,
    pub constant_n_m: f64,
}

/// A piece of the rod with its loads in ascending order of position.
pub struct Segment {
    pub length_m: f64,
    pub joint: Option<Joint>,
    pub loads: Vec<Load>,
}

/// A chain of segments of one section, clamped at the origin along `x`.
pub struct Rod {
    pub segments: Vec<Segment>,
    pub stiffness: Matrix4<f64>,
    pub mass_kg_m: f64,
    pub gravity_m_s2: Vector3<f64>,
}

/// Equilibrium.
#[derive(Default)]
pub struct Solution {
    pub stations: Vec<Vector3<f64>>,
    pub angles_rad: Vec<f64>,
    pub root_force_n: Vector3<f64>,
    pub root_moment_n_m: Vector3<f64>,
    pub root_strain: [f64; 4],
}

#[derive(Clone, Copy)]
struct State {
    r: Vector3<f64>,
    frame: Matrix3<f64>,
    n: Vector3<f64>,
    m: Vector3<f64>,
}

/// Runge–Kutta steps between two loads.
const STEPS: usize = 40;

impl Rod {
    /// A rod without segments and gravity.
    pub fn of(section: &Section) -> Self {
        Self {
            segments: Vec::new(),
            stiffness: section.stiffness,
            mass_kg_m: section.mass_kg_m,
            gravity_m_s2: Vector3::zeros(),
        }
    }

    /// Newton's method for the six components of the root's wrench, in ten load steps.
    pub fn solve(&self) -> Solution {
        let mut root = Vector6::zeros();
        for share in 1..=10 {
            let share = f64::from(share) / 10.0;
            for _ in 0..30 {
                let miss = self.shoot(&root, share, None);
                let jacobian = Matrix6::from_columns(&std::array::from_fn::<_, 6, _>(|k| {
                    let mut moved = root;
                    moved[k] += 1e-6;
                    (self.shoot(&moved, share, None) - miss) / 1e-6
                }));
                let step = jacobian.lu().solve(&miss).expect("regular");
                root -= step;
                if step.norm() < 1e-11 {
                    break;
                }
            }
        }
        let mut solution = Solution::default();
        let miss = self.shoot(&root, 1.0, Some(&mut solution));
        assert!(miss.norm() < 1e-9, "shooting misses the free end by {:.1e}", miss.norm());
        solution.root_force_n = root.fixed_rows::<3>(0).into_owned();
        solution.root_moment_n_m = root.fixed_rows::<3>(3).into_owned();
        let strain = self.strain(&Matrix3::identity(), &solution.root_force_n, &solution.root_moment_n_m);
        solution.root_strain = strain.into();
        solution
    }

    fn strain(&self, frame: &Matrix3<f64>, n: &Vector3<f64>, m: &Vector3<f64>) -> Vector4<f64> {
        let (n, m) = (frame.transpose() * n, frame.transpose() * m);
        self.stiffness.lu().solve(&Vector4::new(n.x, m.x, m.y, m.z)).expect("regular")
    }

    fn slope(&self, state: &State, share: f64) -> State {
        let strain = self.strain(&state.frame, &state.n, &state.m);
        let tangent = state.frame.column(0) * (1.0 + strain[0]);
        State {
            r: tangent,
            frame: state.frame * Vector3::new(strain[1], strain[2], strain[3]).cross_matrix(),
            n: -self.gravity_m_s2 * (self.mass_kg_m * share),
            m: -tangent.cross(&state.n),
        }
    }

    /// Residual wrench at the free end.
    fn shoot(&self, root: &Vector6<f64>, share: f64, mut record: Option<&mut Solution>) -> Vector6<f64> {
        let mut state = State {
            r: Vector3::zeros(),
            frame: Matrix3::identity(),
            n: root.fixed_rows::<3>(0).into_owned(),
            m: root.fixed_rows::<3>(3).into_owned(),
        };
        for segment in &self.segments {
            if let Some(joint) = segment.joint {
                let about_y = state.m.dot(&state.frame.column(1));
                let angle = (about_y - joint.constant_n_m * share) / joint.stiffness_n_m_rad;
                state.frame *= nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), angle).into_inner();
                if let Some(record) = record.as_deref_mut() {
                    record.angles_rad.push(angle);
                }
            }
            let mut s = 0.0;
            for load in &segment.loads {
                state = self.along(state, load.position_m - s, share);
                s = load.position_m;
                let turn = if load.follower { state.frame } else { Matrix3::identity() };
                state.n -= turn * load.force_n * share;
                state.m -= turn * load.moment_n_m * share;
                if let Some(record) = record.as_deref_mut() {
                    record.stations.push(state.r);
                }
            }
            state = self.along(state, segment.length_m - s, share);
        }
        Vector6::new(state.n.x, state.n.y, state.n.z, state.m.x, state.m.y, state.m.z)
    }

    fn along(&self, mut state: State, length_m: f64, share: f64) -> State {
        let h = length_m / STEPS as f64;
        let moved = |state: &State, slope: &State, h: f64| State {
            r: state.r + slope.r * h,
            frame: state.frame + slope.frame * h,
            n: state.n + slope.n * h,
            m: state.m + slope.m * h,
        };
        for _ in 0..STEPS {
            let a = self.slope(&state, share);
            let b = self.slope(&moved(&state, &a, 0.5 * h), share);
            let c = self.slope(&moved(&state, &b, 0.5 * h), share);
            let d = self.slope(&moved(&state, &c, h), share);
            for (slope, weight) in [(a, 1.0), (b, 2.0), (c, 2.0), (d, 1.0)] {
                state = moved(&state, &slope, h * weight / 6.0);
            }
        }
        state
    }
}
