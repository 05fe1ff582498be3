//! Sliding joints in the system: the elements that hold their carriages, the impulse at a border between elements, and the ends of the
//! beam, NOTATION eq. (J15).

use crate::force::memory::JointMemory;
use crate::multibody::kinematics::{Motion, sweep_motion};
use crate::multibody::model::Base;
use crate::multibody::workspace::Pair;
use crate::multibody::{dynamics, energy};
use crate::solve::point::Point;
use crate::solve::{EquationsOfMotion, Singular};
use crate::system::brake::Stopped;
use crate::system::equations::Equations;
use crate::system::{PlantError, System};

impl System {
    /// Moves the carriages of sliding joints into the elements of the new state. The rates change by the impulse that keeps all momenta; the
    /// energy lost is returned, and the work of prescribed motions.
    ///
    /// Overwrites the rates of `before` and `scratch[1]`. Allocates nothing.
    pub(crate) fn cross_borders(&mut self) -> Result<Stopped, Singular> {
        let Self { state, equations, scratch, .. } = self;
        if equations.is_seated(&state.joints) {
            return Ok(Stopped::default());
        }
        state.before.v.resize(state.start.v.len(), 0.0);
        state.before.a.resize(state.start.v.len(), 0.0);
        let (zero, other) = (&mut state.before.v, &mut state.before.a);
        equations.cross_borders(&mut state.start, &state.joints, zero, [&mut scratch[1], other])
    }

    /// Returns an error if a body has left the beam along which it slides.
    pub(crate) fn refuse_off_beam(&self, point: &Point) -> Result<(), PlantError> {
        for joint in self.equations.forces.joints() {
            let Base::Axis(slide) = self.equations.model.bodies[joint.body].base else { continue };
            let position_m = point.q[joint.coordinate];
            if joint.borders().is_some_and(|borders| !borders.contains(position_m)) {
                let beam = &self.machine.bodies[self.equations.model.slides[slide].beam];
                return Err(PlantError::OffBeam {
                    time_s: point.time_s,
                    joint: self.machine.bodies[joint.body].joint.name.clone(),
                    beam: beam.name.clone(),
                    length_m: beam.length_m,
                    position_m,
                });
            }
        }
        Ok(())
    }

    /// Moves the carriages of sliding joints into the elements at the positions of the current state, without an impulse.
    pub(crate) fn follow_carriages(&mut self) {
        let Self { state, equations, .. } = self;
        for (joint, memory) in equations.forces.joints().iter().zip(&mut state.joints) {
            if let Some(borders) = joint.borders() {
                memory.element = borders.element_at(state.now.q[joint.coordinate], 0.0);
            }
        }
        equations.seat(&state.joints);
    }
}

impl Equations {
    /// Elements of the carriages according to the states of the joints: indices of slides, and of elements of the model.
    fn seats<'a>(&'a self, joints: &'a [JointMemory]) -> impl Iterator<Item = (usize, usize)> + 'a {
        self.forces.joints().iter().zip(joints).filter_map(|(joint, memory)| match self.model.bodies[joint.body].base {
            Base::Axis(index) => {
                let (slide, last) = (&self.model.slides[index], joint.borders()?.last());
                Some((index, slide.element(&self.model, memory.element.min(last))))
            }
            Base::Root(_) | Base::Node(_) => None,
        })
    }

    /// Sets the elements of the carriages to those at the positions in `q`.
    pub(crate) fn seat_at(&mut self, q: &[f64]) {
        for joint in self.forces.joints() {
            let (Base::Axis(index), Some(borders)) = (self.model.bodies[joint.body].base, joint.borders()) else {
                continue;
            };
            let element = borders.element_at(q[joint.coordinate], 0.0);
            self.work.slides[index].element = self.model.slides[index].element(&self.model, element);
        }
    }

    fn is_seated(&self, joints: &[JointMemory]) -> bool {
        self.model.slides.is_empty()
            || self.seats(joints).all(|(index, element)| self.work.slides[index].element == element)
    }

    /// Sets the elements of the carriages from the states of the joints.
    pub(crate) fn seat(&mut self, joints: &[JointMemory]) {
        for index in 0..self.model.slides.len() {
            let found = self.seats(joints).find(|(other, _)| *other == index).map(|(_, element)| element);
            if let Some(element) = found {
                self.work.slides[index].element = element;
            }
        }
    }

    /// Kinetic energy in J of the whole model and of the penalties of its loops.
    fn kinetic_j(&mut self, point: &Point, zero: &[f64]) -> f64 {
        sweep_motion(&self.model, &mut self.work, Motion { q: &point.q, v: &point.v, a: zero });
        energy::kinetic(&self.model, &self.work, |_, _| ())
            + energy::kinetic_of_drives(&self.model, &self.work, &point.v)
            + self.loop_kinetic_j()
    }

    /// Kinetic energy in J of the velocities before the impulse at the pose after it.
    fn kinetic_of_carried_j(&mut self, point: &Point, zero: &[f64]) -> f64 {
        sweep_motion(&self.model, &mut self.work, Motion { q: &point.q, v: &point.v, a: zero });
        for (node, carried) in self.work.nodes.iter_mut().zip(&self.work.carried) {
            (node.velocity, node.spin) = (carried.linear, carried.angular);
        }
        energy::kinetic(&self.model, &self.work, |_, _| ())
            + energy::kinetic_of_drives(&self.model, &self.work, &point.v)
            + self.loop_kinetic_j()
    }

    /// Momenta in the directions of all coordinates of the jump from the velocities in [`Workspace::carried`] to those at the rates `v`;
    /// `zero` are zeros. The parts of strains and modes are the same before and after, and cancel. The rows of the multipliers of rigid loops
    /// are the rates of their gaps.
    ///
    /// [`Workspace::carried`]: crate::multibody::Workspace::carried
    fn momenta_of_jump(&mut self, [q, v, zero]: [&[f64]; 3], [jump, before]: [&mut [f64]; 2]) {
        // at zero rates the accelerations of the nodes are linear in those of the coordinates, as velocities are in rates
        sweep_motion(&self.model, &mut self.work, Motion { q, v: zero, a: v });
        let still = Motion { q, v: zero, a: zero };
        jump.fill(0.0);
        dynamics::momenta(&self.model, &mut self.work, still, &self.damping, jump);
        for (node, carried) in self.work.nodes.iter_mut().zip(&self.work.carried) {
            (node.acceleration, node.spin_rate) = (carried.linear, carried.angular);
        }
        before.fill(0.0);
        dynamics::momenta(&self.model, &mut self.work, still, &self.damping, before);
        jump.iter_mut().zip(before.iter()).for_each(|(jump, before)| *jump -= before);
    }

    /// Energy in J that an impulse loses: that of the jump from the velocities in [`Workspace::carried`] to those of `point`, with the jump of the
    /// rates.
    ///
    /// [`Workspace::carried`]: crate::multibody::Workspace::carried
    fn energy_of_jump_j(&mut self, point: &Point, rates: &[f64], zero: &[f64]) -> f64 {
        sweep_motion(&self.model, &mut self.work, Motion { q: &point.q, v: &point.v, a: zero });
        for (node, carried) in self.work.nodes.iter_mut().zip(&self.work.carried) {
            node.velocity -= carried.linear;
            node.spin -= carried.angular;
        }
        energy::kinetic(&self.model, &self.work, |_, _| ())
            + energy::kinetic_of_drives(&self.model, &self.work, rates)
            + self.loop_kinetic_j()
    }

    fn cross_borders(
        &mut self,
        point: &mut Point,
        joints: &[JointMemory],
        zero: &mut [f64],
        [momenta, other]: [&mut [f64]; 2],
    ) -> Result<Stopped, Singular> {
        zero.fill(0.0);
        let before_j = self.kinetic_j(point, zero);
        sweep_motion(&self.model, &mut self.work, Motion { q: &point.q, v: zero, a: &point.v });
        for (kept, node) in self.work.carried.iter_mut().zip(&self.work.nodes) {
            *kept = Pair { linear: node.acceleration, angular: node.spin_rate };
        }
        self.seat(joints);
        let held_j = self.kinetic_of_carried_j(point, zero);
        self.momenta_of_jump([&point.q, &point.v, zero], [momenta, other]);
        self.factorize(1.0, 0.0, 0.0)?;
        self.solve(momenta);
        // the impulses of the constraints are not kept
        let tree = self.model.tree_coordinates();
        point.v[..tree].iter_mut().zip(momenta.iter()).for_each(|(v, jump)| *v -= jump);
        let mut work_j = 0.0;
        if self.forces.joints().iter().any(|joint| joint.law().is_some()) {
            if self.model.constraints() > 0 {
                // the impulses of the constraints act at the prescribed joints too
                let lost_j = self.energy_of_jump_j(point, momenta, zero);
                let after_j = self.kinetic_j(point, zero);
                return Ok(Stopped { lost_j, work_j: lost_j + after_j - before_j });
            }
            self.momenta_of_jump([&point.q, &point.v, zero], [momenta, other]);
            let moved = self.forces.joints().iter().filter(|joint| joint.law().is_some());
            work_j = moved.map(|joint| momenta[joint.coordinate] * point.v[joint.coordinate]).sum();
        }
        let after_j = self.kinetic_j(point, zero);
        // the border is located to a finite accuracy, by which the pose jumps: the resulting energy counts as work, as for the potentials
        Ok(Stopped { lost_j: held_j + work_j - after_j, work_j: work_j + held_j - before_j })
    }
}
