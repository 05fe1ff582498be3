//! Edges of lifting surfaces: free edges, edges continued by another surface or the mirror, and their speed at the start.

use crate::aero::surface::ChordLine;
use crate::force::prescribed::Law;
use crate::machine::pose::{along, first_frames};
use crate::machine::{Body, JointMotion, LiftingSurface, Parent};
use nalgebra::{Matrix3, Vector3};

/// Distance, relative to a body's length or to a chord, below which two positions coincide.
const NEAR: f64 = 1e-9;

/// Distance of two inner edges attached to one point, relative to the chord, up to which they are those of two halves of one wing. With a
/// dihedral, an incidence and the axis at half chord they part by the product of the sines of both angles: 0.1 is 20 and 17 degrees.
const HALVES: f64 = 0.1;

/// Distance in chords up to which edges that are attached to one point and not joined may be meant as those of halves of one wing.
const CLOSE: f64 = 0.5;

/// Speed of an edge relative to the air, divided by the speeds of both, below which they move together.
const REST_SHARE: f64 = 1e-9;

/// Inner edge of a surface.
pub(crate) struct RootEdge {
    /// Body that carries the surface.
    pub body: usize,
    /// Chord at the edge, section frame.
    pub chord: ChordLine,
}

/// Whether the lattice of a body has a free edge at its inner and at its outer end.
///
/// An edge is continued if a child with a surface is attached to the outer end, or if the inner end is attached to such an end. Surfaces
/// whose inner ends are attached to one point (two halves of a wing on the root or on a keel) continue each other if their edges are within
/// a tenth of a chord at the start, because parts attached to one point stay together. A mirror plane through the inner end also continues
/// it. Edges that are only close at the start, such as those of a wing that is folded flat, are free, and so are those at a prismatic joint,
/// whose surface can move away.
pub(crate) fn free_edges(body: usize, edges: &[RootEdge], bodies: &[Body], mirror: Option<Vector3<f64>>) -> [bool; 2] {
    let has_surface = |body: usize| edges.iter().any(|edge| edge.body == body);
    let at_end = |parent: usize, position_m: f64| position_m >= bodies[parent].length_m * (1.0 - NEAR);
    let goes_on = bodies.iter().enumerate().any(|(child, described)| match described.joint.parent {
        Parent::Body { index, position_m } => {
            index == body && at_end(index, position_m) && has_surface(child) && !slides(child, bodies)
        }
        Parent::Root { .. } => false,
    });
    let hangs_on_end = match bodies[body].joint.parent {
        Parent::Root { .. } => false,
        Parent::Body { index, position_m } => has_surface(index) && at_end(index, position_m) && !slides(body, bodies),
    };
    let held = hangs_on_end
        || mirror.is_some_and(|normal| stands_on(&normal, body, bodies))
        || other_half(body, edges, bodies).is_some();
    [!held, !goes_on]
}

/// Body of the other surface whose inner edge is attached to the same point and is nearest at the start, within [`HALVES`].
pub(crate) fn other_half(body: usize, edges: &[RootEdge], bodies: &[Body]) -> Option<usize> {
    let (other, apart) = nearest_edge(body, edges, bodies)?;
    (apart <= HALVES).then_some(other)
}

/// Body of the other surface whose inner edge is attached to the same point and is nearest at the start, and its distance in chords, if it
/// is not joined but within [`CLOSE`]: a slit that may not be intended.
pub(crate) fn slit(body: usize, edges: &[RootEdge], bodies: &[Body]) -> Option<(usize, f64)> {
    nearest_edge(body, edges, bodies).filter(|(_, apart)| *apart > HALVES && *apart <= CLOSE)
}

/// Body of the other surface whose inner edge is attached to the same point and is nearest at the start, and its distance in chords.
fn nearest_edge(body: usize, edges: &[RootEdge], bodies: &[Body]) -> Option<(usize, f64)> {
    let others = edges.iter().filter(|edge| edge.body != body);
    let distances = others.filter_map(|edge| Some((edge.body, distance_chords(body, edge, edges, bodies)?)));
    distances.min_by(|one, two| one.1.total_cmp(&two.1))
}

/// Whether the inner end of a body lies on a plane through the origin and remains there.
pub(crate) fn stands_on(normal: &Vector3<f64>, body: usize, bodies: &[Body]) -> bool {
    if slides(body, bodies) {
        return false;
    }
    let mut holder = &bodies[body].joint.parent;
    while let Parent::Body { index, .. } = holder {
        if !bodies[*index].joint.kind.is_rigid() {
            return false;
        }
        holder = &bodies[*index].joint.parent;
    }
    let position_m = match bodies[body].joint.parent {
        Parent::Root { position_m } => position_m,
        Parent::Body { index, position_m } => {
            let firsts = first_frames(bodies, |joint| joint.start_angle_rad);
            along(&bodies[index], &firsts[index], position_m).position_m
        }
    };
    normal.dot(&position_m).abs() <= NEAR * bodies[body].length_m
}

/// Largest distance in chords, at the leading or the trailing edge, of the inner edges of two surfaces at the start; `None` if they are not
/// attached to one point.
fn distance_chords(body: usize, other: &RootEdge, edges: &[RootEdge], bodies: &[Body]) -> Option<f64> {
    let own = edges.iter().find(|edge| edge.body == body)?;
    if slides(body, bodies) || slides(other.body, bodies) {
        return None;
    }
    let ((place, attitude), (other_place, other_attitude)) = (hold(body, bodies), hold(other.body, bodies));
    let same_place = match (&place, &other_place) {
        (Parent::Root { position_m: a }, Parent::Root { position_m: b }) => {
            (a - b).norm() <= NEAR * bodies[body].length_m
        }
        (Parent::Body { index: a, position_m: s }, Parent::Body { index: b, position_m: t }) => {
            a == b && (s - t).abs() <= NEAR * bodies[*a].length_m
        }
        (Parent::Root { .. } | Parent::Body { .. }, Parent::Root { .. } | Parent::Body { .. }) => false,
    };
    let apart_m = |point: fn(&ChordLine) -> Vector3<f64>| {
        (attitude * point(&own.chord) - other_attitude * point(&other.chord)).norm()
    };
    let chord_m = 0.5 * (own.chord.length_m() + other.chord.length_m());
    same_place.then(|| apart_m(|chord| chord.leading_m).max(apart_m(|chord| chord.trailing_m)) / chord_m)
}

/// Point to which the inner end of a body is attached, and the body's initial attitude in the frame there. If the parent's inner end is at
/// the same point, this is the point to which the parent is attached.
fn hold(body: usize, bodies: &[Body]) -> (Parent, Matrix3<f64>) {
    let joint = &bodies[body].joint;
    let fold = joint.kind.one_freedom().map(|(travel, own)| travel.moved(&own.axis, own.start_angle_rad).1);
    let attitude = fold.unwrap_or_else(Matrix3::identity) * joint.mount;
    match &joint.parent {
        Parent::Body { index, position_m }
            if *position_m <= NEAR * bodies[*index].length_m && stays(*index, bodies) =>
        {
            let (place, holder) = hold(*index, bodies);
            (place, holder * attitude)
        }
        place @ (Parent::Root { .. } | Parent::Body { .. }) => (place.clone(), attitude),
    }
}

/// Whether a body can translate along its joint's axis.
fn slides(body: usize, bodies: &[Body]) -> bool {
    bodies[body].joint.kind.slides()
}

/// Whether the inner end of a body stays at its joint: all joints except free and prismatic ones.
fn stays(body: usize, bodies: &[Body]) -> bool {
    bodies[body].joint.kind.holds_place()
}

/// Speed in m/s of the fastest point of the trailing edges relative to the air at the start, with the root frame at rest; `None` without
/// relative motion.
pub(crate) fn fastest_m_s(
    surfaces: &[LiftingSurface],
    bodies: &[Body],
    wind_m_s: Vector3<f64>,
    start_s: f64,
) -> Option<f64> {
    let firsts = first_frames(bodies, |joint| joint.start_angle_rad);
    let mut motions: Vec<[Vector3<f64>; 2]> = Vec::with_capacity(bodies.len());
    for (body, first) in bodies.iter().zip(&firsts) {
        let (mut velocity_m_s, mut spin_rad_s, mut attitude) =
            (Vector3::zeros(), Vector3::zeros(), Matrix3::identity());
        if let Parent::Body { index, position_m } = body.joint.parent {
            let [inner_m_s, inner_rad_s]: [Vector3<f64>; 2] = motions[index];
            velocity_m_s = inner_m_s + inner_rad_s.cross(&(first.position_m - firsts[index].position_m));
            (spin_rad_s, attitude) = (inner_rad_s, along(&bodies[index], &firsts[index], position_m).attitude);
        }
        if let Some((travel, joint)) = body.joint.kind.one_freedom() {
            let rate = match &joint.motion {
                JointMotion::Free if joint.release => joint.start_rate_rad_s,
                JointMotion::Free | JointMotion::Locked => 0.0,
                JointMotion::Prescribed(motion) => Law::new(motion).at(start_s)[1],
            };
            let [along_m_s, about_rad_s] = travel.moving(&(attitude * joint.axis), rate);
            velocity_m_s += along_m_s;
            spin_rad_s += about_rad_s;
        }
        if let Some(joint) = body.joint.kind.spatial() {
            velocity_m_s += joint.start_velocity_m_s;
            spin_rad_s += attitude * joint.start_angular_velocity_rad_s;
        }
        motions.push([velocity_m_s, spin_rad_s]);
    }
    let (mut fastest_m_s, mut frame_m_s) = (0.0_f64, wind_m_s.norm());
    for surface in surfaces {
        let (first, [velocity_m_s, spin_rad_s]) = (&firsts[surface.body], motions[surface.body]);
        for (position_m, chord) in surface.positions_m.iter().zip(&surface.chords) {
            let section = along(&bodies[surface.body], first, *position_m);
            let edge_m = section.position_m + section.attitude * chord.trailing_m;
            let edge_m_s = velocity_m_s + spin_rad_s.cross(&(edge_m - first.position_m));
            fastest_m_s = fastest_m_s.max((wind_m_s - edge_m_s).norm());
            frame_m_s = frame_m_s.max(edge_m_s.norm());
        }
    }
    (fastest_m_s > REST_SHARE * frame_m_s).then_some(fastest_m_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::section::{Material, Solid};
    use crate::machine::{Joint, Machine};

    /// An edge is continued, on both sides of the joint, if a surface is attached to its parent's outer end, for any lengths; elsewhere
    /// along the parent, and if one of the two has no surface, the edges are free.
    #[test]
    fn surfaces_go_on_at_the_outer_end_of_the_parent() {
        let plate = Solid::rectangle(0.1, 0.01, Material::isotropic(7e10, 0.3, 2700.0));
        let body = |name: &str, length_m: f64| Body::beam(name, length_m, plate).elements(1);
        let chord = ChordLine { leading_m: Vector3::new(0.0, 0.1, 0.0), trailing_m: Vector3::new(0.0, -0.1, 0.0) };
        let lengths_m = [0.3, 1.0, 2.5];
        for (inner_m, outer_m) in lengths_m.iter().flat_map(|inner| lengths_m.map(|outer| (*inner, outer))) {
            for place_m in [0.2, 0.3, 0.6, 1.0, 2.0, 2.5].into_iter().filter(|place_m| *place_m <= inner_m) {
                let fold = Joint::revolute("fold", [0.0, 1.0, 0.0]).on_at("inner", place_m);
                let machine = Machine::builder("Wing")
                    .body(body("inner", inner_m), Joint::clamped("mount"))
                    .body(body("outer", outer_m), fold)
                    .build()
                    .unwrap_or_else(|refused| panic!("{refused}"));
                for (surfaces, joined) in [(vec![0, 1], place_m == inner_m), (vec![0], false), (vec![1], false)] {
                    let edges: Vec<_> = surfaces.iter().map(|&body| RootEdge { body, chord }).collect();
                    let free = [0, 1].map(|body| free_edges(body, &edges, &machine.bodies, None));
                    let at = format!("{outer_m} m at {place_m} of {inner_m} m, surfaces on {surfaces:?}");
                    if surfaces.contains(&0) {
                        assert_eq!(free[0], [true, !joined], "{at}");
                    }
                    if surfaces.contains(&1) {
                        assert_eq!(free[1], [!joined, true], "{at}");
                    }
                }
            }
        }
    }
}
