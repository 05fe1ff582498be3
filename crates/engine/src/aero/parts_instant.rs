//! Aerodynamic models side by side at one instant: their responses stacked, NOTATION eq. (W23), with the derivatives.
//!
//! Rows of the response: the loads of all sections in their frames, six each; the rates of the lag states, model by model; then the other
//! rows, model by model: circulations and hinge moments of strips, loads and coefficients of a rotor.

use crate::aero::flap::Deflection;
use crate::aero::near_sheets::NoCirculation;
use crate::aero::parts::Placed;
use crate::aero::rotor::bem::Rotor;
use crate::aero::strip::continuous::{Answer, LOAD_ROWS, Variable};
use crate::aero::strip::instant::{Instant, SectionAcceleration};
use crate::aero::{AirModel, AirModels, AirState, AirStates};
use crate::load::SectionMotion;
use nalgebra::Vector3;
use std::borrow::Cow;
use std::ops::Range;

/// Places of the responses of all models in the stack, and scratch.
pub struct Stack {
    /// Whether gusts have separate lag states.
    gusts: bool,
    parts: Vec<Level>,
    rows: usize,
    lags: usize,
}

/// The response of one model.
struct Level {
    /// Its lag states among all.
    lags: Range<usize>,
    /// The rows of its rates among all.
    rate_rows: Range<usize>,
    /// Its other rows among all.
    rest_rows: Range<usize>,
    accelerations: Vec<SectionAcceleration>,
    flap_rad_s2: Vec<f64>,
    answer: Answer,
}

impl Stack {
    /// Number of rows of the response of all models.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of lag states of all models.
    pub fn lags(&self) -> usize {
        self.lags
    }
}

impl Level {
    /// Writes the rows of the model among those of all.
    fn put(&self, answer: &[f64], sections: &[usize], all: &mut [f64]) {
        let (loads, rest) = answer.split_at(LOAD_ROWS * sections.len());
        for (rows, section) in loads.chunks_exact(LOAD_ROWS).zip(sections) {
            all[LOAD_ROWS * section..][..LOAD_ROWS].copy_from_slice(rows);
        }
        let (rates, rest) = rest.split_at(self.lags.len());
        all[self.rate_rows.clone()].copy_from_slice(rates);
        all[self.rest_rows.clone()].copy_from_slice(rest);
    }
}

impl Placed {
    /// Copies the part of an instant of all models that concerns this one.
    fn gather_instant(&mut self, at: &Instant, level: &mut Level) {
        self.gather(&at.motions);
        for (own, section) in level.accelerations.iter_mut().zip(&self.sections) {
            *own = at.accelerations[*section];
        }
        for ((own, second), flap) in self.deflections.iter_mut().zip(&mut level.flap_rad_s2).zip(&self.flaps) {
            (*own, *second) = (at.flaps[*flap], at.flap_rad_s2[*flap]);
        }
    }

    /// The variable of this model that is a variable of all; `None` if it belongs to another model.
    fn own_variable(&self, variable: Variable, lags: &Range<usize>) -> Option<Variable> {
        let own_flap = |flap: usize| self.flaps.iter().position(|own| *own == flap);
        match variable {
            Variable::Motion { section, component } => {
                let section = self.sections.iter().position(|own| *own == section)?;
                Some(Variable::Motion { section, component })
            }
            Variable::Lag(lag) => lags.contains(&lag).then(|| Variable::Lag(lag - lags.start)),
            Variable::Air(_) | Variable::AirRate(_) => Some(variable),
            Variable::FlapAngle(flap) => own_flap(flap).map(Variable::FlapAngle),
            Variable::FlapRate(flap) => own_flap(flap).map(Variable::FlapRate),
            Variable::FlapAcceleration(flap) => own_flap(flap).map(Variable::FlapAcceleration),
        }
    }
}

/// The instant of one model, from the gathered motions.
fn instant_of<'a>(
    at: &'a Instant,
    lags: &Range<usize>,
    motions: &'a [SectionMotion],
    accelerations: &'a [SectionAcceleration],
    flaps: (&'a [Deflection], &'a [f64]),
) -> Instant<'a> {
    Instant {
        motions: Cow::Borrowed(motions),
        accelerations: Cow::Borrowed(accelerations),
        flow: at.flow,
        gust_m_s: at.gust_m_s,
        lags: Cow::Borrowed(&at.lags[lags.clone()]),
        flaps: Cow::Borrowed(flaps.0),
        flap_rad_s2: Cow::Borrowed(flaps.1),
    }
}

impl AirModels {
    /// Places of the responses of the models at an instant; `None` with a lattice, which has none.
    pub fn stack(&self, gusts: bool) -> Option<Stack> {
        let sizes: Vec<[usize; 2]> =
            self.parts.iter().map(|part| part.model.instant_rows(gusts)).collect::<Option<_>>()?;
        let lags = sizes.iter().map(|[lags, _]| lags).sum::<usize>();
        let (mut lag, mut row) = (0, LOAD_ROWS * self.sections() + lags);
        let first_rate = LOAD_ROWS * self.sections();
        let place = |(part, [own_lags, rest]): (&Placed, [usize; 2])| {
            let level = Level {
                lags: lag..lag + own_lags,
                rate_rows: first_rate + lag..first_rate + lag + own_lags,
                rest_rows: row..row + rest,
                accelerations: vec![[Vector3::zeros(); 2]; part.sections.len()],
                flap_rad_s2: vec![0.0; part.flaps.len()],
                answer: vec![0.0; LOAD_ROWS * part.sections.len() + own_lags + rest],
            };
            (lag, row) = (lag + own_lags, row + rest);
            level
        };
        let parts = self.parts.iter().zip(sizes).map(place).collect();
        Some(Stack { gusts, parts, rows: row, lags })
    }

    /// Lag states of the states of the models, in the order of linear models; `None` with a lattice.
    pub fn lag_values(&self, states: &AirStates, gusts: bool) -> Option<Vec<f64>> {
        let own = self.parts.iter().zip(&states.0).map(|(part, state)| match (&part.model, state) {
            (AirModel::Strips(strips), AirState::Strips(state)) => Some(strips.lags_m_s(state, gusts)),
            (AirModel::Rotor(rotor), AirState::Rotor(state)) => Some(rotor.lag_values(state)),
            (AirModel::SlenderBody(_), AirState::SlenderBody(_)) => Some(Vec::new()),
            (AirModel::Lattice(_) | AirModel::Strips(_) | AirModel::Rotor(_) | AirModel::SlenderBody(_), _) => None,
        });
        Some(own.collect::<Option<Vec<Vec<f64>>>>()?.concat())
    }

    /// Loads, rates of the lag states and other results of all models at an instant. Allocates nothing without uniform gust.
    pub fn respond(&mut self, at: &Instant, stack: &mut Stack, answer: &mut [f64]) {
        let gusts = stack.gusts;
        for (part, level) in self.parts.iter_mut().zip(&mut stack.parts) {
            part.gather_instant(at, level);
            let Placed { model, motions, deflections, .. } = part;
            let flaps = (&deflections[..], &level.flap_rad_s2[..]);
            let own = instant_of(at, &level.lags, motions, &level.accelerations, flaps);
            model.respond(&own, gusts, &mut level.answer);
            level.put(&level.answer, &part.sections, answer);
        }
    }

    /// Part and section of the annuli whose balance can jump; `of_loads`: of those whose loads jump with it.
    pub fn switches(&self, of_loads: bool) -> impl Iterator<Item = [usize; 2]> {
        self.rotors(of_loads).flat_map(|(part, rotor)| rotor.switches().map(move |section| [part, section]))
    }

    /// Reads the distances of these annuli from their jumps in the last response, eq. (W24).
    pub fn read_switches(&self, of_loads: bool, mut distances: &mut [f64]) {
        for (_, rotor) in self.rotors(of_loads) {
            let (own, rest) = distances.split_at_mut(rotor.switches().count());
            rotor.read_switches(own);
            distances = rest;
        }
    }

    fn rotors(&self, whose_loads_jump: bool) -> impl Iterator<Item = (usize, &Rotor)> {
        self.parts.iter().enumerate().filter_map(move |(index, part)| match &part.model {
            AirModel::Rotor(rotor) => Some((index, &**rotor)).filter(|_| !whose_loads_jump || rotor.loads_jump()),
            AirModel::Lattice(_) | AirModel::Strips(_) | AirModel::SlenderBody(_) => None,
        })
    }

    /// Derivative of the response of all models; models that a variable does not reach have rows of 0.
    pub fn slope(&mut self, at: &Instant, stack: &mut Stack, variable: Variable) -> Answer {
        let (gusts, mut all) = (stack.gusts, vec![0.0; stack.rows]);
        for (part, level) in self.parts.iter_mut().zip(&mut stack.parts) {
            let Some(variable) = part.own_variable(variable, &level.lags) else { continue };
            part.gather_instant(at, level);
            let Placed { model, motions, deflections, .. } = part;
            let flaps = (&deflections[..], &level.flap_rad_s2[..]);
            let own = instant_of(at, &level.lags, motions, &level.accelerations, flaps);
            let slope = model.slope(&own, gusts, variable);
            level.put(&slope, &part.sections, &mut all);
        }
        all
    }

    /// Reason why a model does not hold for the last response: a strip at the speed of sound, surfaces that overlap.
    pub fn invalid(&self) -> Option<NoCirculation> {
        self.parts.iter().find_map(|part| match &part.model {
            AirModel::Strips(strips) => strips.validity().err().map(|error| part.name(error)),
            AirModel::Lattice(_) | AirModel::Rotor(_) | AirModel::SlenderBody(_) => None,
        })
    }

    /// Takes the part and the section of it whose momentum balance jumped between the two sides of a derivative since the last call.
    pub fn jump(&mut self) -> Option<[usize; 2]> {
        self.parts.iter_mut().enumerate().find_map(|(index, part)| match &mut part.model {
            AirModel::Rotor(rotor) => Some([index, rotor.jump()?]),
            AirModel::Lattice(_) | AirModel::Strips(_) | AirModel::SlenderBody(_) => None,
        })
    }

    /// One lag state in the states of the models, in its unit.
    pub fn lag_value(&self, states: &AirStates, stack: &Stack, lag: usize) -> f64 {
        let parts = self.parts.iter().zip(&states.0).zip(&stack.parts);
        let found = parts.filter(|(_, level)| level.lags.contains(&lag)).find_map(|((part, state), level)| {
            let own = lag - level.lags.start;
            match (&part.model, state) {
                (AirModel::Strips(strips), AirState::Strips(state)) => Some(strips.lag_m_s(state, stack.gusts, own)),
                (AirModel::Rotor(rotor), AirState::Rotor(state)) => Some(rotor.lag_value(state, own)),
                (AirModel::Lattice(_) | AirModel::Strips(_) | AirModel::Rotor(_) | AirModel::SlenderBody(_), _) => None,
            }
        });
        found.unwrap_or_default()
    }

    /// Stores lag states in the states of the models.
    pub fn set_lags(&self, lags: &[f64], stack: &Stack, states: &mut AirStates) {
        for ((part, state), level) in self.parts.iter().zip(&mut states.0).zip(&stack.parts) {
            match (&part.model, state) {
                (AirModel::Strips(strips), AirState::Strips(state)) => {
                    strips.set_lags(&lags[level.lags.clone()], stack.gusts, state);
                }
                (AirModel::Rotor(rotor), AirState::Rotor(state)) => {
                    rotor.set_lags(&lags[level.lags.clone()], state);
                }
                (AirModel::Lattice(_) | AirModel::Strips(_) | AirModel::Rotor(_) | AirModel::SlenderBody(_), _) => {}
            }
        }
    }

    /// Stores the last [`AirModels::respond`] in the states of the models: results, lag states (`lags`), and momenta of slender bodies.
    pub fn remember(&self, lags: &[f64], stack: &Stack, states: &mut AirStates) {
        for ((part, state), level) in self.parts.iter().zip(&mut states.0).zip(&stack.parts) {
            match (&part.model, state) {
                (AirModel::Strips(strips), AirState::Strips(state)) => {
                    strips.remember(&lags[level.lags.clone()], stack.gusts, &level.answer, state);
                }
                (AirModel::SlenderBody(body), AirState::SlenderBody(state)) => body.remember(state),
                (AirModel::Rotor(rotor), AirState::Rotor(state)) => rotor.remember(state),
                (AirModel::Lattice(_) | AirModel::Strips(_) | AirModel::Rotor(_) | AirModel::SlenderBody(_), _) => {}
            }
        }
    }

    /// Adds a multiple of the other rows of a response of all models to their states.
    pub fn add_rest(&self, answer: &[f64], amount: f64, states: &mut AirStates) {
        let sizes = self.parts.iter().map(|part| part.model.rest_rows());
        let mut rest = &answer[answer.len() - sizes.sum::<usize>()..];
        for (part, state) in self.parts.iter().zip(&mut states.0) {
            let (own, others) = rest.split_at(part.model.rest_rows());
            part.model.add_rest(own, amount, state);
            rest = others;
        }
    }
}
