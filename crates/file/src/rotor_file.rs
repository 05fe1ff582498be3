//! Aerodynamics of a rotor: keys of `[aerodynamics]` for `model = "bem"`, and the tables `[polar.<name>]`, `[wind]` and
//! `[tower]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Loads at the very tip and hub of the blades, where Prandtl's loss is complete.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum EndRuleFile {
    /// Zero load, as at the end of a lifting line.
    Zero,
    /// Load of a section whose inflow is its own motion only (axial induction 1), as in AeroDyn; for comparison.
    FullInduction,
}

/// Pitch rate of a section about its span that enters its loads without dynamic stall.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum PitchRateFile {
    /// None.
    None,
    /// Relative to the hub.
    Hub,
    /// Relative to the air: with coning the rotor speed contributes.
    Air,
}

/// Interpolation of loads between the stations of a blade.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum SpreadFile {
    /// Linear between stations, none beyond the first and the last.
    Linear,
    /// Each station carries the load of the part of the blade nearest to it.
    PiecewiseConstant,
}

/// Direction of rotation of a rotor, looking downwind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum TurnsFile {
    /// Right-handed about `shaft_axis`.
    Clockwise,
    /// Left-handed about `shaft_axis`.
    CounterClockwise,
}

/// Aerofoil polar of a blade section, from -180 to 180 degrees: `rows` or a `file`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PolarFile {
    /// Rows of angle of attack in degrees, lift, drag and moment coefficient about the quarter chord, linear between rows.
    #[schemars(
        length(min = 1, max = 1000),
        extend("x-allowed" = "at least 1 row [angle of attack in deg, lift, drag, moment coefficient]")
    )]
    pub rows: Option<Vec<[f64; 4]>>,
    /// File with the rows, relative to the model file, in AeroDyn's format (first table only) or as CSV with the
    /// columns `alpha_deg`, `cl`, `cd` and `cm`. Its rows replace this key when the model file is read, so an FMU needs
    /// no other file.
    pub file: Option<String>,
    /// Aspect ratio of the blade: extends rows that end at stall to the full circle by Viterna's method.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub aspect_ratio: Option<f64>,
    /// For rows from negative to positive stall, extended at both ends by Viterna's method: angle beyond either stall
    /// over which the centre of pressure moves to half chord. With `aspect_ratio` only, at most 80. Default: the rows
    /// end at positive stall, and the reflected curve is used at negative angles.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub pressure_shift_deg: Option<f64>,
}

/// Side of a wind field, looking downwind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum SideFile {
    /// Left.
    Port,
    /// Right.
    Starboard,
}

/// Wind field, with `model = "bem"`: added to or modifying the wind of the input.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WindFile {
    /// Upward direction, of any length except zero.
    #[serde(default = "up")]
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub up: [f64; 3],
    /// Horizontal downwind direction, of any length except zero; default: the direction of `wind_m_s`.
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub downwind: Option<[f64; 3]>,
    /// Point on the ground below the hub, root frame.
    #[serde(default)]
    pub ground_m: [f64; 3],
    /// Reference height above the ground for the wind of the input.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub reference_height_m: f64,
    /// Exponent of the power law over height.
    pub shear_exponent: Option<f64>,
    /// Roughness length of the logarithmic law over height.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub roughness_m: Option<f64>,
    /// Wind over time, added to that of the input: rows `[time, speed, direction in deg, vertical speed, horizontal
    /// linear shear, power-law exponent, vertical linear shear, gust]`, the columns of AeroDyn's uniform wind files;
    /// shears over `reference_length_m`.
    #[schemars(length(min = 1, max = 100000))]
    pub table: Option<Vec<[f64; 8]>>,
    /// Reference length of the table's linear shears: the rotor diameter.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub reference_length_m: Option<f64>,
    /// File with the table, relative to the model file: text with the same columns, like AeroDyn's uniform wind files.
    /// Its rows replace this key when the model file is read, so an FMU needs no other file.
    pub table_file: Option<String>,
    /// Full-field wind file of TurbSim, `.bts`, or of Bladed, `.wnd`, relative to the model file; added to the wind of
    /// the input, which should then be zero. Its bytes replace this key, as `field`, when the model file is read.
    pub field_file: Option<String>,
    /// Bytes of a full-field wind file in base64; replaces `field_file` when the model file is read.
    pub field: Option<String>,
    /// Height of the centre of a Bladed wind field above the ground; default: `reference_height_m`. Must agree with the
    /// `.sum` file of the same name in the same folder, if there is one.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub field_centre_height_m: Option<f64>,
    /// Side, looking downwind, at which the lateral points of a Bladed wind field start: TurbSim and Bladed start at
    /// port (`CLOCKWISE` in the `.sum` file). Default: `"port"`.
    pub field_from: Option<SideFile>,
    /// Turbulence generated from a seed, added to the wind of the input, which should then be zero.
    pub turbulence: Option<TurbulenceFile>,
}

fn up() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

/// Turbulence of IEC 61400-1: Kaimal spectra, exponential coherence of the longitudinal component.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TurbulenceFile {
    /// Random seed: the same seed gives the same wind.
    pub seed: u64,
    /// Mean wind speed at the reference height.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mean_m_s: f64,
    /// Standard deviation of the longitudinal component.
    #[schemars(range(min = 0.0))]
    pub standard_deviation_m_s: f64,
    /// Number of lateral and vertical grid points.
    pub points: [usize; 2],
    /// Lateral and vertical spacing of grid points in m.
    pub spacing_m: [f64; 2],
    /// Number of planes in time, a power of two; the wind then repeats.
    pub planes: usize,
    /// Time between planes.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub plane_interval_s: f64,
}

/// Tower that disturbs the wind, with `model = "bem"`; it does not move.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TowerFile {
    /// Base, root frame.
    #[serde(default)]
    pub base_m: [f64; 3],
    /// Direction from the base to the top, of any length except zero.
    #[serde(default = "up")]
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub up: [f64; 3],
    /// Rows `[height above the base in m, diameter in m, drag coefficient]`, heights ascending from 0.
    #[schemars(length(min = 2, max = 1000))]
    pub rows: Vec<[f64; 3]>,
    /// Disturbance of the flow upwind of and abreast of the tower.
    #[serde(default)]
    pub potential: PotentialFile,
    /// Disturbance of the flow downwind of the tower.
    #[serde(default)]
    pub shadow: ShadowFile,
}

/// Flow upwind of and abreast of a tower.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum PotentialFile {
    /// Undisturbed.
    None,
    /// Potential flow around a cylinder.
    #[default]
    Cylinder,
    /// Potential flow with a source for the wake of the drag (Bak).
    Bak,
}

/// Flow downwind of a tower.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum ShadowFile {
    /// Undisturbed.
    #[default]
    None,
    /// Cosine-shaped wake deficit of Powles.
    Powles,
}
