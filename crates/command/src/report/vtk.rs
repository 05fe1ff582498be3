//! Frames as VTK files for ParaView: for each body a closed surface with strain, displacement and velocity; the lifting surfaces; the
//! wake with its circulation; gauges, loads and joints. There is one `.vtu` file per part and time, a `.pvd` file per part that lists
//! the times, and `run.pvd` with all parts as blocks.
//!
//! The format is VTK's XML with binary data in base64: little-endian, each array preceded by its length in bytes (UInt32).

use crate::report::recording::{BodyScene, Frame, Recording, Scene};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nalgebra::Vector3;

/// Beginning of every file: declaration and name of the program.
const BEGIN: &str = "<?xml version=\"1.0\"?>\n<!-- written by foldwing -->\n";
/// VTK's cell type of a vertex.
const VERTEX: u8 = 1;
/// VTK's cell type of a quadrilateral.
const QUADRILATERAL: u8 = 9;
/// VTK's cell type of a polygon.
const POLYGON: u8 = 7;

/// Values of one array: scalars or vectors.
enum Values {
    Scalars(Vec<f64>),
    Vectors(Vec<Vector3<f64>>),
}

/// Surface of quadrilaterals and polygons with values at its points and cells.
#[derive(Default)]
struct Mesh {
    points_m: Vec<Vector3<f64>>,
    cells: Vec<Vec<usize>>,
    at_points: Vec<(&'static str, Values)>,
    at_cells: Vec<(&'static str, Values)>,
}

/// Names of the possible series of a run, in the order of the blocks of `run.pvd`.
pub const SERIES: [&str; 6] = ["wing", "joints", "gauges", "loads", "surfaces", "wake"];

/// Passes the files of the series `wing` and of the other series for which the model has data, and `run.pvd`, to `write` with their
/// names.
///
/// # Errors
/// Errors of `write`.
pub fn files<E>(recording: &Recording, write: impl FnMut(&str, String) -> Result<(), E>) -> Result<(), E> {
    let Some(first) = recording.frames.first() else { return Ok(()) };
    files_about(&recording.scene, &recording.frames, first, write)
}

/// Like [`files`], for frames whose displacements are measured from a separate state.
///
/// # Errors
/// Errors of `write`.
pub fn files_about<E>(
    scene: &Scene,
    frames: &[Frame],
    state: &Frame,
    mut write: impl FnMut(&str, String) -> Result<(), E>,
) -> Result<(), E> {
    let mut blocks = Vec::new();
    for name in SERIES {
        let has = |frame: &Frame| match name {
            "wing" => true,
            "joints" => !scene.hinges.is_empty(),
            "gauges" => !scene.gauges.is_empty(),
            "loads" => !scene.stations.is_empty(),
            "surfaces" => !frame.edges_m.is_empty(),
            _ => !frame.lattice.is_empty(),
        };
        if !has(state) {
            continue;
        }
        let mesh = |frame: &Frame| match name {
            "wing" => wing(scene, frame, state),
            "joints" => joints(scene, frame),
            "gauges" => gauges(frame),
            "loads" => loads(frame),
            "surfaces" => surfaces(frame),
            _ => wake(frame),
        };
        series(name, frames, mesh, &mut write)?;
        blocks.push(name);
    }
    write("run.pvd", collection(frames, &blocks))
}

/// Text of a `.pvd` file: for every time the files of the series, as parts.
fn collection(frames: &[Frame], names: &[&str]) -> String {
    let mut list = format!("{BEGIN}<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n");
    for (i, frame) in frames.iter().enumerate() {
        for (part, name) in names.iter().enumerate() {
            list += &format!(
                "<DataSet timestep=\"{:?}\" group=\"\" part=\"{part}\" name=\"{name}\" file=\"{name}_{i:04}.vtu\"/>\n",
                frame.time_s
            );
        }
    }
    list + "</Collection>\n</VTKFile>\n"
}

fn series<E>(
    stem: &str,
    frames: &[Frame],
    mesh: impl Fn(&Frame) -> Mesh,
    write: &mut impl FnMut(&str, String) -> Result<(), E>,
) -> Result<(), E> {
    for (i, frame) in frames.iter().enumerate() {
        write(&format!("{stem}_{i:04}.vtu"), mesh(frame).document())?;
    }
    write(&format!("{stem}.pvd"), collection(frames, &[stem]))
}

/// A point at every joint that is not clamped, with the frame of its body's first section, axis, coordinate and reaction.
fn joints(scene: &Scene, frame: &Frame) -> Mesh {
    let mut mesh = Mesh::default();
    let (mut axes, mut frames) = (Vec::new(), [const { Vec::new() }; 3]);
    let (mut coordinates, mut forces, mut moments, mut latched) = (vec![], vec![], vec![], vec![]);
    for hinge in &scene.hinges {
        let section = &frame.sections[hinge.body][0];
        mesh.add_vertex(section.position_m);
        axes.push(section.rotation * hinge.axis);
        frames.iter_mut().enumerate().for_each(|(i, axis)| axis.push(section.rotation.column(i).into_owned()));
        coordinates.push(hinge.freedom.map_or(f64::NAN, |freedom| frame.angles_rad[freedom]));
        latched.push(hinge.freedom.map_or(0.0, |freedom| f64::from(u8::from(frame.latched[freedom]))));
        let [force, moment] = frame.acting.reactions[hinge.body];
        forces.push(force);
        moments.push(moment);
    }
    let [x, y, z] = frames;
    mesh.at_points = vec![
        ("axis", Values::Vectors(axes)),
        ("frame_x", Values::Vectors(x)),
        ("frame_y", Values::Vectors(y)),
        ("frame_z", Values::Vectors(z)),
        ("angle_rad_or_position_m", Values::Scalars(coordinates)),
        ("latched", Values::Scalars(latched)),
        ("reaction_force_N", Values::Vectors(forces)),
        ("reaction_moment_N_m", Values::Vectors(moments)),
    ];
    mesh
}

/// A point at every gauge with its strain.
fn gauges(frame: &Frame) -> Mesh {
    let mut mesh = Mesh::default();
    frame.gauges_m.iter().for_each(|place| mesh.add_vertex(*place));
    mesh.at_points = vec![("strain", Values::Scalars(frame.strains.clone()))];
    mesh
}

/// A point at every load station with the loads of the inputs and of the aerodynamics, in the root frame.
fn loads(frame: &Frame) -> Mesh {
    let mut mesh = Mesh::default();
    let acting = &frame.acting;
    acting.stations_m.iter().for_each(|place| mesh.add_vertex(*place));
    mesh.at_points = vec![
        ("force_N", Values::Vectors(acting.forces_n.clone())),
        ("moment_N_m", Values::Vectors(acting.moments_n_m.clone())),
        ("air_force_N", Values::Vectors(acting.air_n.clone())),
    ];
    mesh
}

/// Closed surfaces of the bodies, with displacements from a state.
fn wing(scene: &Scene, frame: &Frame, state: &Frame) -> Mesh {
    let mut mesh = Mesh::default();
    let (mut strains, mut displacements, mut velocities, mut bodies) = (vec![], vec![], vec![], vec![]);
    for (index, body) in scene.bodies.iter().enumerate() {
        let begin = mesh.points_m.len();
        for ((section, start), rim_m) in frame.sections[index].iter().zip(&state.sections[index]).zip(&body.rims_m) {
            for &point in rim_m {
                let (position_m, velocity_m_s) = section.point(point);
                mesh.points_m.push(position_m);
                strains.push(section.axial_strain(point));
                displacements.push(position_m - start.point(point).0);
                velocities.push(velocity_m_s);
            }
        }
        mesh.cells.extend(skin(body, begin));
        bodies.resize(mesh.cells.len(), index as f64);
    }
    mesh.at_points = vec![
        ("axial_strain", Values::Scalars(strains)),
        ("displacement_m", Values::Vectors(displacements)),
        ("velocity_m_s", Values::Vectors(velocities)),
    ];
    mesh.at_cells = vec![("body", Values::Scalars(bodies))];
    mesh
}

/// Cells around a body whose first point has the index `begin`: the sides, and both ends.
fn skin(body: &BodyScene, begin: usize) -> Vec<Vec<usize>> {
    let around = body.rims_m[0].len();
    let point = |section: usize, i: usize| begin + section * around + i % around;
    let last = body.rims_m.len() - 1;
    let sides = (0..last).flat_map(|section| {
        (0..around).map(move |i| {
            vec![point(section, i), point(section, i + 1), point(section + 1, i + 1), point(section + 1, i)]
        })
    });
    let ends = [(0..around).rev().map(|i| point(0, i)).collect(), (0..around).map(|i| point(last, i)).collect()];
    sides.chain(ends).collect()
}

/// Lifting surfaces, one quadrilateral per strip.
fn surfaces(frame: &Frame) -> Mesh {
    let mut mesh = Mesh::default();
    let mut numbers = Vec::new();
    for (index, edges_m) in frame.edges_m.iter().enumerate() {
        mesh.add_grid(edges_m.iter().map(|edge| edge.to_vec()));
        numbers.resize(mesh.cells.len(), index as f64);
    }
    mesh.at_cells = vec![("surface", Values::Scalars(numbers))];
    mesh
}

/// Vortex rings of the wake.
fn wake(frame: &Frame) -> Mesh {
    let mut mesh = Mesh::default();
    let mut circulation = Vec::new();
    for surface in &frame.lattice {
        mesh.add_grid(surface.wake_node_m.iter().cloned());
        circulation.extend(surface.wake_circulation_m2_s.iter().flatten());
    }
    mesh.at_cells = vec![("circulation_m2_s", Values::Scalars(circulation))];
    mesh
}

impl Mesh {
    /// Adds a point as a vertex cell.
    fn add_vertex(&mut self, place_m: Vector3<f64>) {
        self.cells.push(vec![self.points_m.len()]);
        self.points_m.push(place_m);
    }

    /// Adds rows of points and the quadrilaterals between them, row by row.
    fn add_grid(&mut self, rows: impl Iterator<Item = Vec<Vector3<f64>>>) {
        let mut before: Option<usize> = None;
        for row in rows {
            let begin = self.points_m.len();
            let columns = row.len();
            self.points_m.extend(row);
            if let Some(last) = before {
                let cell = |i: usize| vec![last + i, last + i + 1, begin + i + 1, begin + i];
                self.cells.extend((0..columns.saturating_sub(1)).map(cell));
            }
            before = Some(begin);
        }
    }

    fn document(&self) -> String {
        let kind = |cell: &Vec<usize>| match cell.len() {
            1 => VERTEX,
            4 => QUADRILATERAL,
            _ => POLYGON,
        };
        let ends = self.cells.iter().scan(0, |end, cell| {
            *end += cell.len() as i64;
            Some(*end)
        });
        let corners = self.cells.iter().flatten().map(|corner| *corner as i64);
        let points = vectors(&self.points_m);
        let arrays =
            |values: &[(&str, Values)]| values.iter().map(|(name, values)| data(name, values)).collect::<String>();
        format!(
            "{BEGIN}<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\" \
             header_type=\"UInt32\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n\
             <Points>\n{}</Points>\n<Cells>\n{}{}{}</Cells>\n<PointData>\n{}</PointData>\n<CellData>\n{}</CellData>\n\
             </Piece>\n</UnstructuredGrid>\n</VTKFile>\n",
            self.points_m.len(),
            self.cells.len(),
            array("Float64", "points", 3, &points),
            array("Int64", "connectivity", 1, &corners.flat_map(i64::to_le_bytes).collect::<Vec<_>>()),
            array("Int64", "offsets", 1, &ends.flat_map(i64::to_le_bytes).collect::<Vec<_>>()),
            array("UInt8", "types", 1, &self.cells.iter().map(kind).collect::<Vec<_>>()),
            arrays(&self.at_points),
            arrays(&self.at_cells),
        )
    }
}

fn data(name: &str, values: &Values) -> String {
    match values {
        Values::Scalars(values) => {
            array("Float64", name, 1, &values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>())
        }
        Values::Vectors(values) => array("Float64", name, 3, &vectors(values)),
    }
}

fn vectors(values: &[Vector3<f64>]) -> Vec<u8> {
    values.iter().flat_map(|vector| vector.iter().copied()).flat_map(f64::to_le_bytes).collect()
}

fn array(kind: &str, name: &str, components: usize, bytes: &[u8]) -> String {
    let counted = [&(bytes.len() as u32).to_le_bytes(), bytes].concat();
    // readers interpret an array with an explicit number of components, even one, as a list of vectors
    let components = if components > 1 { format!(" NumberOfComponents=\"{components}\"") } else { String::new() };
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\"{components} format=\"binary\">\n{}\n</DataArray>\n",
        STANDARD.encode(counted)
    )
}
