//! Continuous states in the table, and the dependencies of their derivatives, for Model Exchange.

use crate::interface::known::{Input, JointInput, Known};
use crate::interface::table::Place;
use crate::interface::topology::Topology;
use crate::interface::{Dependencies, DependencyKind, Interface, Kind, MAXIMUM_LISTED, Variability};
use foldwing_engine::machine::Machine;

impl Interface {
    /// Returns whether the table has continuous states.
    pub fn has_states(&self) -> bool {
        !self.nominals.is_empty()
    }

    /// Typical magnitudes of the continuous states, in their units.
    pub fn nominals(&self) -> &[f64] {
        &self.nominals
    }

    /// Name of a continuous state.
    pub fn state_name(&self, state: usize) -> &str {
        let of = |place: Place| place == Place::State(state);
        self.bounds.iter().position(|bound| of(bound.place)).map_or("", |row| &self.variables[row].name)
    }

    /// Returns whether a row can be set at events only, not during the integration.
    pub fn is_set_at_events(&self, reference: u32) -> bool {
        self.slots.get(reference as usize).is_some_and(|slot| slot.is_set_at_events())
    }

    /// Returns whether a row is a switch: a Boolean or Integer input.
    pub fn is_switch(&self, reference: u32) -> bool {
        self.slots.get(reference as usize).is_some_and(|slot| slot.is_set_at_events() && slot.kind != Kind::Real)
    }

    /// Returns whether a row is a continuous state.
    pub fn is_state(&self, reference: u32) -> bool {
        self.bounds.get(reference as usize).is_some_and(|bound| matches!(bound.place, Place::State(_)))
    }

    /// Adds dependencies of continuous outputs and derivatives on the states. The time derivative of a coordinate is the state of its rate;
    /// that of a redundant rotation parameter depends on the parameters of its joint and their rates. Accelerations depend on the motion of
    /// the tree and of the trees connected to it, and on the loads on it. Outputs and the energy accounts are assumed to depend on all
    /// states, aerodynamic loads and outputs on which they act also on all inputs.
    pub(super) fn add_states_to(&self, found: &mut [Dependencies], machine: &Machine) {
        if !self.has_states() {
            return;
        }
        let states: Vec<u32> =
            self.variables.iter().filter(|row| row.nominal.is_some()).map(|row| row.value_reference).collect();
        let coordinates = self.coordinates.len();
        let topology = Topology::new(machine);
        let tree = |coordinate: usize| topology.coupled[self.coordinates[coordinate]];
        let one_tree = (0..coordinates).all(|coordinate| tree(coordinate) == tree(0));
        let is_parameter =
            |coordinate: usize| self.variables[states[coordinate] as usize].declared_type == Some("Ratio");
        let list = |rows: Vec<u32>| rows.into_iter().map(|row| (row, DependencyKind::Dependent)).collect();
        for ((found, row), bound) in found.iter_mut().zip(&self.variables).zip(&self.bounds) {
            match bound.place {
                // the loads of strips contain the apparent mass, so that all forces on the machine act on them
                Place::Output(_)
                    if machine.air.is_some()
                        && bound.depends.is_some_and(|depends| self.depends[depends].is_in_air()) =>
                {
                    *found = Dependencies { on_all: true, ..Dependencies::default() };
                }
                Place::Output(_) if row.variability == Variability::Continuous && !found.on_all => {
                    found.running.extend(states.iter().map(|&state| (state, DependencyKind::Dependent)));
                    if found.running.len() > MAXIMUM_LISTED {
                        *found = Dependencies { on_all: true, ..Dependencies::default() };
                    }
                }
                Place::Derivative(state) if state < coordinates && !is_parameter(state) => {
                    found.running = vec![(states[coordinates + state], DependencyKind::Constant)];
                }
                Place::Derivative(state) if state < coordinates => {
                    let of_joint = |&c: &usize| self.coordinates[c] == self.coordinates[state] && is_parameter(c);
                    let joint = (0..coordinates).filter(of_joint);
                    found.running = list(joint.flat_map(|c| [states[c], states[coordinates + c]]).collect());
                }
                // currents of DC motors act on the accelerations too
                Place::Derivative(state)
                    if state < 2 * coordinates && !one_tree && machine.dc_motors().next().is_none() =>
                {
                    let own = tree(state - coordinates);
                    let motion = (0..coordinates).filter(|&c| tree(c) == own);
                    let motion = motion.flat_map(|c| [states[c], states[coordinates + c]]);
                    let acting =
                        self.bounds.iter().zip(&self.variables).filter_map(|(bound, row)| {
                            acts(&topology, own, bound.known?).then_some(row.value_reference)
                        });
                    found.running = list(acting.chain(motion).collect());
                    if found.running.len() > MAXIMUM_LISTED {
                        *found = Dependencies { on_all: true, ..Dependencies::default() };
                    }
                }
                Place::Derivative(_) => found.on_all = true,
                Place::Time
                | Place::Input(_)
                | Place::Parameter(_)
                | Place::Output(_)
                | Place::Local(_)
                | Place::Duration(_)
                | Place::State(_)
                | Place::Indicator(_) => {}
            }
        }
    }

    /// Rows on which a row without a list of dependencies may depend: time, inputs, continuous states and tunable parameters or, before the
    /// initialisation, time, inputs and parameters. `None` if they are more than [`MAXIMUM_LISTED`].
    pub fn everything(&self, initial: bool) -> Option<Vec<(u32, DependencyKind)>> {
        let all = self.bounds.iter().zip(&self.variables).filter_map(|(bound, row)| {
            let known = match bound.place {
                Place::Time | Place::Input(_) => true,
                Place::State(_) => !initial,
                Place::Parameter(_) => initial || row.variability == Variability::Tunable,
                Place::Output(_)
                | Place::Local(_)
                | Place::Duration(_)
                | Place::Derivative(_)
                | Place::Indicator(_) => false,
            };
            known.then_some((row.value_reference, DependencyKind::Dependent))
        });
        let all: Vec<_> = all.take(MAXIMUM_LISTED + 1).collect();
        (all.len() <= MAXIMUM_LISTED).then_some(all)
    }

    /// Adds to a list of dependencies all tunable parameters, on which a row that depends on states may depend. The standard counts
    /// parameters as constant during the integration; importers that differentiate with respect to parameters take the list as it is.
    pub fn with_tunables(&self, list: &[(u32, DependencyKind)], initial: bool) -> Vec<(u32, DependencyKind)> {
        let constant = list.iter().all(|(_, kind)| *kind == DependencyKind::Constant);
        let tunables = self.variables.iter().filter(|row| row.variability == Variability::Tunable);
        let tunables = tunables.map(|row| (row.value_reference, DependencyKind::Dependent));
        let none = initial || constant || !self.has_states();
        list.iter().copied().chain(tunables.filter(|_| !none)).collect()
    }
}

/// Returns whether a known changes the accelerations of the trees connected to the one whose first body is `tree`; aerodynamic coupling is
/// excluded.
fn acts(topology: &Topology, tree: usize, known: Known) -> bool {
    match known {
        // acts through prescribed motions, and motors that have not reached their command
        Known::Time => true,
        Known::Input(input) => match input {
            Input::Joint(joint, JointInput::Command | JointInput::Torque | JointInput::GeneratorOn) => {
                topology.coupled[topology.revolutes[joint]] == tree
            }
            Input::Load(station) => topology.coupled[topology.stations[station].0] == tree,
            Input::Gravity | Input::RootAcceleration | Input::RootAngularVelocity | Input::RootAngularAcceleration => {
                true
            }
            // act through events, which change discrete states
            Input::Joint(_, JointInput::Release | JointInput::LatchEnable) | Input::Failure(_) => false,
            // acts on the rate of the current only
            Input::Joint(_, JointInput::Voltage) => false,
            // the aerodynamic loads connect all trees
            Input::Wind | Input::Flap(_) | Input::FlapRate(_) => false,
        },
        // no knowns during the integration
        Known::Parameter(_) => false,
    }
}
