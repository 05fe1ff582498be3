//! Structure of skates and wheels in the model file.

use schemars::JsonSchema;
use serde::Deserialize;

/// Skate: a point of a body that moves along the body's own `direction` only, on a plane fixed in the root frame, without friction. The
/// constraint acts in both directions: the skate neither slips sideways nor lifts off.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SkateFile {
    /// Body that carries the skate.
    pub body: String,
    /// Distance of the skate's section from the body's inner end; default: its outer end.
    #[schemars(range(min = 0.0))]
    pub position_m: Option<f64>,
    /// Position of the skate's point relative to the section's axis, section frame.
    #[serde(default)]
    pub offset_m: [f64; 3],
    /// Direction of the blade, section frame, of any length except zero; its part in the plane is the heading.
    #[serde(default = "x")]
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub direction: [f64; 3],
    /// Normal of the plane on the side of the body, root frame, of any length except zero.
    #[serde(default = "z")]
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub plane_normal: [f64; 3],
    /// A point of the plane, root frame.
    #[serde(default)]
    pub plane_point_m: [f64; 3],
    /// Whether the point stays in the plane; else only its velocity across the blade is zero.
    #[serde(default = "yes")]
    pub hold_normal: bool,
}

/// Wheel: a thin disc that is part of a body, whose point of contact does not slip on a plane fixed in the root frame: not sideways, and with
/// `rolling` not along the heading. The body turns with the wheel. The constraint acts in both directions: the wheel does not lift off.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WheelFile {
    /// Body that is or carries the wheel.
    pub body: String,
    /// Distance of the section of the wheel's centre from the body's inner end; default: its outer end.
    #[schemars(range(min = 0.0))]
    pub position_m: Option<f64>,
    /// Position of the wheel's centre relative to the section's axis, section frame.
    #[serde(default)]
    pub offset_m: [f64; 3],
    /// Axis of the wheel, section frame, of any length except zero; the heading is `axis × plane_normal`.
    #[serde(default = "y")]
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub axis: [f64; 3],
    /// Radius.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius_m: f64,
    /// Whether the wheel rolls: its velocity along the heading is its radius times its angular velocity about its axis.
    #[serde(default = "yes")]
    pub rolling: bool,
    /// Normal of the plane on the side of the wheel, root frame, of any length except zero.
    #[serde(default = "z")]
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub plane_normal: [f64; 3],
    /// A point of the plane, root frame.
    #[serde(default)]
    pub plane_point_m: [f64; 3],
    /// Whether the point of contact stays in the plane; else only its velocities in the plane are zero.
    #[serde(default = "yes")]
    pub hold_normal: bool,
}

fn x() -> [f64; 3] {
    [1.0, 0.0, 0.0]
}

fn y() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

fn z() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn yes() -> bool {
    true
}
