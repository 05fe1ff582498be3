//! Linearised links, and blocks of one element or pair in its strains and the twist of its inner node.

use crate::beam::modal::MAXIMUM_MODES;
use crate::load::{LoadFrame, Wrench};
use crate::math::se3::{Link, link_curvature};
use crate::math::so3::hat;
use crate::math::strain::{SHEARED, STRAINS, Strain, StrainMatrix};
use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};

/// Maximum number of unknowns of a block: the strains of a pair without shear, or the shapes of a modal body; a joint has at most six
/// degrees of freedom.
pub(super) const UNKNOWNS: usize = if 2 * STRAINS > MAXIMUM_MODES { 2 * STRAINS } else { MAXIMUM_MODES };
/// Maximum number of unknowns of a block with shear: the strains of a pair.
pub(super) const SHEARED_UNKNOWNS: usize = 2 * SHEARED;

/// One value per unknown of a block.
pub(super) type Unknowns<const U: usize = UNKNOWNS> = SVector<f64, U>;

/// Matrix with rows for the strains and columns for a twist.
pub(super) type StrainsByTwist<const N: usize> = SMatrix<f64, N, 6>;
/// Matrix with rows for a twist or wrench and columns for the strains.
pub(super) type TwistByStrains<const N: usize> = SMatrix<f64, 6, N>;

/// One link linearised about its pose, under the wrench at its outer end.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinkTangent<const N: usize> {
    /// `J`: twist of the outer end per strain.
    pub jacobian: TwistByStrains<N>,
    /// Vector `d` from the inner to the outer end.
    arm: Vector3<f64>,
    /// Force `F_b` at the outer end.
    force: Vector3<f64>,
    /// Change of `JᵀW` with the strains, `H_loc`.
    curvature: StrainMatrix<N>,
    /// Change of `JᵀW` with the rotation of the inner node.
    turning: SMatrix<f64, N, 3>,
}

/// Coupling of the twists of an element's ends through its inertia in a rotating frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cross {
    /// Wrench of the outer end per twist of the inner end.
    pub outer_inner: Matrix6<f64>,
    /// Wrench of the inner end per twist of the outer end.
    pub inner_outer: Matrix6<f64>,
}

/// Tangent `P` of the outer end of one link, transferred to its strains and inner end, eq. (L5).
struct LinkBlock<const N: usize> {
    xx: StrainMatrix<N>,
    xa: StrainsByTwist<N>,
    ax: TwistByStrains<N>,
    aa: Matrix6<f64>,
}

impl<const N: usize> LinkTangent<N> {
    /// Zero tangent.
    pub const ZERO: Self = Self {
        jacobian: TwistByStrains::from_array_storage(nalgebra::ArrayStorage([[0.0; 6]; N])),
        arm: Vector3::new(0.0, 0.0, 0.0),
        force: Vector3::new(0.0, 0.0, 0.0),
        curvature: StrainMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; N]; N])),
        turning: SMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; N]; 3])),
    };

    /// A link of `(length, strain)` on a frame `inner` (root ← a), with the wrench at its outer end in the root frame.
    pub fn new(
        link: &Link<N>,
        inner: &Matrix3<f64>,
        (length_m, strain): (f64, &[f64; N]),
        force: &Vector3<f64>,
        moment: &Vector3<f64>,
    ) -> Self {
        let mut jacobian = TwistByStrains::<N>::zeros();
        let mut turning = SMatrix::<f64, N, 3>::zeros();
        for (k, spin) in link.spin_columns().into_iter().enumerate() {
            jacobian.fixed_view_mut::<3, 1>(0, k).copy_from(&link.velocity[k]);
            jacobian.fixed_view_mut::<3, 1>(3, k).copy_from(&spin);
            let row = link.velocity[k].cross(force) + spin.cross(moment);
            turning.row_mut(k).copy_from(&row.transpose());
        }
        let axes = inner.transpose();
        let curvature = link_curvature(length_m, strain, &(axes * force), &(axes * moment));
        Self { jacobian, arm: link.arm_m, force: *force, curvature, turning }
    }

    /// `Φ`: twist of the outer end per twist of the inner end.
    fn shift(&self) -> Matrix6<f64> {
        let mut shift = Matrix6::identity();
        shift.fixed_view_mut::<3, 3>(0, 3).copy_from(&-hat(&self.arm));
        shift
    }

    /// Twist of the outer end due to a change of the strains and the twist of the inner end.
    pub fn displaced(&self, strain: &Strain<N>, inner: &Vector6<f64>) -> Vector6<f64> {
        let turn: Vector3<f64> = inner.fixed_rows::<3>(3).into_owned();
        let mut outer = self.jacobian * strain + inner;
        let mut linear = outer.fixed_rows_mut::<3>(0);
        linear += turn.cross(&self.arm);
        outer
    }

    /// Changes of the forces on the strains and of the wrench transmitted to the inner node, for changes of the strains, of the inner
    /// node's twist and of the wrench at the outer end.
    pub fn push(&self, strain: &Strain<N>, inner: &Vector6<f64>, outer: &Vector6<f64>) -> (Strain<N>, Vector6<f64>) {
        let turn: Vector3<f64> = inner.fixed_rows::<3>(3).into_owned();
        let forces = self.jacobian.transpose() * outer + self.curvature * strain + self.turning * turn;
        let mut passed = self.carried(outer);
        let arm_change: Vector3<f64> = (self.jacobian * strain).fixed_rows::<3>(0).into_owned() + turn.cross(&self.arm);
        let mut moment = passed.fixed_rows_mut::<3>(3);
        moment += arm_change.cross(&self.force);
        (forces, passed)
    }

    /// `Φᵀ` applied to a wrench.
    pub fn carried(&self, wrench: &Vector6<f64>) -> Vector6<f64> {
        let force: Vector3<f64> = wrench.fixed_rows::<3>(0).into_owned();
        let mut carried = *wrench;
        let mut moment = carried.fixed_rows_mut::<3>(3);
        moment += self.arm.cross(&force);
        carried
    }

    fn block(&self, outer: &Matrix6<f64>, cross: Option<&Cross>, slope: Option<&SlopeTangent<N>>) -> LinkBlock<N> {
        let shift = self.shift();
        let mut toward_inner = outer * shift;
        let mut from_outer = shift.transpose() * outer;
        if let Some(cross) = cross {
            toward_inner += cross.outer_inner;
            from_outer += cross.inner_outer;
        }
        let mut xa = self.jacobian.transpose() * toward_inner;
        let mut columns = xa.fixed_view_mut::<N, 3>(0, 3);
        columns += self.turning;
        let mut ax = from_outer * self.jacobian;
        for k in 0..N {
            let column: Vector3<f64> = self.jacobian.fixed_view::<3, 1>(0, k).into_owned();
            let mut moment = ax.fixed_view_mut::<3, 1>(3, k);
            moment += column.cross(&self.force);
        }
        let mut aa = shift.transpose() * toward_inner;
        if let Some(cross) = cross {
            aa += cross.inner_outer * shift;
        }
        let mut spin = aa.fixed_view_mut::<3, 3>(3, 3);
        spin += hat(&self.force) * hat(&self.arm);
        let mut xx = self.jacobian.transpose() * outer * self.jacobian + self.curvature;
        if let Some(slope) = slope {
            xx += self.jacobian.transpose() * slope.columns[1] + slope.rows[1] * self.jacobian + slope.own;
            xa += slope.rows[0] + slope.rows[1] * shift;
            ax += slope.columns[0] + shift.transpose() * slope.columns[1];
        }
        LinkBlock { xx, xa, ax, aa }
    }
}

/// Tangent of an element, a pair, a modal body or a joint in its own unknowns `x` (at most `U`) and the twist `a` of the node to which it
/// is attached.
#[derive(Debug, Clone)]
pub(super) struct Block<const U: usize = UNKNOWNS> {
    pub xx: SMatrix<f64, U, U>,
    pub xa: SMatrix<f64, U, 6>,
    pub ax: SMatrix<f64, 6, U>,
    pub aa: Matrix6<f64>,
}

impl<const U: usize> Block<U> {
    /// Zero block.
    pub fn zeros() -> Self {
        Self { xx: SMatrix::zeros(), xa: SMatrix::zeros(), ax: SMatrix::zeros(), aa: Matrix6::zeros() }
    }

    /// Block of one link or two consecutive links; `outer` is the tangent of the last node, `middle` that of the node between them.
    pub fn of_links<const N: usize>(
        links: &[LinkTangent<N>],
        (cross, slopes): (&[Cross], &[SlopeTangent<N>]),
        outer: &Matrix6<f64>,
        middle: &Matrix6<f64>,
    ) -> Self {
        let mut block = Self::zeros();
        let last = links[links.len() - 1].block(outer, cross.last(), slopes.last());
        if links.len() == 1 {
            block.xx.fixed_view_mut::<N, N>(0, 0).copy_from(&last.xx);
            block.xa.fixed_view_mut::<N, 6>(0, 0).copy_from(&last.xa);
            block.ax.fixed_view_mut::<6, N>(0, 0).copy_from(&last.ax);
            block.aa = last.aa;
            return block;
        }
        let first = links[0].block(&(last.aa + middle), cross.first(), slopes.first());
        let (jacobian, shift) = (&links[0].jacobian, links[0].shift());
        block.xx.fixed_view_mut::<N, N>(0, 0).copy_from(&first.xx);
        block.xx.fixed_view_mut::<N, N>(0, N).copy_from(&(jacobian.transpose() * last.ax));
        block.xx.fixed_view_mut::<N, N>(N, 0).copy_from(&(last.xa * jacobian));
        block.xx.fixed_view_mut::<N, N>(N, N).copy_from(&last.xx);
        block.xa.fixed_view_mut::<N, 6>(0, 0).copy_from(&first.xa);
        block.xa.fixed_view_mut::<N, 6>(N, 0).copy_from(&(last.xa * shift));
        block.ax.fixed_view_mut::<6, N>(0, 0).copy_from(&first.ax);
        block.ax.fixed_view_mut::<6, N>(0, N).copy_from(&(shift.transpose() * last.ax));
        block.aa = first.aa;
        block
    }

    /// Adds another block in the same unknowns.
    pub fn add(&mut self, other: &Self) {
        self.xx += other.xx;
        self.xa += other.xa;
        self.ax += other.ax;
        self.aa += other.aa;
    }

    /// Replaces the unknowns `x` by `T x`, with the matrix `T` in `mixing`.
    pub fn mix(&mut self, mixing: &SMatrix<f64, U, U>) {
        self.xx = mixing.transpose() * self.xx * mixing;
        self.xa = mixing.transpose() * self.xa;
        self.ax *= mixing;
    }
}

/// Force and moment of a load in the root frame.
pub(super) fn turned(load: &Wrench, frame: LoadFrame, rotation: &Matrix3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    match frame {
        LoadFrame::Root => (load.force_n, load.moment_n_m),
        LoadFrame::Section => (rotation * load.force_n, rotation * load.moment_n_m),
    }
}

/// Changes of the inertia forces of an element with its strains, and of the forces on its strains, eq. (L43).
#[derive(Debug, Clone, Copy)]
pub(super) struct SlopeTangent<const N: usize> {
    /// Forces on the strains per twist of the inner and outer node.
    pub rows: [StrainsByTwist<N>; 2],
    /// Wrenches of the inner and outer node per strain.
    pub columns: [TwistByStrains<N>; 2],
    /// Forces on the strains per strain.
    pub own: StrainMatrix<N>,
}

impl<const N: usize> SlopeTangent<N> {
    /// Zero tangent.
    pub const ZERO: Self = Self {
        rows: [SMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; N]; 6])); 2],
        columns: [SMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; 6]; N])); 2],
        own: SMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; N]; N])),
    };
}
