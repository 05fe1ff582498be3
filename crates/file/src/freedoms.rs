//! Degrees of freedom of a cylindrical joint in the model file: each is built as a joint of its own, with the keys of a revolute or prismatic
//! joint.

use crate::joint_file::{JointFile, JointType};
use foldwing_engine::machine::Travel;
use foldwing_engine::machine::builder::{CYLINDRICAL, Freedom, carriage};

/// Keys of a joint that its degrees of freedom have in common; all others are in their tables.
const COMMON: &[&str] =
    &["type", "parent", "child", "parent_position_m", "parent_frame", "parent_offset_m", "root_position_m", "axis"];

/// Whether a key of a part of a joint is one of the whole joint.
pub(super) fn is_common(key: &str) -> bool {
    COMMON.contains(&key) || key.starts_with("mount")
}

impl JointType {
    /// Degrees of freedom with a table each.
    pub fn freedoms(self) -> &'static [Freedom] {
        match self {
            Self::Cylindrical => CYLINDRICAL,
            Self::Clamped
            | Self::Revolute
            | Self::Prismatic
            | Self::Sliding
            | Self::Universal
            | Self::Ball
            | Self::Free => &[],
        }
    }
}

impl JointFile {
    /// Names of the parts that the model has in place of this joint, with their paths in the file below `joint`; none if it is a single
    /// joint.
    pub fn parts(&self, name: &str, original: &str) -> Vec<(String, String)> {
        let along = self.attitude().parts(name).into_iter().flatten().map(|part| (part, original.to_owned()));
        let chain = self.kind.freedoms().iter();
        let chain = chain.map(|own| (own.joint(name), format!("{original}.{}", own.name)));
        let between = (1..self.kind.freedoms().len()).map(|next| (carriage(name, next - 1), original.to_owned()));
        along.chain(chain).chain(between).collect()
    }

    /// The table of a degree of freedom as a joint of its own, whose mount and parent are not used.
    pub fn freedom(&self, travel: Travel) -> JointFile {
        match travel {
            Travel::Rotation => {
                let own = self.rotation.clone().unwrap_or_default();
                JointFile {
                    kind: JointType::Revolute,
                    start_angle_deg: own.start_angle_deg,
                    start_rate_deg_s: own.start_rate_deg_s,
                    release: own.release,
                    motion: own.motion,
                    polynomial_deg: own.polynomial_deg,
                    table_s_deg: own.table_s_deg,
                    table_ends: own.table_ends,
                    motor: own.motor,
                    spring: own.spring,
                    generator: own.generator,
                    dc_motor: own.dc_motor,
                    latch: own.latch,
                    end_stops: own.end_stops,
                    ..JointFile::default()
                }
            }
            Travel::Translation => {
                let own = self.translation.clone().unwrap_or_default();
                JointFile {
                    kind: JointType::Prismatic,
                    start_position_m: own.start_position_m,
                    start_rate_m_s: own.start_rate_m_s,
                    release: own.release,
                    motion: own.motion,
                    polynomial_m: own.polynomial_m,
                    table_s_m: own.table_s_m,
                    table_ends: own.table_ends,
                    motor: own.motor,
                    spring: own.spring,
                    dc_motor: own.dc_motor,
                    latch: own.latch,
                    end_stops: own.end_stops,
                    ..JointFile::default()
                }
            }
        }
    }
}
