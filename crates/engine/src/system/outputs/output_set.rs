//! Sets of outputs: groups that are evaluated together, and the sweeps that they require.

use std::ops::BitOr;

/// A set of groups of [`crate::system::Outputs`].
///
/// Outputs that are not read need no evaluation: angles follow from the coordinates, positions from a sweep of poses, velocities and
/// energies from a sweep of motions, forces from a complete residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OutputSet(u32);

impl OutputSet {
    /// The empty set.
    pub const NONE: Self = Self(0);
    /// Revolute joints: angles, rates, torques, latches.
    pub const JOINTS: Self = Self(1);
    /// Work of the inputs and dissipated energy.
    pub const ACCOUNTS: Self = Self(1 << 1);
    /// Strains of gauges.
    pub const GAUGES: Self = Self(1 << 2);
    /// Positions and attitudes of free ends.
    pub const TIP_PLACES: Self = Self(1 << 3);
    /// Positions and attitudes of load stations.
    pub const STATION_PLACES: Self = Self(1 << 4);
    /// Universal, ball and free joints.
    pub const SPATIAL: Self = Self(1 << 5);
    /// Velocities and accelerations of free ends.
    pub const TIP_MOTIONS: Self = Self(1 << 6);
    /// Velocities and angular velocities of load stations.
    pub const STATION_MOTIONS: Self = Self(1 << 7);
    /// Kinetic and potential energies and their sum.
    pub const ENERGIES: Self = Self(1 << 8);
    /// Forces and moments of joints.
    pub const REACTIONS: Self = Self(1 << 9);
    /// Gaps and forces of closed loops, skates and wheels.
    pub const LOOPS: Self = Self(1 << 10);
    /// Force and moment on the aircraft.
    pub const ROOT: Self = Self(1 << 11);
    /// Aerodynamic loads.
    pub const AIR: Self = Self(1 << 12);
    /// Constraint torques of held revolute joints.
    pub const HOLDING: Self = Self(1 << 13);
    /// Accelerations of load stations.
    pub const STATION_ACCELERATIONS: Self = Self(1 << 14);
    /// Internal loads.
    pub const SECTION_LOADS: Self = Self(1 << 15);
    /// All outputs; also the motion and the forces inside the wing from which shapes, sections and strains are read.
    pub const ALL: Self = Self((1 << 16) - 1);

    /// Whether the set contains all of `other`.
    #[inline]
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether the set contains some of `other`.
    #[inline]
    pub fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Difference of the sets: `self` without `other`.
    #[inline]
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Sweep required for the outputs, depending on whether strains of gauges follow from forces (`recovered`) or from coordinates.
    pub(crate) fn sweep(self, recovered: bool) -> Sweep {
        let forces = Self::REACTIONS | Self::SECTION_LOADS | Self::LOOPS | Self::ROOT | Self::AIR | Self::HOLDING;
        let motions =
            Self::SPATIAL | Self::TIP_MOTIONS | Self::STATION_MOTIONS | Self::STATION_ACCELERATIONS | Self::ENERGIES;
        if self.meets(forces) || recovered && self.meets(Self::GAUGES) {
            Sweep::Residual
        } else if self.meets(motions) {
            Sweep::Motion
        } else if self.meets(Self::TIP_PLACES | Self::STATION_PLACES) {
            Sweep::Poses
        } else {
            Sweep::Nothing
        }
    }
}

impl BitOr for OutputSet {
    type Output = Self;

    #[inline]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// Extent to which the equations are evaluated at the current time; each includes the previous ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Sweep {
    /// Coordinates only.
    Nothing,
    /// Poses of the nodes.
    Poses,
    /// Poses, velocities and accelerations.
    Motion,
    /// Poses, velocities, accelerations and forces.
    Residual,
}
