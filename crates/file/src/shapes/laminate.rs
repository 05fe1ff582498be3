//! Flat strip of plies according to classical lamination theory.

use super::materials::{Across, Material};
use super::properties::SectionProperties;
use nalgebra::{Matrix3, SMatrix, SVector};

/// Coupling relative to the geometric mean of the two stiffnesses below which it counts as zero.
const ROUND_OFF: f64 = 1e-6;

/// Ply of a laminate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ply {
    /// Angle of the fibres from the body's axis towards `+y` in rad.
    pub angle_rad: f64,
    /// Thickness in m.
    pub thickness_m: f64,
    /// Material.
    pub material: Material,
}

/// Coupling with in-plane shear of the strip, which a beam model with four strains cannot represent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::shapes) enum Coupling {
    /// With stretch: the laminate is not balanced.
    Stretch,
    /// With bending or twist: the laminate is not symmetric.
    OutOfPlane,
}

/// Strains of a plate: `εx, εy, γxy, kx, ky, kxy`.
type Plate = SMatrix<f64, 6, 6>;

/// Reduced stiffness of a ply in Pa, in the axes of the strip, for `(εx, εy, γxy)`, NOTATION eq. (S20).
fn reduced_pa(ply: &Ply) -> Matrix3<f64> {
    let Material { youngs_modulus_pa: along, shear_modulus_pa: shear, across, .. } = ply.material;
    let (across, ratio) =
        across.map_or((along, ply.material.poisson_ratio()), |across| (across.youngs_modulus_pa, across.poisson_ratio));
    let scale = 1.0 / (1.0 - ratio * ratio * across / along);
    let own = Matrix3::new(
        scale * along,
        scale * ratio * across,
        0.0,
        scale * ratio * across,
        scale * across,
        0.0,
        0.0,
        0.0,
        shear,
    );
    let (s, c) = ply.angle_rad.sin_cos();
    // strains in ply axes as functions of strains in strip axes
    let turn = Matrix3::new(c * c, s * s, s * c, s * s, c * c, -s * c, -2.0 * s * c, 2.0 * s * c, c * c - s * s);
    turn.transpose() * own * turn
}

/// Shear modulus of a ply in Pa, in the plane of body axis and thickness.
fn transverse_shear_pa(ply: &Ply) -> f64 {
    let along = ply.material.shear_modulus_pa;
    let across = ply.material.across.map_or(along, |Across { shear_modulus_pa, .. }| shear_modulus_pa);
    let (s, c) = ply.angle_rad.sin_cos();
    along * c * c + across * s * s
}

/// Condensed stiffness without a strain whose force is zero, NOTATION eq. (S21).
fn freed(stiffness: &Plate, strain: usize) -> Plate {
    let pivot = stiffness[(strain, strain)];
    Plate::from_fn(|i, j| stiffness[(i, j)] - stiffness[(i, strain)] * stiffness[(strain, j)] / pivot)
}

/// Properties of a strip of plies, given from the lowest `z` to the highest; `width_m` is along `y`. NOTATION eqs. (S20)–(S22).
pub(in crate::shapes) fn laminate(width_m: f64, plies: &[Ply]) -> Result<SectionProperties, Coupling> {
    let thickness_m: f64 = plies.iter().map(|ply| ply.thickness_m).sum();
    let mut plate = Plate::zeros();
    let mut mass = [0.0; 3];
    let mut low = -0.5 * thickness_m;
    for ply in plies {
        let high = low + ply.thickness_m;
        let reduced = reduced_pa(ply);
        let powers = [high - low, 0.5 * (high * high - low * low), (high.powi(3) - low.powi(3)) / 3.0];
        for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
            plate[(i, j)] += powers[i / 3 + j / 3] * reduced[(i % 3, j % 3)];
        }
        mass.iter_mut().zip(powers).for_each(|(sum, power)| *sum += ply.material.density_kg_m3 * power);
        low = high;
    }
    // force and moment in the transverse direction are zero
    let [axial, shear, bend, twist] = [0, 2, 3, 5];
    let open = freed(&freed(&plate, 1), 4);
    let coupled = |i: usize, j: usize| open[(i, j)].abs() > ROUND_OFF * (plate[(i, i)] * plate[(j, j)]).sqrt();
    let unbalanced = [0, 1].iter().any(|strain| {
        plate[(*strain, shear)].abs() > ROUND_OFF * (plate[(*strain, *strain)] * plate[(shear, shear)]).sqrt()
    });
    if unbalanced {
        return Err(Coupling::Stretch);
    }
    if [axial, bend, twist].into_iter().any(|strain| coupled(strain, shear)) {
        return Err(Coupling::OutOfPlane);
    }
    let free = freed(&open, shear);
    let through = through_thickness(plies, thickness_m);
    // transverse shear strain reduces the twisting moment towards the edges, NOTATION eq. (S22)
    let decay = 0.5 * width_m * (through.twist_n_m / free[(twist, twist)]).sqrt();
    let edges = 1.0 - decay.tanh() / decay;
    // lateral contraction in bending twists the cross-section where the bending moment varies along the body
    let ratio = plate_ratio(&plate);
    let (coth, squared) = (1.0 / decay.tanh(), decay * decay);
    let contraction =
        ratio * ratio * free[(twist, twist)] * width_m.powi(3) / 3.0 * (1.0 - 3.0 * coth / decay + 3.0 / squared);
    let along_z = 1.0 / (width_m * through.bend_n_m) + contraction / (width_m * free[(bend, bend)]).powi(2);
    let tension_z = free[(axial, bend)] / free[(axial, axial)];
    let centre_z = mass[1] / mass[0];
    let area_mass = mass[0] * width_m;
    let tidy = |value: f64| if value.abs() < 1e-12 * thickness_m { 0.0 } else { value };
    let coupling = -2.0 * width_m * free[(bend, twist)];
    Ok(SectionProperties {
        axial_stiffness_n: width_m * free[(axial, axial)],
        shear_stiffnesses_n: Some([width_m * open[(shear, shear)] / 1.2, 1.0 / along_z]),
        torsional_rigidity_n_m2: 4.0 * width_m * free[(twist, twist)] * edges,
        flap_stiffness_n_m2: width_m * (free[(bend, bend)] - tension_z * free[(axial, bend)]),
        edge_stiffness_n_m2: free[(axial, axial)] * width_m.powi(3) / 12.0,
        coupling_flap_edge_n_m2: 0.0,
        coupling_axial_twist_n_m: 0.0,
        coupling_twist_flap_n_m2: if coupled(bend, twist) { coupling * edges } else { 0.0 },
        warping_stiffness_n_m4: 0.0,
        tension_centre_m: [0.0, tidy(tension_z)],
        shear_centre_m: Some([0.0; 2]),
        mass_kg_m: area_mass,
        centre_of_mass_m: [0.0, tidy(centre_z)],
        second_moments_kg_m: [area_mass * width_m * width_m / 12.0, 0.0, width_m * (mass[2] - centre_z * mass[1])],
        outline_m: Some([width_m, thickness_m].map(|full| [-0.5 * full, 0.5 * full])),
    })
}

/// Ratio of transverse to longitudinal curvature when all transverse and shear forces and moments are zero: Poisson's ratio of the
/// strip.
fn plate_ratio(plate: &Plate) -> f64 {
    let free = freed(&freed(&freed(plate, 1), 2), 5);
    free[(4, 3)] / free[(4, 4)]
}

/// Transverse shear stiffnesses per width in N/m.
struct Through {
    /// For the shear distribution in bending.
    bend_n_m: f64,
    /// For the shear distribution at the edges in torsion.
    twist_n_m: f64,
}

/// Squared force divided by twice the energy of the transverse shear that balances the axial stresses in bending, or the shear
/// stresses in torsion.
fn through_thickness(plies: &[Ply], thickness_m: f64) -> Through {
    let axial = |ply: &Ply| {
        let reduced = reduced_pa(ply);
        reduced[(0, 0)] - reduced[(0, 1)] * reduced[(1, 0)] / reduced[(1, 1)]
    };
    let twist = |ply: &Ply| reduced_pa(ply)[(2, 2)];
    let stiffness = |modulus: &dyn Fn(&Ply) -> f64| {
        let moments = |centre: f64| {
            let mut low = -0.5 * thickness_m - centre;
            let mut sums = SVector::<f64, 3>::zeros();
            for ply in plies {
                let high = low + ply.thickness_m;
                let powers = [high - low, 0.5 * (high * high - low * low), (high.powi(3) - low.powi(3)) / 3.0];
                (0..3).for_each(|n| sums[n] += modulus(ply) * powers[n]);
                low = high;
            }
            sums
        };
        let about_middle = moments(0.0);
        let centre = about_middle[1] / about_middle[0];
        let second = moments(centre)[2];
        let mut low = -0.5 * thickness_m - centre;
        let (mut flow, mut energy) = (0.0, 0.0);
        for ply in plies {
            let (modulus, shear) = (modulus(ply), transverse_shear_pa(ply));
            // shear flow at z: flow at the ply's lower face minus E (z² − low²)/2; its square is integrated by three Gauss points,
            // exact to the fifth power
            for (place, weight) in GAUSS {
                let z = low + 0.5 * (1.0 + place) * ply.thickness_m;
                let here = flow - 0.5 * modulus * (z * z - low * low);
                energy += 0.5 * weight * ply.thickness_m * here * here / shear;
            }
            let high = low + ply.thickness_m;
            flow -= 0.5 * modulus * (high * high - low * low);
            low = high;
        }
        second * second / energy
    };
    Through { bend_n_m: stiffness(&axial), twist_n_m: stiffness(&twist) }
}

/// Gauss points on (−1, 1) and their weights.
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
