//! Independent reference: a shear-free, extensible Kirchhoff rod under a dead force at its tip, clamped at its root,
//! solved as a boundary-value problem by shooting. It shares no code with the engine.
//!
//! `r' = (1+ε) d₁`, `d_i' = u × d_i`, `n' = 0`, `m' = −r' × n` in the world frame, `u = Σ κ_i d_i`, `K(s) (ε, κ − κ₀(s)) = (n·d₁, m·d_i)`,
//! `K` symmetric 4×4. The unknown is the root moment; the moment at the tip must vanish.

use nalgebra::{Matrix3, Matrix4, SMatrix, SVector, Vector3, Vector4};

/// `(r, d₁, d₂, d₃, m)`.
type State = SVector<f64, 15>;

/// A rod, given by its stiffness for `(ε, κ₁, κ₂, κ₃)` and its natural curvatures `(κ₁, κ₂, κ₃)` as functions of arc length.
pub struct Rod<'a> {
    /// Length in m.
    pub length_m: f64,
    /// Stiffness at an arc length.
    pub stiffness: &'a dyn Fn(f64) -> Matrix4<f64>,
    /// Natural curvatures at an arc length, 1/m.
    pub curvature: &'a dyn Fn(f64) -> [f64; 3],
    /// Number of steps of the Runge–Kutta method.
    pub steps: usize,
}

/// One section of the solution.
#[derive(Clone, Copy)]
pub struct Section {
    /// Position in m.
    pub position: Vector3<f64>,
    /// Frame, columns `d_i`.
    pub frame: Matrix3<f64>,
    /// Moment in the world frame, N·m.
    pub moment: Vector3<f64>,
    /// Strain measures `(ε, κ − κ₀)`.
    pub measures: Vector4<f64>,
}

impl Rod<'_> {
    fn measures(&self, s: f64, state: &State, force: &Vector3<f64>) -> Vector4<f64> {
        let moment = part(state, 12);
        let d = [part(state, 3), part(state, 6), part(state, 9)];
        let resultant = Vector4::new(force.dot(&d[0]), moment.dot(&d[0]), moment.dot(&d[1]), moment.dot(&d[2]));
        (self.stiffness)(s).lu().solve(&resultant).expect("regular stiffness")
    }

    fn slope(&self, s: f64, state: &State, force: &Vector3<f64>) -> State {
        let strain = self.measures(s, state, force);
        let natural = (self.curvature)(s);
        let d = [part(state, 3), part(state, 6), part(state, 9)];
        let turn = d[0] * (natural[0] + strain[1]) + d[1] * (natural[1] + strain[2]) + d[2] * (natural[2] + strain[3]);
        let along = d[0] * (1.0 + strain[0]);
        let mut slope = State::zeros();
        for (i, value) in
            [along, turn.cross(&d[0]), turn.cross(&d[1]), turn.cross(&d[2]), -along.cross(force)].iter().enumerate()
        {
            slope.fixed_rows_mut::<3>(3 * i).copy_from(value);
        }
        slope
    }

    /// Integrates from the root with the root moment `moment` (Runge–Kutta 4); returns the sections at `i L / count`.
    fn march(&self, force: &Vector3<f64>, moment: &Vector3<f64>, count: usize) -> Vec<Section> {
        let mut state = State::zeros();
        for i in 0..3 {
            state[3 + 4 * i] = 1.0;
        }
        state.fixed_rows_mut::<3>(12).copy_from(moment);
        let steps = self.steps.div_ceil(count) * count;
        let h = self.length_m / steps as f64;
        let mut sections = vec![self.section(0.0, &state, force)];
        for i in 0..steps {
            let s = h * i as f64;
            let k1 = self.slope(s, &state, force);
            let k2 = self.slope(s + 0.5 * h, &(state + k1 * (0.5 * h)), force);
            let k3 = self.slope(s + 0.5 * h, &(state + k2 * (0.5 * h)), force);
            let k4 = self.slope(s + h, &(state + k3 * h), force);
            state += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
            if (i + 1) % (steps / count) == 0 {
                sections.push(self.section(s + h, &state, force));
            }
        }
        sections
    }

    fn section(&self, s: f64, state: &State, force: &Vector3<f64>) -> Section {
        Section {
            position: part(state, 0),
            frame: Matrix3::from_columns(&[part(state, 3), part(state, 6), part(state, 9)]),
            moment: part(state, 12),
            measures: self.measures(s, state, force),
        }
    }

    /// Equilibrium under a dead tip `force` in N, applied in load steps; returns the sections at `i L / count`.
    pub fn solve(&self, force: &Vector3<f64>, count: usize) -> Vec<Section> {
        const LOAD_STEPS: usize = 8;
        let mut moment = Vector3::zeros();
        let scale = force.norm() * self.length_m;
        for step in 1..=LOAD_STEPS {
            let force = force * (step as f64 / LOAD_STEPS as f64);
            let tip = |moment: &Vector3<f64>| self.march(&force, moment, 1)[1].moment;
            for iteration in 0.. {
                let miss = tip(&moment);
                if miss.norm() <= 1e-13 * scale || (iteration > 6 && miss.norm() < 1e-11 * scale) {
                    break;
                }
                assert!(iteration < 40, "shooting misses by {:.1e}", miss.norm() / scale);
                let h = 1e-6 * scale;
                let mut jacobian = SMatrix::<f64, 3, 3>::zeros();
                for j in 0..3 {
                    let mut shift = Vector3::zeros();
                    shift[j] = h;
                    jacobian.set_column(j, &((tip(&(moment + shift)) - tip(&(moment - shift))) / (2.0 * h)));
                }
                moment -= jacobian.lu().solve(&miss).expect("regular");
            }
        }
        self.march(force, &moment, count)
    }
}

fn part(state: &State, first: usize) -> Vector3<f64> {
    state.fixed_rows::<3>(first).into_owned()
}
