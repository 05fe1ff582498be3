//! Sections of thin straight walls, open or closed, with any number of cells and materials: torsion and shear computed from the warping of
//! the nodes.
//!
//! Walls are lines with a thickness between nodes. The unknowns are the warping displacements of the nodes; the shear flow in a wall
//! follows from the difference at its ends, and flows are in equilibrium at every node. These are the compatibility and equilibrium
//! conditions of Bredt's theory for any number of cells (NOTATION eqs. (S17), (S18)), without identifying the cells.

use super::materials::Material;
use super::properties::Moments;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// A straight wall.
#[derive(Debug, Clone, Copy)]
pub(in crate::shapes) struct Wall {
    /// Indices of the nodes at its ends.
    pub ends: [usize; 2],
    /// Thickness in m.
    pub thickness_m: f64,
    /// Material.
    pub material: Material,
    /// Length in m by which the area is shorter at each end than the line, where the wall joins the centre line of another wall.
    pub trim_m: f64,
}

/// Nodes `[y, z]` in m and walls between them.
#[derive(Debug, Clone, Default)]
pub(in crate::shapes) struct Walls {
    /// Positions of the nodes in m.
    pub nodes_m: Vec<[f64; 2]>,
    /// Walls.
    pub walls: Vec<Wall>,
}

/// Torsion and shear of a section of walls.
#[derive(Debug, Clone, Copy)]
pub(in crate::shapes) struct Flows {
    /// Torsional rigidity of the cells in N·m²: Bredt's part, with shear constant through the thickness.
    pub cells_n_m2: f64,
    /// Torsional rigidity of the walls in N·m², `∑ G l t³/3`, with shear linear through the thickness.
    pub open_n_m2: f64,
    /// `[GA_y, GA_z]` in N.
    pub shear_stiffnesses_n: [f64; 2],
    /// Shear centre in m, relative to the origin of the nodes.
    pub shear_centre_m: [f64; 2],
    /// `E C_w` about the shear centre in N·m⁴.
    pub warping_stiffness_n_m4: f64,
}

/// Preprocessed wall: ends, length, direction, `G t` and `E t`, lever arm of its shear flow about the origin.
struct Line {
    ends: [usize; 2],
    length_m: f64,
    shear_n_m: f64,
    axial_n_m: f64,
    lever_m: f64,
    open_n_m2: f64,
    poisson_ratio: f64,
}

impl Walls {
    /// Adds a node and returns its index.
    pub fn node(&mut self, position_m: [f64; 2]) -> usize {
        self.nodes_m.push(position_m);
        self.nodes_m.len() - 1
    }

    /// Adds a wall.
    pub fn wall(&mut self, from: usize, to: usize, thickness_m: f64, material: &Material) {
        self.walls.push(Wall { ends: [from, to], thickness_m, material: *material, trim_m: 0.0 });
    }

    /// Integrals over the walls, taken as rectangles between the nodes, with a weight per area.
    pub fn moments(&self, weight: impl Fn(&Material) -> f64) -> Moments {
        let mut moments = Moments::default();
        for wall in &self.walls {
            let ([y0, z0], [y1, z1]) = (self.nodes_m[wall.ends[0]], self.nodes_m[wall.ends[1]]);
            let length = (y1 - y0).hypot(z1 - z0);
            let along = [(y1 - y0) / length, (z1 - z0) / length];
            let middle = [0.5 * (y0 + y1), 0.5 * (z0 + z1)];
            let half = [0.5 * length - wall.trim_m, 0.5 * wall.thickness_m];
            moments.add_rectangle(weight(&wall.material), middle, half, along);
        }
        moments
    }

    /// Computes torsion and shear; `None` if the walls are not connected.
    pub fn flows(&self) -> Option<Flows> {
        let lines = self.lines();
        let centre = self.line_centre(&lines);
        let position = |node: usize| [self.nodes_m[node][0] - centre[0], self.nodes_m[node][1] - centre[1]];
        let factor = self.conductance(&lines).cholesky()?;
        let solve = |sources: &[f64]| {
            // the warping of the first node is zero
            let unknown = factor.solve(&DVector::from_column_slice(&sources[1..]));
            let mut warping = vec![0.0];
            warping.extend(unknown.iter());
            warping
        };
        // axial stress for a unit force: E (a · (1, y, z)) with [∫E ξ ξᵀ] a = (0, V_y, V_z)
        let mut stiffness = Matrix3::zeros();
        for line in &lines {
            let [a, b] = line.ends.map(|end| {
                let [y, z] = position(end);
                Vector3::new(1.0, y, z)
            });
            let weight = line.axial_n_m * line.length_m / 6.0;
            stiffness +=
                weight * (2.0 * a * a.transpose() + 2.0 * b * b.transpose() + a * b.transpose() + b * a.transpose());
        }
        let inverse = stiffness.try_inverse()?;
        let flows = [1, 2].map(|direction| {
            let gradient = inverse.column(direction).into_owned();
            let stress = |end: usize| {
                let [y, z] = position(end);
                gradient.dot(&Vector3::new(1.0, y, z))
            };
            let ends: Vec<[f64; 2]> =
                lines.iter().map(|line| line.ends.map(|end| line.axial_n_m * stress(end))).collect();
            let mut sources = vec![0.0; self.nodes_m.len()];
            for (line, [a, b]) in lines.iter().zip(&ends) {
                sources[line.ends[0]] += line.length_m * (2.0 * a + b) / 6.0;
                sources[line.ends[1]] += line.length_m * (a + 2.0 * b) / 6.0;
            }
            // shear centre without the effect of Poisson's ratio, for which shear and torsion are uncoupled in the energy
            let warping = solve(&sources);
            let moment: f64 = lines
                .iter()
                .map(|line| line.lever_m * line.shear_n_m * (warping[line.ends[1]] - warping[line.ends[0]]))
                .sum();
            // lateral contraction causes shear of the walls if the bending moment varies along the beam
            let contractions: Vec<f64> = lines
                .iter()
                .map(|line| {
                    let [a, b] = line.ends.map(&position);
                    line.poisson_ratio * contraction(&gradient, a, b)
                })
                .collect();
            for (line, contraction) in lines.iter().zip(&contractions) {
                let flow = line.shear_n_m / line.length_m * contraction;
                sources[line.ends[0]] += flow;
                sources[line.ends[1]] -= flow;
            }
            let warping = solve(&sources);
            // shear flow at three Gauss points of each wall, with the weight of its square in the energy
            let energy: f64 = lines
                .iter()
                .zip(ends.iter().zip(&contractions))
                .map(|(line, ([a, b], contraction))| {
                    let length = line.length_m;
                    let begin = line.shear_n_m / length * (warping[line.ends[1]] - warping[line.ends[0]] + contraction)
                        + length * (2.0 * a + b) / 6.0;
                    let gauss = 0.5 * 0.6_f64.sqrt();
                    [(0.5 - gauss, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.5 + gauss, 5.0 / 18.0)]
                        .into_iter()
                        .map(|(place, weight)| {
                            let flow = begin - length * place * (a + 0.5 * (b - a) * place);
                            weight * length * flow * flow / line.shear_n_m
                        })
                        .sum::<f64>()
                })
                .sum();
            (moment, 1.0 / energy)
        });
        let [(moment_y, shear_y), (moment_z, shear_z)] = flows;
        let shear_centre_m = [moment_z, -moment_y];
        let mut sources = vec![0.0; self.nodes_m.len()];
        for line in &lines {
            sources[line.ends[0]] += line.shear_n_m * line.lever_m;
            sources[line.ends[1]] -= line.shear_n_m * line.lever_m;
        }
        let warping = solve(&sources);
        let strain = |line: &Line| (warping[line.ends[1]] - warping[line.ends[0]]) / line.length_m + line.lever_m;
        let cells_n_m2 = lines.iter().map(|line| line.shear_n_m * line.length_m * strain(line).powi(2)).sum();
        Some(Flows {
            cells_n_m2,
            open_n_m2: lines.iter().map(|line| line.open_n_m2).sum(),
            shear_stiffnesses_n: [shear_y, shear_z],
            shear_centre_m,
            warping_stiffness_n_m4: warping_stiffness(&lines, &warping, &inverse, position),
        })
    }

    fn lines(&self) -> Vec<Line> {
        let prepared = |wall: &Wall| {
            let ([y0, z0], [y1, z1]) = (self.nodes_m[wall.ends[0]], self.nodes_m[wall.ends[1]]);
            let length_m = (y1 - y0).hypot(z1 - z0);
            let Material { youngs_modulus_pa, shear_modulus_pa, .. } = wall.material;
            Line {
                ends: wall.ends,
                length_m,
                shear_n_m: shear_modulus_pa * wall.thickness_m,
                axial_n_m: youngs_modulus_pa * wall.thickness_m,
                lever_m: (y0 * (z1 - z0) - z0 * (y1 - y0)) / length_m,
                open_n_m2: shear_modulus_pa * length_m * wall.thickness_m.powi(3) / 3.0,
                poisson_ratio: wall.material.poisson_ratio(),
            }
        };
        self.walls.iter().map(prepared).collect()
    }

    /// Centre of the walls, taken as lines, weighted with Young's modulus.
    fn line_centre(&self, lines: &[Line]) -> [f64; 2] {
        let mut sums = [0.0; 3];
        for line in lines {
            let [[y0, z0], [y1, z1]] = line.ends.map(|end| self.nodes_m[end]);
            let weight = line.axial_n_m * line.length_m;
            sums[0] += weight;
            sums[1] += weight * 0.5 * (y0 + y1);
            sums[2] += weight * 0.5 * (z0 + z1);
        }
        [sums[1] / sums[0], sums[2] / sums[0]]
    }

    /// Matrix that maps the warping of the nodes to the shear flow out of them, without the first node.
    fn conductance(&self, lines: &[Line]) -> DMatrix<f64> {
        let count = self.nodes_m.len() - 1;
        let mut matrix = DMatrix::zeros(count, count);
        for line in lines {
            let conductance = line.shear_n_m / line.length_m;
            let [a, b] = line.ends;
            for (i, j) in [(a, b), (b, a)] {
                if i > 0 {
                    matrix[(i - 1, i - 1)] += conductance;
                    if j > 0 {
                        matrix[(i - 1, j - 1)] -= conductance;
                    }
                }
            }
        }
        matrix
    }
}

/// Displacement along a straight wall from `a` to `b` due to lateral contraction, integrated over the wall, per unit Poisson's ratio: axial
/// strains `g · (1, y, z)` cause equal contractions in both transverse directions, NOTATION eq. (S18).
fn contraction(gradient: &Vector3<f64>, a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let at = |share: f64| {
        let (y, z) = (a[0] + share * along[0], a[1] + share * along[1]);
        let half = 0.5 * (y * y - z * z);
        let in_y = gradient[0] * y + gradient[1] * half + gradient[2] * y * z;
        let in_z = gradient[0] * z - gradient[2] * half + gradient[1] * y * z;
        -(in_y * along[0] + in_z * along[1])
    };
    (at(0.0) + 4.0 * at(0.5) + at(1.0)) / 6.0
}

/// `∫E ω² dA` of the warping per unit twist about the shear centre, NOTATION eq. (S23): the contributions of rotation about another centre,
/// of stretch and of bending are removed by orthogonality.
fn warping_stiffness(
    lines: &[Line],
    warping: &[f64],
    inverse: &Matrix3<f64>,
    position: impl Fn(usize) -> [f64; 2],
) -> f64 {
    let mut mixed = Vector3::zeros();
    let mut square = 0.0;
    for line in lines {
        let weight = line.axial_n_m * line.length_m / 6.0;
        let [(a, first), (b, last)] = line.ends.map(|end| {
            let [y, z] = position(end);
            (Vector3::new(1.0, y, z), warping[end])
        });
        mixed += weight * (a * (2.0 * first + last) + b * (first + 2.0 * last));
        square += 2.0 * weight * (first * first + first * last + last * last);
    }
    (square - mixed.dot(&(inverse * mixed))).max(0.0)
}
