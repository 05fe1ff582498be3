//! Flat wings for these cases: sections along `x`, leading edge towards `+y`, flow along `−y`.

use foldwing::aero::AirLoads;
use foldwing::aero::established::Established;
use foldwing::aero::flow::{Flow, Gust};
use foldwing::aero::lattice::{LatticeOptions, LoadRule, VortexLattice, WakeModel};
use foldwing::aero::lattice_state::LatticeState;
use foldwing::aero::near_sheets::NoCirculation;
use foldwing::aero::surface::{ChordLine, Profile, Surface};
use foldwing::load::SectionMotion;
use nalgebra::{Matrix3, Rotation3, Vector3};

pub const DENSITY_KG_M3: f64 = 1.2;
pub const SPEED_M_S: f64 = 10.0;

pub fn options() -> LatticeOptions {
    LatticeOptions {
        wake: WakeModel::Prescribed,
        wake_rows: 200,
        core_radius_m: 1e-4,
        load_rule: LoadRule::Bernoulli,
        mirror_normal: None,
        ground: None,
        speed_of_sound_m_s: None,
        threads: 1,
    }
}

/// Spanwise positions of `strips + 1` sections over a whole span, the tips inset by a quarter of a panel.
pub fn inset(span_m: f64, strips: usize) -> Vec<f64> {
    let panel_m = span_m / (strips as f64 + 0.5);
    (0..=strips).map(|i| -0.5 * span_m + panel_m * (0.25 + i as f64)).collect()
}

/// A fixed or moving wing with its lattice, states and loads.
pub struct Wing {
    pub lattice: VortexLattice,
    pub motions: Vec<SectionMotion>,
    pub from: LatticeState,
    pub to: LatticeState,
    pub loads: AirLoads,
    pub wind_m_s: Vector3<f64>,
    pub gusts: Vec<Gust>,
    pub time_s: f64,
}

impl Wing {
    /// A wing whose chord is given at every section, with the quarter chord on the axis.
    pub fn new(places_m: &[f64], chord_m: impl Fn(f64) -> f64, chord_panels: usize, options: LatticeOptions) -> Self {
        Self::with_profile(Profile::THIN, places_m, chord_m, chord_panels, options)
    }

    /// A wing with a profile.
    pub fn with_profile(
        profile: Profile,
        places_m: &[f64],
        chord_m: impl Fn(f64) -> f64,
        chord_panels: usize,
        options: LatticeOptions,
    ) -> Self {
        let chords = places_m.iter().map(|x| ChordLine {
            leading_m: Vector3::y() * (0.25 * chord_m(*x)),
            trailing_m: Vector3::y() * (-0.75 * chord_m(*x)),
        });
        let surface = Surface { sections: 0..places_m.len(), chords: chords.collect(), chord_panels, profile };
        let lattice = VortexLattice::new(vec![surface], options);
        let motions = places_m.iter().map(|x| SectionMotion {
            rotation: Matrix3::identity(),
            position_m: Vector3::x() * *x,
            velocity_m_s: Vector3::zeros(),
            spin_rad_s: Vector3::zeros(),
        });
        Self {
            motions: motions.collect(),
            from: lattice.blank_state(),
            to: lattice.blank_state(),
            loads: AirLoads::still(places_m.len()),
            lattice,
            wind_m_s: Vector3::y() * -SPEED_M_S,
            gusts: Vec::new(),
            time_s: 0.0,
        }
    }

    /// Rotates the wind by an angle of attack in rad.
    pub fn with_incidence(mut self, angle_rad: f64) -> Self {
        self.wind_m_s = Rotation3::from_axis_angle(&Vector3::x_axis(), -angle_rad) * self.wind_m_s;
        self
    }

    pub fn start(&mut self, established: bool) {
        self.try_start(established).expect("regular");
    }

    /// Starts the flow, which may fail.
    pub fn try_start(&mut self, established: bool) -> Result<(), NoCirculation> {
        let established = established.then_some(Established::straight(self.panel_step_s()));
        self.start_as(established)
    }

    /// The steady flow, for steps of this length.
    pub fn start_for_steps(&mut self, step_s: f64) {
        self.start_as(Some(Established::straight(step_s))).expect("regular");
    }

    fn start_as(&mut self, established: Option<Established>) -> Result<(), NoCirculation> {
        self.from.profile_m_s.fill(0.0);
        self.go_on_as(established)
    }

    /// The steady flow; if there are several solutions, the one next to the state in `from`.
    pub fn go_on(&mut self) -> Result<(), NoCirculation> {
        self.go_on_as(Some(Established::straight(self.panel_step_s())))
    }

    fn go_on_as(&mut self, established: Option<Established>) -> Result<(), NoCirculation> {
        let flow = Self::flow(self.time_s, self.wind_m_s, &self.gusts);
        self.lattice.start(&self.motions, &flow, established, &mut self.from, &mut self.loads)
    }

    /// Step in s in which the wind travels the length of one panel: the default.
    pub fn panel_step_s(&self) -> f64 {
        let chord = &self.lattice.surfaces()[0];
        chord.chords[0].length_m() / (chord.chord_panels as f64 * SPEED_M_S)
    }

    fn flow(time_s: f64, wind_m_s: Vector3<f64>, gusts: &[Gust]) -> Flow<'_> {
        Flow { time_s, density_kg_m3: DENSITY_KG_M3, wind_m_s, spin_rad_s: Vector3::zeros(), gusts }
    }

    /// One step to the current `motions`.
    pub fn step(&mut self, step_s: f64) {
        self.time_s += step_s;
        let flow = Self::flow(self.time_s, self.wind_m_s, &self.gusts);
        self.lattice.convect(&self.from, &flow, step_s, &mut self.to);
        let (from, to) = (&self.from, &mut self.to);
        self.lattice.solve(from, &self.motions, &flow, step_s, to, &mut self.loads).expect("regular");
        std::mem::swap(&mut self.from, &mut self.to);
    }

    /// Sum of the circulatory forces in N.
    pub fn circulatory_n(&self) -> Vector3<f64> {
        self.loads.circulatory.iter().map(|load| load.force_n).sum()
    }

    /// Sum of the impulsive forces in N.
    pub fn impulsive_n(&self) -> Vector3<f64> {
        self.loads.impulsive.iter().map(|load| load.force_n).sum()
    }
}

/// `½ρV²` in Pa.
pub fn pressure_pa() -> f64 {
    0.5 * DENSITY_KG_M3 * SPEED_M_S * SPEED_M_S
}
