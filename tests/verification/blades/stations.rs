//! WT-30 to WT-33: a beam whose sections and axis are given as tables.

use crate::blades::blade::{description, errors, reference, solve};
use crate::static_newton::assert_order;
use foldwing::beam::axis::Axis;
use foldwing::beam::element::ElementKind::{Constant, Linear};
use foldwing::beam::law::{NaturalStrain, SectionLaw, SectionStation};
use foldwing::beam::section::Section;
use foldwing::config;
use foldwing::multibody::model::BodyDescription;
use nalgebra::{Matrix4, Matrix6, Rotation3, Vector3, Vector4};

const LENGTH_M: f64 = 1.2;

fn section(stiffness: Matrix4<f64>) -> Section {
    Section {
        shear: None,
        stiffness,
        mass_kg_m: 1.0,
        first_moment_kg: [0.0; 2],
        second_moment_kg_m: [1e-3, 0.0, 1e-3],
        half_width_m: 0.1,
        half_height_m: 0.05,
    }
}

/// Stiffness with bend–twist coupling at five stations; its factor falls, rises and falls again.
fn rows() -> Vec<SectionStation> {
    let row = |share: f64, factor: f64| {
        let mut stiffness = Matrix4::from_diagonal(&Vector4::new(90.0, 1.6, 1.3, 2.8)) * factor;
        (stiffness[(1, 2)], stiffness[(2, 1)]) = (0.3 * factor * factor, 0.3 * factor * factor);
        SectionStation { position_m: share * LENGTH_M, section: section(stiffness) }
    };
    [(0.0, 1.0), (0.25, 0.6), (0.5, 0.8), (0.75, 0.5), (1.0, 0.3)].map(|(share, factor)| row(share, factor)).to_vec()
}

fn stiffness(s: f64) -> Matrix4<f64> {
    let rows = rows();
    let piece = ((4.0 * s / LENGTH_M) as usize).min(3);
    let share = 4.0 * s / LENGTH_M - piece as f64;
    rows[piece].section.stiffness * (1.0 - share) + rows[piece + 1].section.stiffness * share
}

/// WT-30. Sections in a table with kinks at its stations: pairs whose ends coincide with the stations converge with fourth order; if a
/// station lies inside an element, the integrals are still exact and the error converges at least with the second order that a kink in the
/// strain permits.
#[test]
fn wt30_order_of_a_table() {
    let force = Vector3::new(0.05, -0.1, 0.2);
    let exact = reference(LENGTH_M, &stiffness, &|_| [0.0; 3], &force, 4);
    let body = description(LENGTH_M, SectionLaw::Table(rows()), [0.0; 4].into());
    for (kind, meshes, least, most) in [(Linear, [4, 8, 16], 3.6, 4.5), (Constant, [16, 32, 64], 1.8, 2.2)] {
        let found = meshes.map(|n| errors(LENGTH_M, &solve(&body, (kind, n), &force, 4), &exact));
        for (i, what) in ["tip", "rotation"].iter().enumerate() {
            assert_order(&format!("WT-30 {kind:?} {what}"), &found.map(|errors| errors[i]), least, most);
        }
    }
    let astride = [5, 10, 20].map(|n| if n % 4 == 0 { n + 1 } else { n });
    let found = astride.map(|n| errors(LENGTH_M, &solve(&body, (Linear, n), &force, 4), &exact)[0]);
    println!("WT-30 stations inside elements: {found:?} at {astride:?} pairs");
    assert!(found[2] < found[0] / 8.0 && found[2] < 1e-4, "{found:?}");
}

/// WT-31. A body's axis given as a table: the tip of a bent, twisted blade is at the position in the table, to fourth order for pairs.
#[test]
fn wt31_axis_in_a_table() {
    let count = 60;
    let stations_m: Vec<f64> = (0..=count).map(|i| LENGTH_M * f64::from(i) / f64::from(count)).collect();
    let along = |f: &dyn Fn(f64) -> f64| stations_m.iter().map(|s| f(*s)).collect::<Vec<f64>>();
    // no curvature at either end, as natural splines assume; other curves lose their curvature in the outermost intervals
    let wave = std::f64::consts::PI / LENGTH_M;
    let axis = Axis {
        y_m: along(&|s| 0.05 * (2.0 * wave * s).sin() - 0.2 * s),
        z_m: along(&|s| 0.12 * (wave * s).sin() + 0.1 * s),
        twist_rad: along(&|s| -0.3 + 0.2 * (wave * s).sin() + 0.2 * s),
        stations_m: stations_m.clone(),
    };
    let shape = axis.natural_shape().unwrap();
    let body = BodyDescription {
        mount: shape.ends.first,
        ..description(LENGTH_M, section(rows()[0].section.stiffness).into(), shape.strain)
    };
    let found = [4, 8, 16].map(|n| {
        let tip = solve(&body, (Linear, n), &Vector3::zeros(), 4).tip;
        (tip.y - axis.y_m[count as usize]).hypot(tip.z - axis.z_m[count as usize])
    });
    assert_order("WT-31 tip", &found, 3.5, 4.6);
    // x follows from the arc length
    let slopes = |s: f64| {
        let (y, z) = (0.1 * wave * (2.0 * wave * s).cos() - 0.2, 0.12 * wave * (wave * s).cos() + 0.1);
        (1.0 - y * y - z * z).sqrt()
    };
    let x: f64 = (0..10_000).map(|i| slopes(LENGTH_M * (f64::from(i) + 0.5) / 1e4) * LENGTH_M / 1e4).sum();
    let tip = solve(&body, (Linear, 16), &Vector3::zeros(), 4).tip;
    assert!((tip.x - x).abs() < 2e-5, "{} {x}", tip.x);
    let straight = NaturalStrain::from([0.0; 4]);
    assert_eq!(
        Axis { y_m: vec![0.0; 2], z_m: vec![0.0; 2], twist_rad: vec![0.4; 2], stations_m: vec![0.0, 1.0] }
            .natural_shape()
            .unwrap()
            .strain,
        straight
    );
}

/// WT-32. Condensed shear: where no shear force acts, the condensed stiffness gives exactly the strains of the full stiffness.
#[test]
fn wt32_condensation_is_exact_without_shear_forces() {
    let root = Matrix6::from_fn(|i, j| ((3 * i + 5 * j) as f64).sin() + if i == j { 4.0 } else { 0.0 });
    let full = root * root.transpose();
    let condensed = config::condensed_stiffness(&full).unwrap();
    // loads (Fz, Mx, My, Mz) in BeamDyn's axes, no shear force
    let loads = nalgebra::Vector6::new(0.0, 0.0, 1.0, -2.0, 0.5, 3.0);
    let strains = full.try_inverse().unwrap() * loads;
    // (x, y, z) here = (z, −y, x) of BeamDyn
    let expected = Vector4::new(strains[2], strains[5], -strains[4], strains[3]);
    let found = condensed.try_inverse().unwrap() * Vector4::new(loads[2], loads[5], -loads[4], loads[3]);
    assert!((found - expected).amax() < 1e-13 * expected.amax(), "{found} {expected}");
    assert!(config::condensed_stiffness(&-full).is_none());
}

/// A blade in BeamDyn's format with two stations and a shear–twist coupling, and its primary file with prebend and twist.
fn beamdyn() -> (String, String) {
    let mut blade =
        "------- BEAMDYN V1.00.* INDIVIDUAL BLADE INPUT FILE ---\n Test\n ---\n2   station_total\n 1 damp_type\n"
            .to_owned();
    blade += " ---- DAMPING\n mu1 mu2\n (-) (-)\n1e-3 1e-3 1e-3 1e-3 1e-3 1e-3\n ---- DISTRIBUTED PROPERTIES ----\n";
    for (share, factor) in [(0.0, 1.0), (1.0, 0.25)] {
        let k = |value: f64| factor * value;
        blade += &format!(
            " {share}\n {} 0 0 0 0 {}\n 0 {} 0 0 0 0\n 0 0 {} 0 0 0\n 0 0 0 {} 0 0\n 0 0 0 0 {} 0\n {} 0 0 0 0 {}\n\n",
            k(2e8),
            k(1e7),
            k(2e8),
            k(3e9),
            k(5e9),
            k(4e9),
            k(1e7),
            k(1e9)
        );
        // centre of mass 0.2 m downwind, 0.1 m towards the trailing edge; moments of inertia about it 30 (about x) and 20 kg m
        let (m, x, y) = (100.0, 0.2, 0.1);
        let (xx, yy, xy) = (30.0 + m * y * y, 20.0 + m * x * x, m * x * y);
        blade += &format!(
            " {m} 0 0 0 0 {a}\n 0 {m} 0 0 0 {b}\n 0 0 {m} {c} {d} 0\n 0 0 {c} {xx} {e} 0\n 0 0 {d} {e} {yy} 0\n {a} {b} 0 0 0 {f}\n\n",
            a = -m * y,
            b = m * x,
            c = m * y,
            d = -m * x,
            e = -xy,
            f = xx + yy
        );
    }
    let mut primary = "--------- BEAMDYN INPUT FILE ---\n blade\n 1 member_total\n 5 kp_total\n 1 5\n kp_xr kp_yr kp_zr initial_twist\n (m) (m) (m) (deg)\n".to_owned();
    for i in 0..5 {
        let z = 5.0 * f64::from(i);
        primary += &format!("{} {} {z} {}\n", -0.002 * z * z, 0.001 * z * z, 10.0 - 0.4 * z);
    }
    (blade, primary)
}

/// WT-33. BeamDyn's files: condensed stiffness, inertia, arc lengths, signs of twist and prebend; then faulty files.
#[test]
fn wt33_beamdyn_files() {
    let (blade, primary) = beamdyn();
    let table = config::read_sections(&blade).unwrap();
    let at = |table: &config::StationTable, name: &str| table.column(name).unwrap_or_else(|| panic!("{name}")).to_vec();
    let close = |found: f64, due: f64| assert!((found - due).abs() <= 1e-9 * due.abs().max(1.0), "{found} {due}");
    close(at(&table, "axial_stiffness_N")[1], 0.25 * 3e9);
    close(at(&table, "flap_stiffness_N_m2")[0], 4e9);
    close(at(&table, "edge_stiffness_N_m2")[0], 5e9);
    close(at(&table, "torsional_rigidity_N_m2")[0], 1e9 - 1e14 / 2e8);
    close(at(&table, "centre_of_mass_y_m")[0], -0.1);
    close(at(&table, "centre_of_mass_z_m")[0], 0.2);
    close(at(&table, "second_moment_yy_kg_m")[0], 30.0);
    close(at(&table, "second_moment_zz_kg_m")[0], 20.0);
    close(at(&table, "second_moment_yz_kg_m")[0], 0.0);
    let axis = config::read_axis(&primary).unwrap();
    assert_eq!((at(&axis, "z_m")[4], at(&axis, "y_m")[4], at(&axis, "twist_deg")[4]), (-0.8, -0.4, -2.0));
    assert_eq!(at(&axis, "twist_deg")[0], -10.0);
    // the parabola, except for the free ends of the splines, which miss a fifth of the difference between arc and chord length
    let parabola: f64 = (0..1000)
        .map(|i| (f64::from(i) + 0.5) * 0.02)
        .map(|z| (1.0 + (0.004f64.powi(2) + 0.002f64.powi(2)) * z * z).sqrt() * 0.02)
        .sum();
    let arc_m = at(&axis, "s_m")[4];
    assert!((arc_m - parabola).abs() < 1.5e-4, "{arc_m} {parabola}");

    for (found, due, reason) in [
        ("2   station_total", "3   station_total", "truncated: the file ends before station 3 of 3"),
        (" 1\n", " 0\n", "station 2 at 0 after 0"),
        ("10000000 0 0 0 0 1000000000", "9000000 0 0 0 0 1000000000", "the stiffness is not symmetric"),
        ("200000000 0 0 0 0 10000000", "200000000 0 0 0 0 x", "\"x\" in the stiffness of station 1"),
        (" 100 0 0 0 0 -10\n", " 90 0 0 0 0 -10\n", "the matrix is not the inertia matrix of a section"),
    ] {
        assert!(blade.contains(found), "{found}");
        let fault = config::read_sections(&blade.replacen(found, due, 1)).unwrap_err();
        assert!(fault.reason.starts_with(reason), "{fault}");
    }
    for (found, due, reason) in [
        ("1 member_total", "2 member_total", "member_total is 2"),
        ("5 kp_total", "6 kp_total", "truncated: the file ends before key point 6 of 6"),
        ("-0 0 0 10", "1 0 0 10", "the first key point is not the origin"),
        ("0.4 20 2", "0.4 nan 2", "\"nan\" in key point 5"),
    ] {
        assert!(primary.contains(found), "{found} {primary}");
        let fault = config::read_axis(&primary.replacen(found, due, 1)).unwrap_err();
        assert!(fault.reason.starts_with(reason), "{fault}");
    }
    // every missing line is reported with its number and expected content
    let lines: Vec<&str> = blade.lines().collect();
    for cut in 1..lines.len() - 1 {
        assert!(config::read_sections(&lines[..cut].join("\n")).is_err(), "{cut} lines are taken for a blade");
    }
    let lines: Vec<&str> = primary.lines().collect();
    let last = lines.iter().rposition(|line| line.split_whitespace().count() >= 4).expect("key points");
    for cut in 1..=last {
        let fault = config::read_axis(&lines[..cut].join("\n")).expect_err("a primary file that is cut short");
        assert_eq!(fault.line, cut + 1, "{cut} lines: {fault}");
        let due = ["member_total", "kp_total", "key point"];
        assert!(due.iter().any(|due| fault.reason.contains(due)), "{cut} lines: {fault}");
    }
    let whole = config::read_axis(&lines[..=last].join("\n")).expect("all key points");
    assert_eq!(whole, axis);
}

const MODEL: &str = "name = \"blade\"\ngravity_m_s2 = [0.0, 0.0, -9.8]\n[section.blade]\nshape = \"table\"\n\
    along = { eta = [0.0, 0.5, 1.0], axial_stiffness_N = [1e9, 8e8, 2e8], torsional_rigidity_N_m2 = [1e8, 6e7, 1e7], \
    flap_stiffness_N_m2 = [1e9, 5e8, 1e8], edge_stiffness_N_m2 = [2e9, 1e9, 3e8], mass_kg_m = [300.0, 200.0, 50.0], \
    second_moment_yy_kg_m = [30.0, 20.0, 5.0], second_moment_zz_kg_m = [10.0, 8.0, 2.0] }\n[body.blade]\nlength_m = 20.0\n\
    section = \"blade\"\nelements = 4\naxis = { eta = [0.0, 0.5, 1.0], twist_deg = [12.0, 6.0, 0.0] }\n\
    [joint.hold]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"blade\"\n";

/// WT-34. The keys of the model file: the first twist rotates the first section relative to the frame that the joint holds; errors name the
/// key.
#[test]
fn wt34_tables_of_the_model_file() {
    let machine = config::parse(MODEL, "blade.toml").unwrap_or_else(|refused| panic!("{refused}"));
    let body = &machine.bodies[0];
    let turned = Rotation3::from_axis_angle(&Vector3::x_axis(), 12f64.to_radians()).into_inner();
    assert!((body.joint.mount - turned).amax() < 1e-15);
    assert!((body.natural_strain.at(7.0)[1] + 0.6f64.to_radians()).abs() < 1e-15);
    assert_eq!(body.section.at(15.0).mass_kg_m, 125.0);
    let refused = |found: &str, due: &str| {
        assert!(MODEL.contains(found), "{found}");
        config::parse(&MODEL.replacen(found, due, 1), "blade.toml").expect_err(due).to_string()
    };
    for (found, due, told) in [
        (
            "eta = [0.0, 0.5, 1.0], axial",
            "eta = [0.0, 0.5, 0.9], axial",
            "'section.blade.along.eta': 3 positions from 0 to 0.9",
        ),
        ("eta = [0.0, 0.5, 1.0], axial", "eta = [0.0, 1.0, 0.5], axial", "'section.blade.along.eta': 0.5 after 1"),
        ("eta = [0.0, 0.5, 1.0], axial", "axial", "'section.blade.along.eta' is missing"),
        (
            "eta = [0.0, 0.5, 1.0], axial",
            "s_m = [0.0, 5.0, 10.0], axial",
            "'body.blade.length_m': 20.0 is not allowed; allowed: 10 m, the last station",
        ),
        (
            "mass_kg_m = [300.0, 200.0, 50.0]",
            "mass_kg_m = [300.0, 50.0]",
            "'section.blade.along.mass_kg_m': an array of 2",
        ),
        (
            "mass_kg_m = [300.0, 200.0, 50.0]",
            "mass_kg_m = [300.0, 0.0, 50.0]",
            "'section.blade.along.mass_kg_m': 0 is not allowed",
        ),
        (
            "second_moment_yy_kg_m = [30.0",
            "second_moment_yy_kg_m = [-30.0",
            "'section.blade.along.second_moment_yy_kg_m': [-30, 0, 10] at station 1",
        ),
        (
            "mass_kg_m =",
            "coupling_twist_flap_N_m2 = [0.0, 1e9, 0.0], mass_kg_m =",
            "not positive definite at station 2",
        ),
        (
            "mass_kg_m =",
            "half_width_m = [1.0, 1.0, 1.0], mass_kg_m =",
            "'section.blade.along.half_height_m' is missing",
        ),
        ("twist_deg = [12.0, 6.0, 0.0]", "twist_deg = [12.0, 6.0]", "'body.blade.axis.twist_deg': an array of 2"),
        (
            "twist_deg = [12.0, 6.0, 0.0]",
            "y_m = [1.0, 0.0, 0.0]",
            "'body.blade.axis.y_m': 1 is not allowed; allowed: 0 at the inner end",
        ),
        ("twist_deg = [12.0, 6.0, 0.0]", "y_m = [0.0, 0.0, 19.0]", "no extent along x"),
        ("elements = 4", "elements = 4\ntwist_1_m = 0.1", "'body.blade.twist_1_m'"),
        ("elements = 4", "elements = 4\nwidth_taper = 0.1", "'body.blade.width_taper'"),
        ("elements = 4", "elements = 4\nouter_section = \"blade\"", "'body.blade.outer_section'"),
        ("along = {", "file = \"blade.csv\"\nalong = {", "either along or file"),
        (
            "eta = [0.0, 0.5, 1.0], twist",
            "s_m = [0.0, 0.5, 19.0], twist",
            "'body.blade.length_m': 20.0 is not allowed; allowed: 19 m, the arc length",
        ),
    ] {
        let message = refused(found, due);
        assert!(message.contains(told), "{message}\nlacks {told}");
    }
}
