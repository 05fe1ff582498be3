//! Selection of the next call, its arguments, and the allowed statuses where it is legal.

use super::*;

/// Log categories, valid ones first.
const CATEGORIES: [&CStr; 5] = [c"logAll", c"logEvents", c"logNonsense", c"", c"\xff%s%n"];

impl Actor {
    /// A call, mostly a legal one that lets the run continue.
    pub(super) fn draw(&self, rng: &mut Rng, others: &[Saved]) -> Plan {
        if rng.u8(..20) < 5 {
            return self.go_on(rng, others);
        }
        loop {
            let mut plan = self.any(rng, others);
            let name = plan.ask.names()[self.face.version()];
            if name.is_empty() || matches!(plan.ask, Ask::Reset | Ask::Terminate) && rng.u8(..10) != 0 {
                continue;
            }
            if self.face.is_legal(name, self.phase) || rng.u8(..5) == 0 {
                if let (0, Some(holes)) = (rng.u8(..30), self.holes(&plan.ask)) {
                    plan.hole = rng.u8(1..=holes);
                    // freeing null has no effect
                    let nothing = matches!(plan.ask, Ask::Free(_));
                    plan.right = vec![if nothing { OK } else { ERROR }];
                }
                return plan;
            }
        }
    }

    /// Number of pointers that can be null although they must not be.
    fn holes(&self, ask: &Ask) -> Option<u8> {
        match ask {
            Ask::Update => Some(if self.face.version() == 0 { 1 } else { 2 }),
            Ask::Completed => Some(if self.face.version() == 0 { 1 } else { 2 }),
            Ask::SetStates(states) if !states.is_empty() => Some(1),
            Ask::Read(_, values) if !values.is_empty() => Some(1),
            Ask::Count(..) | Ask::Save(_) | Ask::Free(_) | Ask::Size(..) => Some(1),
            Ask::Get(kind, references, values) | Ask::Set(kind, references, values)
                if !references.is_empty() && !values.is_empty() =>
            {
                Some(if *kind == Kind::String { 1 } else { 2 })
            }
            Ask::NoType(_, references) if !references.is_empty() => Some(1),
            Ask::Write(_, room) if !room.is_empty() => Some(1),
            Ask::Parse(bytes, _) if !bytes.is_empty() => Some(2),
            Ask::Step { .. } => Some(2),
            Ask::Rates(references, ..) if !references.is_empty() => Some(2),
            Ask::Directional { unknowns, seed, .. } | Ask::Adjoint { unknowns, seed, .. }
                if !unknowns.is_empty() && !seed.is_empty() =>
            {
                Some(2)
            }
            _ => None,
        }
    }

    /// The call that continues the run.
    fn go_on(&self, rng: &mut Rng, others: &[Saved]) -> Plan {
        let times = Times { tolerance: None, start_s: 0.0, stop_s: None };
        match self.phase {
            Phase::Instantiated => Plan::of(Ask::EnterInitialization(times), &[OK]),
            Phase::Initialization => Plan::of(Ask::ExitInitialization, &[OK, ERROR]),
            Phase::Event if rng.bool() => Plan::of(Ask::Update, &[OK, ERROR]),
            Phase::Event if self.face.exchanges() => Plan::of(Ask::EnterContinuous, &[OK]),
            Phase::Event => Plan::of(Ask::EnterStep, &[OK]),
            Phase::Step => self.step(rng),
            Phase::Continuous => self.states(rng),
            Phase::Failed if !self.saved.is_empty() => self.state(rng, others, 1),
            Phase::Failed | Phase::Terminated => Plan::of(Ask::Reset, &[OK]),
        }
    }

    /// Any call.
    fn any(&self, rng: &mut Rng, others: &[Saved]) -> Plan {
        match rng.u8(..32) {
            0 => self.logging(rng),
            1 => self.experiment(rng),
            2 => Plan::of(Ask::ExitInitialization, &[OK, ERROR]),
            3 => Plan::of(Ask::Terminate, &[OK]),
            4 => Plan::of(Ask::Reset, &[OK]),
            5 | 6 if self.face.exchanges() => Plan::of(Ask::EnterEvent, &[OK, DISCARD]),
            5 | 6 => Plan::of(Ask::EnterEvent, &[if self.agreed.event_mode { OK } else { ERROR }]),
            7 => Plan::of(Ask::Update, &[OK, ERROR]),
            8 => Plan::of(Ask::EnterContinuous, &[OK]),
            9 => Plan::of(Ask::EnterStep, &[OK]),
            10 => Plan::of(Ask::Completed, &[OK, DISCARD]),
            11 => {
                let time_s = if rng.bool() { 1e-2 * rng.f64() } else { arguments::real(rng, None) };
                // before the last event it is discarded
                Plan::of(Ask::SetTime(time_s), if time_s.is_finite() { &[OK, DISCARD] } else { &[DISCARD] })
            }
            12 => self.states(rng),
            13 | 14 => self.read(rng),
            15 => Plan::of(Ask::Count(pick(rng, &[Vector::States, Vector::Indicators]), 0), &[OK]),
            16..=18 => self.get(rng),
            19..=22 => self.set(rng),
            23 => {
                let (reference, some) = (rng.u32(..self.face.references()), rng.usize(..3));
                let right = if some == 0 { OK } else { ERROR };
                Plan::of(Ask::NoType(rng.usize(..NO_TYPES.len()), vec![reference; some]), &[right])
            }
            24 => Plan::of(Ask::Never(rng.usize(..NEVER.len())), &[ERROR]),
            25 => self.state(rng, others, 0),
            26 => self.state(rng, others, 1),
            27 => self.state(rng, others, 2),
            28 => self.bytes(rng, others),
            29 => self.parse(rng, others),
            30 => self.step(rng),
            _ => self.derivative(rng),
        }
    }

    fn logging(&self, rng: &mut Rng) -> Plan {
        let names: Vec<_> = (0..rng.usize(..4))
            .map(|_| (rng.u8(..12) != 0).then(|| CATEGORIES[rng.usize(..3).min(rng.usize(..5))]))
            .collect();
        let sound = names.iter().all(|name| name.is_some_and(|name| CATEGORIES[..2].contains(&name)));
        Plan::of(Ask::Logging(names), &[if sound { OK } else { ERROR }])
    }

    fn experiment(&self, rng: &mut Rng) -> Plan {
        let mut number = |sound: f64| if rng.u8(..6) == 0 { arguments::real(rng, None) } else { sound };
        let (tolerance, start_s, stop_s) = (number(1e-4), number(0.0), number(10.0));
        let times = Times { tolerance: rng.bool().then_some(tolerance), start_s, stop_s: rng.bool().then_some(stop_s) };
        let fits = start_s.is_finite() && times.stop_s.is_none_or(|stop_s| stop_s.is_finite() && stop_s >= start_s);
        let tolerable = times.tolerance.is_none_or(|tolerance| (1e-12..=1e-1).contains(&tolerance));
        // in FMI 3.0 a tolerance that has been set as a parameter is used instead
        let right: &[u32] = match (fits, tolerable) {
            (false, _) => &[DISCARD],
            (true, true) => &[OK],
            (true, false) if self.face.version() == 1 => &[OK, DISCARD],
            (true, false) => &[DISCARD],
        };
        let second = self.face.version() == 0 && rng.u8(..3) != 0;
        Plan::of(
            if second { Ask::Experiment(times) } else { Ask::EnterInitialization(times) },
            if second || self.face.version() == 1 { right } else { &[OK] },
        )
    }

    /// States near those read last.
    fn states(&self, rng: &mut Rng) -> Plan {
        let mut states = self.states.clone();
        let moved = if states.is_empty() { 0 } else { rng.usize(..4) };
        for _ in 0..moved {
            let at = rng.usize(..states.len());
            states[at] += match rng.u8(..8) {
                0 => arguments::real(rng, None),
                1 => 1e3 * (rng.f64() - 0.5),
                _ => 1e-4 * (rng.f64() - 0.5),
            };
        }
        if rng.u8(..20) == 0 {
            states.pop();
        }
        let right = match () {
            () if states.len() != self.states.len() => ERROR,
            () if states.iter().any(|state| !state.is_finite()) => DISCARD,
            () => OK,
        };
        Plan::of(Ask::SetStates(states), &[right])
    }

    fn read(&self, rng: &mut Rng) -> Plan {
        let which = pick(rng, &[Vector::States, Vector::Derivatives, Vector::Indicators, Vector::Nominals]);
        let own = if which == Vector::Indicators { self.indicators } else { self.states.len() };
        let n = if rng.u8(..12) == 0 { own + 1 } else { own };
        let right: &[u32] = match () {
            () if n != own => &[ERROR],
            () if which == Vector::Nominals => &[OK],
            // there may be no consistent state for the start values
            () if self.phase == Phase::Initialization => &[OK, DISCARD, ERROR],
            () if which == Vector::States => &[OK],
            () => &[OK, DISCARD],
        };
        Plan::of(Ask::Read(which, vec![0.0; n]), right)
    }

    /// Variables, mostly suitable ones.
    fn references(&self, rng: &mut Rng, fits: impl Fn(&Variable) -> bool) -> Vec<u32> {
        let rows = self.face.table().variables();
        let fitting: Vec<u32> = (0..self.face.references())
            .filter(|&reference| fits(&rows[self.face.rows(reference)[0] as usize]))
            .collect();
        let count = rng.usize(..5);
        let drawn = |_| match rng.u8(..40) {
            0 => rng.u32(..),
            1 => pick(rng, &[self.face.references(), u32::MAX, 1 << 31]),
            2 => rng.u32(..self.face.references()),
            _ if fitting.is_empty() => rng.u32(..self.face.references()),
            _ => pick(rng, &fitting),
        };
        (0..count).map(drawn).collect()
    }

    fn kind(&self, rng: &mut Rng) -> Kind {
        let strings = self.face.version() == 0 && rng.u8(..8) == 0;
        if strings {
            Kind::String
        } else {
            pick(rng, &[Kind::Real, Kind::Real, Kind::Real, Kind::Boolean, Kind::Integer])
        }
    }

    /// Rows of variables, and whether all exist.
    fn rows(&self, references: &[u32]) -> (Vec<u32>, bool) {
        let rows: Vec<Vec<u32>> = references.iter().map(|&reference| self.face.rows(reference)).collect();
        let exist = rows.iter().all(|rows| !rows.is_empty());
        (rows.concat(), exist)
    }

    fn get(&self, rng: &mut Rng) -> Plan {
        let kind = self.kind(rng);
        let references = self.references(rng, |row| row.value.kind() == kind);
        let (rows, exist) = self.rows(&references);
        let table = self.face.table();
        let verdict = arguments::batch(rows.iter().map(|&row| arguments::reading(table, row, kind)));
        let wrong = self.face.version() == 1 && rng.u8(..20) == 0;
        let n = if self.face.version() == 0 { references.len() } else { rows.len() + usize::from(wrong) };
        let right: &[u32] = match verdict {
            _ if wrong || !exist => &[ERROR],
            Verdict::Taken if self.phase == Phase::Initialization => &[OK, DISCARD, ERROR],
            Verdict::Taken if self.face.exchanges() => &[OK, DISCARD],
            Verdict::Taken => &[OK],
            _ => &[ERROR],
        };
        Plan::of(Ask::Get(kind, references, vec![0.0; n]), right)
    }

    fn set(&self, rng: &mut Rng) -> Plan {
        let kind = self.kind(rng);
        let references = self
            .references(rng, |row| row.value.kind() == kind && (arguments::is_settable(row) || kind == Kind::Integer));
        let (rows, exist) = self.rows(&references);
        let table = self.face.table();
        let row = |row: u32| &table.variables()[row as usize];
        let mut values: Vec<f64> = rows
            .iter()
            .map(|&at| match kind {
                Kind::Real => arguments::real(rng, Some(row(at))),
                _ => pick(rng, &[0.0, 1.0, 1.0, -1.0]),
            })
            .collect();
        if self.face.version() == 0 {
            values.resize(references.len(), 0.0);
        }
        let value = |i: usize| match kind {
            Kind::Real => Value::Real(values[i]),
            Kind::Integer => Value::Integer(values[i] as i32),
            _ => Value::Boolean(values[i] != 0.0),
        };
        let started = !matches!(self.phase, Phase::Instantiated | Phase::Initialization);
        let exchanging = matches!(self.phase, Phase::Event | Phase::Continuous);
        let verdicts: Vec<Verdict> = rows
            .iter()
            .enumerate()
            .map(|(i, &row)| arguments::setting(table, row, value(i), started, exchanging))
            .collect();
        // variables that cannot change while time advances
        let passing = self.phase == Phase::Step && self.agreed.event_mode;
        let discrete = |&at: &u32| !(row(at).causality == Causality::Input && row(at).value.kind() == Kind::Real);
        let switch = |&at: &u32| row(at).value.kind() != Kind::Real;
        let wrong = self.face.version() == 1 && rng.u8(..20) == 0;
        let refused = wrong
            || !exist
            || kind == Kind::String && !references.is_empty()
            || kind != Kind::String && verdicts.contains(&Verdict::BadCall)
            || passing && rows.iter().any(discrete)
            || self.phase == Phase::Continuous && rows.iter().any(switch);
        let right: &[u32] = match (refused, verdicts.contains(&Verdict::BadValue)) {
            (true, true) => &[DISCARD, ERROR],
            (true, false) => &[ERROR],
            (false, true) => &[DISCARD],
            (false, false) => &[OK],
        };
        if wrong {
            values.push(0.0);
        }
        Plan::of(Ask::Set(kind, references, values), right)
    }

    /// A handle: of this instance, of another one, freed, invented, or null.
    fn handle(&self, rng: &mut Rng, others: &[Saved]) -> (Handle, Option<usize>) {
        let own = (!self.saved.is_empty()).then(|| rng.usize(..self.saved.len()));
        let wild = match rng.u8(..12) {
            0 => ptr::null_mut(),
            1 => ptr::without_provenance_mut(rng.usize(1..4096)),
            2 if !self.freed.is_empty() => pick(rng, &self.freed),
            3 if !others.is_empty() => others[rng.usize(..others.len())].handle,
            _ => match own {
                Some(own) => return (self.saved[own].handle, Some(own)),
                None => ptr::null_mut(),
            },
        };
        (wild, None)
    }

    /// Saves, restores or frees.
    fn state(&self, rng: &mut Rng, others: &[Saved], which: u8) -> Plan {
        let (handle, own) = self.handle(rng, others);
        let known = if own.is_some() { OK } else { ERROR };
        let null = if handle.is_null() { OK } else { known };
        let mut plan = match which {
            0 => Plan::of(Ask::Save(handle), &[null]),
            1 => Plan::of(Ask::Restore(handle), &[known]),
            _ => Plan::of(Ask::Free(handle), &[null]),
        };
        if which == 1 && own.is_some_and(|own| self.saved[own].forged) {
            plan.right = vec![OK, ERROR];
        }
        plan.own = own;
        plan
    }

    /// Size or bytes of a saved state.
    fn bytes(&self, rng: &mut Rng, others: &[Saved]) -> Plan {
        let (handle, own) = self.handle(rng, others);
        let needed = own.map_or(1000, |own| self.saved[own].bytes.len());
        let known = if own.is_some() { OK } else { ERROR };
        let room = match rng.u8(..6) {
            0 => rng.usize(..needed),
            1 => needed + rng.usize(..50),
            _ => needed,
        };
        let mut plan = match rng.bool() {
            true => Plan::of(Ask::Size(handle, 0), &[known]),
            false => Plan::of(Ask::Write(handle, vec![0xaa; room]), &[if room < needed { ERROR } else { known }]),
        };
        plan.own = own;
        plan
    }

    /// A state of this instance, of its twin, or of another model, from bytes, intact or corrupted.
    fn parse(&self, rng: &mut Rng, others: &[Saved]) -> Plan {
        let pool: Vec<&Saved> = self.saved.iter().chain(others).collect();
        let at = (!pool.is_empty()).then(|| rng.usize(..pool.len()));
        let mut bytes = at.map_or_else(|| self.bytes.clone(), |at| pool[at].bytes.clone());
        let own = at.filter(|&at| at < self.saved.len());
        let mut forged = at.map_or(self.forged, |at| pool[at].forged);
        let ours = bytes.get(10..48) == self.bytes.get(10..48);
        let mut right = if ours { vec![OK] } else { vec![ERROR] };
        if rng.bool() {
            if !arguments::damage(rng, &mut bytes) {
                right = vec![ERROR];
            } else if ours {
                right = vec![OK, ERROR];
                forged = true;
            }
        }
        Plan { own, forged, ..Plan::of(Ask::Parse(bytes, ptr::null_mut()), &right) }
    }

    /// A step whose start is relative to the instance's time.
    fn step(&self, rng: &mut Rng) -> Plan {
        let step_s = arguments::step_s(rng);
        let time_s = match rng.u8(..15) {
            0 => pick(rng, &[f64::NAN, f64::INFINITY, -1e9, 1.0, -1e-3]),
            1 => 1e-10 * (rng.f64() - 0.5),
            _ => 0.0,
        };
        let returns = (rng.u8(..3) == 0).then(|| (0.0, if rng.bool() { 0.0 } else { arguments::real(rng, None) }));
        self.agree_to_return(returns);
        // a step can fail, or end beyond the stop time
        Plan::of(Ask::Step { time_s, step_s, event: false, early: false, last_s: 0.0 }, &[OK, ERROR])
    }

    fn derivative(&self, rng: &mut Rng) -> Plan {
        let real = |row: &Variable, causality| row.value.kind() == Kind::Real && row.causality == causality;
        let unknowns = self.references(rng, |row| real(row, Causality::Output));
        let (rows, exist) = self.rows(&unknowns);
        if rng.u8(..3) == 0 {
            let orders: Vec<i32> =
                unknowns.iter().map(|_| if rng.u8(..20) == 0 { pick(rng, &[0, 2, -1, i32::MIN]) } else { 1 }).collect();
            let table = self.face.table();
            let first = |reference: &u32| self.face.rows(*reference).first().copied().unwrap_or(u32::MAX);
            let verdicts =
                unknowns.iter().zip(&orders).map(|(row, &order)| arguments::reading_rate(table, first(row), order));
            let right = match arguments::batch(verdicts) {
                Verdict::Taken if exist => OK,
                _ => ERROR,
            };
            return Plan::of(Ask::Rates(unknowns, orders, vec![0.0; rows.len()]), &[right]);
        }
        let knowns = self.references(rng, |row| real(row, Causality::Input));
        let (columns, _) = self.rows(&knowns);
        let forward = rng.bool();
        let (of_seed, of_result) = if forward { (columns.len(), rows.len()) } else { (rows.len(), columns.len()) };
        let seed = (0..of_seed).map(|_| arguments::real(rng, None)).collect();
        let result = vec![0.0; of_result];
        let ask = match forward {
            true => Ask::Directional { unknowns, knowns, seed, result },
            false => Ask::Adjoint { unknowns, knowns, seed, result },
        };
        Plan::of(ask, &[OK, DISCARD, ERROR])
    }
}
