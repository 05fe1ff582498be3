//! Growing motions of a model in discrete time of a machine with a lattice, NOTATION eqs. (L27) to (L30).

use crate::solve::lagged::LaggedMode;
use crate::solve::near_one::nearest_one;
use crate::study::Study;
use crate::study::lattice_space::SampledSpace;
use crate::study::stability::Growth;
use crate::system::PlantError;
use crate::system::shape::ModeShape;
use nalgebra::{Complex, DVector};

impl Study<'_> {
    /// Growing motions of a model in discrete time, fastest first: among the slowest, one of each pair.
    ///
    /// # Errors
    /// If the eigenvalues are not found.
    pub fn growing_in_lattice(&self, space: &SampledSpace) -> Result<Vec<Growth>, PlantError> {
        let cause = || "the eigenvalues of the model in discrete time are not found".into();
        let failed = || PlantError::Linearization { time_s: self.system.state.now.time_s, cause: cause() };
        let freedoms = self.system.freedoms();
        let motions = nearest_one(&space.matrices.a).ok_or_else(failed)?;
        let mut list: Vec<Growth> = motions
            .into_iter()
            .map(|(z, shape)| (z.ln() / space.step_s, shape))
            .filter(|(value, _)| value.re > 0.0 && value.norm() > space.free_1_s)
            .map(|(eigenvalue_1_s, states)| {
                let shape: DVector<Complex<f64>> = states.rows(0, space.freedoms).into_owned();
                self.mode_shape(LaggedMode { eigenvalue_1_s, shape, lag_share: 0.0 }, &freedoms)
            })
            .filter(ModeShape::grows)
            .map(|mode| self.growth(&mode))
            .collect();
        list.sort_by(|a, b| b.eigenvalue_1_s.re.total_cmp(&a.eigenvalue_1_s.re));
        Ok(list)
    }
}
