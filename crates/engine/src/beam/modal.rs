//! Bending in a few given mode shapes: blade and tower of \[E\], with shapes, integrals and lumped masses.
//!
//! A body bends flapwise (along its `z`) and edgewise (along its `y`) in given polynomials, its axis shortens to second order in the
//! deflections, and its mass is on the axis. Integrals are sums over equal cells with the properties at mid-cell; running integrals add
//! full cells and a fraction of one, NOTATION eqs. (M1)–(M5).

use crate::beam::modal_mass::MassMoments;
use crate::beam::profile::Profile;
use crate::beam::section::Section;
use crate::beam::small_turn::SmallTurn;
use crate::math::strain::{EDGE, FLAP, StrainMatrix};
use nalgebra::{SMatrix, Vector3};

/// Maximum number of shapes of a body, limited by the storage for the elimination in the recursions.
pub const MAXIMUM_MODES: usize = 8;
/// Number of shapes up to which sums have a fixed length: blades have three and towers four.
pub(crate) const FEW_MODES: usize = 4;

/// One shape with its damping.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Coefficients of `x²`, `x³`, …, with `x` from 0 at the inner to 1 at the outer end; their sum is 1, so that the coordinate is the
    /// deflection of the outer end in m.
    pub coefficients: Vec<f64>,
    /// Damping ratio of this shape alone, for the untwisted body with a free outer end.
    pub damping_ratio: f64,
    /// Initial deflection of the outer end in m.
    pub start_m: f64,
}

impl Shape {
    /// Value `φ(x)`.
    pub fn value(&self, x: f64) -> f64 {
        self.sum(x, |power| (1.0, power))
    }

    /// First derivative `dφ/dx`.
    pub fn slope(&self, x: f64) -> f64 {
        self.sum(x, |power| (f64::from(power), power - 1))
    }

    /// Second derivative `d²φ/dx²`.
    pub fn curvature(&self, x: f64) -> f64 {
        self.sum(x, |power| (f64::from(power * (power - 1)), power - 2))
    }

    fn sum(&self, x: f64, term: impl Fn(i32) -> (f64, i32)) -> f64 {
        let powers = (2..).map(term);
        self.coefficients.iter().zip(powers).map(|(c, (factor, power))| c * factor * x.powi(power)).sum()
    }
}

/// Modal body as described in the model.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalLaw {
    /// Length in m.
    pub length_m: f64,
    /// Number of equal cells for the sums.
    pub cells: usize,
    /// Mass per length in kg/m as a function of the distance from the inner end in m.
    pub mass_kg_m: Profile,
    /// Flapwise bending stiffness in N·m².
    pub flap_stiffness_n_m2: Profile,
    /// Edgewise bending stiffness in N·m².
    pub edge_stiffness_n_m2: Profile,
    /// Structural twist in rad, right-handed about the axis; with `None` the shapes are the polynomials.
    pub twist_rad: Option<Profile>,
    /// Flapwise shapes.
    pub flap: Vec<Shape>,
    /// Edgewise shapes; their coordinates follow the flapwise ones.
    pub edge: Vec<Shape>,
    /// Whether the axis shortens with the deflection; without, `S_ij = 0`, NOTATION eq. (M13).
    pub axial_shortening: bool,
    /// Whether sections rotate with the slope; without, `ω_i = 0` and all sections keep the attitude of the inner end, eq. (M13).
    pub section_rotation: bool,
    /// Whether the angular velocity of a section is the rate of its small angles, as in \[E\], for comparison with it: power then differs
    /// from the rate of the energies at second order in the slopes. Not available in model files.
    pub rates_of_angles: bool,
    /// Factor of the mass.
    pub mass_factor: f64,
    /// Factor of the stiffness.
    pub stiffness_factor: f64,
}

impl ModalLaw {
    /// Number of shapes.
    pub fn modes(&self) -> usize {
        self.flap.len() + self.edge.len()
    }

    /// Total mass in kg: sum over the cells.
    pub fn mass_in_all_kg(&self) -> f64 {
        let cell_m = self.cell_m();
        self.middles_m().map(|s| self.mass_factor * self.mass_kg_m.at(s) * cell_m).sum()
    }

    /// Section at a position in the form of a beam section: mass and bending stiffnesses.
    pub(crate) fn section(&self, s_m: f64) -> Section {
        let bending = [&self.flap_stiffness_n_m2, &self.edge_stiffness_n_m2];
        let mut stiffness = StrainMatrix::zeros();
        for (strain, bending) in [FLAP, EDGE].into_iter().zip(bending) {
            stiffness[(strain, strain)] = self.stiffness_factor * bending.at(s_m);
        }
        Section {
            shear: None,
            stiffness,
            mass_kg_m: self.mass_factor * self.mass_kg_m.at(s_m),
            first_moment_kg: [0.0; 2],
            second_moment_kg_m: [0.0; 3],
            half_width_m: 0.0,
            half_height_m: 0.0,
        }
    }

    fn cell_m(&self) -> f64 {
        self.length_m / self.cells as f64
    }

    fn middles_m(&self) -> impl Iterator<Item = f64> {
        let cell_m = self.cell_m();
        (0..self.cells).map(move |k| (k as f64 + 0.5) * cell_m)
    }

    /// Flapwise and edgewise directions in the section as `[y, z]`, eq. (M1).
    fn directions(&self, s_m: f64) -> [[f64; 2]; 2] {
        let (sine, cosine) = self.twist_rad.as_ref().map_or((0.0, 1.0), |twist| twist.at(s_m).sin_cos());
        [[-sine, cosine], [cosine, sine]]
    }

    /// All shapes in the order of their coordinates, each with 0 for flapwise or 1 for edgewise.
    pub fn shapes(&self) -> impl Iterator<Item = (usize, &Shape)> {
        self.flap.iter().map(|shape| (0, shape)).chain(self.edge.iter().map(|shape| (1, shape)))
    }
}

/// Values of the shapes at one position: deflection and slope per coordinate, NOTATION eq. (M2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapesAt {
    /// Distance from the inner end in m.
    pub place_m: f64,
    /// Deflection `[y, z]` per coordinate.
    pub bend: [[f64; 2]; MAXIMUM_MODES],
    /// Slope of the deflection `[y, z]` per coordinate, 1/m.
    pub slope_1_m: [[f64; 2]; MAXIMUM_MODES],
    /// `S_ij`: twice the shortening of the axis per product of two coordinates, 1/m.
    pub shortening_1_m: [[f64; MAXIMUM_MODES]; MAXIMUM_MODES],
}

impl ShapesAt {
    const ZERO: Self = Self {
        place_m: 0.0,
        bend: [[0.0; 2]; MAXIMUM_MODES],
        slope_1_m: [[0.0; 2]; MAXIMUM_MODES],
        shortening_1_m: [[0.0; MAXIMUM_MODES]; MAXIMUM_MODES],
    };

    /// Sets to zero the terms that the body's settings exclude, eq. (M13).
    fn kept(mut self, [shortening, rotation]: [bool; 2]) -> Self {
        if !shortening {
            self.shortening_1_m = Self::ZERO.shortening_1_m;
        }
        if !rotation {
            self.slope_1_m = Self::ZERO.slope_1_m;
        }
        self
    }

    /// Sum `Σ_j S_ij x_j` for each shape `i`.
    #[inline]
    pub fn shortened(&self, x: &[f64]) -> [f64; MAXIMUM_MODES] {
        let mut sums = [0.0; MAXIMUM_MODES];
        // S is symmetric: its columns are rows, whose entries are contiguous and can be multiplied together
        if x.len() <= FEW_MODES {
            self.add_columns::<FEW_MODES>(x, &mut sums);
        } else {
            self.add_columns::<MAXIMUM_MODES>(x, &mut sums);
        }
        sums
    }

    /// Computes the first `N` sums.
    #[inline]
    fn add_columns<const N: usize>(&self, x: &[f64], sums: &mut [f64; MAXIMUM_MODES]) {
        for (column, x) in self.shortening_1_m.iter().zip(x) {
            for (sum, s) in sums[..N].iter_mut().zip(&column[..N]) {
                *sum += s * x;
            }
        }
    }

    /// Position on the axis in the frame of the inner end in m, eq. (M2), from the coordinates and their [`Self::shortened`].
    #[inline]
    pub fn position_m(&self, q: &[f64], shortened: &[f64; MAXIMUM_MODES]) -> Vector3<f64> {
        let mut position = Vector3::new(self.place_m, 0.0, 0.0);
        for ((q, bend), s) in q.iter().zip(&self.bend).zip(shortened) {
            position.x -= 0.5 * q * s;
            position.y += q * bend[0];
            position.z += q * bend[1];
        }
        position
    }

    /// Velocity of the position per unit rate of coordinate `i`, eq. (M4).
    #[inline]
    pub fn velocity(&self, i: usize, shortened: &[f64; MAXIMUM_MODES]) -> Vector3<f64> {
        Vector3::new(-shortened[i], self.bend[i][0], self.bend[i][1])
    }

    /// Velocity of the position for given rates of the coordinates.
    #[inline]
    pub fn moved(&self, rates: &[f64], shortened: &[f64; MAXIMUM_MODES]) -> Vector3<f64> {
        let mut velocity = Vector3::zeros();
        for ((rate, bend), s) in rates.iter().zip(&self.bend).zip(shortened) {
            velocity.x -= s * rate;
            velocity.y += bend[0] * rate;
            velocity.z += bend[1] * rate;
        }
        velocity
    }

    /// Slope of the force on coordinate `i` by coordinate `j` for a constant load on the section in the frame of the inner end, eq. (X40).
    pub(crate) fn force_slope(
        &self,
        (i, j): (usize, usize),
        turn: &SmallTurn,
        (force, moment): (&Vector3<f64>, &Vector3<f64>),
    ) -> f64 {
        turn.spin_along(&self.angles_1_m(i), &self.angles_1_m(j)).dot(moment) - self.shortening_1_m[i][j] * force.x
    }

    /// Small angles `w_i` of the section per unit of coordinate `i` in 1/m, eq. (M3).
    #[inline]
    pub fn angles_1_m(&self, i: usize) -> Vector3<f64> {
        Vector3::new(0.0, -self.slope_1_m[i][1], self.slope_1_m[i][0])
    }

    /// Small angles of the section in rad, eq. (M3).
    #[inline]
    pub fn angles_rad(&self, q: &[f64]) -> Vector3<f64> {
        q.iter().enumerate().map(|(i, q)| self.angles_1_m(i) * *q).sum()
    }
}

/// Running integrals at the beginning of a cell, and the data with which they continue in it.
#[derive(Debug, Clone, PartialEq)]
struct Cell {
    start: ShapesAt,
    middle: ShapesAt,
    /// Second derivative of the deflection at mid-cell per coordinate, 1/m².
    curvature_1_m2: [[f64; 2]; MAXIMUM_MODES],
}

/// A lumped mass on the axis.
#[derive(Debug, Clone, PartialEq)]
pub struct MassPoint {
    /// Mass in kg.
    pub mass_kg: f64,
    /// Shapes at the position of the mass.
    pub shapes: ShapesAt,
}

/// Modal body with its integrals.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalElement {
    /// Length in m.
    pub length_m: f64,
    /// Number of shapes.
    pub modes: usize,
    /// Number of flapwise shapes; the others are edgewise.
    pub flaps: usize,
    /// Masses of the cells, each at mid-cell.
    pub masses: Vec<MassPoint>,
    /// Sums over the masses, for a body with at most [`FEW_MODES`] shapes.
    pub(crate) moments: Option<Box<MassMoments>>,
    /// Shapes at the outer end.
    pub tip: ShapesAt,
    /// Stiffness matrix of the coordinates in N/m, eq. (M5).
    pub stiffness: SMatrix<f64, MAXIMUM_MODES, MAXIMUM_MODES>,
    /// Damping matrix of the coordinates in N·s/m, eq. (M6); not symmetric if the ratios of damping ratio to frequency differ.
    pub damping: SMatrix<f64, MAXIMUM_MODES, MAXIMUM_MODES>,
    cell_m: f64,
    cells: Vec<Cell>,
    /// Shapes at positions that are used in every step, from the inner end outward.
    places: Vec<ShapesAt>,
    /// Polynomials of the shapes without twist; otherwise `None`.
    shapes: Option<Vec<(usize, Shape)>>,
    /// Whether axial shortening and section rotation are included, eq. (M13).
    keeps: [bool; 2],
    /// Whether the angular velocity of sections is the rate of their small angles.
    rates_of_angles: bool,
}

impl ModalElement {
    /// Computes the integrals of a law with at most [`MAXIMUM_MODES`] shapes.
    pub fn new(law: &ModalLaw) -> Self {
        let shapes: Vec<(usize, Shape)> = law.shapes().map(|(kind, shape)| (kind, shape.clone())).collect();
        let (modes, length_m, cell_m) = (shapes.len(), law.length_m, law.cell_m());
        let mut element = Self {
            length_m,
            modes,
            flaps: law.flap.len(),
            masses: Vec::new(),
            moments: None,
            tip: ShapesAt::ZERO,
            stiffness: SMatrix::zeros(),
            damping: SMatrix::zeros(),
            cell_m,
            cells: Vec::new(),
            places: Vec::new(),
            shapes: law.twist_rad.is_none().then(|| shapes.clone()),
            keeps: [law.axial_shortening, law.section_rotation],
            rates_of_angles: law.rates_of_angles,
        };
        let mut start = ShapesAt::ZERO;
        let mut untwisted = [0.0; MAXIMUM_MODES];
        for (k, middle_m) in law.middles_m().enumerate() {
            start.place_m = k as f64 * cell_m;
            let (x, directions) = (middle_m / length_m, law.directions(middle_m));
            let mut curvature_1_m2 = [[0.0; 2]; MAXIMUM_MODES];
            for (curvature, (kind, shape)) in curvature_1_m2.iter_mut().zip(&shapes) {
                *curvature = directions[*kind].map(|share| share * shape.curvature(x) / (length_m * length_m));
            }
            let mut cell = Cell { start, middle: ShapesAt::ZERO, curvature_1_m2 };
            cell.middle = element.within(&cell, middle_m);
            start = element.within(&cell, (k + 1) as f64 * cell_m);
            let mass_kg = law.mass_factor * law.mass_kg_m.at(middle_m) * cell_m;
            let bending = [&law.flap_stiffness_n_m2, &law.edge_stiffness_n_m2]
                .map(|stiffness| law.stiffness_factor * stiffness.at(middle_m) * cell_m / length_m.powi(4));
            for (i, (kind, shape)) in shapes.iter().enumerate() {
                untwisted[i] += mass_kg * shape.value(x).powi(2);
                for (j, (other_kind, other)) in shapes.iter().enumerate() {
                    if kind == other_kind {
                        element.stiffness[(i, j)] += bending[*kind] * shape.curvature(x) * other.curvature(x);
                    }
                }
            }
            element.masses.push(MassPoint { mass_kg, shapes: cell.middle.kept(element.keeps) });
            element.cells.push(cell);
        }
        element.moments = (modes <= FEW_MODES).then(|| Box::new(MassMoments::new(&element.masses)));
        element.tip = start.kept(element.keeps);
        if law.twist_rad.is_none() {
            // the coordinate is the deflection at the outer end, even if the published coefficients are rounded
            let directions = law.directions(length_m);
            for (bend, (kind, _)) in element.tip.bend.iter_mut().zip(&shapes) {
                *bend = directions[*kind];
            }
        }
        for (j, (_, shape)) in shapes.iter().enumerate() {
            let angular_1_s = (element.stiffness[(j, j)] / untwisted[j]).sqrt();
            for i in 0..modes {
                element.damping[(i, j)] = element.stiffness[(i, j)] * 2.0 * shape.damping_ratio / angular_1_s;
            }
        }
        element
    }

    /// Whether the angular velocity of sections is the rate of their small angles, and not that of their attitude.
    pub(crate) fn has_rates_of_angles(&self) -> bool {
        self.rates_of_angles
    }

    /// Rotation of a section with small angles in rad, eq. (M3).
    #[inline]
    pub(crate) fn turn(&self, angles_rad: Vector3<f64>) -> SmallTurn {
        SmallTurn::new(angles_rad, self.rates_of_angles)
    }

    /// Computes and stores the shapes at a position that is used in every step.
    pub(crate) fn keep(&mut self, place_m: f64) {
        if place_m < self.length_m
            && let Err(next) = self.index(place_m)
        {
            self.places.insert(next, self.at(place_m));
        }
    }

    /// Index of a stored position, or the index at which it would be inserted.
    #[inline]
    fn index(&self, place_m: f64) -> Result<usize, usize> {
        self.places.binary_search_by(|shapes| shapes.place_m.total_cmp(&place_m))
    }

    /// Shapes at a position; computed into `own` if the position is not stored.
    #[inline]
    pub(crate) fn shapes<'s>(&'s self, place_m: f64, own: &'s mut Option<ShapesAt>) -> &'s ShapesAt {
        if place_m >= self.length_m {
            return &self.tip;
        }
        match self.index(place_m) {
            Ok(place) => &self.places[place],
            Err(_) => own.insert(self.at(place_m)),
        }
    }

    /// As `shapes`, for successive positions: `next` is the index of the position if it follows the previous one.
    #[inline]
    pub(crate) fn shapes_from<'s>(
        &'s self,
        place_m: f64,
        next: &mut usize,
        own: &'s mut Option<ShapesAt>,
    ) -> &'s ShapesAt {
        let place = *next;
        *next = place + 1;
        match self.places.get(place) {
            Some(shapes) if shapes.place_m == place_m => shapes,
            Some(_) | None => {
                if let Ok(found) = self.index(place_m) {
                    *next = found + 1;
                }
                self.shapes(place_m, own)
            }
        }
    }

    /// Shapes at a distance from the inner end in m; at mid-cell and at the outer end they are those used in the sums.
    pub fn at(&self, place_m: f64) -> ShapesAt {
        if place_m >= self.length_m {
            return self.tip;
        }
        let cell = (place_m / self.length_m * self.cells.len() as f64) as usize;
        self.within(&self.cells[cell.min(self.cells.len() - 1)], place_m).kept(self.keeps)
    }

    /// Shapes at a position within a cell.
    fn within(&self, cell: &Cell, place_m: f64) -> ShapesAt {
        let start_m = cell.start.place_m;
        let mut shapes = ShapesAt { place_m, ..ShapesAt::ZERO };
        let distance_m = place_m - start_m;
        // the slopes at mid-cell continue the running integrals through the cell
        let half_m = 0.5 * self.cell_m;
        let mut middle = [[0.0; 2]; MAXIMUM_MODES];
        for i in 0..self.modes {
            match &self.shapes {
                Some(polynomials) => {
                    let (kind, shape) = &polynomials[i];
                    let axis = 1 - kind;
                    let x = |s_m: f64| s_m / self.length_m;
                    middle[i][axis] = shape.slope(x(start_m + half_m)) / self.length_m;
                    shapes.slope_1_m[i][axis] = shape.slope(x(place_m)) / self.length_m;
                    shapes.bend[i][axis] = shape.value(x(place_m));
                }
                None => {
                    for (axis, middle) in middle[i].iter_mut().enumerate() {
                        let (slope, curvature) = (cell.start.slope_1_m[i][axis], cell.curvature_1_m2[i][axis]);
                        *middle = slope + curvature * half_m;
                        shapes.slope_1_m[i][axis] = slope + curvature * distance_m;
                        shapes.bend[i][axis] = cell.start.bend[i][axis] + *middle * distance_m;
                    }
                }
            }
        }
        for i in 0..self.modes {
            for j in 0..self.modes {
                let product = middle[i][0] * middle[j][0] + middle[i][1] * middle[j][1];
                shapes.shortening_1_m[i][j] = cell.start.shortening_1_m[i][j] + product * distance_m;
            }
        }
        shapes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element() -> ModalElement {
        let shape =
            |coefficients: &[f64]| Shape { coefficients: coefficients.to_vec(), damping_ratio: 0.0, start_m: 0.0 };
        ModalElement::new(&ModalLaw {
            length_m: 60.0,
            cells: 17,
            mass_kg_m: Profile::Polynomial(vec![300.0]),
            flap_stiffness_n_m2: Profile::Polynomial(vec![1e9]),
            edge_stiffness_n_m2: Profile::Polynomial(vec![3e9]),
            twist_rad: Some(Profile::Polynomial(vec![0.1])),
            flap: vec![shape(&[1.0]), shape(&[-0.6, 1.6])],
            edge: vec![shape(&[0.8, 0.2])],
            axial_shortening: true,
            section_rotation: true,
            rates_of_angles: false,
            mass_factor: 1.0,
            stiffness_factor: 1.0,
        })
    }

    /// Stored positions give the computed shapes, for any order of storing, and also at the outer end.
    #[test]
    fn kept_places_are_computed_ones() {
        let mut kept = element();
        let places = [31.0, 3.5, 60.0, 12.25, 31.0, 0.0];
        places.iter().for_each(|place_m| kept.keep(*place_m));
        assert_eq!(kept.places.len(), 4);
        let plain = element();
        for place_m in places.into_iter().chain([17.0, 61.0]) {
            assert_eq!(*kept.shapes(place_m, &mut None), plain.at(place_m), "{place_m}");
        }
    }
}
