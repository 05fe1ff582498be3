//! Random machines from the builder with extreme values: each is either valid or rejected; none panics. Machines with ordinary values are
//! generated as model files: `tests/machines`.

use crate::share::share;
use foldwing::aero::flow::GustShape;
use foldwing::beam::law::SectionLaw;
use foldwing::beam::profile::Profile;
use foldwing::beam::section::{Material, Outline, Section, Solid};
use foldwing::load::{LoadFrame, Wrench};
use foldwing::machine::builder::{BodyBuilder, GustBuilder, JointBuilder, MachineBuilder};
use foldwing::machine::*;
use foldwing::plant::Plant;
use nalgebra::Vector3;
use std::sync::Arc;

/// Values far outside the usual range.
const STRANGE: &[f64] = &[
    0.0,
    -0.0,
    -1.0,
    1e-300,
    -1e-300,
    1e30,
    1.1e30,
    1e200,
    -1e200,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN_POSITIVE,
];

/// Generates parts of machines; a fraction of the values, names and counts is extreme.
struct Dice {
    random: fastrand::Rng,
    /// One value in this many is extreme.
    strange: usize,
}

impl Dice {
    fn strikes(&mut self) -> bool {
        self.random.usize(..self.strange) == 0
    }

    fn number(&mut self, least: f64, most: f64) -> f64 {
        if self.strikes() {
            return STRANGE[self.random.usize(..STRANGE.len())];
        }
        least + (most - least) * self.random.f64()
    }

    fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.number(-size, size))
    }

    fn count(&mut self, least: usize, most: usize) -> usize {
        if self.strikes() { [0, 1001, usize::MAX][self.random.usize(..3)] } else { self.random.usize(least..=most) }
    }

    fn name(&mut self, kind: &str, index: usize) -> String {
        if self.strikes() {
            let strange = ["", "1", "root", "a b", "energy", "tip_b0", "b0", "j0"];
            return strange[self.random.usize(..strange.len())].to_owned();
        }
        format!("{kind}{index}")
    }

    fn section(&mut self, length_m: f64) -> SectionLaw {
        let material = Material::isotropic(self.number(1e9, 1e11), self.number(0.1, 0.4), self.number(500.0, 3000.0));
        let outline = if self.random.bool() { Outline::Rectangle } else { Outline::Ellipse };
        let (width_m, height_m) = (self.number(0.02, 0.1), self.number(0.002, 0.01));
        let solid = Solid { outline, width_m, height_m, material, torsional_rigidity_n_m2: None, shear_factor: None };
        match self.random.usize(..4) {
            0 => solid.into(),
            1 => solid.section().into(),
            2 => {
                let rows = vec![[0.0, self.number(0.5, 1.0)], [self.number(0.5, 0.9) * length_m, 1.0]];
                SectionLaw::Tapered {
                    solid,
                    width: Profile::linear(1.0, self.number(0.5, 1.5), length_m),
                    height: Profile::Table(rows),
                }
            }
            _ => {
                let outer = Section { mass_kg_m: self.number(0.1, 1.0), ..solid.section() };
                SectionLaw::between(solid.section(), outer, length_m)
            }
        }
    }

    fn body(&mut self, index: usize) -> BodyBuilder {
        let length_m = self.number(0.2, 0.6);
        let section = self.section(length_m);
        let mut body = Body::beam(self.name("b", index), length_m, section)
            .elements(self.count(1, 3))
            .element(if self.random.bool() { ElementKind::Linear } else { ElementKind::Constant })
            .mass_damping_1_s(self.number(0.0, 2.0))
            .stiffness_damping_s(self.number(0.0, 1e-3))
            .damp_attached_masses(self.random.bool())
            .load_stations(self.count(0, 3));
        if self.random.bool() {
            body = body.natural_curvature_1_m([self.number(-1.0, 1.0), self.number(-1.0, 1.0), 0.0]);
        }
        if self.random.bool() {
            body = body.load_frame(LoadFrame::Section);
        }
        body
    }

    fn joint(&mut self, index: usize, bodies: usize) -> JointBuilder {
        let name = self.name("j", index);
        let axis = self.vector(1.0) + Vector3::new(0.0, 3.0, 0.0);
        let drive = Motor {
            stiffness_n_m_rad: self.number(0.1, 1.0),
            damping_n_m_s_rad: self.number(0.0, 0.01),
            ..Motor::default()
        };
        let joint = match self.random.usize(..7) {
            0 => Joint::clamped(name),
            1 => Joint::universal(name, axis, [1.0, 0.0, 0.0]).motor(drive),
            2 => Joint::ball(name).motor(drive),
            3 if index == 0 => Joint::free(name).start_velocity_m_s(self.vector(2.0)),
            4 => {
                let points = vec![(0.0, 0.0), (self.number(0.1, 1.0), self.number(-1.0, 1.0))];
                Joint::revolute(name, axis).prescribed(Motion::Table(points))
            }
            5 => {
                let (slide, start_m) = (Joint::prismatic(name, axis), self.number(-0.1, 0.1));
                match self.random.usize(..3) {
                    0 => {
                        let latch = Latch::with_ratio(self.number(2.0, 1e4)).capture_m(self.number(0.0, 0.01));
                        slide.motor(drive).start_position_m(start_m).latch(latch)
                    }
                    1 => slide.prescribed(Motion::Polynomial(vec![start_m, self.number(-1.0, 1.0)])),
                    _ => slide.motor(drive).start_position_m(start_m).start_rate_m_s(self.number(-1.0, 1.0)),
                }
            }
            _ => {
                let fold = Joint::revolute(name, axis).motor(drive).start_angle_rad(self.number(-2.0, 2.0));
                match self.random.usize(..3) {
                    0 => fold.latch(Latch::with_ratio(self.number(2.0, 1e4)).capture_rad(self.number(0.0, 0.1))),
                    1 => fold.release(false),
                    _ => fold.start_rate_rad_s(self.number(-5.0, 5.0)),
                }
            }
        };
        let joint = joint.mount_rotation_rad(self.vector(0.5));
        if index == 0 {
            return joint.at_root(self.vector(1.0));
        }
        // occasionally a body that comes later or does not exist: a cycle or an invalid reference
        let parent = if self.strikes() { self.random.usize(..bodies + 1) } else { self.random.usize(..index) };
        let parent = format!("b{parent}");
        if self.random.bool() { joint.on(parent) } else { joint.on_at(parent, self.number(0.0, 0.2)) }
    }

    fn machine(&mut self) -> MachineBuilder {
        let bodies = self.random.usize(1..=4);
        let mut machine = Machine::builder(self.name("m", 0)).gravity_m_s2(self.vector(10.0));
        for index in 0..bodies {
            machine = machine.body(self.body(index), self.joint(index, bodies));
        }
        let any = |dice: &mut Self| format!("b{}", dice.random.usize(..bodies));
        if self.random.bool() {
            let mut mass = AttachedMass::point(self.name("mass", 0), self.number(0.0, 0.2), self.number(0.01, 0.1));
            mass.offset_m = self.vector(0.01);
            machine = machine.mass(any(self), mass);
        }
        if self.random.bool() {
            machine = machine.gauge(Gauge::on(self.name("g", 0), any(self), self.number(0.0, 0.2)));
        }
        if self.strikes() {
            let bodies = [any(self), any(self)];
            let closure = Closure::between("pin", [&bodies[0], &bodies[1]], self.number(1e3, 1e5));
            machine = machine.closure(closure.positions_m([self.number(0.0, 0.2), self.number(0.0, 0.2)]));
        }
        if self.strikes() {
            let wrench = Wrench { force_n: self.vector(1.0), moment_n_m: self.vector(0.1) };
            machine = machine.load("push", any(self), self.count(1, 3), wrench);
        }
        if self.random.usize(..3) == 0 {
            let air = if self.random.bool() { Air::strips() } else { Air::lattice().wake_rows(self.count(5, 10)) };
            let air = air.wind_m_s(self.vector(5.0)).step_s(self.number(2e-3, 5e-3));
            let chord_m = Profile::constant(self.number(0.02, 0.1));
            machine = machine
                .air(air.density_kg_m3(self.number(0.5, 1.5)))
                .surface(LiftingSurface::on(any(self), self.count(2, 3)).chord_panels(2).chord_m(chord_m));
            if self.random.bool() {
                let gust = GustBuilder::new(self.name("gust", 0), GustShape::SharpEdge, self.vector(1.0));
                machine = machine.gust(gust.direction([1.0, 0.0, 0.0]).speed_m_s(self.number(1.0, 10.0)));
            }
        }
        machine.step_s(self.number(1e-3, 2e-3)).stop_time_s(self.number(0.1, 1.0))
    }
}

/// Simulates 10 ms from the start.
fn run(machine: Machine) -> Result<(), String> {
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).map_err(|error| error.to_string())?;
    plant.step(0.01).map_err(|error| error.to_string())
}

/// M-07: one extreme value, name or count in 30. An accepted machine passes its own checks; it runs or returns an error with the cause.
#[test]
fn strange_machines_are_taken_or_refused() {
    let share = share();
    let (mut taken, mut ran, mut faults) = (0, 0, 0);
    for seed in 0..2000u64.div_ceil(share as u64) {
        let builder = Dice { random: fastrand::Rng::with_seed(seed), strange: 30 }.machine();
        match builder.build() {
            Ok(machine) => {
                taken += 1;
                assert_eq!(machine.validate(), [], "seed {seed}");
                if taken % 5 == 0 {
                    ran += usize::from(run(machine).is_ok());
                }
            }
            Err(refused) => {
                assert!(!refused.faults.is_empty(), "seed {seed}");
                faults += refused.faults.len();
                for fault in refused.faults {
                    let told = fault.to_string();
                    assert!(!fault.value.is_empty() && !fault.allowed.is_empty(), "seed {seed}: {told}");
                }
            }
        }
    }
    println!("{taken} of 2000 / {share} taken, {ran} of a fifth of them ran, {faults} faults told");
    assert!(
        share * taken > 100 && ran * 5 > taken / 2 && share * faults > 1000,
        "{taken} taken, {ran} ran, {faults} faults"
    );
}
