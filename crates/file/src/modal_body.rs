//! Modal bodies of the model file.

use crate::body_file::LoadFrameFile;
use crate::checker::Checker;
use foldwing_engine::beam::profile::Profile;
use foldwing_engine::machine::builder::BodyBuilder;
use foldwing_engine::machine::{Body, ModalLaw, Shape};
use schemars::JsonSchema;
use serde::Deserialize;

/// Modal body: deflects in a few given mode shapes, flapwise along `z` and edgewise along `y`, as ElastoDyn's blades
/// and towers; the coordinates are the deflections of the outer end. The axis shortens to second order; it neither
/// stretches nor twists. Joints and masses attach to its ends.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ModalBodyFile {
    /// Number of copies, each with its joint and everything attached to it, spaced evenly about the parent's `x` axis:
    /// names of the copies end in 1, 2, …, as do the names of joints, masses and loads on them. Default: one body, name
    /// unchanged.
    #[schemars(range(min = 1, max = 12))]
    pub count: Option<usize>,
    /// Length of the undeformed axis.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length_m: f64,
    /// Number of equal segments for the integrals along the body, each with its mass at its middle, as ElastoDyn's
    /// `BldNodes`.
    #[schemars(range(min = 1, max = 1000))]
    pub nodes: usize,
    /// Positions of the properties below as fractions of the length, ascending from 0 to 1; linear interpolation
    /// between them.
    #[schemars(length(min = 2, max = 1000), inner(range(min = 0.0, max = 1.0)))]
    pub stations: Vec<f64>,
    /// Mass per length at the stations.
    #[schemars(extend("x-allowed" = "an array of numbers > 0, one per station"))]
    pub mass_kg_m: Vec<f64>,
    /// Flapwise bending stiffness at the stations.
    #[serde(rename = "flap_stiffness_N_m2")]
    #[schemars(extend("x-allowed" = "an array of numbers > 0, one per station"))]
    pub flap_stiffness_n_m2: Vec<f64>,
    /// Edgewise bending stiffness at the stations.
    #[serde(rename = "edge_stiffness_N_m2")]
    #[schemars(extend("x-allowed" = "an array of numbers > 0, one per station"))]
    pub edge_stiffness_n_m2: Vec<f64>,
    /// Structural twist at the stations, right-handed about the axis: rotates the flapwise and edgewise directions.
    /// Without it the deflections are the mode shapes themselves.
    #[schemars(extend("x-allowed" = "an array of finite numbers in deg, one per station"))]
    pub twist_deg: Option<Vec<f64>>,
    /// Flapwise mode shapes: coefficients of x², x³, …, with x from 0 to 1; the coefficients of each shape sum to 1.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "an array of arrays of finite numbers, each of which adds up to 1"))]
    pub flap_shapes: Vec<Vec<f64>>,
    /// Edgewise mode shapes, as `flap_shapes`.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "an array of arrays of finite numbers, each of which adds up to 1"))]
    pub edge_shapes: Vec<Vec<f64>>,
    /// Damping ratio of each flapwise shape, for the untwisted body with a free outer end. Default 0.
    #[schemars(inner(range(min = 0.0)))]
    pub flap_damping_ratios: Option<Vec<f64>>,
    /// Damping ratio of each edgewise shape. Default 0.
    #[schemars(inner(range(min = 0.0)))]
    pub edge_damping_ratios: Option<Vec<f64>>,
    /// Deflection of the outer end in each flapwise shape at the start. Default 0.
    pub flap_start_m: Option<Vec<f64>>,
    /// Deflection of the outer end in each edgewise shape at the start. Default 0.
    pub edge_start_m: Option<Vec<f64>>,
    /// Include the axial shortening due to bending. Without it a rotating blade has no centrifugal stiffening.
    #[serde(default = "crate::freedom_file::yes")]
    pub axial_shortening: bool,
    /// Include the rotation of sections due to bending. Without it sections, and bodies attached to the outer end, keep
    /// the attitude of the inner end, and moments on them do not bend the body.
    #[serde(default = "crate::freedom_file::yes")]
    pub section_rotation: bool,
    /// Distances of load stations from the inner end, ascending. Default: none.
    #[schemars(length(max = 1000))]
    pub load_station_positions_m: Option<Vec<f64>>,
    /// Frame of the forces and moments at the stations: `root` (dead loads) or `section` (follower loads).
    #[serde(default)]
    pub load_frame: LoadFrameFile,
}

/// Builds a body. Arrays of the wrong length are reported here.
pub(super) fn build(name: &str, file: &ModalBodyFile, checker: &mut Checker) -> BodyBuilder {
    let stations = file.stations.len();
    let ends = file.stations.first() == Some(&0.0) && file.stations.last() == Some(&1.0);
    let ascending = file.stations.windows(2).all(|pair| pair[0] < pair[1]);
    let sound = ends && ascending;
    if !sound {
        checker.refuse(&["modal_body", name, "stations"], "fractions of the length that ascend from 0 to 1");
    }
    let mut along = |key: &str, values: &[f64], factor: f64| {
        if values.len() != stations {
            checker.refuse(&["modal_body", name, key], format!("an array of {stations} numbers, one per station"));
        }
        let rows = file.stations.iter().zip(values).map(|(share, value)| [share * file.length_m, value * factor]);
        match sound && values.len() == stations {
            true => Profile::Table(rows.collect()),
            false => Profile::constant(1.0),
        }
    };
    let mass_kg_m = along("mass_kg_m", &file.mass_kg_m, 1.0);
    let flap_stiffness_n_m2 = along("flap_stiffness_N_m2", &file.flap_stiffness_n_m2, 1.0);
    let edge_stiffness_n_m2 = along("edge_stiffness_N_m2", &file.edge_stiffness_n_m2, 1.0);
    let twist_rad = file.twist_deg.as_ref().map(|twist| along("twist_deg", twist, 1f64.to_radians()));
    let mut shapes = |kind: &str, coefficients: &[Vec<f64>], ratios: Option<&Vec<f64>>, start: Option<&Vec<f64>>| {
        let mut each = |key: String, values: Option<&Vec<f64>>| {
            let count = coefficients.len();
            let fits = values.is_none_or(|values| values.len() == count);
            if !fits {
                checker.refuse(&["modal_body", name, &key], format!("an array of {count} numbers, one per shape"));
            }
            values.filter(|_| fits).cloned().unwrap_or_else(|| vec![0.0; count])
        };
        let ratios = each(format!("{kind}_damping_ratios"), ratios);
        let start = each(format!("{kind}_start_m"), start);
        let shape = |((coefficients, ratio), start): ((&Vec<f64>, f64), f64)| Shape {
            coefficients: coefficients.clone(),
            damping_ratio: ratio,
            start_m: start,
        };
        coefficients.iter().zip(ratios).zip(start).map(shape).collect::<Vec<Shape>>()
    };
    let law = ModalLaw {
        length_m: file.length_m,
        cells: file.nodes,
        mass_kg_m,
        flap_stiffness_n_m2,
        edge_stiffness_n_m2,
        twist_rad,
        flap: shapes("flap", &file.flap_shapes, file.flap_damping_ratios.as_ref(), file.flap_start_m.as_ref()),
        edge: shapes("edge", &file.edge_shapes, file.edge_damping_ratios.as_ref(), file.edge_start_m.as_ref()),
        axial_shortening: file.axial_shortening,
        section_rotation: file.section_rotation,
        rates_of_angles: false,
        mass_factor: 1.0,
        stiffness_factor: 1.0,
    };
    let body = Body::modal(name, law).load_frame(file.load_frame.into());
    match &file.load_station_positions_m {
        Some(positions_m) => body.load_station_positions_m(positions_m.as_slice()),
        None => body,
    }
}
