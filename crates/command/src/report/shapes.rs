//! Modes as motions of the recorded sections, for the page and the VTK files: complex displacements and rotations about a state, and
//! the machine displaced by them at an amplitude.
//!
//! Rotations are finite: a section turns by its rotation vector, and its position follows from the turned axis inward of it. So bodies keep
//! their lengths at any amplitude, and the motion is that of the linear mode at small ones.

use crate::report::recording::{Frame, Scene};
use foldwing_engine::math::so3::rotation_about;
use foldwing_engine::plant::{Plant, SectionChange, SectionState};
use nalgebra::{Complex, Matrix3, Vector3};

/// Largest displacement of a mode at amplitude 1, over the diagonal of the box around the machine.
pub const LARGEST_SHARE: f64 = 0.1;
/// Largest rotation at amplitude 1 in rad: reduces the displacement of motions that are mainly rotations.
pub const LARGEST_ROTATION_RAD: f64 = 0.5;

/// Changes of the sections of all bodies at one state: real and imaginary parts.
pub type Changes = Vec<Vec<[SectionChange; 2]>>;

/// A mode that can be drawn. Its motion about the state is `Re(changes · exp(λ t))` with the exponent.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnMode {
    /// Number that the tables of the command have of it.
    pub number: usize,
    /// Eigenvalue in 1/s, from which frequency and damping follow.
    pub eigenvalue_1_s: Complex<f64>,
    /// Exponent of the motion between the states in 1/s: the eigenvalue, or the principal exponent about a periodic motion.
    pub exponent_1_s: Complex<f64>,
    /// The motion grows.
    pub grows: bool,
    /// Deformation and name in words.
    pub words: String,
    /// Motion at amplitude 1 about each frame of its state.
    pub changes: Vec<Changes>,
    /// Largest displacement in m at amplitude 1, at the drawn points.
    pub largest_m: f64,
    /// Largest rotation in rad at amplitude 1.
    pub largest_rad: f64,
}

/// A state with its modes.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnState {
    /// Value of the quantity over which the states are.
    pub value: f64,
    /// What happens there; empty for most.
    pub words: String,
    /// The state, or the samples of a turn with its end, which has no motion of its own.
    pub frames: Vec<Frame>,
    /// Period of the turn in s.
    pub period_s: Option<f64>,
    /// Modes; `None` where one was not found.
    pub modes: Vec<Option<DrawnMode>>,
}

/// Modes about one or more states of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Shapes {
    /// Constant parts of the machine.
    pub scene: Scene,
    /// Title of the page below the name.
    pub title: String,
    /// Name and unit of the quantity over which the states are; `None` for a single state.
    pub quantity: Option<[&'static str; 2]>,
    /// The states.
    pub states: Vec<DrawnState>,
}

/// The present state of a plant for modes: without wake and circulation, which they do not have.
pub fn state_of(scene: &Scene, plant: &Plant) -> Frame {
    let mut frame = Frame::of(scene, plant);
    frame.lattice.clear();
    frame.acting.circulation_m2_s.clear();
    frame
}

/// Motion of the drawn sections about the present state of a plant, of changes of its free coordinates, at any amplitude.
pub fn changes_of(scene: &Scene, plant: &Plant, coordinates: &[Complex<f64>]) -> Changes {
    let places_m: Vec<Vec<f64>> = scene.bodies.iter().map(|body| body.places_m.clone()).collect();
    let part = |read: fn(&Complex<f64>) -> f64| {
        plant.section_changes(&coordinates.iter().map(read).collect::<Vec<f64>>(), &places_m)
    };
    let (real, imaginary) = (part(|x| x.re), part(|x| x.im));
    real.into_iter().zip(imaginary).map(|(re, im)| re.into_iter().zip(im).map(|(re, im)| [re, im]).collect()).collect()
}

impl DrawnMode {
    /// Scales the motion to amplitude 1 about the frames of its state: its largest displacement is [`LARGEST_SHARE`] of the size of the
    /// machine, unless its largest rotation would be more than [`LARGEST_ROTATION_RAD`].
    pub fn scaled(mut self, scene: &Scene, frames: &[Frame]) -> Self {
        let (mut largest_m, mut largest_rad) = (0.0f64, 0.0f64);
        for (frame, changes) in frames.iter().zip(&self.changes) {
            for (body, changes) in changes.iter().enumerate() {
                for (i, change) in changes.iter().enumerate() {
                    largest_rad = largest_rad.max(largest(&change.map(|part| part.rotation_rad)));
                    let section = &frame.sections[body][i];
                    for [y_m, z_m] in &scene.bodies[body].rims_m[i] {
                        let arm_m = section.rotation * Vector3::new(0.0, *y_m, *z_m);
                        largest_m = largest_m.max(largest(&at_arm(change, &arm_m)));
                    }
                }
            }
            for (surface, edges_m) in scene.surfaces.iter().zip(&frame.edges_m) {
                for (place_m, ends_m) in surface.places_m.iter().zip(edges_m) {
                    let (i, share) = interval(&scene.bodies[surface.body].places_m, *place_m);
                    let change = between(&changes[surface.body], i, share);
                    let axis_m = mixed(&frame.sections[surface.body], i, share).0;
                    let reach = |end_m: &Vector3<f64>| largest(&at_arm(&change, &(end_m - axis_m)));
                    largest_m = ends_m.iter().map(reach).fold(largest_m, f64::max);
                }
            }
        }
        let size_m = frames.first().map_or(0.0, |frame| size_m(scene, frame));
        let by_displacement = if largest_m > 0.0 { LARGEST_SHARE * size_m / largest_m } else { f64::INFINITY };
        let by_rotation = if largest_rad > 0.0 { LARGEST_ROTATION_RAD / largest_rad } else { f64::INFINITY };
        let scale = by_displacement.min(by_rotation);
        let scale = if scale.is_finite() { scale } else { 1.0 };
        for part in self.changes.iter_mut().flatten().flatten().flatten() {
            part.displacement_m *= scale;
            part.rotation_rad *= scale;
            part.measures *= scale;
        }
        (self.largest_m, self.largest_rad) = (scale * largest_m, scale * largest_rad);
        self
    }
}

/// Largest length of `Re(z e^{iθ})` over `θ`.
fn largest([re, im]: &[Vector3<f64>; 2]) -> f64 {
    let (sum, difference) = (re.norm_squared() + im.norm_squared(), re.norm_squared() - im.norm_squared());
    (0.5 * (sum + difference.hypot(2.0 * re.dot(im)))).sqrt()
}

/// Displacement of a point at an arm from the axis.
fn at_arm(change: &[SectionChange; 2], arm_m: &Vector3<f64>) -> [Vector3<f64>; 2] {
    change.map(|part| part.displacement_m + part.rotation_rad.cross(arm_m))
}

/// Diagonal of the box around the drawn points in m.
pub fn size_m(scene: &Scene, frame: &Frame) -> f64 {
    let rims = scene.bodies.iter().zip(&frame.sections).flat_map(|(body, sections)| {
        sections.iter().zip(&body.rims_m).flat_map(|(section, rim)| rim.iter().map(|point| section.point(*point).0))
    });
    let edges = frame.edges_m.iter().flatten().flatten().copied();
    let (mut least, mut most) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    for point in rims.chain(edges) {
        least = least.inf(&point);
        most = most.sup(&point);
    }
    let size_m = (most - least).norm();
    if size_m.is_finite() { size_m } else { 0.0 }
}

/// Interval of ascending places that contains one, and the share of it before the place.
fn interval(places_m: &[f64], place_m: f64) -> (usize, f64) {
    if places_m.len() < 2 {
        return (0, 0.0);
    }
    let i = places_m.partition_point(|other| *other <= place_m).clamp(1, places_m.len() - 1) - 1;
    (i, ((place_m - places_m[i]) / (places_m[i + 1] - places_m[i])).clamp(0.0, 1.0))
}

/// Change between two sections.
fn between(changes: &[[SectionChange; 2]], i: usize, share: f64) -> [SectionChange; 2] {
    let next = (i + 1).min(changes.len() - 1);
    [0, 1].map(|part| {
        let (a, b) = (&changes[i][part], &changes[next][part]);
        SectionChange {
            displacement_m: a.displacement_m.lerp(&b.displacement_m, share),
            rotation_rad: a.rotation_rad.lerp(&b.rotation_rad, share),
            measures: a.measures.lerp(&b.measures, share),
        }
    })
}

/// Position and axes between two sections.
fn mixed(sections: &[SectionState], i: usize, share: f64) -> (Vector3<f64>, Matrix3<f64>) {
    let (a, b) = (&sections[i], &sections[(i + 1).min(sections.len() - 1)]);
    let axis = |k: usize| a.rotation.column(k).into_owned().lerp(&b.rotation.column(k).into_owned(), share);
    let y = axis(1).normalize();
    let x = y.cross(&axis(2)).normalize();
    (a.position_m.lerp(&b.position_m, share), Matrix3::from_columns(&[x, y, x.cross(&y)]))
}

/// Rotation by a rotation vector in rad.
fn turn(vector_rad: &Vector3<f64>) -> Matrix3<f64> {
    match vector_rad.norm() {
        0.0 => Matrix3::identity(),
        angle_rad => rotation_about(&(vector_rad / angle_rad), angle_rad),
    }
}

/// The machine displaced by a mode: `factor` is the complex amplitude, `a e^{iθ}` at amplitude `a` and phase `θ`, and `rate_1_s` its
/// logarithmic rate, for velocities. Strain measures are those of the mode alone, without those of the state.
pub fn displaced(
    scene: &Scene,
    frame: &Frame,
    changes: &Changes,
    factor: Complex<f64>,
    rate_1_s: Complex<f64>,
) -> Frame {
    let real = |part: &[SectionChange; 2], by: Complex<f64>| {
        let [re, im] = part;
        SectionChange {
            displacement_m: re.displacement_m * by.re - im.displacement_m * by.im,
            rotation_rad: re.rotation_rad * by.re - im.rotation_rad * by.im,
            measures: re.measures * by.re - im.measures * by.im,
        }
    };
    let mut moved: Vec<Vec<SectionState>> = Vec::new();
    for (body, sections) in frame.sections.iter().enumerate() {
        let now: Vec<SectionChange> = changes[body].iter().map(|part| real(part, factor)).collect();
        let start = match scene.bodies[body].carrier {
            None => sections[0].position_m + now[0].displacement_m,
            Some((carrier, place_m)) => {
                let (i, share) = interval(&scene.bodies[carrier].places_m, place_m);
                let own = real(&between(&changes[carrier], i, share), factor);
                let arm_m = sections[0].position_m - mixed(&frame.sections[carrier], i, share).0;
                let slide_m = now[0].displacement_m - own.displacement_m - own.rotation_rad.cross(&arm_m);
                mixed(&moved[carrier], i, share).0 + turn(&own.rotation_rad) * (arm_m + slide_m)
            }
        };
        let mut position_m = start;
        let mut list = Vec::with_capacity(sections.len());
        for (i, section) in sections.iter().enumerate() {
            if i > 0 {
                let arm_m = section.position_m - sections[i - 1].position_m;
                let mean_rad = (now[i - 1].rotation_rad + now[i].rotation_rad) * 0.5;
                let strained_m = now[i].displacement_m - now[i - 1].displacement_m - mean_rad.cross(&arm_m);
                position_m += turn(&mean_rad) * (arm_m + strained_m);
            }
            let speed = real(&changes[body][i], factor * rate_1_s);
            list.push(SectionState {
                position_m,
                velocity_m_s: speed.displacement_m,
                angular_velocity_rad_s: speed.rotation_rad,
                rotation: turn(&now[i].rotation_rad) * section.rotation,
                measures: now[i].measures,
            });
        }
        moved.push(list);
    }
    let carried = |body: usize, place_m: f64, point_m: &Vector3<f64>| {
        let (i, share) = interval(&scene.bodies[body].places_m, place_m);
        let (from_m, axes) = mixed(&frame.sections[body], i, share);
        let (to_m, turned) = mixed(&moved[body], i, share);
        to_m + turned * (axes.transpose() * (point_m - from_m))
    };
    let mut found = frame.clone();
    for (surface, edges_m) in scene.surfaces.iter().zip(&mut found.edges_m) {
        for (place_m, ends_m) in surface.places_m.iter().zip(edges_m) {
            *ends_m = ends_m.map(|end_m| carried(surface.body, *place_m, &end_m));
        }
    }
    for (gauge, (place, strain)) in scene.gauges.iter().zip(found.gauges_m.iter_mut().zip(&mut found.strains)) {
        *place = carried(gauge.body, gauge.place_m, place);
        let (i, share) = interval(&scene.bodies[gauge.body].places_m, gauge.place_m);
        let change = real(&between(&changes[gauge.body], i, share), factor);
        *strain = SectionState { measures: change.measures, ..moved[gauge.body][i] }.axial_strain(gauge.point_m);
    }
    found.sections = moved;
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::recording::tests::shipped;
    use foldwing_engine::beam::section::{Material, Solid};
    use foldwing_engine::machine::builder::BodyBuilder;
    use foldwing_engine::machine::{Body, Joint, Machine};
    use foldwing_engine::plant::{Holding, ModeShape, Search};
    use std::f64::consts::{FRAC_PI_2, TAU};
    use std::sync::Arc;

    /// A beam whose height is a thousandth of its length: rotary inertia lowers the third mode by `3 (βL h/L)²/24`, 8e-6.
    const LENGTH_M: f64 = 2.0;
    const HEIGHT_M: f64 = 0.002;

    fn beam(elements: usize) -> BodyBuilder {
        let plate = Solid::rectangle(0.04, HEIGHT_M, Material::isotropic(7e10, 0.3, 2700.0));
        Body::beam("beam", LENGTH_M, plate).elements(elements)
    }

    fn started(machine: Machine) -> Plant {
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        plant
    }

    /// Modes about the undeformed state, with the plant in it.
    fn bare(machine: Machine, count: usize) -> (Plant, Vec<ModeShape>) {
        let mut plant = started(machine);
        plant.study().undeformed(0.0).unwrap_or_else(|error| panic!("{error}"));
        let modes = plant.study().bare_modes(count).unwrap_or_else(|error| panic!("{error}"));
        (plant, modes)
    }

    fn cantilever(elements: usize) -> Machine {
        Machine::builder("Cantilever")
            .body(beam(elements), Joint::clamped("wall"))
            .build()
            .unwrap_or_else(|error| panic!("{error}"))
    }

    fn drawn(plant: &Plant, mode: &ModeShape) -> (Scene, Frame, DrawnMode) {
        let scene = Scene::of(plant);
        let frame = state_of(&scene, plant);
        let raw = DrawnMode {
            number: 1,
            eigenvalue_1_s: mode.eigenvalue_1_s,
            exponent_1_s: mode.eigenvalue_1_s,
            grows: false,
            words: String::new(),
            changes: vec![changes_of(&scene, plant, &mode.coordinates)],
            largest_m: 0.0,
            largest_rad: 0.0,
        };
        let mode = raw.scaled(&scene, std::slice::from_ref(&frame));
        (scene, frame, mode)
    }

    /// Deflection of a clamped-free beam at `x/L`, 1 at the end, Blevins, Formulas for Natural Frequency and Mode Shape (1979), table 8-1.
    fn deflection(beta: f64, x: f64) -> f64 {
        let sigma = (beta.sinh() - beta.sin()) / (beta.cosh() + beta.cos());
        let shape = |x: f64| (beta * x).cosh() - (beta * x).cos() - sigma * ((beta * x).sinh() - (beta * x).sin());
        shape(x) / shape(1.0)
    }

    /// MS-01. The first three bending modes of a cantilever, drawn: deflection at all sections over that of the end to 1e-3 of the closed
    /// form also in the middle of 10 pairs of elements, to 1e-5 at the ends of 20; nodes to 1e-5 and 2e-6 of the length.
    #[test]
    fn bending_modes_of_a_cantilever_have_their_closed_form() {
        for (elements, bounds) in [(10, [1e-3, 1e-5]), (20, [1e-5, 2e-6])] {
            compare_with_closed_form(elements, bounds);
        }
    }

    fn compare_with_closed_form(elements: usize, bounds: [f64; 2]) {
        let (plant, modes) = bare(cantilever(elements), 3);
        let nodes: [(f64, &[f64]); 3] =
            [(1.875_104_069, &[]), (4.694_091_133, &[0.783_444_551]), (7.854_757_438, &[0.503_547_873, 0.867_677_592])];
        for (mode, (beta, nodes)) in modes.iter().zip(nodes) {
            let (scene, _, mode) = drawn(&plant, mode);
            let places: Vec<f64> = scene.bodies[0].places_m.iter().map(|place_m| place_m / LENGTH_M).collect();
            let raised: Vec<f64> = mode.changes[0][0].iter().map(|[re, _]| re.displacement_m.z).collect();
            let tip = raised[raised.len() - 1];
            let mut worst = 0.0f64;
            for (x, z) in places.iter().zip(&raised) {
                worst = worst.max((z / tip - deflection(beta, *x)).abs());
            }
            // between sections the deflection is the cubic of deflections and rotations
            let step_m = LENGTH_M * (places[1] - places[0]);
            let slopes: Vec<f64> = mode.changes[0][0].iter().map(|[re, _]| -re.rotation_rad.y * step_m).collect();
            let between = |i: usize, t: f64| {
                let [t2, t3] = [t * t, t * t * t];
                raised[i - 1] * (2.0 * t3 - 3.0 * t2 + 1.0)
                    + slopes[i - 1] * (t3 - 2.0 * t2 + t)
                    + raised[i] * (3.0 * t2 - 2.0 * t3)
                    + slopes[i] * (t3 - t2)
            };
            let root = |i: usize| {
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..50 {
                    let middle = 0.5 * (low + high);
                    if between(i, middle) * raised[i - 1] > 0.0 { low = middle } else { high = middle }
                }
                places[i - 1] + (places[i] - places[i - 1]) * low
            };
            let found: Vec<f64> = (2..raised.len()).filter(|&i| raised[i - 1] * raised[i] < 0.0).map(root).collect();
            assert_eq!(found.len(), nodes.len(), "beta {beta}: {found:?}");
            let off = found.iter().zip(nodes).map(|(found, due)| (found - due).abs()).fold(0.0, f64::max);
            println!("MS-01 {elements} elements, beta {beta}: deflection off by {worst:.1e}, nodes by {off:.1e}");
            assert!(worst < bounds[0], "beta {beta}: {worst:.1e}");
            assert!(off < bounds[1], "beta {beta}: {found:?}");
            // at amplitude 1 the end moves by a tenth of the diagonal of the box, or the largest rotation is half a radian
            let share = tip.abs() / LENGTH_M.hypot(0.04) / LARGEST_SHARE;
            let turn = mode.largest_rad / LARGEST_ROTATION_RAD;
            assert!((share.max(turn) - 1.0).abs() < 1e-4, "{share} {turn}");
        }
    }

    /// MS-02. Modes are orthogonal over the mass matrix, which is not their own: `φᵢᵀ M φⱼ` over the geometric mean of the masses, and over
    /// the mass of the beam by integrals of the drawn deflections.
    #[test]
    fn modes_are_orthogonal_over_the_mass() {
        let (mut plant, modes) = bare(cantilever(10), 6);
        let mass = plant.study().second_order().unwrap_or_else(|error| panic!("{error}")).mass;
        let product = |i: usize, j: usize| {
            let column = |mode: &ModeShape| {
                nalgebra::DVector::from_iterator(mass.nrows(), mode.coordinates.iter().map(|x| x.re))
            };
            column(&modes[i]).dot(&(&mass * column(&modes[j])))
        };
        for i in 0..6 {
            for j in 0..i {
                let share = product(i, j).abs() / (product(i, i) * product(j, j)).sqrt();
                assert!(share < 1e-9, "modes {} and {}: {share:.1e}", i + 1, j + 1);
            }
        }
        let shapes: Vec<Vec<f64>> = (0..3)
            .map(|i| drawn(&plant, &modes[i]).2.changes[0][0].iter().map(|[re, _]| re.displacement_m.z).collect())
            .collect();
        let integral = |i: usize, j: usize| {
            let n = shapes[i].len() - 1;
            // Simpson's rule over equal intervals
            (0..=n)
                .map(|k| {
                    let weight = if k == 0 || k == n {
                        1.0
                    } else if k % 2 == 1 {
                        4.0
                    } else {
                        2.0
                    };
                    weight * shapes[i][k] * shapes[j][k]
                })
                .sum::<f64>()
        };
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let share = integral(i, j).abs() / (integral(i, i) * integral(j, j)).sqrt();
            println!("MS-02 deflections {} and {}: {share:.1e}", i + 1, j + 1);
            assert!(share < 1e-3, "{share:.1e}");
        }
    }

    /// MS-03. A rigid arm on a hinge turns as a whole: at amplitude 1 by the largest rotation or less, at any amplitude on a circle.
    #[test]
    fn a_hinge_is_a_pure_rotation() {
        let spring =
            foldwing_engine::machine::Spring { stiffness_n_m_rad: 5.0, damping_n_m_s_rad: 0.0, rest_angle_rad: 0.3 };
        let stiff = Solid::rectangle(0.1, 0.1, Material::isotropic(7e16, 0.3, 2700.0));
        let arm = Body::beam("arm", 1.5, stiff).elements(2);
        let joint =
            Joint::revolute("hinge", [0.0, 1.0, 0.0]).at_root([0.2, 0.1, 0.5]).start_angle_rad(0.3).spring(spring);
        let machine = Machine::builder("Arm").body(arm, joint).build().unwrap_or_else(|error| panic!("{error}"));
        let (plant, modes) = bare(machine, 1);
        let (scene, frame, mode) = drawn(&plant, &modes[0]);
        let hinge_m = Vector3::new(0.2, 0.1, 0.5);
        let axis = Vector3::y();
        for (section, [re, im]) in frame.sections[0].iter().zip(&mode.changes[0][0]) {
            let due = re.rotation_rad.cross(&(section.position_m - hinge_m));
            assert!((re.displacement_m - due).norm() < 1e-9 && im.displacement_m.norm() < 1e-12, "{re:?}");
            // the arm itself bends by the ratio of the stiffnesses, 1e-11
            assert!((re.rotation_rad - axis * re.rotation_rad.y).norm() < 1e-9, "{re:?}");
        }
        for amplitude in [0.1, 1.0, 3.0] {
            let angle_rad = amplitude * mode.changes[0][0][0][0].rotation_rad.y;
            let moved = displaced(&scene, &frame, &mode.changes[0], Complex::new(amplitude, 0.0), Complex::default());
            for (before, after) in frame.sections[0].iter().zip(&moved.sections[0]) {
                let due = hinge_m + rotation_about(&axis, angle_rad) * (before.position_m - hinge_m);
                assert!((after.position_m - due).norm() < 1e-8, "amplitude {amplitude}: {due} {}", after.position_m);
            }
        }
        // a tenth of the diagonal of the box is less than half a radian at 1.5 m
        assert!((mode.largest_m / size_m(&scene, &frame) - LARGEST_SHARE).abs() < 1e-12, "{mode:?}");
    }

    /// MS-04. At amplitude 1 the largest displacement that the drawn points reach over a cycle is a tenth of the size of the machine, or
    /// the largest rotation is half a radian; also of complex modes with a lifting surface.
    #[test]
    fn amplitude_one_has_its_size() {
        let mut plant = started(shipped("goland_wing"));
        plant.study().rest(0.0, Holding::AsReleased, Search::default()).unwrap_or_else(|error| panic!("{error}"));
        let modes = plant.study().modes(3).unwrap_or_else(|error| panic!("{error}"));
        for mode in &modes {
            let (scene, frame, mode) = drawn(&plant, mode);
            let mut largest_m = 0.0f64;
            for k in 0..720 {
                let phase = Complex::from_polar(1e-6, TAU * f64::from(k) / 720.0);
                let moved = displaced(&scene, &frame, &mode.changes[0], phase, Complex::default());
                for (before, after) in
                    frame.edges_m.iter().flatten().flatten().zip(moved.edges_m.iter().flatten().flatten())
                {
                    largest_m = largest_m.max((after - before).norm() * 1e6);
                }
            }
            // half a degree beside the largest, and the second order of the rotation
            assert!((largest_m / mode.largest_m - 1.0).abs() < 1e-4, "{largest_m} {}", mode.largest_m);
            let share = largest_m / size_m(&scene, &frame);
            assert!((share / LARGEST_SHARE - 1.0).abs() < 1e-4, "{share}");
        }
        // the twist of a rod moves no drawn point far: its rotation is limited
        let rod = Solid::ellipse(0.01, 0.01, Material::isotropic(7e10, 0.3, 2700.0)).with_torsional_rigidity_n_m2(1e-4);
        let machine = Machine::builder("Rod").body(Body::beam("rod", 1.0, rod).elements(4), Joint::clamped("wall"));
        let (plant, modes) = bare(machine.build().unwrap_or_else(|error| panic!("{error}")), 1);
        let (_, _, mode) = drawn(&plant, &modes[0]);
        assert!((mode.largest_rad - LARGEST_ROTATION_RAD).abs() < 1e-12 && mode.largest_m < 0.01, "{mode:?}");
    }

    /// MS-05. The drawn sections are those of the modes, which another recursion finds: at the mesh of curved, branched, folding and
    /// flying machines; the drawn motion at a small amplitude is that of the sections.
    #[test]
    fn drawn_motions_are_those_of_the_modes() {
        for name in ["curved_blade", "branched", "folding_wing_constant", "four_bar", "flying_wing", "roll_fold"] {
            let (plant, modes) = match name {
                // without an equilibrium
                "flying_wing" | "four_bar" | "roll_fold" => bare(shipped(name), 8),
                _ => {
                    let mut plant = started(shipped(name));
                    let rest = plant.study().rest(0.0, Holding::AsReleased, Search::default());
                    rest.unwrap_or_else(|error| panic!("{name}: {error}"));
                    let modes = plant.study().modes(6).unwrap_or_else(|error| panic!("{name}: {error}"));
                    (plant, modes)
                }
            };
            let places_m: Vec<Vec<f64>> = (0..plant.machine().bodies.len()).map(|body| plant.mesh_m(body)).collect();
            let still = vec![0.0; plant.freedoms().len()];
            let nothing = plant.section_changes(&still, &places_m).into_iter().flatten();
            assert!(nothing.map(|change| change.measures.norm()).all(|size| size == 0.0), "{name}: natural strain");
            for mode in &modes {
                let parts: [Vec<f64>; 2] = [|x: &Complex<f64>| x.re, |x: &Complex<f64>| x.im]
                    .map(|read| mode.coordinates.iter().map(read).collect());
                let sections = parts.map(|part| plant.section_changes(&part, &places_m));
                for (sections, nodes) in sections.iter().zip([&mode.real, &mode.imaginary]) {
                    for (section, node) in sections.iter().flatten().zip(nodes.iter().flatten()) {
                        let off_m = (section.displacement_m - node.displacement_m).norm() / mode.length_m;
                        let off_rad = (section.rotation_rad - node.rotation_rad).norm();
                        assert!(off_m < 1e-9 && off_rad < 1e-9, "{name}: {off_m:.1e} {off_rad:.1e}");
                    }
                }
                let (scene, frame, mode) = drawn(&plant, mode);
                let step = 1e-5;
                let factor = |sign: f64| Complex::from_polar(sign * step, 0.7);
                let [above, below] = [1.0, -1.0]
                    .map(|sign| displaced(&scene, &frame, &mode.changes[0], factor(sign), Complex::default()).sections);
                let changes = mode.changes[0].iter().flatten();
                for ((above, below), [re, im]) in above.iter().flatten().zip(below.iter().flatten()).zip(changes) {
                    let found = (above.position_m - below.position_m) / (2.0 * step);
                    let due = re.displacement_m * 0.7f64.cos() - im.displacement_m * 0.7f64.sin();
                    // round-off of a position over the step
                    assert!((found - due).norm() < 1e-8 * mode.largest_m.max(1.0), "{name}: {found} {due}");
                }
            }
        }
    }

    /// MS-06. A beam drawn at a large amplitude has its length, to the strain of its mode, and the sections of its parts stay at right angles.
    #[test]
    fn bodies_keep_their_length_at_any_amplitude() {
        let (plant, modes) = bare(cantilever(10), 2);
        for mode in &modes {
            let (scene, frame, mode) = drawn(&plant, mode);
            let moved = displaced(&scene, &frame, &mode.changes[0], Complex::new(3.0, 0.0), Complex::default());
            let length_m: f64 =
                moved.sections[0].windows(2).map(|pair| (pair[1].position_m - pair[0].position_m).norm()).sum();
            // chords over arcs: a linear drawing of the first mode would be 5 % longer
            assert!((length_m / LENGTH_M - 1.0).abs() < 1e-4, "{length_m}");
            let off =
                moved.sections[0].iter().map(|s| (s.rotation.transpose() * s.rotation - Matrix3::identity()).norm());
            assert!(off.fold(0.0, f64::max) < 1e-12);
        }
    }

    /// MS-07. Of a fluttering wing, bending and twist have the phase of the eigenvector in the drawn cycle: the first harmonic of the drawn
    /// end, at a small amplitude, against the components of the mode at its mesh.
    #[test]
    fn bending_and_twist_have_the_phase_of_the_eigenvector() {
        let mut plant = started(shipped("goland_wing"));
        *plant.inputs_mut().wind_m_s_mut() = Vector3::new(0.0, -140.0, 0.0);
        plant.study().rest(0.0, Holding::AsReleased, Search::default()).unwrap_or_else(|error| panic!("{error}"));
        let modes = plant.study().modes(4).unwrap_or_else(|error| panic!("{error}"));
        let mode = modes.iter().find(|mode| mode.grows()).unwrap_or_else(|| panic!("no mode grows at 140 m/s"));
        let last = mode.real[0].len() - 1;
        let at = |read: fn(&foldwing_engine::plant::NodeMotion) -> f64| {
            Complex::new(read(&mode.real[0][last]), read(&mode.imaginary[0][last]))
        };
        let due = at(|node| node.displacement_m.z) / at(|node| node.rotation_rad.x);
        let (scene, frame, drawn) = drawn(&plant, mode);
        let (mut bending, mut twist) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
        for k in 0..48 {
            let phase = Complex::from_polar(1.0, TAU * f64::from(k) / 48.0);
            let moved = displaced(&scene, &frame, &drawn.changes[0], phase * 1e-4, Complex::default());
            let (section, before) = (moved.sections[0].last().unwrap(), frame.sections[0].last().unwrap());
            bending += phase.conj() * (section.position_m.z - before.position_m.z);
            let turned = section.rotation * before.rotation.transpose();
            twist += phase.conj() * (0.5 * (turned[(2, 1)] - turned[(1, 2)]));
        }
        let found = bending / twist;
        println!(
            "MS-07 phase of bending before twist {:.3} deg, of the eigenvector {:.3} deg",
            found.arg().to_degrees(),
            due.arg().to_degrees()
        );
        assert!((found / due - 1.0).norm() < 1e-6, "{found} {due}");
        // far from both in and out of phase: what makes the flutter
        assert!(due.arg().abs() > 0.2 && due.arg().abs() < FRAC_PI_2 + 1.2, "{due}");
    }

    /// Conjugate pairs are drawn once, also of a rotor that turns: every mode of the shipped machines has its own eigenvalue in the upper
    /// half plane.
    #[test]
    fn conjugate_pairs_are_drawn_once() {
        let mut plant = started(shipped("goland_wing"));
        plant.study().rest(0.0, Holding::AsReleased, Search::default()).unwrap_or_else(|error| panic!("{error}"));
        let modes = plant.study().modes(8).unwrap_or_else(|error| panic!("{error}"));
        for (i, mode) in modes.iter().enumerate() {
            assert!(mode.eigenvalue_1_s.im >= 0.0, "{}", mode.eigenvalue_1_s);
            for other in &modes[..i] {
                let apart = (mode.eigenvalue_1_s - other.eigenvalue_1_s).norm();
                assert!(apart > 1e-6 * mode.eigenvalue_1_s.norm(), "{}", mode.eigenvalue_1_s);
            }
        }
    }
}
