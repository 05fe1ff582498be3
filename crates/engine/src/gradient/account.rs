//! Energy accounts (work of the inputs, dissipated energy): integrals of powers, eq. (X22), with jumps at events, eq. (X23).

use crate::gradient::parameter::Neighbours;
use crate::gradient::step::{ONWARD, time_step_s};
use crate::gradient::tape::Step;
use crate::gradient::variation::Variation;
use crate::gradient::{Entry, Gradient, GradientError, add};
use crate::load::RootMotion;
use crate::math::difference::SIXTH_ORDER;
use crate::multibody::energy::first_moment_kg_m;
use crate::signal::JointInputs;
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::equations::Equations;
use crate::system::{EnergyOutputs, System};
use std::mem::offset_of;

/// Difference step of powers with respect to coordinates: rotation in rad, or displacement relative to the machine's length.
const STEP: f64 = 2e-3;
/// Weights of central differences of fourth order: powers are quadratic in the rates, those of prescribed motions cubic.
const BY_RATES: [f64; 2] = [8.0 / 12.0, -1.0 / 12.0];
/// Weight of central differences: powers are linear in the accelerations.
const BY_ACCELERATIONS: [f64; 1] = [0.5];
/// Difference between the recorded jump of an account and that of the energies, relative to the energies, above which the account has other
/// energies.
const SAME_JUMP: f64 = 1e-9;
/// Part of the message about an event that is not covered.
const OTHER_ENERGIES: &str =
    "energy accounts across an event that changes more than potentials and the energy of an impulse";

/// An energy account.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Account {
    /// Work of the inputs.
    Work,
    /// Energy dissipated.
    Dissipated,
}

impl Account {
    /// The account of an output; `None` if the output is not an account.
    pub fn of(system: &System, index: usize) -> Option<Self> {
        let place = system.outputs.layout().accounts().iter().position(|account| *account == index)?;
        [Self::Work, Self::Dissipated].get(place).copied()
    }

    /// Its entry in values of both accounts.
    pub fn of_powers(self, [work, dissipated]: [f64; 2]) -> f64 {
        match self {
            Self::Work => work,
            Self::Dissipated => dissipated,
        }
    }

    /// Its jump at an event from those of the kinetic and the total energy: work jumps with the potentials, dissipation by the loss of
    /// kinetic energy in impulses. `loses`: at a failure the loss of potentials is dissipated too.
    fn of_jumps(self, loses: bool, [kinetic, total]: [f64; 2]) -> f64 {
        match (self, loses) {
            (Self::Work, true) => 0.0,
            (Self::Work, false) => total - kinetic,
            (Self::Dissipated, true) => -total,
            (Self::Dissipated, false) => -kinetic,
        }
    }

    fn booked(self, at: &Point) -> f64 {
        match self {
            Self::Work => at.work,
            Self::Dissipated => at.dissipated,
        }
    }
}

/// One side of an event.
#[derive(Clone, Copy)]
pub(super) struct EventSide<'s> {
    /// The step that ends or starts there.
    pub step: &'s Step,
    /// The point there.
    pub at: &'s Point,
    /// 1 after the event, −1 before it.
    pub sign: f64,
    /// Whether the event is a failure at which potentials fall.
    pub loses: bool,
}

/// Whether potentials fall between kinetic and total energies before and after an event.
fn falls([was, is]: [[f64; 2]; 2]) -> bool {
    is[1] - is[0] < was[1] - was[0]
}

/// Powers of work and dissipation at a point of a step whose middle is at `middle_s`.
pub(super) fn powers(system: &mut System, at: &Point, middle_s: f64) -> [f64; 2] {
    let equations = &mut system.equations;
    equations.branch_s = middle_s;
    let mut residual = vec![0.0; at.q.len()];
    equations.residual(at.time_s, &at.q, &at.v, &at.a, &mut residual);
    let powers = equations.powers(at.time_s, &at.q, &at.v, &at.a);
    [powers.work, powers.dissipated]
}

/// Adds the slopes of the powers along a variation of the state.
pub(super) fn add_slopes_along(
    system: &mut System,
    (at, middle_s): (&Point, f64),
    along: &Variation,
    sum: &mut [f64; 2],
) {
    // only the torques on prescribed joints depend on accelerations
    let accelerated = system.equations.forces.joints().iter().any(|joint| joint.law().is_some());
    let by_coordinates = SIXTH_ORDER.map(|weight| weight / 60.0);
    let parts: [(&[f64], f64, &[f64]); 3] = [
        (&along.q, STEP, &by_coordinates),
        (&along.v, 1.0, &BY_RATES),
        (&along.a, 1.0, if accelerated { &BY_ACCELERATIONS } else { &[] }),
    ];
    // a difference step may lead past a kink of a force, and torques may be of any degree in the rates: they continue on their pieces, and
    // on their tangents, at the point itself
    system.equations.forces.hold([at.time_s, middle_s], &at.q, &at.v);
    system.equations.forces.linearize(at.time_s, &at.q, &at.v);
    let mut there = at.clone();
    for (kind, (direction, step, weights)) in parts.into_iter().enumerate() {
        let size = system.equations.size_of(direction);
        if size.is_nan() || size <= 0.0 {
            continue;
        }
        let step = step / size;
        for (steps, weight) in (1..).zip(weights) {
            for sign in [1.0, -1.0] {
                there.copy_from(at);
                let part = [&mut there.q, &mut there.v, &mut there.a].into_iter().nth(kind);
                part.into_iter().for_each(|part| add(part, sign * f64::from(steps) * step, direction));
                let powers = powers(system, &there, middle_s);
                sum.iter_mut().zip(powers).for_each(|(sum, power)| *sum += sign * weight / step * power);
            }
        }
    }
    system.equations.forces.drop_tangents();
    system.equations.forces.let_go();
}

/// Adds the slopes of the powers along a change of the loads of the air, of which they are linear. These are set back but for round-off.
fn add_slopes_by_loads(system: &mut System, (at, middle_s): (&Point, f64), direction: &[f64], sum: &mut [f64; 2]) {
    let size = direction.iter().fold(0.0f64, |size, entry| size.max(entry.abs()));
    if size <= 0.0 {
        return;
    }
    let step = system.air_scale_n().max(f64::MIN_POSITIVE) / size;
    for sign in [1.0, -1.0] {
        system.equations.add_air_loads(direction, sign * step);
        let powers = powers(system, at, middle_s);
        system.equations.add_air_loads(direction, -sign * step);
        sum.iter_mut().zip(powers).for_each(|(sum, power)| *sum += sign * 0.5 / step * power);
    }
}

impl Gradient<'_> {
    /// Slopes of both powers at a point of a step in each direction: with respect to its parameter, along its variation of the state and along
    /// that of the loads of the air.
    pub(super) fn power_slopes(
        &mut self,
        step: &Step,
        at: &Point,
        variations: &[Variation],
        loads: &[Vec<f64>],
    ) -> Vec<[f64; 2]> {
        let middle_s = step.middle_s();
        let by_neighbours = self.powers_by_neighbours(step, at);
        let shares = self.shares(at.time_s);
        let of = |(entry, share): (&Entry, f64)| by_neighbours[entry.beside].map(|slope| share * slope);
        let mut slopes: Vec<[f64; 2]> = self.entries.iter().zip(shares).map(of).collect();
        let by_rates = self.work_by_rates(at);
        slopes.iter_mut().zip(by_rates).for_each(|([work, _], by_rate)| *work += by_rate);
        for (slopes, variation) in slopes.iter_mut().zip(variations) {
            add_slopes_along(self.system, (at, middle_s), variation, slopes);
        }
        for (slopes, loads) in slopes.iter_mut().zip(loads) {
            add_slopes_by_loads(self.system, (at, middle_s), loads, slopes);
        }
        if !loads.is_empty() {
            self.system.configure();
        }
        slopes
    }

    /// Slopes of the power of work with respect to the rows of gravity, of the root's acceleration and of commands by their rates, eq. (X36): a
    /// gravity field that varies in time does work on the potential, as does a neutral angle that moves. A change of all rows, which the
    /// neighbouring machines have, does not change its rate.
    fn work_by_rates(&mut self, at: &Point) -> Vec<f64> {
        let columns = self.entries.iter().map(|entry| {
            let column = &self.tape.inputs.columns()[self.neighbours[entry.beside].column()?];
            Some((column.index, self.tape.inputs.weight_rate_1_s(entry.row?, self.piece)))
        });
        let columns: Vec<Option<(usize, f64)>> = columns.collect();
        if columns.iter().all(Option::is_none) {
            return vec![0.0; columns.len()];
        }
        self.place(at);
        let by_rate = |column: Option<(usize, f64)>| {
            column.map_or(0.0, |(index, rate_1_s)| rate_1_s * self.work_per_rate(index, at))
        };
        columns.into_iter().map(by_rate).collect()
    }

    /// Power of the work per rate of an input at the point of the last residual.
    fn work_per_rate(&self, input: usize, at: &Point) -> f64 {
        let layout = self.system.state.inputs.layout();
        let Equations { model, work, forces, .. } = &self.system.equations;
        let fields = [(offset_of!(RootMotion, gravity_m_s2), -1.0), (offset_of!(RootMotion, acceleration_m_s2), 1.0)];
        for (offset, sign) in fields {
            let first = layout.root.place(0, offset);
            if (first..first + 3).contains(&input) {
                return sign * first_moment_kg_m(model, work)[input - first];
            }
        }
        let command = |joint: &usize| layout.joints.place(*joint, offset_of!(JointInputs, command_rad)) == input;
        (0..forces.joints().len()).find(command).map_or(0.0, |joint| {
            forces.joints()[joint].work_per_command_rate_n_m([at.time_s, self.middle_s], [&at.q, &at.v], work)
        })
    }

    fn powers_by_neighbours(&mut self, step: &Step, at: &Point) -> Vec<[f64; 2]> {
        self.hold(at);
        let of = |beside: &mut Neighbours| {
            let mut slopes = [0.0; 2];
            beside.add_slopes(&mut slopes, |system, each| each.copy_from_slice(&powers(system, at, step.middle_s())));
            slopes
        };
        let slopes = self.neighbours.iter_mut().map(of).collect();
        self.let_go();
        slopes
    }

    /// Slopes of both powers with respect to time at a point of a step, for inputs that vary.
    pub(super) fn powers_by_time(&mut self, step: &Step, at: &Point) -> [f64; 2] {
        self.hold(at);
        let step_s = time_step_s(step.length_s());
        let mut slopes = [0.0; 2];
        for (steps, weight) in ONWARD {
            let there = Point { time_s: at.time_s + steps * step_s, ..at.clone() };
            let powers = powers(self.system, &there, step.middle_s());
            slopes.iter_mut().zip(powers).for_each(|(slope, power)| *slope += weight / step_s * power);
        }
        self.let_go();
        slopes
    }

    /// Derivatives of a power with respect to the state at a point of a step.
    pub(super) fn power_gradient(&mut self, account: Account, step: &Step, at: &Point) -> Variation {
        let n = self.system.coordinates();
        let mut state = Variation::zeros(n);
        let mut unit = Variation::zeros(n);
        for i in 0..n {
            let mut slope = |part: fn(&mut Variation) -> &mut [f64]| {
                part(&mut unit)[i] = 1.0;
                let mut slopes = [0.0; 2];
                add_slopes_along(self.system, (at, step.middle_s()), &unit, &mut slopes);
                part(&mut unit)[i] = 0.0;
                account.of_powers(slopes)
            };
            (state.q[i], state.v[i], state.a[i]) =
                (slope(|unit| &mut unit.q), slope(|unit| &mut unit.v), slope(|unit| &mut unit.a));
        }
        self.system.equations.clear_resting(&mut state.v);
        self.system.equations.clear_resting(&mut state.a);
        state
    }

    /// Derivatives of a power at a point of a step with respect to the loads of the air.
    pub(super) fn power_by_loads(&mut self, account: Account, step: &Step, at: &Point) -> Vec<f64> {
        let middle_s = step.middle_s();
        self.by_each_load(|system, unit| {
            let mut slopes = [0.0; 2];
            add_slopes_by_loads(system, (at, middle_s), unit, &mut slopes);
            account.of_powers(slopes)
        })
    }

    /// Derivatives of a power at a point of a step with respect to the parameters.
    pub(super) fn power_by_parameters(&mut self, account: Account, step: &Step, at: &Point) -> Vec<f64> {
        let both = self.powers_by_neighbours(step, at);
        let by_neighbours: Vec<f64> = both.into_iter().map(|slopes| account.of_powers(slopes)).collect();
        let mut by_parameters = self.by_parameters(at.time_s, &by_neighbours);
        for (sum, by_rate) in by_parameters.iter_mut().zip(self.work_by_rates(at)) {
            *sum += account.of_powers([by_rate, 0.0]);
        }
        by_parameters
    }

    /// Subtracts the slopes of the energies before an event at the start of a step in the rows of the accounts.
    pub(super) fn account_before(
        &mut self,
        index: usize,
        (variations, shifts_s): (&[Variation], &[f64]),
        accounts: &[(usize, Account)],
        table: &mut [Vec<f64>],
    ) -> Result<(), GradientError> {
        let tape = self.tape;
        if let (Some(before), true) = (index.checked_sub(1), tape.steps[index].renewed && !accounts.is_empty()) {
            let loses = self.check_jump(index)?;
            let step = &tape.steps[before];
            let side = EventSide { step, at: &step.end, sign: -1.0, loses };
            self.add_energies(side, (variations, shifts_s), accounts, table);
        }
        Ok(())
    }

    /// Adds the slopes of the energies after an event at the start of a step in the rows of the accounts.
    pub(super) fn account_behind(
        &mut self,
        index: usize,
        (variations, shifts_s): (&[Variation], &[f64]),
        accounts: &[(usize, Account)],
        table: &mut [Vec<f64>],
    ) {
        let tape = self.tape;
        let step = &tape.steps[index];
        if index > 0 && step.renewed && !accounts.is_empty() {
            let side = EventSide { step, at: &step.start, sign: 1.0, loses: self.loses(index) };
            self.add_energies(side, (variations, shifts_s), accounts, table);
        }
    }

    /// Indices of the kinetic and the total energy.
    fn energies(&self) -> [usize; 2] {
        let energy = &self.system.outputs.layout().energy;
        [offset_of!(EnergyOutputs, kinetic), offset_of!(EnergyOutputs, total)].map(|offset| energy.place(0, offset))
    }

    /// Whether an event at the start of a step is a failure at which potentials fall.
    fn loses(&mut self, index: usize) -> bool {
        let tape = self.tape;
        let Some(before) = index.checked_sub(1) else { return false };
        tape.steps[before].failures != tape.steps[index].failures && falls(self.energies_at_event(before, index))
    }

    /// Kinetic and total energy before and after an event between two steps.
    fn energies_at_event(&mut self, before: usize, behind: usize) -> [[f64; 2]; 2] {
        let tape = self.tape;
        let (before, behind) = (&tape.steps[before], &tape.steps[behind]);
        let indices = self.energies();
        [(before, &before.end), (behind, &behind.start)].map(|(step, at)| {
            self.adopt(step);
            let values = super::outputs::values(self.system, at);
            indices.map(|index| values[index])
        })
    }

    /// Returns an error if an account changes at an event by an energy other than those of (X23), such as the work of a prescribed motion
    /// in an impulse; otherwise whether the event is a failure at which potentials fall.
    pub(super) fn check_jump(&mut self, index: usize) -> Result<bool, GradientError> {
        let tape = self.tape;
        let Some(index_before) = index.checked_sub(1).filter(|_| tape.steps[index].renewed) else { return Ok(false) };
        let (before, behind) = (&tape.steps[index_before], &tape.steps[index]);
        let [was, is] = self.energies_at_event(index_before, index);
        let loses = before.failures != behind.failures && falls([was, is]);
        let refused = || {
            let remedy =
                format!("choose times before the event at {} s, or use finite differences", behind.start.time_s);
            GradientError::OtherChoice { part: OTHER_ENERGIES, remedy }
        };
        // at a row of the inputs a change of the row does work, and the failure dissipates the rest
        if loses && before.piece != behind.piece && self.entries.iter().any(|entry| entry.row.is_some()) {
            return Err(refused());
        }
        let size = [was, is].iter().flatten().fold(0.0f64, |size, energy| size.max(energy.abs()));
        for account in [Account::Work, Account::Dissipated] {
            let booked = account.booked(&behind.start) - account.booked(&before.end);
            let known = account.of_jumps(loses, [is[0] - was[0], is[1] - was[1]]);
            if (booked - known).abs() > SAME_JUMP * size.max(booked.abs()) {
                return Err(refused());
            }
        }
        Ok(loses)
    }

    /// Adds `sign` times the slopes of the energies at a point before or after an event to the rows of the accounts; the point varies by
    /// `variations`, its time by `shifts_s`.
    pub(super) fn add_energies(
        &mut self,
        EventSide { step, at, sign, loses }: EventSide,
        (variations, shifts_s): (&[Variation], &[f64]),
        accounts: &[(usize, Account)],
        table: &mut [Vec<f64>],
    ) {
        self.adopt(step);
        self.place(at);
        let indices = self.energies();
        let slopes = self.output_slopes_at(at, &indices, variations, &[]);
        let by_time = self.energies_by_time(step, at);
        for (row, account) in accounts {
            for (direction, sum) in table[*row].iter_mut().enumerate() {
                let along = |energy: usize| slopes[energy][direction] + by_time[energy] * shifts_s[direction];
                *sum += sign * account.of_jumps(loses, [along(0), along(1)]);
            }
        }
    }

    fn energies_by_time(&mut self, step: &Step, at: &Point) -> [f64; 2] {
        match self.inputs_move() {
            true => self.energies().map(|index| self.slope_by_time(index, at, step.length_s())),
            false => [0.0; 2],
        }
    }

    /// Adds `sign` times the derivatives of an account's energy at a point before or after an event to the multipliers of the point, of its
    /// time and of the parameters.
    pub(super) fn add_energy_seed(
        &mut self,
        EventSide { step, at, sign, loses }: EventSide,
        account: Account,
        (on, shift): (&mut Variation, &mut f64),
        gradient: Option<&mut Vec<f64>>,
    ) {
        self.adopt(step);
        self.place(at);
        let weights = [[1.0, 0.0], [0.0, 1.0]].map(|jumps| account.of_jumps(loses, jumps));
        let indices = self.energies();
        let by_time = self.energies_by_time(step, at);
        let mut by_parameters = vec![0.0; self.entries.len()];
        for ((index, weight), by_time) in
            indices.into_iter().zip(weights).zip(by_time).filter(|((_, weight), _)| *weight != 0.0)
        {
            on.add(sign * weight, &self.output_gradient(index, at));
            *shift += sign * weight * by_time;
            add(&mut by_parameters, sign * weight, &self.output_by_parameters(index, at));
        }
        if let Some(gradient) = gradient {
            add(gradient, 1.0, &by_parameters);
        }
    }
}
