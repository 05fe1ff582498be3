//! The shipped aircraft as one rigid body with quasi-steady strips, written from eqs. (W1) to (W7) and from its rods and masses, without
//! any code of the engine.

use nalgebra::{Complex, DMatrix, Matrix3, Matrix6, Rotation3, SMatrix, Vector3, Vector6};

const DENSITY_KG_M3: f64 = 1.225;
const LIFT_SLOPE_1_RAD: f64 = std::f64::consts::TAU;
const DRAG_COEFFICIENT: f64 = 0.01;
const AXIS_FRACTION: f64 = 0.35;

/// A strip: position of its axis, its directions towards the trailing edge and up, chord and width.
struct Strip {
    axis_m: Vector3<f64>,
    aft: Vector3<f64>,
    up: Vector3<f64>,
    chord_m: f64,
    width_m: f64,
}

/// The aircraft.
pub struct Rigid {
    strips: Vec<Strip>,
    /// Mass matrix about the origin: forces and moments per acceleration and angular acceleration.
    pub mass: Matrix6<f64>,
    mass_kg: f64,
    /// Mass times the position of the centre of mass.
    first_moment_kg_m: Vector3<f64>,
}

/// A beam of the aircraft: inner end, direction, length, width of the section along `width_axis` and its height, density.
struct Rod {
    inner_m: Vector3<f64>,
    along: Vector3<f64>,
    width_axis: Vector3<f64>,
    length_m: f64,
    width_m: f64,
    height_m: f64,
    density_kg_m3: f64,
}

impl Rigid {
    /// The aircraft with both tips at a fold angle, positive upward.
    pub fn new(fold_rad: f64) -> Self {
        let (ahead, left, up) = (Vector3::x(), Vector3::y(), Vector3::z());
        let mut rods = Vec::new();
        let mut strips = Vec::new();
        let mut wing = |inner_m: Vector3<f64>,
                        along: Vector3<f64>,
                        up: Vector3<f64>,
                        length_m: f64,
                        [chord_m, incidence_deg]: [f64; 2],
                        count: usize,
                        spar: bool| {
            let (width_m, height_m, density_kg_m3) = if spar { (0.03, 0.006, 2700.0) } else { (0.05, 0.01, 400.0) };
            rods.push(Rod { inner_m, along, width_axis: ahead, length_m, width_m, height_m, density_kg_m3 });
            let (sin, cos) = incidence_deg.to_radians().sin_cos();
            for i in 0..count {
                let width_m = length_m / count as f64;
                strips.push(Strip {
                    axis_m: inner_m + along * (width_m * (i as f64 + 0.5)),
                    aft: -ahead * cos - up * sin,
                    up: up * cos - ahead * sin,
                    chord_m,
                    width_m,
                });
            }
        };
        for side in [left, -left] {
            wing(Vector3::zeros(), side, up, 0.6, [0.25, 2.0], 5, true);
            let (sin, cos) = fold_rad.sin_cos();
            wing(side * 0.6, side * cos + up * sin, up * cos - side * sin, 0.4, [0.25, 2.0], 4, true);
            wing(-ahead + up * 0.05, side, up, 0.3, [0.15, 0.0], 3, false);
        }
        // the z axis of the fin's section is its normal, which points to the left
        wing(-ahead + up * 0.05, up, left, 0.3, [0.15, 0.0], 3, false);
        let mut rigid = Self { strips, mass: Matrix6::zeros(), mass_kg: 0.0, first_moment_kg_m: Vector3::zeros() };
        rigid.add(3.5, Vector3::new(-0.05, 0.0, -0.02), Matrix3::from_diagonal(&Vector3::new(0.02, 0.25, 0.25)));
        for rod in rods {
            let mass_kg = rod.density_kg_m3 * rod.width_m * rod.height_m * rod.length_m;
            let height_axis = rod.along.cross(&rod.width_axis);
            let about = |axis: Vector3<f64>, size_m: f64| {
                (Matrix3::identity() - axis * axis.transpose(), size_m * size_m / 12.0)
            };
            // a box: each edge of length l adds l²/12 about the two other directions
            let sizes =
                [about(rod.along, rod.length_m), about(rod.width_axis, rod.width_m), about(height_axis, rod.height_m)];
            let inertia = sizes.iter().fold(Matrix3::zeros(), |sum, (matrix, square)| sum + matrix * *square * mass_kg);
            rigid.add(mass_kg, rod.inner_m + rod.along * (0.5 * rod.length_m), inertia);
        }
        rigid
    }

    fn add(&mut self, mass_kg: f64, centre_m: Vector3<f64>, inertia_kg_m2: Matrix3<f64>) {
        let hat = centre_m.cross_matrix();
        let mut mass = Matrix6::zeros();
        mass.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * mass_kg));
        mass.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-hat * mass_kg));
        mass.fixed_view_mut::<3, 3>(3, 0).copy_from(&(hat * mass_kg));
        mass.fixed_view_mut::<3, 3>(3, 3).copy_from(&(inertia_kg_m2 - hat * hat * mass_kg));
        self.mass += mass;
        self.mass_kg += mass_kg;
        self.first_moment_kg_m += centre_m * mass_kg;
    }

    /// Aerodynamic force, weight, thrust and a control moment, the latter two fixed to the aircraft: force in N and moment about the origin
    /// in N·m.
    fn loads(
        &self,
        flight: &Flight,
        turn: Vector3<f64>,
        velocity_m_s: Vector3<f64>,
        spin_rad_s: Vector3<f64>,
    ) -> Vector6<f64> {
        let attitude = Rotation3::from_scaled_axis(turn);
        let mut force = flight.gravity_m_s2 * self.mass_kg + attitude * Vector3::new(flight.thrust_n, 0.0, 0.0);
        let mut moment = (attitude * self.first_moment_kg_m).cross(&flight.gravity_m_s2)
            + attitude * Vector3::new(0.0, flight.moment_n_m, 0.0);
        for strip in &self.strips {
            let (t, n) = (attitude * strip.aft, attitude * strip.up);
            let c = strip.chord_m;
            let point = |fraction: f64| attitude * strip.axis_m + t * (c * (fraction - AXIS_FRACTION));
            let relative = |fraction: f64| flight.wind_m_s - velocity_m_s - spin_rad_s.cross(&point(fraction));
            let pitch = n.dot(&(relative(1.0) - relative(0.0)));
            let middle = relative(0.5);
            let (v, w) = (t.dot(&middle), n.dot(&middle));
            let gamma = v / (v * v + w * w + (pitch / 4.0).powi(2)).sqrt();
            let downwash = n.dot(&relative(0.5 + gamma / 4.0));
            let circulation = 0.5 * c * LIFT_SLOPE_1_RAD * downwash;
            let at = 0.5 - gamma / 4.0;
            // a flow along the span has no effect
            let flow = relative(at) - n.cross(&t) * n.cross(&t).dot(&relative(at));
            let load = DENSITY_KG_M3 * v.abs() * circulation * n
                - 0.5 * DENSITY_KG_M3 * c * LIFT_SLOPE_1_RAD * gamma * (downwash - gamma * pitch / 4.0).powi(2) * t
                + 0.5 * DENSITY_KG_M3 * c * DRAG_COEFFICIENT * flow.norm() * flow;
            let nose_up = -std::f64::consts::PI / 16.0 * DENSITY_KG_M3 * c * c * v * gamma * pitch;
            force += load * strip.width_m;
            moment += point(at).cross(&load) * strip.width_m + n.cross(&t) * (nose_up * strip.width_m);
        }
        let mut loads = Vector6::zeros();
        loads.fixed_rows_mut::<3>(0).copy_from(&force);
        loads.fixed_rows_mut::<3>(3).copy_from(&moment);
        loads
    }

    /// Residual of the equations of balance.
    pub fn left(&self, flight: &Flight) -> Vector6<f64> {
        self.loads(flight, Vector3::zeros(), Vector3::zeros(), Vector3::zeros())
    }

    /// Derivatives of the loads with respect to rotation, velocity and angular velocity, by fourth-order differences.
    pub fn slopes(&self, flight: &Flight) -> [SMatrix<f64, 6, 3>; 3] {
        let slope = |part: usize, axis: usize, step: f64| {
            let at = |steps: f64| {
                let mut changes = [Vector3::zeros(); 3];
                changes[part][axis] = steps * step;
                self.loads(flight, changes[0], changes[1], changes[2])
            };
            ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * step)
        };
        [(0, 1e-3), (1, 1e-2), (2, 1e-2)].map(|(part, step)| {
            let columns: Vec<Vector6<f64>> = (0..3).map(|axis| slope(part, axis, step)).collect();
            SMatrix::<f64, 6, 3>::from_columns(&columns)
        })
    }

    /// Eigenvalues in 1/s of the motions about a steady flight, without those of the position; one of each complex pair.
    pub fn eigenvalues_1_s(&self, flight: &Flight) -> Vec<Complex<f64>> {
        let [turn, velocity, spin] = self.slopes(flight);
        let inverse = self.mass.try_inverse().expect("a mass matrix");
        // states: rotation, velocity, angular velocity
        let mut a = DMatrix::zeros(9, 9);
        a.view_mut((0, 6), (3, 3)).fill_with_identity();
        for (first, slopes) in [(0, turn), (3, velocity), (6, spin)] {
            a.view_mut((3, first), (6, 3)).copy_from(&(inverse * slopes));
        }
        let mut values: Vec<Complex<f64>> =
            a.complex_eigenvalues().iter().copied().filter(|value| value.im >= 0.0).collect();
        values.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        values
    }
}

/// Steady flight in the frame of the aircraft.
pub struct Flight {
    pub wind_m_s: Vector3<f64>,
    pub gravity_m_s2: Vector3<f64>,
    pub thrust_n: f64,
    pub moment_n_m: f64,
}
