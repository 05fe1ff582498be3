//! Stability of a state of rest in the air of a lattice: by the model in discrete time, NOTATION eqs. (L27) to (L30).

use crate::solve::lagged::LaggedMode;
use crate::solve::near_one::nearest_one;
use crate::study::Study;
use crate::study::lattice_space::SampledSpace;
use crate::study::stability::{Growth, Stability};
use crate::system::PlantError;
use crate::system::shape::ModeShape;
use nalgebra::{Complex, DVector};

impl Study<'_> {
    /// Stability of the present state, which must be one of rest, with the air of its lattice: by the slowest motions of the model in
    /// discrete time, those whose eigenvalues are nearest 1. `None` where that model has more states than memory holds.
    ///
    /// # Errors
    /// As [`Study::lattice_space`]; and where the eigenvalues are not found.
    pub fn lattice_stability(&mut self) -> Result<Option<Stability>, PlantError> {
        let Ok(space) = self.lattice_space_within(&[], &|_| DVector::zeros(0))? else { return Ok(None) };
        let growing = self.growing_in_lattice(&space)?;
        Ok(Some(Stability { negative_directions: 0, potential: false, neutral: false, growing, in_lattice: true }))
    }

    /// Motions of a model in discrete time that grow, fastest first: among the slowest, one of each pair.
    ///
    /// # Errors
    /// Where the eigenvalues are not found.
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
