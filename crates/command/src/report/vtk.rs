//! Frames as VTK files for ParaView: per body a closed surface with strain, displacement and velocity, the lifting
//! surfaces, the wake with its circulation; one `.vtu` file per time and a `.pvd` file that lists the times.
//!
//! The format is VTK's XML, binary in base64: little-endian, each array after its length in bytes (UInt32).

use crate::report::recording::{BodyScene, Frame, Recording, Scene};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nalgebra::Vector3;

/// How every file begins: with the declaration, and by whom it was written.
const BEGIN: &str = "<?xml version=\"1.0\"?>\n<!-- written by foldwing -->\n";
/// VTK's number of a quadrilateral.
const QUADRILATERAL: u8 = 9;
/// VTK's number of a polygon.
const POLYGON: u8 = 7;

/// Values of one array: scalars or vectors.
enum Values {
    Scalars(Vec<f64>),
    Vectors(Vec<Vector3<f64>>),
}

/// A surface of quadrilaterals and polygons with values at its points and cells.
#[derive(Default)]
struct Mesh {
    points_m: Vec<Vector3<f64>>,
    cells: Vec<Vec<usize>>,
    at_points: Vec<(&'static str, Values)>,
    at_cells: Vec<(&'static str, Values)>,
}

/// Hands the files of the series `wing`, and where there is air `surfaces` and `wake`, to `write` with their names.
///
/// # Errors
/// What `write` answers.
pub fn files<E>(recording: &Recording, mut write: impl FnMut(&str, String) -> Result<(), E>) -> Result<(), E> {
    let first = recording.frames.first();
    let wing = |frame: &Frame| wing(&recording.scene, frame, first.unwrap_or(frame));
    series("wing", recording, wing, &mut write)?;
    if first.is_some_and(|frame| !frame.edges_m.is_empty()) {
        series("surfaces", recording, surfaces, &mut write)?;
    }
    if first.is_some_and(|frame| !frame.lattice.is_empty()) {
        series("wake", recording, wake, &mut write)?;
    }
    Ok(())
}

fn series<E>(
    stem: &str,
    recording: &Recording,
    mesh: impl Fn(&Frame) -> Mesh,
    write: &mut impl FnMut(&str, String) -> Result<(), E>,
) -> Result<(), E> {
    let mut list = format!("{BEGIN}<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n");
    for (i, frame) in recording.frames.iter().enumerate() {
        let name = format!("{stem}_{i:04}.vtu");
        write(&name, mesh(frame).document())?;
        list += &format!("<DataSet timestep=\"{:?}\" part=\"0\" file=\"{name}\"/>\n", frame.time_s);
    }
    list += "</Collection>\n</VTKFile>\n";
    write(&format!("{stem}.pvd"), list)
}

/// Closed surfaces of the bodies; displacements from the first frame.
fn wing(scene: &Scene, frame: &Frame, first: &Frame) -> Mesh {
    let mut mesh = Mesh::default();
    let (mut strains, mut displacements, mut velocities, mut bodies) = (vec![], vec![], vec![], vec![]);
    for (index, body) in scene.bodies.iter().enumerate() {
        let begin = mesh.points_m.len();
        for ((section, start), rim_m) in frame.sections[index].iter().zip(&first.sections[index]).zip(&body.rims_m) {
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

/// Cells around a body whose points begin at an index: the sides, and both ends.
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

/// Rings of the wake.
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
        let kind = |cell: &Vec<usize>| if cell.len() == 4 { QUADRILATERAL } else { POLYGON };
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
    // readers take an array with a stated number of components, even of one, as a list of vectors
    let components = if components > 1 { format!(" NumberOfComponents=\"{components}\"") } else { String::new() };
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\"{components} format=\"binary\">\n{}\n</DataArray>\n",
        STANDARD.encode(counted)
    )
}
