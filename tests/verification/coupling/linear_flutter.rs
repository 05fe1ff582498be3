//! flutter and divergence from the eigenvalues of the linear aeroelastic model, against closed forms, determinants in the
//! frequency domain, and simulations in time.

use crate::coupling::goland::Goland;
use crate::strips::theory::{Aerofoil, theodorsen};
use crate::whole::is_whole;
use foldwing::aero::strip::indicial::{Fit, Indicial};
use foldwing::config;
use foldwing::machine::Machine;
use foldwing::plant::{Branches, Holding, ModeShape, Plant, change_of_sign};
use nalgebra::{Complex, Matrix2, Vector2, Vector3};
use std::sync::Arc;

/// W-32: flutter of Goland's wing with the product's fit to Wagner's function, m/s and rad/s, by transfer matrices.
const FITTED: [f64; 2] = [137.335, 69.346];

/// A machine in equilibrium in a wind.
struct InWind {
    plant: Plant,
    direction: Vector3<f64>,
}

impl InWind {
    fn new(machine: Machine) -> Self {
        let plant = Plant::new(Arc::new(machine));
        let direction = plant.inputs().wind_m_s().normalize();
        Self { plant, direction }
    }

    fn modes(&mut self, speed_m_s: f64, count: usize) -> Result<(Vec<ModeShape>, Option<bool>), String> {
        *self.plant.inputs_mut().wind_m_s_mut() = self.direction * speed_m_s;
        let rest = self.plant.study().equilibrium(0.0, Holding::AsReleased).map_err(|error| error.to_string());
        rest.and_then(|_| self.plant.study().modes_and_rest(count).map_err(|error| error.to_string()))
    }

    /// First flutter speed in m/s and frequency in rad/s.
    fn flutter(&mut self, speeds_m_s: &[f64], count: usize) -> Option<[f64; 2]> {
        let mut modes_at = |speed_m_s: f64| self.modes(speed_m_s, count).map(|(modes, _)| modes);
        let (branches, failed) = Branches::follow(speeds_m_s, &mut modes_at);
        assert!(failed.is_none(), "{failed:?}");
        let crossings = branches.crossings(&mut modes_at);
        let first = crossings.iter().find(|crossing| crossing.begins && !crossing.mode.is_real());
        first.map(|first| [first.at, first.mode.eigenvalue_1_s.im])
    }

    /// Divergence speed in m/s between two speeds.
    fn divergence(&mut self, speeds_m_s: [f64; 2]) -> f64 {
        let sign = |found: Result<(_, Option<bool>), String>| found.map(|(_, sign)| sign);
        let low = sign(self.modes(speeds_m_s[0], 1)).expect("an equilibrium").expect("a stiffness");
        let mut at = |speed_m_s: f64| sign(self.modes(speed_m_s, 1));
        change_of_sign(speeds_m_s, low, &mut at).expect("a sign at every speed")
    }
}

/// A section on two springs with a mass ratio of one: flutter against the determinant in the frequency domain, with the fit used by
/// the strips, and the finer fit against Theodorsen's function itself.
#[test]
fn q61_typical_section_flutters_where_theodorsen_says() {
    let (density_kg_m3, semi_chord_m) = (1.2, 1.0);
    let mass_kg_m = std::f64::consts::PI * density_kg_m3 * semi_chord_m * semi_chord_m;
    let (arm_m, radius_m, heave_rad_s, pitch_rad_s) = (0.5, 0.8_f64, 10.0_f64, 14.0_f64);
    let mass = Matrix2::new(1.0, arm_m, arm_m, radius_m.powi(2)) * mass_kg_m;
    let stiffness =
        Matrix2::from_diagonal(&Vector2::new(heave_rad_s.powi(2), (radius_m * pitch_rad_s).powi(2))) * mass_kg_m;
    let determinant = |lag: &dyn Fn(f64) -> Complex<f64>, at: &Vector2<f64>| {
        let aerofoil = Aerofoil { density_kg_m3, speed_m_s: at.x, semi_chord_m, axis: -0.5 };
        let k = at.y * semi_chord_m / at.x;
        let (zero, one) = (Complex::new(0.0, 0.0), Complex::new(1.0, 0.0));
        let heaving = aerofoil.response(lag(k), k, one, zero);
        let pitching = aerofoil.response(lag(k), k, zero, one);
        let own = stiffness - mass * at.y.powi(2);
        let f = (heaving.lift_n_m() + own[(0, 0)]) * (-pitching.moment_n() + own[(1, 1)])
            - (pitching.lift_n_m() + own[(0, 1)]) * (-heaving.moment_n() + own[(1, 0)]);
        Vector2::new(f.re, f.im)
    };
    let flutter = |lag: &dyn Fn(f64) -> Complex<f64>| {
        let mut at = Vector2::new(24.5, 15.4);
        for _ in 0..50 {
            let slope =
                |shift: Vector2<f64>| (determinant(lag, &(at + shift)) - determinant(lag, &(at - shift))) / 2e-6;
            let jacobian = Matrix2::from_columns(&[slope(Vector2::x() * 1e-6), slope(Vector2::y() * 1e-6)]);
            at -= jacobian.try_inverse().expect("regular") * determinant(lag, &at);
        }
        at
    };
    let machine = |fit: &str| {
        let polar = mass_kg_m * (radius_m * radius_m - arm_m * arm_m);
        let text = format!(
            "name = \"Section\"\n[section.wing]\nshape = \"explicit\"\naxial_stiffness_N = 1e9\n\
             torsional_rigidity_N_m2 = 1e9\nflap_stiffness_N_m2 = 1e9\nedge_stiffness_N_m2 = 1e9\n\
             mass_kg_m = {mass_kg_m:?}\ncentre_of_mass_m = [{:?}, 0.0]\nsecond_moments_kg_m = [{polar:?}, 0.0, 0.0]\n\
             [body.wing]\nlength_m = 1.0\nsection = \"wing\"\nelements = 1\n[rigid_body.carriage]\n\
             [joint.heave]\ntype = \"prismatic\"\nparent = \"root\"\nchild = \"carriage\"\naxis = [0.0, 0.0, 1.0]\n\
             [joint.heave.spring]\nstiffness_N_m = {:?}\n\
             [joint.pitch]\ntype = \"revolute\"\nparent = \"carriage\"\nchild = \"wing\"\naxis = [1.0, 0.0, 0.0]\n\
             [joint.pitch.spring]\nstiffness_N_m_rad = {:?}\n\
             [aerodynamics]\nmodel = \"strip\"\nindicial = \"{fit}\"\ndensity_kg_m3 = {density_kg_m3}\n\
             wind_m_s = [0.0, -20.0, 0.0]\nstep_s = 1e-3\n\
             [surface.wing]\nbody = \"wing\"\nchord_m = 2.0\nelastic_axis_fraction = 0.25\nstrips = 1\n",
            -arm_m,
            stiffness[(0, 0)],
            stiffness[(1, 1)],
        );
        config::parse(&text, "section.toml").unwrap_or_else(|error| panic!("{error}"))
    };
    let speeds: Vec<f64> = (0..=12).map(|i| 18.0 + f64::from(i)).collect();
    let fitted = |fit: Fit, k: f64| {
        let (p, Indicial { weights, rates, .. }) = (Complex::new(0.0, k), fit.wagner());
        weights.iter().zip(rates).fold(Complex::new(1.0, 0.0), |c, (weight, rate)| c - p * *weight / (p + *rate))
    };
    for (name, fit) in [("jones", Fit::Jones), ("fine", Fit::Fine)] {
        let reference = flutter(&|k| fitted(fit, k));
        let found = InWind::new(machine(name)).flutter(&speeds, 2).expect("flutter");
        let off = [found[0] / reference.x - 1.0, found[1] / reference.y - 1.0];
        println!("Q-61 {name}: {found:.6?} (m/s, rad/s), {off:+.8?} from {:.6}, {:.6}", reference.x, reference.y);
        // beam and sections are stiff, not rigid: (15/1e4)²
        assert!(off.iter().all(|off| off.abs() < 2e-6), "{name}: {off:?}");
    }
    // the finer fit is within 6e-4 of Theodorsen's function: effect on the speed of an error of this size in any direction
    let exact = flutter(&theodorsen);
    let shifts = [(6e-4, 0.0), (-6e-4, 0.0), (0.0, 6e-4), (0.0, -6e-4)].map(|(re, im)| {
        let shifted = flutter(&|k| theodorsen(k) + Complex::new(re, im));
        (shifted.x / exact.x - 1.0).abs()
    });
    let allowed = shifts[0].max(shifts[1]).hypot(shifts[2].max(shifts[3]));
    let off = InWind::new(machine("fine")).flutter(&speeds, 2).expect("flutter")[0] / exact.x - 1.0;
    println!("Q-61 fine: {off:+.6} from Theodorsen's {:.6} m/s, allowed {allowed:.6}", exact.x);
    assert!(off.abs() < allowed, "{off} against {allowed}");
}

/// Goland's wing next to twelve carriages on soft springs, all slower than its flutter mode: the growing mode is the thirteenth by
/// frequency; nevertheless the verdict is that of the wing alone, and a sweep of the wind speed reports the mode that grows from 138 m/s
/// on.
#[test]
fn q90_a_growing_motion_above_many_slow_ones_counts() {
    let shipped = std::fs::read_to_string("examples/models/goland_wing.toml").expect("the shipped model");
    let (wing, gusts) = shipped.split_once("[gust.bump]").expect("a gust");
    let after = gusts.split_once("[solver]").expect("a solver").1;
    let slow = |count: usize| {
        let carriage = |i: usize| {
            format!(
                "[rigid_body.slow{i}]\nmass_kg = 1.0\n[joint.slow{i}]\ntype = \"prismatic\"\n\
                 parent = \"root\"\nchild = \"slow{i}\"\naxis = [1.0, 0.0, 0.0]\n[joint.slow{i}.spring]\nstiffness_N_m = {}.0\n",
                4 * (i + 1) * (i + 1)
            )
        };
        let text = format!("{wing}{}[solver]{after}", (0..count).map(carriage).collect::<String>());
        InWind::new(config::parse(&text, "goland.toml").unwrap_or_else(|error| panic!("{error}")))
    };
    let growing = |count: usize, speed_m_s: f64| {
        let mut air = slow(count);
        air.modes(speed_m_s, 1).expect("modes");
        let stability = air.plant.study().stability().expect("a verdict");
        stability.growing.iter().map(|growth| growth.eigenvalue_1_s).collect::<Vec<_>>()
    };
    let (alone, among) = (growing(0, 150.0), growing(12, 150.0));
    println!("Q-90: {alone:?} 1/s alone, {among:?} 1/s among twelve slower motions");
    assert_eq!((alone.len(), among.len()), (1, 1));
    assert!((alone[0] - among[0]).norm() < 1e-7 * alone[0].norm());
    assert!(growing(12, 130.0).is_empty());
    let speeds = [130.0, 134.0, 138.0, 142.0];
    let mut air = slow(12);
    let (branches, failed) =
        Branches::follow(&speeds, &mut |speed_m_s| air.modes(speed_m_s, 4).map(|(modes, _)| modes));
    assert!(failed.is_none(), "{failed:?}");
    let begins = branches.beginnings();
    let is_flutter = |mode: &ModeShape| (mode.eigenvalue_1_s.im - FITTED[1]).abs() < 1.0;
    assert!(
        begins.iter().any(|(_, [low, high], mode)| [*low, *high] == [134.0, 138.0] && is_flutter(mode)),
        "{begins:?}"
    );
}

/// Goland's wing: flutter from eigenvalues, of second order in the strips, extrapolated, against W-32's transfer matrices and against
/// simulations on the same mesh.
#[test]
fn q62_goland_flutters_where_the_continuous_wing_does() {
    let speeds: Vec<f64> = (0..=8).map(|i| 120.0 + 5.0 * f64::from(i)).collect();
    let run = |strips: usize, pairs: usize| {
        let machine = Goland { strips, pairs, gust_m_s: 0.0, ..Goland::strips() }.machine(130.0, |structure| structure);
        InWind::new(machine).flutter(&speeds, 4).expect("flutter")
    };
    let found = [run(8, 8), run(16, 8), run(32, 8)];
    let order = ((found[0][0] - found[1][0]) / (found[1][0] - found[2][0])).log2();
    let limit: [f64; 2] = std::array::from_fn(|i| found[2][i] + (found[2][i] - found[1][i]) / 3.0);
    let off: [f64; 2] = std::array::from_fn(|i| limit[i] / FITTED[i] - 1.0);
    println!("Q-62 8, 16, 32 strips {found:.5?} (m/s, rad/s), order {order:.2}; carried on {limit:.5?}, {off:+.7?}");
    assert!((order - 2.0).abs() < 0.2, "{order}");
    // W-32 is given to 7e-6; the next order leaves a tenth of the change by extrapolation, 1e-5
    assert!(off.iter().all(|off| off.abs() < 2e-5), "{off:?}");
    let fine: [f64; 2] = std::array::from_fn(|i| found[2][i] / FITTED[i] - 1.0);
    assert!(fine.iter().all(|off| off.abs() < 1e-3), "{fine:?}");
    // fourth order
    let pairs = run(16, 4);
    assert!((pairs[0] / found[1][0] - 1.0).abs() < 2e-5, "{pairs:?}");
    if is_whole() {
        // steps of 0.075 and 0.0375 chords, extrapolated with their second order
        let steps = [0.075, 0.0375].map(|step_chords| Goland { step_chords, ..Goland::strips() }.flutter(137.0, 0.036));
        let marched: [f64; 2] = std::array::from_fn(|i| steps[1][i] + (steps[1][i] - steps[0][i]) / 3.0);
        let off: [f64; 2] = std::array::from_fn(|i| pairs[i] / marched[i] - 1.0);
        println!("Q-62 marched on 16 strips {marched:.4?}: eigenvalues {off:+.7?} off");
        assert!(off.iter().all(|off| off.abs() < 1e-3), "{off:?}");
    }
}

/// A plate with its elastic axis behind the quarter chord and its centre of mass on that axis, swept forward by an angle in rad.
fn plate(strips: usize, [bending, torsion]: [f64; 2], sweep_rad: f64) -> Machine {
    let text = format!(
        "name = \"Plate\"\n[section.plate]\nshape = \"explicit\"\naxial_stiffness_N = 1e9\n\
         torsional_rigidity_N_m2 = {torsion:?}\nflap_stiffness_N_m2 = {bending:?}\nedge_stiffness_N_m2 = 1e9\n\
         mass_kg_m = 5.0\nsecond_moments_kg_m = [0.1, 0.0, 0.0]\n\
         [body.plate]\nlength_m = 3.0\nsection = \"plate\"\nelements = 6\n\
         [joint.wall]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"plate\"\n\
         [aerodynamics]\nmodel = \"strip\"\ndensity_kg_m3 = 1.225\nwind_m_s = [{:?}, {:?}, 0.0]\nstep_s = 1e-3\n\
         [surface.plate]\nbody = \"plate\"\nchord_m = 0.4\nelastic_axis_fraction = 0.5\nstrips = {strips}\n",
        -sweep_rad.sin(),
        -sweep_rad.cos(),
    );
    config::parse(&text, "plate.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Divergence in closed form: for a straight plate that only twists, `q e c a₀ L²/GJ = (π/2)²`, and for a plate swept forward by 30°
/// that only bends, `q cos²Λ tan Λ c a₀ L³/EI = 6.32970` (the first root of `2 e^{x/2} cos(√3 x/2) + e^{−x} = 0`, cubed).
#[test]
fn q63_divergence_in_closed_form() {
    let slope = std::f64::consts::TAU;
    let (length_m, chord_m, density) = (3.0_f64, 0.4, 1.225);
    let speed = |pressure_pa: f64| (2.0 * pressure_pa / density).sqrt();
    let sweep_rad = 30f64.to_radians();
    // Γ''' = −kΓ outward from the wall, with Γ = w': Γ(0) = Γ'(L) = Γ''(L) = 0
    let condition = |x: f64| 2.0 * (0.5 * x).exp() * (0.75f64.sqrt() * x).cos() + (-x).exp();
    let (mut low, mut high) = (1.5, 2.2);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if condition(middle) * condition(low) > 0.0 { low = middle } else { high = middle }
    }
    let bent = low.powi(3);
    assert!((bent - 6.3297).abs() < 1e-4, "{bent}");
    let straight = (
        [1e8, 1e4],
        0.0,
        speed((std::f64::consts::FRAC_PI_2 / length_m).powi(2) * 1e4 / (0.25 * chord_m * chord_m * slope)),
    );
    let swept = (
        [1e4, 1e8],
        sweep_rad,
        speed(bent * 1e4 / (length_m.powi(3) * chord_m * slope * sweep_rad.cos().powi(2) * sweep_rad.tan())),
    );
    for (name, (stiffness, sweep_rad, exact)) in [("straight", straight), ("swept", swept)] {
        let found = [16, 32]
            .map(|strips| InWind::new(plate(strips, stiffness, sweep_rad)).divergence([0.7 * exact, 1.3 * exact]));
        let limit = found[1] + (found[1] - found[0]) / 3.0;
        println!(
            "Q-63 {name}: 16, 32 strips {found:.5?} m/s, carried on {limit:.5} m/s, exact {exact:.5} m/s: {:+.1e}",
            limit / exact - 1.0
        );
        // the twist or bending to be excluded is 1e4 times as stiff
        assert!((limit / exact - 1.0).abs() < 2e-4, "{name}: {limit} against {exact}");
    }
}

/// Goland's wing with a hinge along the chord at three quarters of the span, and a closed latch with a stiffness in N·m/rad.
fn hinged_tip(latch_n_m_rad: f64) -> Machine {
    let shipped = include_str!("../../../examples/models/goland_wing.toml");
    let (section, _) = shipped.split_once("[body.wing]").expect("a body");
    let text = format!(
        "{section}[body.inner]\nlength_m = 4.572\nsection = \"wing\"\nelements = 3\n[body.tip]\nlength_m = 1.524\n\
         section = \"wing\"\nelements = 1\n[joint.wall]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"inner\"\n\
         [joint.fold]\ntype = \"revolute\"\nparent = \"inner\"\nchild = \"tip\"\naxis = [0.0, 1.0, 0.0]\n\
         [joint.fold.latch]\nenable = true\nstiffness_N_m_rad = {latch_n_m_rad:?}\n\
         [aerodynamics]\nmodel = \"strip\"\ndensity_kg_m3 = 1.225\nwind_m_s = [0.0, -130.0, 0.0]\nstep_s = 1e-3\n\
         [surface.inner]\nbody = \"inner\"\nchord_m = 1.8288\nelastic_axis_fraction = 0.33\nstrips = 12\n\
         [surface.tip]\nbody = \"tip\"\nchord_m = 1.8288\nelastic_axis_fraction = 0.33\nstrips = 4\n"
    );
    config::parse(&text, "hinged.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Flutter of Goland's wing with a hinged tip as a function of the latch stiffness: with a stiff latch it is Goland's wing on the
/// same strips, with a soft latch the tip follows the flow; the curve is continuous.
#[test]
fn q64_hinged_tip_over_latch_stiffness() {
    let speeds: Vec<f64> = (0..=14).map(|i| 60.0 + 15.0 * f64::from(i)).collect();
    let all = [1e2, 1e4, 1e5, 3e5, 1e6, 3e6, 1e7, 1e10];
    let chosen = if is_whole() { all.to_vec() } else { vec![1e2, 1e5, 1e6, 1e10] };
    let map: Vec<(f64, Option<[f64; 2]>)> = chosen
        .into_iter()
        .map(|stiffness| (stiffness, InWind::new(hinged_tip(stiffness)).flutter(&speeds, 5)))
        .collect();
    for (stiffness, found) in &map {
        println!("Q-64 latch {stiffness:.0e} N m/rad: flutter {found:.4?} (m/s, rad/s)");
        // edgewise bending, at 487 rad/s, has so little damping that round-off may change its sign
        assert!(found.is_none_or(|found| found[1] < 200.0), "{found:?}");
    }
    let whole = Goland { gust_m_s: 0.0, ..Goland::strips() }.machine(130.0, |structure| structure);
    let whole = InWind::new(whole).flutter(&speeds, 5).expect("flutter");
    let (Some(soft), Some(stiff)) = (map[0].1, map[map.len() - 1].1) else { panic!("{map:?}") };
    // the latch is 1e10/1e6 times as stiff as one metre of the wing
    assert!(
        (stiff[0] / whole[0] - 1.0).abs() < 1e-4 && (stiff[1] / whole[1] - 1.0).abs() < 1e-4,
        "{stiff:?} {whole:?}"
    );
    assert!((soft[0] / whole[0] - 1.0).abs() > 0.02, "the latch matters: {map:?}");
}
