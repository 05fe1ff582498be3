//! Latches in code: equivalent of a table `[joint.<name>.latch]` of the model file.

use crate::machine::fault::Checker;
use crate::machine::validate::joint::latch_stiffness_n_m_rad;
use crate::machine::{DEFAULT_CAPTURE_RAD, Latch, LatchKind, Travel};

/// Stiffness of a latch under construction.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stiffening {
    /// Stiffness of the closed joint relative to that of motor and spring.
    Ratio(f64),
    /// Stiffness that the latch adds, in N·m/rad.
    Added(f64),
    /// No stiffness: the latch is rigid.
    Rigid,
}

/// A latch under construction, see [`Latch::with_ratio`], [`Latch::with_stiffness_n_m_rad`], [`Latch::rigid`].
#[derive(Debug, Clone, PartialEq)]
pub struct LatchBuilder {
    stiffening: Stiffening,
    angle_rad: f64,
    capture_rad: f64,
    initially_closed: bool,
    enable: bool,
}

impl From<Latch> for LatchBuilder {
    fn from(latch: Latch) -> Self {
        Self {
            stiffening: match latch.kind {
                LatchKind::Elastic => Stiffening::Added(latch.stiffness_n_m_rad),
                LatchKind::Rigid => Stiffening::Rigid,
            },
            angle_rad: latch.angle_rad,
            capture_rad: latch.capture_rad,
            initially_closed: latch.initially_closed,
            enable: latch.enable,
        }
    }
}

impl Latch {
    /// A latch at angle 0, open and enabled, that makes its joint `ratio` times as stiff as motor and spring alone: it adds `(ratio − 1)
    /// k`.
    pub fn with_ratio(ratio: f64) -> LatchBuilder {
        LatchBuilder { stiffening: Stiffening::Ratio(ratio), ..Self::with_stiffness_n_m_rad(0.0) }
    }

    /// A latch at angle 0, open and enabled, that adds a stiffness in N·m/rad when it is closed.
    pub fn with_stiffness_n_m_rad(stiffness_n_m_rad: f64) -> LatchBuilder {
        LatchBuilder {
            stiffening: Stiffening::Added(stiffness_n_m_rad),
            angle_rad: 0.0,
            capture_rad: DEFAULT_CAPTURE_RAD,
            initially_closed: false,
            enable: true,
        }
    }

    /// A latch of a prismatic joint at position 0, open and enabled, that adds a stiffness in N/m when it is closed.
    pub fn with_stiffness_n_m(stiffness_n_m: f64) -> LatchBuilder {
        Self::with_stiffness_n_m_rad(stiffness_n_m)
    }

    /// A latch at angle 0, open and enabled, that holds the joint at the angle of capture without a spring: an impulse stops the joint,
    /// NOTATION eq. (A7).
    pub fn rigid() -> LatchBuilder {
        LatchBuilder { stiffening: Stiffening::Rigid, ..Self::with_stiffness_n_m_rad(0.0) }
    }
}

impl LatchBuilder {
    /// Angle in rad at which the latch closes. Default 0.
    pub fn angle_rad(self, angle_rad: f64) -> Self {
        Self { angle_rad, ..self }
    }

    /// Half-width in rad of the capture range. Default [`DEFAULT_CAPTURE_RAD`].
    pub fn capture_rad(self, capture_rad: f64) -> Self {
        Self { capture_rad, ..self }
    }

    /// Position in m at which the latch of a prismatic joint closes. Default 0.
    pub fn position_m(self, position_m: f64) -> Self {
        self.angle_rad(position_m)
    }

    /// Half-width in m of the capture range of a prismatic joint. Default 1e-6 m.
    pub fn capture_m(self, capture_m: f64) -> Self {
        self.capture_rad(capture_m)
    }

    /// Whether the latch is closed at the start. Default false.
    pub fn initially_closed(self, initially_closed: bool) -> Self {
        Self { initially_closed, ..self }
    }

    /// Start value of the enable input. Default true.
    pub fn enable(self, enable: bool) -> Self {
        Self { enable, ..self }
    }

    pub(super) fn build(&self, joint: &str, travel: Travel, own_n_m_rad: f64, checker: &mut Checker) -> Latch {
        let stiffness_n_m_rad = match self.stiffening {
            Stiffening::Added(stiffness_n_m_rad) => stiffness_n_m_rad,
            Stiffening::Rigid => 0.0,
            // after an error, a valid stiffness replaces it
            Stiffening::Ratio(ratio) => {
                latch_stiffness_n_m_rad(joint, travel, ratio, own_n_m_rad, checker).unwrap_or(1.0)
            }
        };
        Latch {
            kind: if self.stiffening == Stiffening::Rigid { LatchKind::Rigid } else { LatchKind::Elastic },
            angle_rad: self.angle_rad,
            stiffness_n_m_rad,
            capture_rad: self.capture_rad,
            initially_closed: self.initially_closed,
            enable: self.enable,
        }
    }
}
