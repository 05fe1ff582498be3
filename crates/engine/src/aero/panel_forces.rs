//! Normal forces of the panels of a lattice, for displays of the pressure: computed together with the loads, but not part of a state.

/// Normal forces of all panels, in the order of the equations, of the circulation with which they were summed.
#[derive(Debug, Clone, Default)]
pub(super) struct PanelForces {
    normal_n: Vec<f64>,
    /// Circulation of the rings in m²/s; NaN while the forces belong to none.
    of_m2_s: Vec<f64>,
}

impl PanelForces {
    /// No forces on a number of panels.
    pub fn new(panels: usize, rings: usize) -> Self {
        Self { normal_n: vec![0.0; panels], of_m2_s: vec![f64::NAN; rings] }
    }

    /// Sets the forces to zero; they belong to no circulation until [`Self::settle`].
    pub fn clear(&mut self) {
        self.normal_n.fill(0.0);
        self.of_m2_s.fill(f64::NAN);
    }

    /// Adds a force to a panel.
    pub fn add(&mut self, panel: usize, force_n: f64) {
        self.normal_n[panel] += force_n;
    }

    /// Marks the forces as those of a circulation.
    pub fn settle(&mut self, circulation_m2_s: &[f64]) {
        self.of_m2_s.copy_from_slice(circulation_m2_s);
    }

    /// Returns whether the forces are those of a circulation.
    pub fn belong_to(&self, circulation_m2_s: &[f64]) -> bool {
        self.of_m2_s == circulation_m2_s
    }

    /// Force of a panel in N.
    pub fn normal_n(&self, panel: usize) -> f64 {
        self.normal_n[panel]
    }
}
