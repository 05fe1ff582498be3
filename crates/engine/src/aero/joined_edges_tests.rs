//! Tests of edges that are joined.

use super::*;
use crate::aero::lattice::{LatticeOptions, LoadRule};
use crate::aero::surface::{Profile, Surface};
use crate::aero::test_lattices::{chord, flow, options, section};
use crate::load::Wrench;
use nalgebra::{Matrix3, Rotation3};

/// Two adjacent wings in sideslip, whose common edges count as one or as one to a share. The loads do not depend on the order in which the
/// edges or the wings are given.
#[test]
fn neither_body_of_a_joint_is_the_first() {
    let outwards_m = [[-2.0, -1.0, 0.0], [0.0, 1.0, 2.0]];
    for raised_m in [0.1, 1.0] {
        let loads = |wings: [usize; 2], edges_swapped: bool| {
            let motions = wings.map(|wing| {
                // one wing is higher and has another incidence: otherwise they would be mirror images
                let [height_m, pitch_rad] = if wing == 0 { [0.0, 0.0] } else { [raised_m, 0.05] };
                outwards_m[wing].map(|x| section(Vector3::new(x, 0.0, height_m), pitch_rad)).to_vec()
            });
            // the outer edge of the left wing and the inner edge of the right wing
            let mut edges = [0, 1].map(|surface| Edge { surface, outer: wings[surface] == 0 });
            if edges_swapped {
                edges.swap(0, 1);
            }
            let loads =
                loads_of(&motions, Vector3::new(4.0, -10.0, 1.0), (None, CORE_M), |lattice| lattice.join(edges));
            let of = |wing: usize| {
                let first = 3 * usize::from(wings[0] != wing);
                loads[first..first + 3].to_vec()
            };
            [of(0), of(1)].concat()
        };
        let expected = loads([0, 1], false);
        for (wings, edges_swapped) in [([0, 1], true), ([1, 0], false), ([1, 0], true)] {
            let off = largest_difference(&loads(wings, edges_swapped), &expected);
            assert!(off < 1e-11, "{raised_m} m, {wings:?}, {edges_swapped}: {off:e}");
        }
    }
}

/// A left and a right wing of strips of 1 m with a joint at `x = 0`, the right one at a height and an incidence, in rigid motion.
fn apart(
    height_m: f64,
    pitch_rad: f64,
    [velocity_m_s, spin_rad_s]: [Vector3<f64>; 2],
) -> (VortexLattice, LatticeState, Vec<SectionMotion>) {
    let surface = |first: usize| Surface {
        sections: first..first + 3,
        chords: vec![chord(); 3],
        chord_panels: 2,
        profile: Profile::THIN,
    };
    let mut lattice = VortexLattice::new(vec![surface(0), surface(3)], options());
    lattice.join([Edge { surface: 0, outer: true }, Edge { surface: 1, outer: false }]);
    let wings = [([-2.0, -1.0, 0.0], 0.0, 0.0), ([0.0, 1.0, 2.0], height_m, pitch_rad)];
    let motions: Vec<SectionMotion> = (wings.iter())
        .flat_map(|&(outwards_m, height_m, pitch_rad)| {
            outwards_m.map(|x| section(Vector3::new(x + 0.2 * height_m, 0.0, height_m), pitch_rad))
        })
        .map(|still| SectionMotion {
            velocity_m_s: velocity_m_s + spin_rad_s.cross(&still.position_m),
            spin_rad_s,
            ..still
        })
        .collect();
    let mut state = lattice.blank_state();
    state.wake_rows = 1;
    lattice.place(&motions, Some((&flow(Vector3::new(0.0, -10.0, 0.0)), 0.1)), &mut state);
    (lattice, state, motions)
}

/// Loads by the rule of Kutta and Joukowski, a surface for each list of sections.
fn loads_of(
    wings: &[Vec<SectionMotion>],
    wind_m_s: Vector3<f64>,
    (mirror_normal, core_radius_m): (Option<Vector3<f64>>, f64),
    join: impl Fn(&mut VortexLattice),
) -> Vec<Wrench> {
    let surfaces = (wings.iter().enumerate()).map(|(at, wing)| Surface {
        sections: at * wing.len()..(at + 1) * wing.len(),
        chords: vec![chord(); wing.len()],
        chord_panels: 3,
        profile: Profile::THIN,
    });
    let options =
        LatticeOptions { wake_rows: 5, core_radius_m, load_rule: LoadRule::KuttaJoukowski, mirror_normal, ..options() };
    let mut lattice = VortexLattice::new(surfaces.collect(), options);
    join(&mut lattice);
    let motions = wings.concat();
    let (mut state, mut loads) = (lattice.blank_state(), AirLoads::still(motions.len()));
    lattice.start(&motions, &flow(wind_m_s), None, &mut state, &mut loads).unwrap();
    loads.circulatory
}

/// Largest difference of forces and moments, relative to the largest force.
fn largest_difference(loads: &[Wrench], expected: &[Wrench]) -> f64 {
    let largest_n = expected.iter().map(|load| load.force_n.norm()).fold(0.0, f64::max);
    let off = |(own, expected): (&Wrench, &Wrench)| {
        (own.force_n - expected.force_n).norm() + (own.moment_n_m - expected.moment_n_m).norm()
    };
    loads.iter().zip(expected).map(off).fold(0.0, f64::max) / largest_n
}

/// The right wing of three sections with a dihedral angle and an incidence, whose inner edge is at a distance from the plane `x = 0`,
/// and its mirror image as a left wing.
fn halves(from_plane_m: f64) -> [Vec<SectionMotion>; 2] {
    let mirror = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0));
    let dihedral = Rotation3::from_axis_angle(&-Vector3::y_axis(), 0.3_f64.atan()).into_inner();
    let right = [0.0, 1.0, 2.0].map(|x| {
        let still = section(Vector3::new(x + from_plane_m, 0.0, 0.3 * x), 0.2);
        SectionMotion { rotation: dihedral * still.rotation, ..still }
    });
    let left = right.map(|section| SectionMotion {
        rotation: mirror * section.rotation * mirror,
        position_m: mirror * section.position_m,
        ..section
    });
    [left.into_iter().rev().collect(), right.to_vec()]
}

const WIND_M_S: Vector3<f64> = Vector3::new(0.0, -10.0, 1.0);
const CORE_M: f64 = 1e-3;
const INNER: [Edge; 2] = [Edge { surface: 0, outer: true }, Edge { surface: 1, outer: false }];

/// A half wing joined to its image has the loads of the right one of two halves, whether their edges count as one, as two, or as both to
/// a share.
#[test]
fn an_image_is_the_other_half() {
    for apart_strips in [0.0, 0.3, 0.9, 1.1, 1.5] {
        let [left, right] = halves(0.5 * apart_strips * 1.09_f64.sqrt());
        let two = loads_of(&[left, right.clone()], WIND_M_S, (None, CORE_M), |lattice| lattice.join(INNER));
        let one = loads_of(&[right], WIND_M_S, (Some(Vector3::x()), CORE_M), |lattice| {
            lattice.join_image(Edge { surface: 0, outer: false });
        });
        let off = largest_difference(&one, &two[3..]);
        assert!(off < 1e-10, "{apart_strips}: {off:e}");
    }
}

/// The loads are continuous where edges start to count as two and where they end to count as one. Between these distances the lines of
/// both approach each other without limit; to the share to which they are one they induce nothing on each other.
#[test]
fn loads_are_continuous_where_edges_part() {
    let loads = |apart_strips: f64| {
        let wings = halves(0.5 * apart_strips * 1.09_f64.sqrt());
        // thinner than the lines are apart 4e-3 strips beyond the first border: 0.25 mm
        loads_of(&wings, WIND_M_S, (None, 1e-6), |lattice| lattice.join(INNER))
    };
    for border in MERGED_STRIPS {
        // second differences, which fall with the square of the distance unless the loads jump
        let [coarse, fine] = [8e-3, 4e-3].map(|strips| {
            let [before, at, beyond] = [-strips, 0.0, strips].map(|strips| loads(border + strips));
            let expected: Vec<Wrench> = (before.iter().zip(&beyond))
                .map(|(one, other)| Wrench {
                    force_n: 0.5 * (one.force_n + other.force_n),
                    moment_n_m: 0.5 * (one.moment_n_m + other.moment_n_m),
                })
                .collect();
            largest_difference(&at, &expected)
        });
        // 1.8e-4 of the largest force at 4e-3 strips, four times that at 8e-3
        assert!(coarse < 2e-3 && fine < coarse / 3.0, "{border}: {coarse:e}, {fine:e}");
    }
}

/// Edges up to 0.8 strips apart lie in the middle, from 1.2 strips on each lies on its own wing; in between they move towards each other
/// by the share, with the point where the wake starts.
#[test]
fn edges_lie_in_the_middle_as_far_as_they_are_close() {
    for (apart_strips, share) in [(0.3, 1.0), (0.79, 1.0), (1.0, 0.5), (1.21, 0.0)] {
        let apart_m = apart_strips / 1.04_f64.sqrt(); // the height: a fifth of it lies along the span
        let (lattice, state, _) = apart(apart_m, 0.0, [Vector3::zeros(); 2]);
        let [left, right] = [(0, 2), (1, 0)].map(|(surface, column)| {
            let bound: Vec<f64> = (0..=3).map(|row| lattice.corner_m(&state, surface, row, column).z).collect();
            let wake_z = state.wake_node_m[lattice.wake[surface].node(0, column)].z;
            let edge_z = state.edge_m[lattice.wake[surface].node(0, column)].z;
            [&bound[..], &[wake_z, edge_z]].concat()
        });
        for (left, right) in left.iter().zip(&right) {
            assert!((left - 0.5 * share * apart_m).abs() < 1e-12, "{apart_m}: {left}");
            assert!((right - (1.0 - 0.5 * share) * apart_m).abs() < 1e-12, "{apart_m}: {right}");
        }
        // the other corners are those of the wings
        assert!(lattice.corner_m(&state, 1, 0, 1).z == apart_m && lattice.corner_m(&state, 0, 0, 1).z == 0.0);
    }
}

/// In a rigid motion of both wings the corners and the panels at joined edges have the velocities of that motion, and collocation points
/// stay on the planes of their panels, in the middle between the lines of the strip.
#[test]
fn joined_edges_move_with_the_wings() {
    let motion = [Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, -0.7, 1.1)];
    let rigid_m_s = |point_m: &Vector3<f64>| motion[0] + motion[1].cross(point_m);
    for height_m in [0.3, 1.0] {
        let (lattice, state, motions) = apart(height_m, 0.2, motion);
        for (surface, column) in [(0, 2), (1, 0)] {
            for row in 0..=2 {
                let node = lattice.bound[surface].node(row, column);
                let off_m_s = lattice.corner_velocity_m_s[node] - rigid_m_s(&state.corner_m[node]);
                assert!(off_m_s.norm() < 1e-12, "{height_m}, {surface}, {row}: {off_m_s}");
            }
            let end = lattice.wake[surface].node(0, column);
            assert!((state.edge_m_s[end] - rigid_m_s(&state.edge_m[end])).norm() < 1e-12);
        }
        for (surface, strip, plane) in [(0, 1, 1), (1, 0, 4)] {
            for row in 0..2 {
                let ring = lattice.bound[surface].ring(row, strip);
                let point_m = state.collocation_m[ring];
                assert!((state.surface_m_s[ring] - rigid_m_s(&point_m)).norm() < 1e-12, "{height_m}, {surface}");
                let normal = motions[plane].rotation * Vector3::z();
                assert!(normal.dot(&(point_m - motions[plane].position_m)).abs() < 1e-12, "{height_m}, {surface}");
                let corner_m = |row, column| lattice.corner_m(&state, surface, row, column);
                if height_m < 0.8 && row == 0 {
                    let middle_m: Vector3<f64> = [(0, strip), (0, strip + 1), (1, strip), (1, strip + 1)]
                        .map(|(row, at)| corner_m(row, at))
                        .iter()
                        .sum();
                    let off_m = normal.cross(&(0.25 * middle_m - point_m));
                    assert!(off_m.norm() < 1e-12, "{surface}: {off_m}");
                }
                let panel = 2 * 2 * surface + 2 * row + strip;
                assert_eq!(lattice.points[panel / LANES].get(panel % LANES), point_m);
            }
        }
    }
}

/// A wing that folds over the strip of the other one overlaps it, however far apart the edges are; one that ends above it does not.
#[test]
fn sheets_that_overlap_are_found() {
    let overlap_m = |shift_m: f64, fold_rad: f64, raised_m: f64| {
        let (mut lattice, mut state, mut motions) = apart(0.0, 0.0, [Vector3::zeros(); 2]);
        for (column, motion) in motions[3..].iter_mut().enumerate() {
            let along = Vector3::new(fold_rad.cos(), 0.0, fold_rad.sin());
            motion.position_m = Vector3::new(-shift_m, 0.0, raised_m) + along * column as f64;
        }
        lattice.place(&motions, None, &mut state);
        lattice.crossed_edges.map(|crossed| (crossed.surfaces, crossed.depth_m))
    };
    // the right wing rises from below the left one, 1.5 and 1.9 strips inside of its edge
    for shift_m in [1.5, 1.9] {
        let (surfaces, depth_m) = overlap_m(shift_m, 1.0, -0.2).expect("an overlap");
        assert_eq!(surfaces, [0, 1]);
        assert!((depth_m - (shift_m - 0.2 / 1f64.tan())).abs() < 1e-12, "{depth_m}");
    }
    // it passes through the left one with its second strip
    let (_, depth_m) = overlap_m(1.9, 1.0, -1.0).expect("an overlap");
    assert!((depth_m - (1.9 - 1.0 / 1f64.tan())).abs() < 1e-12, "{depth_m}");
    assert_eq!(overlap_m(0.5, 1.0, -0.2), None, "merged");
    assert_eq!(overlap_m(1.5, 1.0, 0.2), None, "above");
    assert_eq!(overlap_m(-1.5, 1.0, -0.2), None, "beside");
}
