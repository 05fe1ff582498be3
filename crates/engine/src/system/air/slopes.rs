//! Derivatives of the aerodynamic response to small motions of the model, its lag states and its inputs, in continuous time: strips,
//! NOTATION eqs. (W13) and (W14), rotors, eqs. (B27) and (B31), and slender bodies, eqs. (W21) and (W22), stacked by eq. (W23).

use crate::aero::strip::continuous::{AIR_VARIABLES, LOAD_ROWS, LagPlace, MOTION_VARIABLES, Variable};
use crate::aero::strip::instant::{Instant, SectionAcceleration};
use crate::aero::{AirModel, AirPart};
use crate::load::SectionMotion;
use crate::machine;
use crate::system::air::controls::deflections;
use crate::system::air::gaps;
use crate::system::air::start::flow;
use crate::system::air::{AirHistory, StepLoads};
use crate::system::{PlantError, System};
use nalgebra::{DMatrix, Vector3};

/// Variables of the motion of a section.
pub(crate) const SECTION_VARIABLES: usize = MOTION_VARIABLES;
/// Components of the wind and of the angular velocity of the root frame, whose rates have an effect too.
const AIR_RATES: usize = 6;

/// Aerodynamic response per unit of each variable. Rows: loads of the sections in their frames (six each), rates of the lag states in their
/// units per s, and then, model by model, circulations in m²/s and hinge moments in N·m of strips, or loads and coefficients of a rotor.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AirSlopes {
    /// Number of load rows.
    pub load_rows: usize,
    /// Names of the lag states.
    pub lags: Vec<String>,
    /// Derivatives with respect to the degrees of freedom: coordinates, rates, accelerations.
    pub motion: [DMatrix<f64>; 3],
    /// Derivatives with respect to the lag states.
    pub lag: DMatrix<f64>,
    /// Derivatives with respect to wind, angular velocity of the root frame, rates of the control surfaces, uniform gust, angles of the
    /// control surfaces.
    pub air: DMatrix<f64>,
    /// Derivatives with respect to the rates of wind, angular velocity of the root frame and rates of the control surfaces.
    pub air_rate: DMatrix<f64>,
}

impl System {
    /// Whether the aerodynamic models have linear models in continuous time: strips, rotors and slender bodies.
    pub fn air_is_linearised(&self) -> bool {
        self.air.as_ref().is_some_and(|air| air.settings.is_linearised())
    }

    /// Derivatives of the aerodynamic response at the current state, of all models. `sections` holds motion and accelerations of all
    /// sections; `by` holds their derivatives with respect to coordinates, rates and accelerations of the degrees of freedom,
    /// [`SECTION_VARIABLES`] rows for each section. `None` without aerodynamics or with a lattice.
    ///
    /// # Errors
    /// If strips with a speed of sound reach Mach 1, or if the momentum balance of an annulus is discontinuous.
    pub(crate) fn air_slopes(
        &mut self,
        sections: &[(SectionMotion, SectionAcceleration)],
        by: [&DMatrix<f64>; 3],
        gusts: bool,
    ) -> Result<Option<AirSlopes>, PlantError> {
        let Some(lags) = self.present_lags(gusts) else { return Ok(None) };
        let Some(air) = self.air.as_mut() else { return Ok(None) };
        let gusts = air.has_gust_lags(gusts);
        let at = Instant {
            motions: sections.iter().map(|(motion, _)| *motion).collect::<Vec<_>>().into(),
            accelerations: sections.iter().map(|(_, acceleration)| *acceleration).collect::<Vec<_>>().into(),
            flow: flow(&air.settings, &self.state, self.state.now.time_s),
            gust_m_s: Vector3::zeros(),
            lags: lags.into(),
            flaps: deflections(&air.settings, &self.state.applied_inputs).collect::<Vec<_>>().into(),
            flap_rad_s2: vec![0.0; air.settings.flaps.len()].into(),
        };
        let model = &mut air.model;
        let Some(mut stack) = model.stack(gusts) else { return Ok(None) };
        let rows = stack.rows();
        model.respond(&at, &mut stack, &mut vec![0.0; rows]);
        if let Some(failure) = model.invalid() {
            return Err(gaps::failure(&self.machine, &air.settings, self.state.now.time_s, failure));
        }
        let mut motion = by.map(|matrix| DMatrix::zeros(rows, matrix.ncols()));
        for section in 0..sections.len() {
            for component in 0..SECTION_VARIABLES {
                let place = section * SECTION_VARIABLES + component;
                if by.iter().all(|matrix| matrix.row(place).iter().all(|entry| *entry == 0.0)) {
                    continue;
                }
                let slope = model.slope(&at, &mut stack, Variable::Motion { section, component });
                for (target, matrix) in motion.iter_mut().zip(by) {
                    let along = matrix.row(place);
                    for (row, value) in slope.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                        target.row_mut(row).zip_apply(&along, |entry, along| *entry += value * along);
                    }
                }
            }
        }
        let mut columns = |variables: Vec<Variable>| {
            let slopes: Vec<f64> =
                variables.iter().flat_map(|variable| model.slope(&at, &mut stack, *variable)).collect();
            DMatrix::from_vec(rows, variables.len(), slopes)
        };
        let lag = columns((0..at.lags.len()).map(Variable::Lag).collect());
        let flaps = 0..at.flaps.len();
        let shared = (0..AIR_RATES).map(Variable::Air).chain(flaps.clone().map(Variable::FlapRate));
        let shared = shared.chain((AIR_RATES..AIR_VARIABLES).map(Variable::Air));
        let air_columns = columns(shared.chain(flaps.clone().map(Variable::FlapAngle)).collect());
        let rates = (0..AIR_RATES).map(Variable::AirRate);
        let air_rate = columns(rates.chain(flaps.map(Variable::FlapAcceleration)).collect());
        if let Some([part, section]) = model.jump() {
            return Err(self.no_slope(part, section));
        }
        Ok(Some(AirSlopes {
            load_rows: LOAD_ROWS * sections.len(),
            lags: self.lag_names(gusts),
            motion,
            lag,
            air: air_columns,
            air_rate,
        }))
    }

    /// Names, units and values of the aerodynamic lag states at the current state, in the order of linear models.
    pub fn air_lags(&self, gusts: bool) -> Vec<(String, &'static str, f64)> {
        let values = self.present_lags(gusts).unwrap_or_default();
        let names = self.lag_names(gusts).into_iter().zip(self.lag_units(gusts));
        names.zip(values).map(|((name, unit), value)| (name, unit, value)).collect()
    }

    /// Units of the lag states, in the order of linear models.
    pub(crate) fn lag_units(&self, gusts: bool) -> Vec<&'static str> {
        let Some(air) = &self.air else { return Vec::new() };
        let of = |(model, _): (&AirModel, _)| match model {
            AirModel::Rotor(rotor) => rotor.lags().iter().map(|(_, lag)| lag.unit()).collect(),
            AirModel::Strips(strips) => vec!["m/s"; strips.lag_count(air.has_gust_lags(gusts))],
            AirModel::Lattice(_) | AirModel::SlenderBody(_) => Vec::new(),
        };
        air.model.each().flat_map(of).collect()
    }

    /// Names of the lag states, in the order of linear models.
    pub(crate) fn lag_names(&self, gusts: bool) -> Vec<String> {
        let Some(air) = &self.air else { return Vec::new() };
        let own = air.settings.parts.iter().zip(air.model.each());
        own.flat_map(|(part, (model, _))| match model {
            AirModel::Strips(model) => {
                let places = model.lags(air.has_gust_lags(gusts));
                places.iter().map(|place| self.lag_name(part, place)).collect()
            }
            AirModel::Rotor(model) => {
                let places: Vec<String> = self.stations_of_blades(part);
                model.lags().iter().map(|(section, lag)| format!("{}.{}", places[*section], lag.name())).collect()
            }
            AirModel::Lattice(_) | AirModel::SlenderBody(_) => Vec::new(),
        })
        .collect()
    }

    /// Surfaces of an aerodynamic part.
    fn surfaces_of<'s>(&'s self, part: &'s AirPart) -> impl Iterator<Item = &'s machine::LiftingSurface> {
        let air = self.machine.air.iter();
        air.flat_map(|air| part.surfaces.iter().map(|surface| &air.surfaces[*surface]))
    }

    /// Names of the sections of a rotor's blades: `blade1.station[3]`.
    fn stations_of_blades(&self, part: &AirPart) -> Vec<String> {
        let blades = self.surfaces_of(part);
        let of = |blade: &machine::LiftingSurface| {
            let body = self.machine.bodies[blade.body].name.clone();
            (1..=blade.positions_m.len()).map(move |station| format!("{body}.station[{station}]"))
        };
        blades.flat_map(of).collect()
    }

    /// Error: the momentum balance of an annulus is discontinuous, so that there is no linear model.
    pub(crate) fn no_slope(&self, part: usize, section: usize) -> PlantError {
        let part = self.machine.air.as_ref().and_then(|air| air.parts.get(part));
        let blades = part.map_or_else(Vec::new, |part| self.stations_of_blades(part));
        let place = blades.get(section).cloned().unwrap_or_default();
        let cause = format!(
            "the momentum balance of {place} is discontinuous at this operating point, between two states of the \
             annulus; choose another wind, pitch or rotor speed, or write inflow_lag_s, with which it is continuous"
        );
        PlantError::Linearization { time_s: self.state.now.time_s, cause }
    }

    /// Largest aerodynamic load so far in N.
    pub(crate) fn air_scale_n(&self) -> f64 {
        self.state.air.as_ref().map_or(0.0, |history| history.scale_n)
    }

    /// Adds a multiple of a response to the loads and circulations in the state; returns their previous values.
    pub(crate) fn add_to_air(&mut self, answer: &[f64], amount: f64) -> Option<AirHistory> {
        let history = self.state.air.as_mut()?;
        let kept = history.clone();
        let loads = &answer[..LOAD_ROWS * history.at_begin.len()];
        let StepLoads { from, to, .. } = &mut history.loads;
        for ((from, to), entries) in from.iter_mut().zip(to).zip(loads.chunks_exact(LOAD_ROWS)) {
            for load in [from, to] {
                load.force_n += Vector3::from_column_slice(&entries[..3]) * amount;
                load.moment_n_m += Vector3::from_column_slice(&entries[3..]) * amount;
            }
        }
        if let Some(air) = &self.air {
            for states in [&mut history.before, &mut history.after] {
                air.model.add_rest(answer, amount, states);
            }
        }
        Some(kept)
    }

    /// Undoes [`System::add_to_air`].
    pub(crate) fn take_air_back(&mut self, kept: Option<AirHistory>) {
        self.state.air = kept;
        self.configure();
    }

    /// Name of a lag state, `wing.strip[3].lag[1]`, or for gusts `wing.strip[3].gust_lag[1]`.
    fn lag_name(&self, part: &AirPart, place: &LagPlace) -> String {
        let mut strip = place.strip;
        for surface in self.surfaces_of(part) {
            let own = surface.positions_m.len() - 1;
            if strip < own {
                let (body, kind) =
                    (&self.machine.bodies[surface.body].name, if place.gust { "gust_lag" } else { "lag" });
                return format!("{body}.strip[{}].{kind}[{}]", strip + 1, place.term + 1);
            }
            strip -= own;
        }
        String::new()
    }
}
