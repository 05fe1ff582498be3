//! Modes as motions of the recorded sections, for the page and the VTK files: complex displacements and rotations about a state, and the
//! model displaced by a mode of some amplitude.
//!
//! Rotations are finite: a section rotates by its rotation vector, and its position follows by integration along the rotated axis from the
//! inner end. Bodies therefore keep their lengths at any amplitude, and the motion at small amplitudes is that of the linear mode.

use crate::report::recording::{Frame, Scene};
use foldwing_engine::math::so3::rotation_about;
use foldwing_engine::plant::{Plant, SectionChange, SectionState};
use nalgebra::{Complex, Matrix3, Vector3};

/// Largest displacement of a mode at amplitude 1, relative to the diagonal of the box around the model.
pub const LARGEST_SHARE: f64 = 0.1;
/// Largest rotation at amplitude 1 in rad; it limits the displacement of motions that are mainly rotations.
pub const LARGEST_ROTATION_RAD: f64 = 0.5;

/// Changes of the sections of all bodies about one state: real and imaginary parts.
pub type Changes = Vec<Vec<[SectionChange; 2]>>;

/// Mode in drawable form. Its motion about the state is `Re(changes · exp(λ t))`, where `λ` is `exponent_1_s`.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnMode {
    /// Number of the mode in the tables of the command.
    pub number: usize,
    /// Eigenvalue in 1/s, which gives frequency and damping.
    pub eigenvalue_1_s: Complex<f64>,
    /// Exponent of the motion in 1/s: the eigenvalue, or for a periodic motion the principal exponent.
    pub exponent_1_s: Complex<f64>,
    /// Whether the motion grows.
    pub grows: bool,
    /// Description of the deformation, and name of the mode.
    pub words: String,
    /// Motion at amplitude 1 about each frame of the state.
    pub changes: Vec<Changes>,
    /// Largest displacement of the drawn points in m at amplitude 1.
    pub largest_m: f64,
    /// Largest rotation in rad at amplitude 1.
    pub largest_rad: f64,
}

/// State with its modes.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnState {
    /// Value of the quantity that varies over the states.
    pub value: f64,
    /// Event at this state; usually empty.
    pub words: String,
    /// The state; for a periodic motion the samples of a revolution and its end, about which no motion is stored.
    pub frames: Vec<Frame>,
    /// Period of the revolution in s.
    pub period_s: Option<f64>,
    /// Modes; `None` where one was not found.
    pub modes: Vec<Option<DrawnMode>>,
}

/// Modes about one or more states of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Shapes {
    /// Constant parts of the model.
    pub scene: Scene,
    /// Title of the page below the name.
    pub title: String,
    /// Name and unit of the quantity that varies over the states; `None` for a single state.
    pub quantity: Option<[&'static str; 2]>,
    /// The states.
    pub states: Vec<DrawnState>,
}

/// Current state of a plant about which modes are drawn, without wake and circulation, which modes do not have.
pub fn state_of(scene: &Scene, plant: &Plant) -> Frame {
    let mut frame = Frame::of(scene, plant);
    frame.lattice.clear();
    frame.acting.circulation_m2_s.clear();
    frame
}

/// Motion of the drawn sections about the current state of a plant, for changes of its free coordinates of any size.
pub fn changes_of(scene: &Scene, plant: &Plant, coordinates: &[Complex<f64>]) -> Changes {
    let places_m: Vec<Vec<f64>> = scene.bodies.iter().map(|body| body.places_m.clone()).collect();
    let part = |read: fn(&Complex<f64>) -> f64| {
        plant.section_changes(&coordinates.iter().map(read).collect::<Vec<f64>>(), &places_m)
    };
    let (real, imaginary) = (part(|x| x.re), part(|x| x.im));
    real.into_iter().zip(imaginary).map(|(re, im)| re.into_iter().zip(im).map(|(re, im)| [re, im]).collect()).collect()
}

impl DrawnMode {
    /// Scales the motion to amplitude 1 about the frames of its state: its largest displacement is [`LARGEST_SHARE`] of the model's size,
    /// or less if its largest rotation would exceed [`LARGEST_ROTATION_RAD`].
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

/// Displacement of a point at a distance vector from the axis.
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

/// Interval of ascending positions that contains a position, and the fraction of the interval before it.
fn interval(places_m: &[f64], place_m: f64) -> (usize, f64) {
    if places_m.len() < 2 {
        return (0, 0.0);
    }
    let i = places_m.partition_point(|other| *other <= place_m).clamp(1, places_m.len() - 1) - 1;
    (i, ((place_m - places_m[i]) / (places_m[i + 1] - places_m[i])).clamp(0.0, 1.0))
}

/// Interpolates the change between two sections.
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

/// Interpolates position and axes between two sections.
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

/// The model displaced by a mode: `factor` is the complex amplitude, `a e^{iθ}` for amplitude `a` and phase `θ`, and `rate_1_s` its
/// logarithmic time derivative, for velocities. Strain measures are those of the mode alone, without those of the state.
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
#[path = "shapes_tests.rs"]
mod tests;
