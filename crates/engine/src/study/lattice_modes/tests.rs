use super::*;
use crate::beam::profile::Profile as Along;
use crate::beam::section::{Material, Solid};
use crate::machine::{Air, Body, Joint, LiftingSurface, Machine, Motor};
use crate::run::Plant;
use crate::solve::eigen::eigen;
use crate::study::lattice_space::SampledSpace;
use crate::study::{Holding, JUDGED_MODES};
use std::sync::Arc;

const STEP_S: f64 = 0.01;

/// The eigenvalues of a soft wing that rolls against a spring are independent of the far wake: with a wake of 235 rows they equal those
/// with 40 rows, although a motion whose decay rate equals the frequency of the highest mode overflows between the first and the last row.
/// The additional rows change the eigenvalues by 1e-4.
#[test]
fn modes_are_found_beside_a_wake_of_many_rows() {
    let modes = |wake_rows: usize| {
        let drive = Motor { stiffness_n_m_rad: 544.0, ..Motor::default() };
        let material = Material { youngs_modulus_pa: 3.6e8, shear_modulus_pa: 1.44e8, density_kg_m3: 500.0 };
        let machine = Machine::builder("Rolling")
            .body(
                Body::beam("wing", 1.0, Solid::rectangle(0.2, 0.04, material)).elements(3),
                Joint::revolute("roll", [0.0, 1.0, 0.0]).motor(drive),
            )
            .air(Air::lattice().density_kg_m3(0.58).wind_m_s([0.0, -20.0, 0.0]).step_s(STEP_S).wake_rows(wake_rows))
            .surface(LiftingSurface::on("wing", 2).chord_panels(1).chord_m(Along::constant(0.2)))
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
        let (modes, _) = plant.study().lattice_modes_and_rest(8).unwrap_or_else(|error| panic!("{error}"));
        modes.iter().map(|mode| mode.eigenvalue_1_s).collect::<Vec<_>>()
    };
    let (short, long) = (modes(40), modes(235));
    assert!(short.len() >= 4 && 235.0 * STEP_S * short[short.len() - 1].norm() > 0.95 * f64::MAX.ln(), "{short:?}");
    for mode in &short {
        let nearest = long.iter().map(|other| (other - mode).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-3 * mode.norm(), "{mode} is not in {long:?}");
    }
}

/// A soft wing that rolls against a spring without damping, at high air density.
struct Wing {
    elements: usize,
    length_m: f64,
    youngs_modulus_pa: f64,
    density_kg_m3: f64,
    stiffness_n_m_rad: f64,
    air_kg_m3: f64,
    speed_m_s: f64,
    chord_m: f64,
    panels: usize,
    strips: usize,
    axis: f64,
    wake_rows: usize,
}

impl Wing {
    fn step_s(&self) -> f64 {
        self.chord_m / self.panels as f64 / self.speed_m_s
    }

    fn at_rest(&self) -> Plant {
        let drive = Motor { stiffness_n_m_rad: self.stiffness_n_m_rad, ..Motor::default() };
        let material = Material {
            youngs_modulus_pa: self.youngs_modulus_pa,
            shear_modulus_pa: 0.4 * self.youngs_modulus_pa,
            density_kg_m3: self.density_kg_m3,
        };
        let section = Solid::rectangle(self.chord_m, 0.04, material);
        let air = Air::lattice().density_kg_m3(self.air_kg_m3).wind_m_s([0.0, -self.speed_m_s, 0.0]);
        let machine = Machine::builder("Rolling")
            .body(
                Body::beam("wing", self.length_m, section).elements(self.elements),
                Joint::revolute("roll", [0.0, 1.0, 0.0]).motor(drive),
            )
            .air(air.step_s(self.step_s()).wake_rows(self.wake_rows))
            .surface(
                LiftingSurface::on("wing", self.strips)
                    .chord_panels(self.panels)
                    .chord_m(Along::constant(self.chord_m))
                    .elastic_axis_fraction(self.axis),
            )
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
        plant
    }
}

/// A wing with one growing mode, an oscillation that grows by `exp(0.0535)` in each step.
const FLUTTERS: Wing = Wing {
    elements: 1,
    length_m: 0.459,
    youngs_modulus_pa: 4.33e7,
    density_kg_m3: 527.0,
    stiffness_n_m_rad: 8.09,
    air_kg_m3: 25.9,
    speed_m_s: 60.0,
    chord_m: 0.2,
    panels: 1,
    strips: 3,
    axis: 0.421,
    wake_rows: 40,
};

/// A wing that also diverges: its oscillation grows by `exp(0.181)` and advances by 0.113 rad in each step.
const LEAVES: Wing = Wing {
    elements: 2,
    length_m: 1.0,
    youngs_modulus_pa: 7.81e7,
    density_kg_m3: 500.0,
    stiffness_n_m_rad: 43.7,
    air_kg_m3: 10.2,
    axis: 0.5,
    ..FLUTTERS
};

/// A wing of the test below; the first one has its eigenvalue between the axes, the others are random.
fn random_wing(seed: u64) -> Wing {
    if seed == 0 {
        return Wing { wake_rows: 150, ..LEAVES };
    }
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x1234_5678_9ABC_DEF1;
    let mut of = |low: f64, high: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low * (high / low).powf((state >> 11) as f64 / (1_u64 << 53) as f64)
    };
    Wing {
        elements: of(1.0, 4.0) as usize,
        length_m: of(0.5, 1.5),
        youngs_modulus_pa: of(5e6, 3e8),
        density_kg_m3: of(150.0, 600.0),
        stiffness_n_m_rad: of(2.0, 600.0),
        air_kg_m3: of(2.0, 20.0),
        speed_m_s: of(20.0, 80.0),
        chord_m: of(0.1, 0.3),
        panels: of(1.0, 3.0) as usize,
        axis: of(0.4, 0.8),
        wake_rows: of(80.0, 220.0) as usize,
        ..LEAVES
    }
}

/// Discs, together with the disc about 0, cover the eigenvalues between two magnitudes that decay by up to half of the fastest decay. None
/// extends further to the left than that decay.
#[test]
fn discs_cover_all_that_grows() {
    for (decay_1_s, from_1_s, to_1_s) in
        [(1.0, 0.0, 0.7), (1.0, 0.0, 1.3), (1.0, 0.0, 60.0), (0.02, 0.0, 3.1), (1.0, 7.0, 14.0), (1.0, 0.8, 1.6)]
    {
        let list = discs(decay_1_s, from_1_s, to_1_s);
        for disc in &list {
            assert!(disc.center_1_s.re - disc.radius_1_s > -decay_1_s * (1.0 + 1e-12), "{disc:?}");
        }
        for i in 1..400 {
            for j in 0..400 {
                let size_1_s = from_1_s + (to_1_s - from_1_s) * f64::from(i) / 400.0;
                let place = Complex::from_polar(size_1_s, PI * f64::from(j) / 400.0);
                let about_0 = size_1_s <= decay_1_s;
                let inside = |disc: &Disc| (place - disc.center_1_s).norm() <= disc.radius_1_s;
                assert!(place.re < -0.5 * decay_1_s || about_0 || list.iter().any(inside), "{place} of {to_1_s}");
            }
        }
    }
}

/// Eigenvalues of the complete discrete-time model up to a magnitude, of modes of the machine or growing modes, within the decay covered by
/// discs. They are corrected like estimates: those of a matrix with hundreds of delays are accurate to 1e-6.
fn of_the_whole(space: &SampledSpace, delays: &Delays, to_1_s: f64, free_1_s: f64) -> Vec<Complex<f64>> {
    let own = eigen(&space.matrices.a).expect("eigenvalues");
    let mut list = Vec::new();
    for (i, &z) in own.values.iter().enumerate().filter(|(_, z)| z.im >= 0.0) {
        let value = z.ln() / space.step_s;
        if value.re < -0.6 * delays.fastest_decay_1_s() || value.norm() > 1.001 * to_1_s {
            continue;
        }
        let right = DVector::from_fn(2 * space.freedoms, |row, _| {
            Complex::new(own.vectors[(row, i)], if z.im > 0.0 { own.vectors[(row, i + 1)] } else { 0.0 })
        });
        let Some(((z, right), wake)) = delays.corrected((z, right)) else { continue };
        let (found, size) = (z.ln() / space.step_s, value.norm());
        let is_it = (found - value).norm() < 1e-5 * size.max(1e-2 / space.step_s);
        let counts = found.norm() > free_1_s && found.norm() < to_1_s * (1.0 - 1e-9);
        let left_out = !grows(found) && wake > WAKE || delays.is_faster_than_steps(z, &right);
        if is_it && counts && !left_out {
            list.push(found);
        }
    }
    list
}

/// With a wake of many rows, every growing mode, and every mode that decays more slowly than the limit of discs for that wake, is
/// found once, on random soft wings in comparison with all eigenvalues of the complete model. Discs along the two axes missed strong
/// flutter between them.
#[test]
#[ignore = "long; `make long` runs it"]
fn q89_all_motions_between_the_axes_are_found() {
    const SEEDS: u64 = 10;
    let (mut strong, mut count) = (0, 0);
    for seed in 0..SEEDS {
        let wing = random_wing(seed);
        let mut plant = wing.at_rest();
        let mut study = plant.study();
        let space = study.lattice_space(&[], &|_| DVector::zeros(0)).unwrap_or_else(|error| panic!("{error}"));
        let system = study.sampled_lattice(false).unwrap_or_else(|error| panic!("{error}"));
        let delays = Delays::new(&system);
        let start = study.start_of(&delays, JUDGED_MODES).unwrap_or_else(|error| panic!("{error}"));
        let to_1_s = start.radius_1_s.expect("a wing that moves").min(delays.fastest_1_s());
        let expected = of_the_whole(&space, &delays, to_1_s, start.free_1_s);
        let values = |list: Vec<LaggedMode>| list.iter().map(|mode| mode.eigenvalue_1_s).collect::<Vec<_>>();
        let all = values(delays.inside(0.0, to_1_s, start.free_1_s, Sought::All).expect("moments"));
        let growing = values(delays.growing(to_1_s, start.free_1_s, None).expect("moments").0);
        let times = |list: &[Complex<f64>], value: &Complex<f64>| {
            list.iter().filter(|other| (*other - value).norm() < 1e-5 * value.norm()).count()
        };
        for value in &expected {
            assert_eq!(times(&all, value), 1, "{seed}: {value} in {all:?}");
            assert_eq!(times(&growing, value), usize::from(grows(*value)), "{seed}: {value} in {growing:?}");
            let decay_1_s = delays.fastest_decay_1_s();
            count += 1;
            strong += usize::from(value.re > decay_1_s && value.im > decay_1_s);
        }
        assert!(growing.iter().all(|value| times(&expected, value) == 1), "{seed}: {growing:?} {expected:?}");
    }
    assert!(strong > 0 && count > 4 * SEEDS as usize, "{strong} of {count}");
}

/// A wing whose single growing mode is a fast-growing oscillation is unstable for any number of rows. With 280 rows it was reported
/// as stable. The wake after the 100th row acts with a factor of `exp(-100 · 0.054) = 0.005` and from a distance of 100 chords: it changes
/// the eigenvalue by 3e-8.
#[test]
fn q89_strong_flutter_beside_a_wake_of_many_rows_is_an_instability() {
    let of = |wake_rows: usize| {
        let wing = Wing { wake_rows, ..FLUTTERS };
        let mut plant = wing.at_rest();
        let judged = plant.study().stability().unwrap_or_else(|error| panic!("{error}"));
        assert!(judged.in_lattice && judged.not_judged.is_none() && !judged.is_stable(), "{wake_rows}: {judged:?}");
        let list = judged.growing.iter().map(|growth| growth.eigenvalue_1_s * wing.step_s()).collect::<Vec<_>>();
        assert!(list.len() == 1 && list[0].re > 0.05 && list[0].im > 0.4, "{wake_rows}: {list:?}");
        list[0]
    };
    let rows = [100, 150, 280, 400].map(of);
    for value in &rows[1..] {
        assert!((value - rows[0]).norm() < 1e-4 * rows[0].norm(), "{rows:?}");
    }
}

/// A disc about a point off the real axis yields estimates of the eigenvalues above and below the height of its centre: the moments
/// determine them up to their mirror image at this height.
#[test]
fn estimates_above_and_below_the_centre_of_a_disc() {
    let mut plant = LEAVES.at_rest();
    let mut study = plant.study();
    let system = study.sampled_lattice(false).unwrap_or_else(|error| panic!("{error}"));
    let delays = Delays::new(&system);
    let step_s = LEAVES.step_s();
    let eigenvalue_1_s = Complex::new(0.181, 0.113) / step_s;
    let radius_1_s = 0.08 / step_s;
    for height in [-0.5, 0.5] {
        let center_1_s = eigenvalue_1_s + Complex::new(0.1, height) * radius_1_s;
        let (guesses, _) = delays.within(Disc { center_1_s, radius_1_s }).expect("moments");
        let apart = guesses.iter().map(|(z, _)| (z.ln() / step_s - eigenvalue_1_s).norm() / eigenvalue_1_s.norm());
        let nearest = apart.fold(f64::INFINITY, f64::min);
        // the eigenvalue above is quoted with three digits
        assert!(nearest < 5e-3, "at {height} of the radius below the centre: {guesses:?}");
    }
}
