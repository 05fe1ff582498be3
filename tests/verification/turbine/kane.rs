//! Kane's derivation as an independent reference: partial velocities of every point assembled as in \[K\] (2)–(9), its equation (11) with
//! corrected sign and acceleration, sections whose angular velocity is the rate of their attitude, and `M u̇ = f` solved as a whole. Shares
//! no formula with the recursions: sums for the shapes, attitudes and assembly are separate.

use crate::trees::Random;
use crate::turbine::machine::*;
use foldwing::beam::modal::{ModalLaw, Shape};
use foldwing::machine::{JointKind, Machine, Parent};
use foldwing::plant::Plant;
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Unit, Vector3};
use std::sync::Arc;

/// A frame in Kane's method: origin and attitude, their partial velocities, and the accelerations at constant speeds (\[K\] 5–8).
#[derive(Clone)]
struct Frame {
    rotation: Matrix3<f64>,
    position: Vector3<f64>,
    /// `v_k` of the origin and `ω_k`, per speed.
    velocity: Vec<Vector3<f64>>,
    spin: Vec<Vector3<f64>>,
    /// `Σ dv_k/dt u_k` and `Σ dω_k/dt u_k`.
    rest: Vector3<f64>,
    spin_rest: Vector3<f64>,
    /// `ω`.
    omega: Vector3<f64>,
}

impl Frame {
    fn earth(speeds: usize) -> Self {
        let zero = Vector3::zeros();
        Self {
            rotation: Matrix3::identity(),
            position: zero,
            velocity: vec![zero; speeds],
            spin: vec![zero; speeds],
            rest: zero,
            spin_rest: zero,
            omega: zero,
        }
    }

    /// The frame at a point fixed to this frame, `arm` in the frame's axes.
    fn moved(&self, arm: &Vector3<f64>) -> Self {
        let arm = self.rotation * arm;
        let mut frame = self.clone();
        frame.position += arm;
        frame.velocity.iter_mut().zip(&self.spin).for_each(|(v, w)| *v += w.cross(&arm));
        frame.rest += self.spin_rest.cross(&arm) + self.omega.cross(&self.omega.cross(&arm));
        frame
    }

    fn turned(mut self, rotation: &Matrix3<f64>) -> Self {
        self.rotation *= rotation;
        self
    }

    /// A frame that rotates about an axis of this one with speed `k`.
    fn hinged(mut self, axis: &Vector3<f64>, k: usize, angle: f64, speed: f64) -> Self {
        let axis = self.rotation * axis;
        self.spin[k] += axis;
        self.spin_rest += self.omega.cross(&axis) * speed;
        self.omega += axis * speed;
        self.rotation = Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle) * self.rotation;
        self
    }

    /// A section of a bent body: deflections `u_i`, slopes `u_i'` (body axes) and shortening `S`, with coordinates starting at `first`.
    fn bent(&self, at: &Bent, first: usize, q: &[f64], u: &[f64]) -> Self {
        let n = at.deflection.len();
        let (q, u) = (&q[first..first + n], &u[first..first + n]);
        let along = |a: &[f64], b: &[f64]| -> f64 {
            (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| at.shortening[(i, j)] * a[i] * b[j]).sum()
        };
        let mut place = Vector3::new(at.place_m - 0.5 * along(q, q), 0.0, 0.0);
        let (mut rate, mut angles) = (Vector3::zeros(), Vector3::zeros());
        let mut partial = Vec::new();
        for i in 0..n {
            place += at.deflection[i] * q[i];
            let drawn: f64 = (0..n).map(|j| at.shortening[(i, j)] * q[j]).sum();
            let own = at.deflection[i] - Vector3::x() * drawn;
            rate += own * u[i];
            partial.push(own);
            angles += Vector3::x().cross(&at.slope[i]) * q[i];
        }
        let mut frame = self.moved(&place);
        let drawn = Vector3::x() * along(u, u);
        frame.rest += self.rotation * -drawn + self.omega.cross(&(self.rotation * rate)) * 2.0;
        let mut angle_rates = Vector3::zeros();
        for i in 0..n {
            let own = Vector3::x().cross(&at.slope[i]);
            let turn = self.rotation * turning(&angles, &own)[0];
            frame.velocity[first + i] += self.rotation * partial[i];
            frame.spin[first + i] += turn;
            frame.spin_rest += self.omega.cross(&turn) * u[i];
            angle_rates += own * u[i];
        }
        let [omega, rest] = turning(&angles, &angle_rates);
        frame.omega += self.rotation * omega;
        frame.spin_rest += self.rotation * rest;
        let angle = angles.norm();
        if angle > 0.0 {
            frame.rotation = self.rotation * Rotation3::from_axis_angle(&Unit::new_normalize(angles), angle.atan());
        }
        frame
    }
}

/// Angular velocity, and angular acceleration at constant rates, of a section rotated by `atan |t|` about `t`, whose small angles `t` have
/// the rates `u`: by axis `n` and angle `θ`, `ω = θ̇n + sin θ ṅ + (1 - cos θ) n × ṅ`.
fn turning(t: &Vector3<f64>, u: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let r = t.norm();
    if r == 0.0 {
        return [*u, Vector3::zeros()];
    }
    let n = t / r;
    let (sine, cosine) = r.atan().sin_cos();
    let dr = n.dot(u);
    let dn = (u - n * dr) / r;
    let ddr = dn.dot(u);
    let ddn = (dn * dr * 2.0 + n * ddr) / -r;
    let rate = dr / (1.0 + r * r);
    let second = ddr / (1.0 + r * r) - 2.0 * r * (dr / (1.0 + r * r)).powi(2);
    [
        n * rate + dn * sine + n.cross(&dn) * (1.0 - cosine),
        n * second
            + dn * (rate * (1.0 + cosine))
            + ddn * sine
            + n.cross(&dn) * (sine * rate)
            + n.cross(&ddn) * (1.0 - cosine),
    ]
}

/// Shapes at a position, summed here.
struct Bent {
    place_m: f64,
    deflection: Vec<Vector3<f64>>,
    slope: Vec<Vector3<f64>>,
    shortening: DMatrix<f64>,
}

/// Mass properties, the outer end, stiffness and damping.
struct Shapes {
    masses: Vec<(f64, Bent)>,
    tip: Bent,
    stiffness: DMatrix<f64>,
    damping: DMatrix<f64>,
}

/// `φ`, `φ'`, `φ''` at `x`, from the coefficients of the powers.
fn powers(coefficients: &[f64], x: f64) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for (k, c) in coefficients.iter().enumerate() {
        let p = (k + 2) as i32;
        sums[0] += c * x.powi(p);
        sums[1] += c * f64::from(p) * x.powi(p - 1);
        sums[2] += c * f64::from(p * (p - 1)) * x.powi(p - 2);
    }
    sums
}

/// ElastoDyn's sums for whole columns, as in `blade_modes_check.py`.
fn shapes(law: &ModalLaw) -> Shapes {
    let (cells, length_m) = (law.cells, law.length_m);
    let h = length_m / cells as f64;
    let places: Vec<f64> = (0..cells).map(|k| (k as f64 + 0.5) * h).collect();
    let modes: Vec<(bool, &Vec<f64>, f64)> = law
        .flap
        .iter()
        .map(|shape| (false, &shape.coefficients, shape.damping_ratio))
        .chain(law.edge.iter().map(|shape| (true, &shape.coefficients, shape.damping_ratio)))
        .collect();
    let n = modes.len();
    let direction = |edge: bool, s: f64| {
        let twist = law.twist_rad.as_ref().map_or(0.0, |twist| twist.at(s));
        let flap = Rotation3::from_axis_angle(&Vector3::x_axis(), twist) * Vector3::z();
        if edge { flap.cross(&Vector3::x()) } else { flap }
    };
    // running integral: full cells and half of the current one; the last entry is the total
    let running = |values: &[Vector3<f64>]| -> Vec<Vector3<f64>> {
        let before = |k: usize| values[..k].iter().sum::<Vector3<f64>>() * h;
        let mut all: Vec<Vector3<f64>> = (0..cells).map(|k| before(k) + values[k] * (0.5 * h)).collect();
        all.push(before(cells));
        all
    };
    let (mut deflection, mut slope) = (Vec::new(), Vec::new());
    for (edge, coefficients, _) in &modes {
        if law.twist_rad.is_some() {
            let bending: Vec<Vector3<f64>> = places
                .iter()
                .map(|s| direction(*edge, *s) * (powers(coefficients, s / length_m)[2] / length_m.powi(2)))
                .collect();
            let slopes = running(&bending);
            deflection.push(running(&slopes[..cells]));
            slope.push(slopes);
        } else {
            let at = |s: f64| powers(coefficients, s / length_m);
            let all = || places.iter().copied().chain([length_m]);
            // at the top the coordinate itself, [K] (2): printed coefficients sum to 1 within 1e-3
            let value = |s: f64| if s == length_m { 1.0 } else { at(s)[0] };
            deflection.push(all().map(|s| direction(*edge, s) * value(s)).collect());
            slope.push(all().map(|s| direction(*edge, s) * (at(s)[1] / length_m)).collect());
        }
    }
    let mut shortening = vec![DMatrix::zeros(n, n); cells + 1];
    for i in 0..n {
        for j in 0..n {
            let product: Vec<Vector3<f64>> = (0..cells).map(|k| Vector3::x() * slope[i][k].dot(&slope[j][k])).collect();
            for (k, sum) in running(&product).iter().enumerate() {
                shortening[k][(i, j)] = sum.x;
            }
        }
    }
    let at = |k: usize, place_m: f64| Bent {
        place_m,
        deflection: deflection.iter().map(|all| all[k]).collect(),
        slope: slope.iter().map(|all| if law.section_rotation { all[k] } else { Vector3::zeros() }).collect(),
        shortening: if law.axial_shortening { shortening[k].clone() } else { DMatrix::zeros(n, n) },
    };
    let masses = (0..cells).map(|k| (law.mass_kg_m.at(places[k]) * h, at(k, places[k]))).collect();
    let (mut stiffness, mut damping) = (DMatrix::<f64>::zeros(n, n), DMatrix::<f64>::zeros(n, n));
    for j in 0..n {
        let mut plain = 0.0;
        for s in &places {
            let shape = powers(modes[j].1, s / length_m);
            plain += law.mass_kg_m.at(*s) * h * shape[0].powi(2);
            let rigidity = if modes[j].0 { &law.edge_stiffness_n_m2 } else { &law.flap_stiffness_n_m2 };
            for i in (0..n).filter(|i| modes[*i].0 == modes[j].0) {
                let other = powers(modes[i].1, s / length_m);
                stiffness[(i, j)] += rigidity.at(*s) * h * other[2] * shape[2] / length_m.powi(4);
            }
        }
        let frequency_hz: f64 = (stiffness[(j, j)] / plain).sqrt() / std::f64::consts::TAU;
        for i in 0..n {
            damping[(i, j)] = stiffness[(i, j)] * modes[j].2 / (std::f64::consts::PI * frequency_hz);
        }
    }
    Shapes { masses, tip: at(cells, length_m), stiffness, damping }
}

/// The system `M u̇ = f` of the whole machine, \[K\] (9)–(11).
struct Kane {
    mass: DMatrix<f64>,
    force: DVector<f64>,
    gravity_m_s2: Vector3<f64>,
}

impl Kane {
    /// Adds a particle, or a rigid body with its centre at the frame's origin and `inertia` in its axes.
    fn add(&mut self, mass_kg: f64, inertia: &Matrix3<f64>, at: &Frame) {
        let inertia = at.rotation * inertia * at.rotation.transpose();
        let gyro = inertia * at.spin_rest + at.omega.cross(&(inertia * at.omega));
        for k in 0..self.force.len() {
            self.force[k] += at.velocity[k].dot(&((self.gravity_m_s2 - at.rest) * mass_kg)) - at.spin[k].dot(&gyro);
            for l in 0..self.force.len() {
                self.mass[(k, l)] +=
                    mass_kg * at.velocity[k].dot(&at.velocity[l]) + at.spin[k].dot(&(inertia * at.spin[l]));
            }
        }
    }
}

impl Kane {
    /// Adds a rotor about an axis of its carrier that rotates `ratio` times as fast as speed `k`: the generator of \[K\].
    fn add_rotor(&mut self, inertia: f64, ratio: f64, axis: &Vector3<f64>, k: usize, carrier: &Frame) {
        let axis = carrier.rotation * axis;
        let mut spin: Vec<f64> = carrier.spin.iter().map(|spin| spin.dot(&axis)).collect();
        spin[k] += ratio;
        for i in 0..spin.len() {
            self.force[i] -= inertia * spin[i] * carrier.spin_rest.dot(&axis);
            for j in 0..spin.len() {
                self.mass[(i, j)] += inertia * spin[i] * spin[j];
            }
        }
    }
}

/// Accelerations of the machine's degrees of freedom, in the order of the engine: joints before shapes, body by body.
fn accelerations(machine: &Machine, q: &[f64], u: &[f64]) -> DVector<f64> {
    let n = q.len();
    let mut kane = Kane { mass: DMatrix::zeros(n, n), force: DVector::zeros(n), gravity_m_s2: machine.gravity_m_s2 };
    let mut ends: Vec<Frame> = Vec::new();
    let mut next = 0;
    for body in &machine.bodies {
        let joint = &body.joint;
        let mut frame = match joint.parent {
            Parent::Root { position_m } => Frame::earth(n).moved(&position_m),
            Parent::Body { index, .. } => ends[index].moved(&joint.offset_m),
        };
        if let JointKind::Revolute(hinge) = &joint.kind
            && hinge.motion == foldwing::machine::JointMotion::Free
        {
            if let Some(ratio) = hinge.motor.gear_ratio {
                kane.add_rotor(hinge.motor.inertia_kg_m2 / ratio.powi(2), ratio, &hinge.axis, next, &frame);
            }
            frame = frame.hinged(&hinge.axis, next, q[next], u[next]);
            if let Some(spring) = &hinge.spring {
                kane.force[next] -= spring.stiffness_n_m_rad * q[next] + spring.damping_n_m_s_rad * u[next];
            }
            next += 1;
        }
        frame = frame.turned(&joint.mount);
        for mass in &body.masses {
            kane.add(mass.mass_kg, &mass.inertia_kg_m2, &frame.moved(&mass.offset_m));
        }
        if body.is_modal() {
            let shapes = shapes(law(body));
            for (mass_kg, at) in &shapes.masses {
                kane.add(*mass_kg, &Matrix3::zeros(), &frame.bent(at, next, q, u));
            }
            let modes = shapes.stiffness.nrows();
            for i in 0..modes {
                for j in 0..modes {
                    kane.force[next + i] -=
                        shapes.stiffness[(i, j)] * q[next + j] + shapes.damping[(i, j)] * u[next + j];
                }
            }
            frame = frame.bent(&shapes.tip, next, q, u);
            next += modes;
        }
        ends.push(frame);
    }
    assert_eq!(next, n);
    kane.mass.cholesky().expect("a mass matrix").solve(&kane.force)
}

/// WT-06. Accelerations of the 16 coordinates at random states, with the rotor at 12 rpm and far from any equilibrium: equal to those of
/// Kane's equations to 1e-12 of the largest acceleration of their kind (forces of 1e9 N·m cancel in the drive train).
#[test]
fn wt06_accelerations_are_those_of_kanes_equations() {
    let worst = worst_beside_kane(&turbine(), 16);
    println!("WT-06: {worst:.1e}");
}

/// WT-06. Blades with six shapes, for which forces are summed mass by mass: up to four shapes use sums that are computed once.
#[test]
fn wt06_blades_with_many_shapes() {
    let mut machine = turbine();
    for name in ["blade1", "blade2", "blade3"] {
        let law = law_mut(&mut machine, name);
        for coefficients in [[3.0, -7.0, 5.0], [-5.0, 16.0, -10.0]] {
            law.edge.push(Shape { coefficients: coefficients.to_vec(), ..law.edge[0].clone() });
        }
        law.flap.push(Shape { coefficients: vec![6.0, -18.0, 13.0], ..law.flap[0].clone() });
    }
    let worst = worst_beside_kane(&machine, 25);
    println!("WT-06, six shapes per blade: {worst:.1e}");
}

/// WT-50. WT-06 without shortening, without rotation of sections, and without both, for the blades alone, the tower alone and all bodies:
/// bodies with different settings are attached to each other.
#[test]
fn wt50_bodies_that_keep_less_are_kanes_too() {
    let (blades, tower) = (["blade1", "blade2", "blade3"], ["tower"]);
    for [axial_shortening, section_rotation] in [[false, true], [true, false], [false, false]] {
        let mut both = turbine();
        for bodies in [&blades[..], &tower[..]] {
            let mut machine = turbine();
            for name in bodies {
                for machine in [&mut machine, &mut both] {
                    let law = law_mut(machine, name);
                    (law.axial_shortening, law.section_rotation) = (axial_shortening, section_rotation);
                }
            }
            let worst = worst_beside_kane(&machine, 16);
            println!("WT-50 {bodies:?}, shortening {axial_shortening}, rotation {section_rotation}: {worst:.1e}");
        }
        let worst = worst_beside_kane(&both, 16);
        println!("WT-50 all, shortening {axial_shortening}, rotation {section_rotation}: {worst:.1e}");
    }
}

/// Largest difference of the accelerations at five random states; asserts that it is below 1e-12.
fn worst_beside_kane(machine: &Machine, coordinates: usize) -> f64 {
    let mut plant = Plant::new(Arc::new(machine.clone()));
    plant.initialize(0.0).expect("a start");
    let names: Vec<String> = plant.freedoms().into_iter().map(|freedom| freedom.name).collect();
    let n = names.len();
    assert_eq!(n, coordinates);
    let mut worst_all = 0.0f64;
    for seed in 1..=5 {
        let mut random = Random::new(seed);
        let mut states = vec![0.0; 2 * n];
        for (k, name) in names.iter().enumerate() {
            let (size, rate) = match name.as_str() {
                "yaw.angle" => (0.2, 0.05),
                "drive_train.angle" => (0.01, 0.2),
                "shaft.angle" => (3.0, 0.1),
                name if name.starts_with("tower") => (0.5, 1.0),
                _ => (3.0, 4.0),
            };
            states[k] = size * random.symmetric();
            states[n + k] = rate * random.symmetric();
            if name == "shaft.angle" {
                states[n + k] += 1.27;
            }
        }
        let mut rates = vec![0.0; 2 * n];
        let mut hybrid = plant.hybrid().expect("a hybrid system");
        assert_eq!(hybrid.states(), 2 * n);
        hybrid.set(0.0, &states);
        hybrid.derivatives(&mut rates).expect("derivatives");
        let expected = accelerations(machine, &states[..n], &states[n..]);
        let angular = |name: &str| name.ends_with(".angle");
        for (k, name) in names.iter().enumerate() {
            let of_kind = names.iter().zip(expected.iter()).filter(|(other, _)| angular(other) == angular(name));
            let scale = of_kind.map(|(_, a)| a.abs()).fold(0.0, f64::max);
            let error = (rates[n + k] - expected[k]).abs() / scale;
            worst_all = worst_all.max(error);
            assert!(error < 1e-12, "seed {seed}, {name}: {} for {}, {error:.1e}", rates[n + k], expected[k]);
        }
    }
    worst_all
}
