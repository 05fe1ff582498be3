//! Keys of materials and of sections given by shape.

use crate::air_file::LeadingEdgeFile;
use crate::function::FunctionFile;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::Deserialize;

/// A material of the model; others are in the library of `docs/guide/sections.md`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialFile {
    /// Young's modulus; along the fibres, if there are any.
    #[serde(rename = "youngs_modulus_Pa")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub youngs_modulus_pa: f64,
    /// Shear modulus; instead of `poisson_ratio`, or with it for a unidirectional material.
    #[serde(rename = "shear_modulus_Pa")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub shear_modulus_pa: Option<f64>,
    /// Poisson's ratio; instead of `shear_modulus_Pa`. Of a unidirectional material the major one.
    #[schemars(extend("exclusiveMinimum" = -1, "maximum" = 0.5))]
    pub poisson_ratio: Option<f64>,
    /// Density.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density_kg_m3: f64,
    /// Young's modulus across the fibres, which makes the material a unidirectional one. Used by laminates only.
    #[serde(rename = "transverse_youngs_modulus_Pa")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub transverse_youngs_modulus_pa: Option<f64>,
    /// Shear modulus in the plane across the fibres of a unidirectional material; default: half of
    /// `transverse_youngs_modulus_Pa` over 1.4.
    #[serde(rename = "transverse_shear_modulus_Pa")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub transverse_shear_modulus_pa: Option<f64>,
}

/// Round tube.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TubeSection {
    /// Outer diameter along the body.
    pub diameter_m: FunctionFile,
    /// Thickness of the wall along the body, less than half the diameter.
    pub wall_m: FunctionFile,
    /// Name of the material: of a table `[material.<name>]` or of the library.
    pub material: String,
}

/// Box, I-beam or channel.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FrameSection {
    /// Outer width along `y`, along the body.
    pub width_m: FunctionFile,
    /// Outer height along `z`, along the body.
    pub height_m: FunctionFile,
    /// Thickness of the walls along the body; with `web_wall_m` only of those parallel to `y`: top and bottom, flanges.
    pub wall_m: FunctionFile,
    /// Thickness of the walls parallel to `z` along the body: sides, webs. Default: `wall_m`.
    pub web_wall_m: Option<FunctionFile>,
    /// Name of the material: of a table `[material.<name>]` or of the library.
    pub material: String,
}

/// Channel.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ChannelSection {
    /// Outer width along `y`, the width of the flanges, as a function along the body.
    pub width_m: FunctionFile,
    /// Outer height along `z`, the height of the web, as a function along the body.
    pub height_m: FunctionFile,
    /// Thickness of the walls along the body; with `web_wall_m` the thickness of the flanges only.
    pub wall_m: FunctionFile,
    /// Thickness of the web along the body. Default: `wall_m`.
    pub web_wall_m: Option<FunctionFile>,
    /// Side on which the channel is open.
    #[serde(default)]
    pub open_side: LeadingEdgeFile,
    /// Name of the material: of a table `[material.<name>]` or of the library.
    pub material: String,
}

/// Angle of two legs.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AngleSection {
    /// Outer width along the body: length of the leg along `y`, which lies at the lower side and reaches towards `+y`.
    pub width_m: FunctionFile,
    /// Outer height along the body: length of the leg along `z`.
    pub height_m: FunctionFile,
    /// Thickness of both legs along the body.
    pub wall_m: FunctionFile,
    /// Name of the material: of a table `[material.<name>]` or of the library.
    pub material: String,
}

/// Thin-walled profile: the skin of an aerofoil with spars.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ProfileSection {
    /// Chord along the body.
    pub chord_m: FunctionFile,
    /// Name of a NACA aerofoil of four digits, such as `"naca2412"`.
    pub aerofoil: Option<String>,
    /// Outline of the outer surface, instead of `aerofoil`: points `[x, z]` as fractions of the chord, `x` from the leading edge, in order
    /// from the trailing edge over one side to the leading edge and back along the other.
    #[schemars(
        length(min = 4, max = 1000),
        extend("x-allowed" = "an array of 4 to 1000 points [x, z] of finite numbers")
    )]
    pub outline: Option<Vec<[f64; 2]>>,
    /// Thickness of the skin along the body.
    pub skin_wall_m: FunctionFile,
    /// Name of the material of the skin: of a table `[material.<name>]` or of the library.
    pub material: String,
    /// Spars by name.
    #[serde(default)]
    pub spar: IndexMap<String, SparFile>,
    /// Side of the section on which the leading edge lies.
    #[serde(default)]
    pub leading_edge: LeadingEdgeFile,
}

/// Spar of a profile: a wall across it, parallel to `z`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SparFile {
    /// Position behind the leading edge as a fraction of the chord.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub position: f64,
    /// Thickness along the body.
    pub wall_m: FunctionFile,
    /// Name of the material of the spar; default: the material of the skin.
    pub material: Option<String>,
}

/// Flat strip of plies, by classical lamination theory.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LaminateSection {
    /// Width along `y`, along the body.
    pub width_m: FunctionFile,
    /// Angles of the fibres of the plies from the body's axis towards `+y`, from the lowest `z` to the highest.
    #[schemars(length(min = 1, max = 1000))]
    pub layup_deg: Vec<f64>,
    /// The plies of `layup_deg` are the lower half, and the upper half mirrors them.
    #[serde(default)]
    pub symmetric: bool,
    /// Thickness of each ply.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub ply_thickness_m: Option<f64>,
    /// Thicknesses of the plies, instead of `ply_thickness_m`: one for each angle in `layup_deg`.
    #[schemars(length(min = 1, max = 1000))]
    pub ply_thicknesses_m: Option<Vec<f64>>,
    /// Name of the material of the plies: of a table `[material.<name>]` or of the library.
    pub material: Option<String>,
    /// Names of the materials, instead of `material`: one for each angle in `layup_deg`.
    #[schemars(length(min = 1, max = 1000), extend("x-allowed" = "an array of 1 to 1000 names of materials"))]
    pub ply_materials: Option<Vec<String>>,
}
