//! Air of a rotor: keys of `[aerodynamics]` for `model = "bem"`, and the tables `[polar.<name>]`, `[wind]` and `[tower]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Loads at the very tip and hub of the blades, where Prandtl's loss is complete.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum EndRuleFile {
    /// No load, as a lifting line ends.
    Zero,
    /// The load of a section that meets its own motion alone (axial induction 1), as AeroDyn has it; for comparison.
    FullInduction,
}

/// Turning of a section about its span that a section without dynamic stall feels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum PitchRateFile {
    /// None.
    None,
    /// Against the hub.
    Hub,
    /// In the air: a coned blade that goes round turns in it besides.
    Air,
}

/// Loads between the stations of a blade.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum SpreadFile {
    /// Linear between stations, none beyond the first and the last.
    Linear,
    /// Each station carries the load of the part of the blade that is nearest to it.
    PiecewiseConstant,
}

/// Direction of rotation of a rotor, looking downwind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum TurnsFile {
    /// By the right hand about `shaft_axis`.
    Clockwise,
    /// By the left hand about `shaft_axis`.
    CounterClockwise,
}

/// Polar of a blade's section, from -180 to 180 degrees: `rows` or a `file`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PolarFile {
    /// Rows of angle of attack in degrees, lift, drag and moment coefficient about the quarter chord, linear between rows.
    #[schemars(
        length(min = 1, max = 1000),
        extend("x-allowed" = "at least 1 row [angle of attack in deg, lift, drag, moment coefficient]")
    )]
    pub rows: Option<Vec<[f64; 4]>>,
    /// File beside the model file that has them, in AeroDyn's format (its first table) or as CSV with the columns `alpha_deg`,
    /// `cl`, `cd` and `cm`. Its rows take the key's place when the model file is read, so an FMU needs no other file.
    pub file: Option<String>,
    /// Aspect ratio of the blade: extends rows that end at stall to the full circle by Viterna's formulas.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub aspect_ratio: Option<f64>,
    /// The rows go from the negative to the positive stall, and Viterna's formulas extend both ends: over this angle beyond either
    /// stall the centre of pressure goes to half chord. With `aspect_ratio` only, at most 80. Default: rows that end at the positive
    /// stall, and the reflected half of it for negative angles.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub pressure_shift_deg: Option<f64>,
}

/// Side of a field of wind, for who looks downwind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum SideFile {
    /// Left.
    Port,
    /// Right.
    Starboard,
}

/// Wind as a field, with `model = "bem"`: what it adds to, or does to, the wind of the input.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WindFile {
    /// Direction upward, of any length except zero.
    #[serde(default = "up")]
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub up: [f64; 3],
    /// Level direction downwind, of any length except zero; default: that of `wind_m_s`.
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub downwind: Option<[f64; 3]>,
    /// Point on the ground below the hub, root frame.
    #[serde(default)]
    pub ground_m: [f64; 3],
    /// Height above the ground at which the input's wind blows.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub reference_height_m: f64,
    /// Exponent of a power law over height.
    pub shear_exponent: Option<f64>,
    /// Roughness length of a logarithmic law over height.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub roughness_m: Option<f64>,
    /// Wind over time, added to that of the input: rows `[time, speed, direction in deg, vertical speed, horizontal linear shear,
    /// power-law exponent, vertical linear shear, gust]`, the columns of AeroDyn's uniform wind files; shears over
    /// `reference_length_m`.
    #[schemars(length(min = 1, max = 100000))]
    pub table: Option<Vec<[f64; 8]>>,
    /// Length over which the table's linear shears are taken: the rotor's diameter.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub reference_length_m: Option<f64>,
    /// File beside the model file that contains the table: text in the same columns, like AeroDyn's uniform wind
    /// files. Its rows replace this key when the model file is read, so an FMU needs no other file.
    pub table_file: Option<String>,
    /// File beside the model file with a full field of TurbSim, `.bts`, or of Bladed, `.wnd`, added to the wind of the input,
    /// which should then be zero. When the model file is read, `field` with its bytes replaces this key.
    pub field_file: Option<String>,
    /// Bytes of such a file in base64; replaces `field_file` when the model file is read.
    pub field: Option<String>,
    /// Height of the middle of a field of Bladed above the ground; default: `reference_height_m`. A `.sum` file of the same name
    /// beside the field must not say otherwise.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub field_centre_height_m: Option<f64>,
    /// Side, for who looks downwind, from which points across are written in a field of Bladed: TurbSim and Bladed write them from
    /// port (`CLOCKWISE` in the `.sum` file). Default: `"port"`.
    pub field_from: Option<SideFile>,
    /// Turbulence from a seed, added to the wind of the input, which then should be zero.
    pub turbulence: Option<TurbulenceFile>,
}

fn up() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

/// Turbulence of IEC 61400-1: Kaimal's spectra, exponential coherence along the wind.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TurbulenceFile {
    /// The same seed gives the same wind.
    pub seed: u64,
    /// Mean wind at the reference height.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mean_m_s: f64,
    /// Standard deviation along the wind.
    #[schemars(range(min = 0.0))]
    pub standard_deviation_m_s: f64,
    /// Points across and upward.
    pub points: [usize; 2],
    /// Distance of points across and upward in m.
    pub spacing_m: [f64; 2],
    /// Planes over time, a power of two; the wind then repeats.
    pub planes: usize,
    /// Time between planes.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub plane_interval_s: f64,
}

/// Tower that the wind goes around, with `model = "bem"`; it stands still.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TowerFile {
    /// Foot, root frame.
    #[serde(default)]
    pub base_m: [f64; 3],
    /// Direction from the foot to the top, of any length except zero.
    #[serde(default = "up")]
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub up: [f64; 3],
    /// Rows `[height above the foot in m, diameter in m, drag coefficient]`, heights ascending from 0.
    #[schemars(length(min = 2, max = 1000))]
    pub rows: Vec<[f64; 3]>,
    /// Flow ahead of it and beside it.
    #[serde(default)]
    pub potential: PotentialFile,
    /// Flow behind it.
    #[serde(default)]
    pub shadow: ShadowFile,
}

/// Flow around a tower.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum PotentialFile {
    /// Not looked at.
    None,
    /// A cylinder in potential flow.
    #[default]
    Cylinder,
    /// With a source for the wake of its drag (Bak).
    Bak,
}

/// Flow behind a tower.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum ShadowFile {
    /// Not looked at.
    #[default]
    None,
    /// Powles' cosine.
    Powles,
}
