//! Properties of a cross-section given by its shape, about the beam axis: those that beams use, and those that are only reported.

use foldwing_engine::beam::section::{Section, uncoupled_shear};
use foldwing_engine::math::strain::{EDGE, FLAP, STRAINS, STRETCH, StrainMatrix, TWIST};
use serde::Serialize;

/// Properties of a cross-section, in the section frame (`y` chordwise, `z` through the thickness); positions are measured from the beam
/// axis. The beam axis of a section by shape is its shear centre, so that transverse loads on the axis do not twist it, NOTATION
/// eq. (S12).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SectionProperties {
    /// Axial stiffness `EA` in N.
    #[serde(rename = "axial_stiffness_N")]
    pub axial_stiffness_n: f64,
    /// Shear stiffnesses `[GA_y, GA_z]` in N: squared force divided by twice the energy due to a force along `y` or `z`, NOTATION eq.
    /// (S13). Used by bodies with shear deformation only. `None` for sections given by their stiffness.
    #[serde(rename = "shear_stiffnesses_N")]
    pub shear_stiffnesses_n: Option<[f64; 2]>,
    /// Torsional rigidity `GJ` in N·m².
    #[serde(rename = "torsional_rigidity_N_m2")]
    pub torsional_rigidity_n_m2: f64,
    /// Flapwise bending stiffness `EI_y = ∫E z² dA` about the tension centre in N·m².
    #[serde(rename = "flap_stiffness_N_m2")]
    pub flap_stiffness_n_m2: f64,
    /// Edgewise bending stiffness `EI_z = ∫E y² dA` about the tension centre in N·m².
    #[serde(rename = "edge_stiffness_N_m2")]
    pub edge_stiffness_n_m2: f64,
    /// Coupling of the two curvatures, `−∫E y z dA` about the tension centre, in N·m².
    #[serde(rename = "coupling_flap_edge_N_m2")]
    pub coupling_flap_edge_n_m2: f64,
    /// Coupling of stretch and twist in N·m.
    #[serde(rename = "coupling_axial_twist_N_m")]
    pub coupling_axial_twist_n_m: f64,
    /// Coupling of twist and curvature about `y` in N·m².
    #[serde(rename = "coupling_twist_flap_N_m2")]
    pub coupling_twist_flap_n_m2: f64,
    /// Warping stiffness `E C_w` about the shear centre in N·m⁴ of an open thin-walled section; 0 for other sections. Not used by the
    /// beams.
    #[serde(rename = "warping_stiffness_N_m4")]
    pub warping_stiffness_n_m4: f64,
    /// Tension centre `[y, z]` in m: an axial force at this point causes no bending.
    pub tension_centre_m: [f64; 2],
    /// Shear centre `[y, z]` in m: a transverse force at this point causes no twist. `None` for sections given by their stiffness.
    pub shear_centre_m: Option<[f64; 2]>,
    /// Mass per length in kg/m.
    pub mass_kg_m: f64,
    /// Centre of mass `[y, z]` in m.
    pub centre_of_mass_m: [f64; 2],
    /// Second moments of mass per length about the centre of mass `[∫ρy² dA, ∫ρyz dA, ∫ρz² dA]` in kg·m.
    pub second_moments_kg_m: [f64; 3],
    /// Bounding box of the outline in m: smallest and largest `y`, smallest and largest `z`; `None` if not stated.
    pub outline_m: Option<[[f64; 2]; 2]>,
}

/// Weighted integrals over the area of a section, about any origin.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(in crate::shapes) struct Moments {
    /// `∫w dA`.
    pub whole: f64,
    /// `(∫w y dA, ∫w z dA)`.
    pub first: [f64; 2],
    /// `(∫w y² dA, ∫w y z dA, ∫w z² dA)`.
    pub second: [f64; 3],
}

impl Moments {
    /// Adds a rectangle with weight `w` per area, given by its centre, its half sides and the direction of the first side.
    pub fn add_rectangle(&mut self, weight: f64, middle: [f64; 2], half: [f64; 2], along: [f64; 2]) {
        let whole = weight * 4.0 * half[0] * half[1];
        let ([y, z], [a, b]) = (middle, along);
        let (own, across) = (half[0] * half[0] / 3.0, half[1] * half[1] / 3.0);
        self.whole += whole;
        self.first[0] += whole * y;
        self.first[1] += whole * z;
        self.second[0] += whole * (y * y + own * a * a + across * b * b);
        self.second[1] += whole * (y * z + (own - across) * a * b);
        self.second[2] += whole * (z * z + own * b * b + across * a * a);
    }

    /// Centre `[y, z]`.
    pub fn centre(&self) -> [f64; 2] {
        self.first.map(|moment| moment / self.whole)
    }

    /// Second moments about the centre.
    pub fn about_centre(&self) -> [f64; 3] {
        let [y, z] = self.centre();
        let [yy, yz, zz] = self.second;
        [yy - self.whole * y * y, yz - self.whole * y * z, zz - self.whole * z * z]
    }
}

/// Properties of a shape about any origin; [`Raw::about_shear_centre`] converts them to the beam axis.
#[derive(Debug, Clone)]
pub(in crate::shapes) struct Raw {
    /// Integrals weighted with Young's modulus.
    pub stiffness: Moments,
    /// Integrals weighted with the density.
    pub mass: Moments,
    /// `GJ` in N·m².
    pub torsional_rigidity_n_m2: f64,
    /// `[GA_y, GA_z]` in N.
    pub shear_stiffnesses_n: [f64; 2],
    /// Shear centre in m.
    pub shear_centre_m: [f64; 2],
    /// `E C_w` in N·m⁴.
    pub warping_stiffness_n_m4: f64,
    /// Bounding box of the outline in m: smallest and largest `y`, smallest and largest `z`.
    pub reach_m: [[f64; 2]; 2],
}

impl Raw {
    /// Returns the mirror image with `y` reversed.
    pub fn mirrored(mut self) -> Self {
        for moments in [&mut self.stiffness, &mut self.mass] {
            moments.first[0] *= -1.0;
            moments.second[1] *= -1.0;
        }
        self.shear_centre_m[0] *= -1.0;
        let [left, right] = self.reach_m[0];
        self.reach_m[0] = [-right, -left];
        self
    }

    /// Returns the properties about the shear centre.
    pub fn about_shear_centre(&self) -> SectionProperties {
        let [y0, z0] = self.shear_centre_m;
        let from_axis = |[y, z]: [f64; 2]| [clean(y - y0, self.size_m()), clean(z - z0, self.size_m())];
        let [yy, yz, zz] = self.stiffness.about_centre();
        let [[left, right], [low, high]] = self.reach_m;
        SectionProperties {
            axial_stiffness_n: self.stiffness.whole,
            shear_stiffnesses_n: Some(self.shear_stiffnesses_n),
            torsional_rigidity_n_m2: self.torsional_rigidity_n_m2,
            flap_stiffness_n_m2: zz,
            edge_stiffness_n_m2: yy,
            coupling_flap_edge_n_m2: 0.0 - clean(yz, yy + zz),
            coupling_axial_twist_n_m: 0.0,
            coupling_twist_flap_n_m2: 0.0,
            warping_stiffness_n_m4: self.warping_stiffness_n_m4,
            tension_centre_m: from_axis(self.stiffness.centre()),
            shear_centre_m: Some([0.0; 2]),
            mass_kg_m: self.mass.whole,
            centre_of_mass_m: from_axis(self.mass.centre()),
            second_moments_kg_m: {
                let [yy, yz, zz] = self.mass.about_centre();
                [yy, clean(yz, yy + zz), zz]
            },
            outline_m: Some([from_axis([left, low]), from_axis([right, high])])
                .map(|[[left, low], [right, high]]| [[left, right], [low, high]]),
        }
    }

    fn size_m(&self) -> f64 {
        let [[left, right], [low, high]] = self.reach_m;
        (right - left).max(high - low)
    }
}

/// Replaces the round-off of a difference of numbers of magnitude `size` by zero.
fn clean(value: f64, size: f64) -> f64 {
    if value.abs() < 1e-12 * size { 0.0 } else { value }
}

impl SectionProperties {
    /// Properties of a section given by its stiffness and inertia. The tension centre is that with free twist.
    pub fn of(section: &Section) -> Self {
        let stiffness = &section.stiffness;
        let twist = stiffness[(TWIST, TWIST)];
        let freed = StrainMatrix::<STRAINS>::from_fn(|i, j| {
            stiffness[(i, j)] - stiffness[(i, TWIST)] * stiffness[(TWIST, j)] / twist
        });
        let (y, z) =
            (-freed[(STRETCH, EDGE)] / freed[(STRETCH, STRETCH)], freed[(STRETCH, FLAP)] / freed[(STRETCH, STRETCH)]);
        let about = |i: usize, j: usize| {
            stiffness[(i, j)] - stiffness[(STRETCH, i)] * stiffness[(STRETCH, j)] / stiffness[(STRETCH, STRETCH)]
        };
        let (mass, [first_y, first_z]) = (section.mass_kg_m, section.first_moment_kg);
        let [yy, yz, zz] = section.second_moment_kg_m;
        Self {
            axial_stiffness_n: stiffness[(STRETCH, STRETCH)],
            shear_stiffnesses_n: None,
            torsional_rigidity_n_m2: twist,
            flap_stiffness_n_m2: about(FLAP, FLAP),
            edge_stiffness_n_m2: about(EDGE, EDGE),
            coupling_flap_edge_n_m2: about(FLAP, EDGE),
            coupling_axial_twist_n_m: stiffness[(STRETCH, TWIST)],
            coupling_twist_flap_n_m2: stiffness[(TWIST, FLAP)],
            warping_stiffness_n_m4: 0.0,
            tension_centre_m: [y + 0.0, z + 0.0],
            shear_centre_m: None,
            mass_kg_m: mass,
            centre_of_mass_m: [first_y / mass, first_z / mass],
            second_moments_kg_m: [
                yy - first_y * first_y / mass,
                yz - first_y * first_z / mass,
                zz - first_z * first_z / mass,
            ],
            outline_m: (section.half_width_m > 0.0)
                .then_some([section.half_width_m, section.half_height_m].map(|half| [-half, half])),
        }
    }

    /// Returns stiffness and inertia about the beam axis, NOTATION eqs. (S1), (K7).
    pub fn section(&self) -> Section {
        let ([y, z], axial) = (self.tension_centre_m, self.axial_stiffness_n);
        let mut stiffness = StrainMatrix::<STRAINS>::zeros();
        let mut set = |i: usize, j: usize, value: f64| {
            stiffness[(i, j)] = value;
            stiffness[(j, i)] = value;
        };
        set(STRETCH, STRETCH, axial);
        set(TWIST, TWIST, self.torsional_rigidity_n_m2);
        set(STRETCH, TWIST, self.coupling_axial_twist_n_m);
        set(TWIST, FLAP, self.coupling_twist_flap_n_m2);
        set(STRETCH, FLAP, axial * z);
        set(STRETCH, EDGE, -axial * y);
        set(FLAP, FLAP, self.flap_stiffness_n_m2 + axial * z * z);
        set(EDGE, EDGE, self.edge_stiffness_n_m2 + axial * y * y);
        set(FLAP, EDGE, self.coupling_flap_edge_n_m2 - axial * y * z);
        let (mass, [y, z], [yy, yz, zz]) = (self.mass_kg_m, self.centre_of_mass_m, self.second_moments_kg_m);
        let [half_width_m, half_height_m] =
            self.outline_m.map_or([0.0; 2], |outline| outline.map(|[low, high]| high.max(-low)));
        Section {
            stiffness,
            shear: self.shear_stiffnesses_n.map(|shear_n| uncoupled_shear(&stiffness, shear_n)),
            mass_kg_m: mass,
            first_moment_kg: [mass * y, mass * z],
            second_moment_kg_m: [yy + mass * y * y, yz + mass * y * z, zz + mass * z * z],
            half_width_m,
            half_height_m,
        }
    }
}
