//! Analyses that parts of a machine do not permit: errors that name the analysis and the part.

use crate::system::{PlantError, System};

/// Maximum number of coordinates of a machine with sliding joints for analyses with a dense matrix.
const MAXIMUM_DENSE: usize = 1200;

impl System {
    /// Whether there are constraints by multipliers: rigid loops, skates and wheels.
    pub(crate) fn is_constrained(&self) -> bool {
        self.equations.model.constraints() > 0
    }

    /// Returns an error that names an analysis that skates and wheels do not permit.
    pub(crate) fn refuse_no_slip(&self, analysis: &'static str) -> Result<(), PlantError> {
        match self.machine.no_slips.first() {
            None => Ok(()),
            Some(no_slip) => {
                let (time_s, name) = (self.state.now.time_s, no_slip.name.clone());
                Err(PlantError::NoSlip { time_s, kind: no_slip.table(), name, analysis })
            }
        }
    }

    /// Returns an error that names an analysis if a rigid loop, a skate or a wheel does not permit it.
    pub(crate) fn refuse_constraints(&self, analysis: &'static str) -> Result<(), PlantError> {
        self.refuse_no_slip(analysis)?;
        match self.machine.closures.iter().find(|closure| closure.rigid) {
            None => Ok(()),
            Some(closure) => {
                let (time_s, name) = (self.state.now.time_s, closure.name.clone());
                Err(PlantError::RigidLoop { time_s, name, analysis })
            }
        }
    }

    /// Returns an error that names an analysis if a DC motor does not permit it.
    pub(crate) fn refuse_dc_motor(&self, analysis: &'static str) -> Result<(), PlantError> {
        match self.machine.dc_motors().next() {
            None => Ok(()),
            Some((joint, _)) => {
                let (time_s, joint) = (self.state.now.time_s, self.joint_name(joint).to_owned());
                Err(PlantError::DcMotor { time_s, joint, analysis })
            }
        }
    }

    /// Returns an error that names an analysis that a machine with sliding joints does not permit: with rigid loops, or with too many
    /// coordinates for a dense matrix.
    pub(crate) fn refuse_sliding(&self, analysis: &'static str) -> Result<(), PlantError> {
        let Some(joint) = self.machine.sliding_joint() else { return Ok(()) };
        self.refuse_constraints(analysis)?;
        let coordinates = self.coordinates();
        if coordinates <= MAXIMUM_DENSE {
            return Ok(());
        }
        let (time_s, joint) = (self.state.now.time_s, joint.to_owned());
        Err(PlantError::Sliding { time_s, joint, analysis, coordinates, maximum: MAXIMUM_DENSE })
    }
}
