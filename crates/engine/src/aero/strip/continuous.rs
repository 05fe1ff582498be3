//! Strips in continuous time: loads and rates of the lags at one instant, and their derivatives with respect to the motion of the
//! sections and to the air, NOTATION eqs. (W13) and (W14).
//!
//! The limit of the steps of [`Strips::solve`] as they shrink: the lag states of (W6) obey `ẋ = b (2Q/c)(w − x)`, and the apparent mass of
//! (W8) is proportional to the accelerations of the sections at the instant.

use crate::aero::flap::HingeMoment;
use crate::aero::flow::Flow;
use crate::aero::pieces::Pieces;
use crate::aero::strip::flap::MassRates;
use crate::aero::strip::indicial::Lag;
use crate::aero::strip::instant::Instant;
use crate::aero::strip::section::{Cut, Strip};
use crate::aero::strip::{Inflow, StripState, Strips};
use crate::load::Wrench;
use crate::math::corners::slope_off_corners;
use nalgebra::{Rotation3, Vector3};
use std::borrow::Cow;
use std::f64::consts::PI;
use std::ops::Range;

/// Number of rows for the loads of a section: force and moment in its own frame.
pub const LOAD_ROWS: usize = 6;
/// Variables of a section's motion: position, rotation, velocity, angular velocity, acceleration, angular acceleration,
/// root frame.
pub const MOTION_VARIABLES: usize = 18;
/// Variables of the air that all strips share: wind, angular velocity of the root frame, uniform gust, root frame.
pub const AIR_VARIABLES: usize = 9;
/// Step of a difference over the strip's own scale: its span or chord, its relative speed. The seventh derivatives that
/// the sixth-order rule drops weigh 1e-18 of that scale, round-off 1e-12.
const STEP: f64 = 1e-3;
/// Lower bound of the speed for difference steps in the velocity, over that of the fastest strip: a strip at the hub of a rotor, or at the
/// centre of a turn, has no speed.
const SLOWEST: f64 = 1e-3;
/// Kinds of the loads of sections, as in [`slope_off_corners`]: 0 of forces, 1 of moments.
pub(crate) fn kinds_of_loads(sections: usize) -> Vec<usize> {
    (0..LOAD_ROWS * sections).map(|row| row % LOAD_ROWS / 3).collect()
}

/// Loads of all sections in their own frames, six rows each, then rates of the lag states in m/s², then circulations of the strips in m²/s,
/// then hinge moments of the control surfaces in N·m.
pub type Answer = Vec<f64>;

/// The variable of a derivative.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variable {
    /// One of the [`MOTION_VARIABLES`] of a section.
    Motion {
        /// The section.
        section: usize,
        /// Component of the variable.
        component: usize,
    },
    /// One of the lag states.
    Lag(usize),
    /// One of the [`AIR_VARIABLES`].
    Air(usize),
    /// Rate of one of the first six components, which acts only on the apparent mass.
    AirRate(usize),
    /// Angle of a control surface.
    FlapAngle(usize),
    /// Rate of a control surface.
    FlapRate(usize),
    /// Second derivative of the angle of a control surface, which acts only on the apparent mass.
    FlapAcceleration(usize),
}

/// Place of a lag state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LagPlace {
    /// Strip, surface by surface.
    pub strip: usize,
    /// True for gusts and the velocity induced by the lifting line; false for motion and wind.
    pub gust: bool,
    /// Term of the fit.
    pub term: usize,
}

impl Strips {
    /// The lag states in the order of [`Instant::lags`]: strip by strip those of the motion, and those of gusts if the model has a lifting
    /// line or with `gusts`. Empty without lag.
    pub fn lags(&self, gusts: bool) -> Vec<LagPlace> {
        if !self.options.unsteady {
            return Vec::new();
        }
        let [motion, gust] = self.lag_terms(gusts);
        let of = |strip: usize| {
            let place = move |gust: bool| move |term: usize| LagPlace { strip, gust, term };
            (0..motion).map(place(false)).chain((0..gust).map(place(true)))
        };
        (0..self.strips.len()).flat_map(of).collect()
    }

    /// Numbers of lag states of motion and of gusts of one strip.
    fn lag_terms(&self, gusts: bool) -> [usize; 2] {
        let fit = self.options.fit;
        let gusts = gusts || self.line.is_some();
        if self.options.unsteady { [fit.wagner().terms, if gusts { fit.kuessner().terms } else { 0 }] } else { [0; 2] }
    }

    /// Number of strips.
    pub fn count(&self) -> usize {
        self.strips.len()
    }

    /// Lag states of a state, in the order of [`Strips::lags`].
    pub fn lags_m_s(&self, state: &StripState, gusts: bool) -> Vec<f64> {
        let of = |place: LagPlace| {
            let history = &state.strips[place.strip];
            if place.gust { history.gust.followers_m_s[place.term] } else { history.motion.followers_m_s[place.term] }
        };
        self.lags(gusts).into_iter().map(of).collect()
    }

    /// Number of lag states, as in [`Strips::lags`].
    pub fn lag_count(&self, gusts: bool) -> usize {
        self.lag_terms(gusts).iter().sum::<usize>() * self.strips.len()
    }

    /// One lag state of a state, in m/s.
    pub fn lag_m_s(&self, state: &StripState, gusts: bool, lag: usize) -> f64 {
        let [motion, gust] = self.lag_terms(gusts);
        let (history, term) = (&state.strips[lag / (motion + gust)], lag % (motion + gust));
        let own = if term < motion { &history.motion } else { &history.gust };
        own.followers_m_s[if term < motion { term } else { term - motion }]
    }

    /// Stores lag states in m/s in a state.
    pub fn set_lags(&self, lags_m_s: &[f64], gusts: bool, state: &mut StripState) {
        let [motion, gust] = self.lag_terms(gusts);
        for (history, own) in state.strips.iter_mut().zip(lags_m_s.chunks_exact((motion + gust).max(1))) {
            history.motion.followers_m_s[..motion].copy_from_slice(&own[..motion]);
            history.gust.followers_m_s[..gust].copy_from_slice(&own[motion..]);
        }
    }

    /// Loads, rates of the lag states and circulations at an instant, eq. (W13).
    pub fn answer(&mut self, at: &Instant, gusts: bool) -> Answer {
        let mut answer = vec![0.0; self.rows(at.motions.len(), gusts)];
        self.respond(at, gusts, &mut answer);
        answer
    }

    /// The same into a buffer of [`Strips::rows`] entries. Allocates nothing without a uniform gust.
    pub fn respond(&mut self, at: &Instant, gusts: bool, answer: &mut [f64]) {
        self.answer_of(at, gusts, 0..self.strips.len(), answer);
    }

    /// Stores the instant of the last [`Strips::respond`] in a state, with its lag states and response: steps can continue from there.
    pub fn remember(&self, lags_m_s: &[f64], gusts: bool, answer: &[f64], state: &mut StripState) {
        let [motion, gust] = self.lag_terms(gusts);
        let end = answer.len() - self.flap_count();
        let circulations = &answer[end - self.strips.len()..end];
        let strips = state.strips.iter_mut().zip(&self.inflows).zip(circulations);
        for (index, ((history, now), circulation_m2_s)) in strips.enumerate() {
            let own = &lags_m_s[index * (motion + gust)..][..motion + gust];
            let mut lags = [Lag::established(now.downwash_m_s), Lag::established(now.gust_downwash_m_s)];
            lags[0].followers_m_s[..motion].copy_from_slice(&own[..motion]);
            lags[1].followers_m_s[..gust].copy_from_slice(&own[motion..]);
            *history = now.history(lags[0], lags[1]);
            history.circulation_m2_s = *circulation_m2_s;
        }
        for (hinge, moment_n_m) in state.hinges.iter_mut().zip(&answer[end..]) {
            *hinge = HingeMoment { circulatory_n_m: *moment_n_m, impulsive_n_m: 0.0 };
        }
    }

    /// Length of an [`Answer`].
    pub fn rows(&self, sections: usize, gusts: bool) -> usize {
        LOAD_ROWS * sections + self.lag_count(gusts) + self.strips.len() + self.flap_count()
    }

    /// Kinds of the rows of an [`Answer`]: forces, moments, rates of lag states, circulations, hinge moments.
    fn kinds(&self, sections: usize, gusts: bool) -> Vec<usize> {
        let mut kinds = kinds_of_loads(sections);
        let rest = [self.lag_count(gusts), self.strips.len(), self.flap_count()];
        kinds.extend(rest.into_iter().zip(2..).flat_map(|(count, kind)| std::iter::repeat_n(kind, count)));
        kinds
    }

    /// The same for some strips, or for all if a lifting line couples them; the loads of other strips are zero.
    fn answer_of(&mut self, at: &Instant, gusts: bool, strips: Range<usize>, answer: &mut [f64]) {
        answer.fill(0.0);
        self.deflect(&at.flaps);
        let strips = if self.line.is_some() { 0..self.strips.len() } else { strips };
        // only differences have a uniform gust; evaluations for an integrator allocate nothing
        let all = at.gusts();
        let flow = Flow { gusts: &all, ..at.flow };
        let terms = self.lag_terms(gusts);
        let lag = |strip: usize, now_m_s: f64, gust: bool| {
            let mut lag = Lag::established(now_m_s);
            let first = strip * (terms[0] + terms[1]) + if gust { terms[0] } else { 0 };
            let count = terms[usize::from(gust)];
            lag.followers_m_s[..count].copy_from_slice(&at.lags[first..first + count]);
            lag
        };
        self.inflows.clear();
        let (own, profiles, controls) = (&self.strips, &self.profiles, &self.controls);
        let meet = |index: usize| {
            let strip = &own[index];
            Inflow::of(strip, &profiles[strip.surface], controls.on(index), &at.motions, &flow)
        };
        self.inflows.extend(strips.clone().map(meet));
        if self.line.is_some() {
            self.meet(&at.motions, &flow);
            let options = self.options;
            self.add_induced(|strip, now, gust_m_s| {
                options.effective_m_s(&lag(strip, now.downwash_m_s, false), &lag(strip, gust_m_s, true))
            });
        }
        let sections = at.motions.len();
        let mut loads = std::mem::take(&mut self.section_loads);
        loads.clear();
        loads.resize(sections, Wrench::default());
        let hinges = answer.len() - self.flap_count();
        for (index, now) in strips.zip(&self.inflows) {
            let strip = &self.strips[index];
            let profile = &self.profiles[strip.surface];
            let lags = [lag(index, now.downwash_m_s, false), lag(index, now.gust_downwash_m_s, true)];
            let effective_m_s = self.options.effective_m_s(&lags[0], &lags[1]);
            let suction = self.options.leading_edge_suction;
            let pieces = &mut Pieces::Free;
            let section = now.section_loads(strip, profile, suction, effective_m_s, flow.density_kg_m3, pieces);
            strip.add_force(&mut loads, &now.cut, section.fraction, &(section.force_n_m * now.cut.span_m));
            strip.add_moment(&mut loads, &now.cut, section.moment_n * now.cut.span_m);
            self.add_legs(index, section.circulation_m2_s, flow.density_kg_m3, &mut loads);
            let mut hinge_n_m =
                now.add_flap(strip, section.circulation_m2_s, flow.density_kg_m3, profile.polar.is_none(), &mut loads);
            if self.options.apparent_mass {
                let rates = add_apparent_mass(strip, &now.cut, at, &flow, &mut loads);
                let flap_rad_s2 = now.flap.map_or(0.0, |flap| flap.share * at.flap_rad_s2[flap.flap]);
                let rates = MassRates { flap_rad_s2, ..rates };
                hinge_n_m += now.add_flap_mass(strip, flow.density_kg_m3, &now.cut.up, &rates, &mut loads);
            }
            if let Some(flap) = &now.flap {
                answer[hinges + flap.flap] += hinge_n_m;
            }
            let way_1_s = 2.0 * now.speed_m_s / now.cut.chord_m;
            let fits = [self.options.fit.wagner(), self.options.fit.kuessner()];
            let mut row = LOAD_ROWS * sections + index * (terms[0] + terms[1]);
            for ((lag, fit), count) in lags.iter().zip(fits).zip(terms) {
                for term in 0..count {
                    answer[row] = fit.rates[term] * way_1_s * (lag.downwash_m_s - lag.followers_m_s[term]);
                    row += 1;
                }
            }
            let circulations = LOAD_ROWS * sections + (terms[0] + terms[1]) * self.strips.len();
            answer[circulations + index] = section.circulation_m2_s;
        }
        for ((load, motion), rows) in loads.iter().zip(at.motions.iter()).zip(answer.chunks_exact_mut(LOAD_ROWS)) {
            let turned = motion.rotation.transpose();
            rows[..3].copy_from_slice((turned * load.force_n).as_slice());
            rows[3..].copy_from_slice((turned * load.moment_n_m).as_slice());
        }
        self.section_loads = loads;
    }

    /// Derivative of the [`Answer`] at an instant: sixth-order central differences over the scale of the strips
    /// concerned, eq. (W14), off the kinks of polars down to steps of 2e-7 rad; exact for accelerations, in which it is linear.
    pub fn slope(&mut self, at: &Instant, gusts: bool, variable: Variable) -> Answer {
        let strips = self.touched(at, gusts, variable);
        let scale = self.scale(at, strips.clone(), variable);
        let rows = self.rows(at.motions.len(), gusts);
        let Some(step) = scale else { return vec![0.0; rows] };
        let kinds = self.kinds(at.motions.len(), gusts);
        let linear = matches!(
            variable,
            Variable::Motion { component: 12.., .. } | Variable::AirRate(_) | Variable::FlapAcceleration(_)
        );
        // only the apparent mass: next to the aerodynamic loads its response would lose digits, 6e-10 of an entry in LR-16
        let at = if linear { Cow::Owned(at.still()) } else { Cow::Borrowed(at) };
        let mut answer = |shift: f64, side: &mut [f64]| {
            let mut beside = at.clone().into_owned();
            displace(&mut beside, variable, shift);
            match variable {
                Variable::AirRate(component) => self.answer_of_air_rate(&beside, gusts, component, shift, side),
                Variable::Motion { .. }
                | Variable::Lag(_)
                | Variable::Air(_)
                | Variable::FlapAngle(_)
                | Variable::FlapRate(_)
                | Variable::FlapAcceleration(_) => self.answer_of(&beside, gusts, strips.clone(), side),
            }
        };
        if linear {
            let mut sides = [(); 2].map(|()| vec![0.0; rows]);
            let [above, below] = &mut sides;
            answer(step, above);
            answer(-step, below);
            return above.iter().zip(below).map(|(above, below)| (above - *below) / (2.0 * step)).collect();
        }
        let mut present = vec![0.0; rows];
        answer(0.0, &mut present);
        slope_off_corners(step, &kinds, &present, answer)
    }

    /// Response of the apparent mass alone to a rate of the air.
    fn answer_of_air_rate(&mut self, at: &Instant, gusts: bool, component: usize, rate: f64, answer: &mut [f64]) {
        answer.fill(0.0);
        debug_assert_eq!(answer.len(), self.rows(at.motions.len(), gusts));
        if !self.options.apparent_mass {
            return;
        }
        let mut axis = Vector3::zeros();
        axis[component % 3] = rate;
        let mut loads = vec![Wrench::default(); at.motions.len()];
        for strip in &self.strips {
            let cut = strip.cut(&at.motions, &at.flow);
            let gain = |place_m: &Vector3<f64>| if component < 3 { axis } else { -axis.cross(place_m) };
            let [leading, trailing] = [gain(&cut.leading_m), gain(&cut.trailing_m)];
            let middle_m_s2 = cut.up.dot(&(0.5 * (leading + trailing)));
            let difference_m_s2 = cut.up.dot(&(trailing - leading));
            push(strip, &cut, at.flow.density_kg_m3, [middle_m_s2, difference_m_s2], &mut loads);
        }
        for ((load, motion), rows) in loads.iter().zip(at.motions.iter()).zip(answer.chunks_exact_mut(LOAD_ROWS)) {
            let turned = motion.rotation.transpose();
            rows[..3].copy_from_slice((turned * load.force_n).as_slice());
            rows[3..].copy_from_slice((turned * load.moment_n_m).as_slice());
        }
    }

    /// Strips whose response depends on a variable, apart from a lifting line.
    fn touched(&self, at: &Instant, gusts: bool, variable: Variable) -> Range<usize> {
        match variable {
            Variable::Motion { section, .. } => {
                let touches = |strip: &&Strip| strip.sections.contains(&section);
                let first = self.strips.iter().position(|strip| touches(&strip)).unwrap_or(0);
                first..first + self.strips.iter().filter(touches).count()
            }
            Variable::Lag(lag) => {
                let per_strip = self.lag_terms(gusts).iter().sum::<usize>().max(1);
                debug_assert_eq!(at.lags.len(), per_strip * self.strips.len());
                lag / per_strip..lag / per_strip + 1
            }
            Variable::Air(_) | Variable::AirRate(_) => 0..self.strips.len(),
            Variable::FlapAngle(flap) | Variable::FlapRate(flap) | Variable::FlapAcceleration(flap) => {
                self.flap_strips(flap)
            }
        }
    }

    /// Step of the difference. `None` if no air moves and only the apparent mass responds: the rest is quadratic in the
    /// velocities.
    fn scale(&self, at: &Instant, strips: Range<usize>, variable: Variable) -> Option<f64> {
        let speed_m_s = |strip: &Strip| {
            let cut = strip.cut(&at.motions, &at.flow);
            let air_m_s = cut.air_m_s(0.5) + at.gust_m_s;
            (air_m_s - cut.along() * cut.along().dot(&air_m_s)).norm()
        };
        let fastest_m_s = self.strips.iter().map(speed_m_s).fold(0.0, f64::max);
        let own =
            || self.strips[strips.clone()].iter().map(|strip| (strip.cut(&at.motions, &at.flow), speed_m_s(strip)));
        let slowest_m_s = own().map(|(_, speed_m_s)| speed_m_s).fold(f64::INFINITY, f64::min);
        let speed_m_s = slowest_m_s.max(SLOWEST * fastest_m_s);
        let chord_m = own().map(|(cut, _)| cut.chord_m).fold(0.0, f64::max);
        let span_m = own().map(|(cut, _)| cut.span_m).fold(f64::INFINITY, f64::min);
        let moving = |step: f64| (fastest_m_s > 0.0).then_some(step);
        match variable {
            Variable::Motion { component, .. } => match component {
                0..3 => Some(STEP * chord_m.min(span_m)),
                3..6 => Some(STEP * (span_m / chord_m).min(1.0)),
                6..9 => moving(STEP * speed_m_s),
                9..12 => moving(STEP * speed_m_s / chord_m),
                _ => Some(1.0),
            },
            Variable::Lag(_) => moving(STEP * speed_m_s),
            Variable::Air(component) => match component {
                0..3 | 6..9 => moving(STEP * speed_m_s),
                _ => moving(STEP * speed_m_s / at.motions.iter().map(|m| m.position_m.norm()).fold(chord_m, f64::max)),
            },
            Variable::FlapAngle(_) => moving(STEP),
            Variable::FlapRate(_) => moving(STEP * speed_m_s / chord_m),
            Variable::AirRate(_) | Variable::FlapAcceleration(_) => Some(1.0),
        }
    }
}

/// Shifts one variable of an instant.
pub(crate) fn displace(at: &mut Instant, variable: Variable, shift: f64) {
    let axis = |component: usize| {
        let mut axis = Vector3::zeros();
        axis[component % 3] = shift;
        axis
    };
    match variable {
        Variable::Motion { section, component } => {
            let (motion, axis) = (&mut at.motions.to_mut()[section], axis(component));
            match component / 3 {
                0 => motion.position_m += axis,
                1 => motion.rotation = Rotation3::new(axis).into_inner() * motion.rotation,
                2 => motion.velocity_m_s += axis,
                3 => motion.spin_rad_s += axis,
                part => at.accelerations.to_mut()[section][part - 4] += axis,
            }
        }
        Variable::Lag(lag) => at.lags.to_mut()[lag] += shift,
        Variable::Air(component) => match component / 3 {
            0 => at.flow.wind_m_s += axis(component),
            1 => at.flow.spin_rad_s += axis(component),
            _ => at.gust_m_s += axis(component),
        },
        Variable::AirRate(_) => {}
        Variable::FlapAngle(flap) => at.flaps.to_mut()[flap].angle_rad += shift,
        Variable::FlapRate(flap) => at.flaps.to_mut()[flap].rate_rad_s += shift,
        Variable::FlapAcceleration(flap) => at.flap_rad_s2.to_mut()[flap] += shift,
    }
}

/// Adds the loads of the apparent mass for the accelerations of the sections, eq. (W13): wind and rotation of the root are constant.
/// Returns the corresponding rates, without those of a control surface.
fn add_apparent_mass(strip: &Strip, cut: &Cut, at: &Instant, flow: &Flow, loads: &mut [Wrench]) -> MassRates {
    let point = |end: usize, arm_m: &Vector3<f64>| {
        let (motion, [acceleration, spin_rate]) =
            (&at.motions[strip.sections[end]], &at.accelerations[strip.sections[end]]);
        let swing_m_s = motion.spin_rad_s.cross(arm_m);
        let second = acceleration + spin_rate.cross(arm_m) + motion.spin_rad_s.cross(&swing_m_s);
        (motion.velocity_m_s + swing_m_s, second)
    };
    let [inner, outer] = [0, 1].map(|end| cut.arms_m[end].map(|arm_m| point(end, &arm_m)));
    let mean = |edge: usize| (0.5 * (inner[edge].0 + outer[edge].0), 0.5 * (inner[edge].1 + outer[edge].1));
    let [leading, trailing] = [mean(0), mean(1)];
    let rate = |(velocity, second): (Vector3<f64>, Vector3<f64>)| -flow.spin_rad_s.cross(&velocity) - second;
    let [leading_m_s2, trailing_m_s2] = [rate(leading), rate(trailing)];
    // rotation of the normal: n = d × s/|d × s|
    let chord_m = cut.trailing_m - cut.leading_m;
    let quarter_m = |end: usize| {
        let motion = &at.motions[strip.sections[end]];
        motion.position_m + cut.arms_m[end][0] * 0.75 + cut.arms_m[end][1] * 0.25
    };
    let along_m = quarter_m(1) - quarter_m(0);
    let quarter_m_s = |ends: &[(Vector3<f64>, Vector3<f64>); 2]| ends[0].0 * 0.75 + ends[1].0 * 0.25;
    let along_m_s = quarter_m_s(&outer) - quarter_m_s(&inner);
    let across = chord_m.cross(&along_m);
    let across_rate = (trailing.0 - leading.0).cross(&along_m) + chord_m.cross(&along_m_s);
    let up_rate = (across_rate - cut.up * cut.up.dot(&across_rate)) / across.norm();
    let difference_m_s = cut.trailing_air_m_s - cut.leading_air_m_s;
    let middle_m_s2 = up_rate.dot(&cut.air_m_s(0.5)) + cut.up.dot(&(0.5 * (leading_m_s2 + trailing_m_s2)));
    let pitching_m_s2 = up_rate.dot(&difference_m_s) + cut.up.dot(&(trailing_m_s2 - leading_m_s2));
    push(strip, cut, flow.density_kg_m3, [middle_m_s2, pitching_m_s2], loads);
    MassRates { middle_m_s2, difference_m_s2: pitching_m_s2, flap_rad_s2: 0.0 }
}

/// Force and moment of the apparent mass, eq. (W8), for the rates of `w_½` and of `n·Δ` in m/s².
fn push(strip: &Strip, cut: &Cut, density_kg_m3: f64, [middle_m_s2, difference_m_s2]: [f64; 2], loads: &mut [Wrench]) {
    let semi_chord_m = 0.5 * cut.chord_m;
    let mass_kg_m = PI * density_kg_m3 * semi_chord_m.powi(2);
    strip.add_force(loads, cut, 0.5, &(cut.up * (mass_kg_m * middle_m_s2 * cut.span_m)));
    strip.add_moment(loads, cut, -mass_kg_m * semi_chord_m / 16.0 * difference_m_s2 * cut.span_m);
}
