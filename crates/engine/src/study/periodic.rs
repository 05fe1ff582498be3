//! Moving parts of a perturbation of a periodic motion, in the fixed frame, and the model averaged over the revolution.

use crate::solve::linearize::SecondOrder;
use crate::solve::modes::{Mode, modes_beyond};
use crate::solve::multiblade::Multiblade;
use crate::study::{Rotor, Study};
use crate::system::PlantError;
use crate::system::freedoms::Freedom;
use crate::system::shape::WhirlShare;
use nalgebra::{Complex, DVector};

/// Transformation of the coordinates of a model with a spinning rotor to the fixed frame.
#[derive(Debug, Clone)]
pub struct GroundView {
    freedoms: Vec<Freedom>,
    rotor: Rotor,
    blades: Multiblade,
    /// Masses of the transformed coordinates, the diagonal of the transformed mass.
    mass: nalgebra::DMatrix<f64>,
    speed_rad_s: f64,
    /// Sum of the equations added so far, and their number.
    sum: Option<(SecondOrder, usize)>,
    first: Option<SecondOrder>,
    spread: f64,
}

/// Modes of the equations averaged over a revolution, eq. (L36).
#[derive(Debug, Clone, PartialEq)]
pub struct AveragedModes {
    /// Eigenvalues in 1/s with positive imaginary part, or real, lowest frequency first.
    pub eigenvalues_1_s: Vec<Complex<f64>>,
    /// Largest change of an entry of the transformed stiffness over the revolution, relative to the diagonal entries of its two
    /// coordinates, which averaging neglects.
    pub spread: f64,
}

impl Study<'_> {
    /// Transformation to the fixed frame for a model in its current state, at the start of a revolution of the shaft of `rotor`; without
    /// a rotor of equal blades (`None`) the coordinates are those of the model.
    ///
    /// # Errors
    /// If blades of the rotor have different degrees of freedom.
    pub fn ground_view(&self, shaft: usize, rotor: Option<&Rotor>, speed_rad_s: f64) -> Result<GroundView, PlantError> {
        let freedoms = self.system.freedoms();
        let rotor = rotor.cloned().unwrap_or(Rotor { shaft, blades: vec![Vec::new()] });
        let time_s = self.system.state.now.time_s;
        let blades = self.blades(&rotor, &freedoms).map_err(|cause| PlantError::Linearization { time_s, cause })?;
        let mass = self.mass_matrix(&freedoms);
        let n = freedoms.len();
        let none = nalgebra::DMatrix::zeros(n, n);
        let bare = SecondOrder { mass, damping: none.clone(), stiffness: none };
        let mass = blades.transform(&bare, 0.0, speed_rad_s).mass;
        Ok(GroundView { freedoms, rotor, blades, mass, speed_rad_s, sum: None, first: None, spread: 0.0 })
    }

    /// Adds the equations about the current state, at an azimuth from the start of the revolution, to the average.
    ///
    /// # Errors
    /// As for [`Study::second_order`].
    pub fn see(&mut self, view: &mut GroundView, azimuth_rad: f64) -> Result<(), PlantError> {
        let seen = view.blades.transform(&self.second_order()?, azimuth_rad, view.speed_rad_s);
        let first = view.first.get_or_insert_with(|| seen.clone());
        for i in 0..seen.mass.nrows() {
            for j in 0..seen.mass.nrows() {
                let own = |k: usize| first.stiffness[(k, k)].abs() + first.mass[(k, k)] * view.speed_rad_s.powi(2);
                let change = (seen.stiffness[(i, j)] - first.stiffness[(i, j)]).abs() / (own(i) * own(j)).sqrt();
                view.spread = view.spread.max(change);
            }
        }
        match &mut view.sum {
            Some((sum, count)) => {
                sum.mass += seen.mass;
                sum.damping += seen.damping;
                sum.stiffness += seen.stiffness;
                *count += 1;
            }
            None => view.sum = Some((seen, 1)),
        }
        Ok(())
    }

    /// Names of the moving parts of a motion in transformed coordinates, largest participation first, eq. (L26).
    pub fn moving_parts(&self, view: &GroundView, shape: &DVector<Complex<f64>>) -> Vec<WhirlShare> {
        let shares = view.blades.shares(shape, &view.mass, view.speed_rad_s);
        self.named(&view.freedoms, &view.rotor, &shares)
    }
}

impl GroundView {
    /// Coordinates in the fixed frame.
    pub fn components(&self, coordinates: &DVector<Complex<f64>>, azimuth_rad: f64) -> DVector<Complex<f64>> {
        self.blades.components(coordinates, azimuth_rad)
    }

    /// Coordinates of the model, from components in the fixed frame: the inverse of [`GroundView::components`].
    pub fn coordinates(&self, components: &DVector<Complex<f64>>, azimuth_rad: f64) -> DVector<Complex<f64>> {
        self.blades.coordinates(components, azimuth_rad)
    }

    /// Masses of the transformed coordinates.
    pub fn weights(&self) -> DVector<f64> {
        self.mass.diagonal()
    }

    /// Modes of the average of the equations added by [`Study::see`]; `None` before the first one, and if the average has no modes.
    pub fn averaged(&self) -> Option<AveragedModes> {
        let (sum, count) = self.sum.as_ref()?;
        let share = 1.0 / *count as f64;
        let [mass, damping, stiffness] = [&sum.mass * share, &sum.damping * share, &sum.stiffness * share];
        let shift_1_s2 = self.blades.shift_1_s2(self.speed_rad_s);
        let list: Vec<Mode> = modes_beyond([&mass, &damping, &stiffness], self.freedoms.len(), shift_1_s2).ok()?;
        let eigenvalues_1_s = list.into_iter().map(|mode| mode.eigenvalue_1_s).collect();
        Some(AveragedModes { eigenvalues_1_s, spread: self.spread })
    }
}
