//! The start of a run: coordinates and rates, then accelerations and outputs.

use crate::force::drive::Slew;
use crate::force::memory::Contact;
use crate::force::memory::LatchState;
use crate::force::memory::{JointMemory, Told};
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::events::{Place, settle};
use crate::system::failure_memory::{self, FailureMemory};
use crate::system::{PlantError, System};

impl System {
    /// Builds the equations and sets the unstrained start state.
    pub(crate) fn start(&mut self, time_s: f64) {
        self.rebuild();
        let mut q = self.equations.model.natural_coordinates();
        let mut v = vec![0.0; q.len()];
        let mut joints = Vec::new();
        self.state.failures = vec![FailureMemory::default(); self.machine.failures.len()];
        failure_memory::begin(&self.machine.failures, &self.state.inputs, time_s, &mut self.state.failures);
        let inputs = &self.state.inputs;
        for (((_, revolute), inputs), (parameters, equations)) in self
            .machine
            .one_freedoms()
            .zip(inputs.joints())
            .zip(self.state.parameters.joints().iter().zip(self.equations.forces.joints()))
        {
            let c = equations.coordinate;
            q[c] = parameters.start_angle_rad;
            let caught = equations.latch().is_some_and(|latch| latch.latch.catches(q[c]));
            // closed according to the description, at any position of the joint
            let described = revolute.latch.as_ref().is_some_and(|latch| latch.initially_closed);
            let mut told = Told {
                time_s,
                at_end: false,
                release: inputs.release.is_on(),
                latch_enable: inputs.latch_enable.is_on(),
                command_rad: inputs.command_rad,
                command_rate_rad_s: 0.0,
                rate_limit_rad_s: parameters.rate_limit_rad_s,
            };
            let described = described && !equations.has_rigid_latch();
            let closed = told.latch_enable && (caught || described);
            let mut state = JointMemory {
                released: told.release,
                crossed: 0,
                tripped: 0,
                element: 0,
                contact: Contact::default(),
                latch: LatchState { closed, enabled: told.latch_enable, time_s: -1.0, count: 0, impulse_n_m_s: 0.0 },
                slew: Slew {
                    from_rad: inputs.command_rad,
                    target_rad: inputs.command_rad,
                    target_rate_rad_s: 0.0,
                    start_s: time_s,
                    rate_limit_rad_s: parameters.rate_limit_rad_s,
                },
            };
            if !self.state.failures.is_empty() {
                failure_memory::begin_joint(
                    &self.machine.failures,
                    &self.state.failures,
                    (equations.body, described),
                    &mut told,
                    &mut state,
                );
            }
            if !equations.is_held_in(&state) {
                v[c] = revolute.start_rate_rad_s;
            }
            joints.push(state);
        }

        for (circuit, (_, own)) in self.equations.model.circuits.iter().zip(self.machine.dc_motors()) {
            v[circuit.coordinate] = own.start_current_a;
        }
        for (body, described) in self.equations.model.bodies.iter().zip(&self.machine.bodies) {
            if let (Some(modal), Some(law)) = (&body.modal, described.section.modal()) {
                for (q, (_, shape)) in q[modal.range()].iter_mut().zip(law.shapes()) {
                    *q = shape.start_m;
                }
            }
        }
        for ((_, spatial), equations) in self.machine.spatials().zip(&self.equations.spatial) {
            equations.start(spatial, &q, &mut v);
        }
        let state = &mut self.state;
        state.joints = joints;
        state.spatial_rotations = vec![Default::default(); self.spatial_joints.len()];
        state.applied_inputs.clone_from(&state.inputs);
        state.applied_rates.clear();
        state.applied_from_s = time_s;
        state.applied_parameters.clone_from(&state.parameters);
        state.statistics = Default::default();
        state.tip_rotations = vec![Default::default(); self.tip_bodies.len()];
        state.station_rotations = vec![Default::default(); self.equations.load_stations];
        state.air = None;
        state.outside = None;
        let coordinates = q.len();
        state.now = Point { time_s, q, v, ..Point::zeros(coordinates) };
        state.step_s = state.parameters.solver().max_step_s;
        for (forces, memory) in self.equations.forces.joints().iter().zip(&mut state.joints) {
            forces.begin(&state.now, memory);
        }
        self.limit_frequencies();
        self.configure();
    }

    /// Computes the accelerations and the outputs of the start state.
    pub(crate) fn conclude_start(&mut self, time_s: f64) -> Result<(), PlantError> {
        let now = &mut self.state.now;
        self.equations.branch_s = time_s;
        self.equations.prescribe(time_s, &mut now.q, &mut now.v, &mut now.a);
        let mut changed = false;
        for (forces, memory) in self.equations.forces.joints().iter().zip(&mut self.state.joints) {
            // the rates may have been changed since the start state was set
            let (contact, tripped, element) = (memory.contact, memory.tripped, memory.element);
            forces.begin(&self.state.now, memory);
            changed |= memory.contact != contact || memory.tripped != tripped || memory.element != element;
        }
        if changed {
            self.configure();
        }
        self.refuse_off_beam(&self.state.now)?;
        if let Err(error) = self.equations.close_point(&mut self.state.now) {
            return Err(self.not_closed(&self.state.now, &error));
        }
        self.start_air(time_s)?;
        let now = &mut self.state.now;
        self.equations.residual(time_s, &now.q, &now.v, &now.a, &mut self.scratch[0]);
        let jump = settle(&mut self.equations, &mut self.scratch[0], now);
        let jump = self.accelerations(time_s, jump)?;
        self.refuse_leap(Place::Now, jump)?;
        self.restrain_step(jump);
        self.state.before = self.state.now.clone();
        self.state.start = self.state.now.clone();
        self.state.ahead = self.state.now.clone();
        let stage = Point { auxiliary: Vec::new(), ..Point::zeros(self.coordinates()) };
        self.state.stages = vec![stage; self.continuation.inner_stages()];
        self.state.initialized = true;
        self.remember_attitudes();
        // stored for steps and outputs
        self.begin.clone_from(&self.state);
        self.evaluate();
        if self.outputs.are_finite() {
            Ok(())
        } else {
            Err(PlantError::NotFinite { time_s, cause: self.largest_input() })
        }
    }
}
