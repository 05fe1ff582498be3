//! Run read from the data of the page (`packed.rs`) for images: named quantities, interpolated states between frames,
//! extents.

use super::outlines::{Aerofoil, Solid};
use crate::report::viewer::PackedRun;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nalgebra::Vector3;
use serde::Deserialize;
use serde::de::IgnoredAny;

/// Point or vector in m in the root frame.
pub(super) type Vector = Vector3<f64>;

/// Number of values of a section: position, axes y and z, velocity, four strain measures.
const PER_SECTION: usize = 16;
/// Number of values of a load station.
const PER_STATION: usize = 12;

/// Parts of the model that do not change during the run.
#[derive(Debug, Deserialize)]
pub(super) struct About {
    pub name: String,
    pub bodies: Vec<Body>,
    joints: Vec<IgnoredAny>,
    pub gauges: Vec<Gauge>,
    pub hinges: Vec<Hinge>,
    pub masses: Vec<Mass>,
    stations: Vec<IgnoredAny>,
    energies: Vec<IgnoredAny>,
    pub surfaces: Vec<Surface>,
    pub winds: usize,
    pub strips: usize,
    #[serde(rename = "edgeForces")]
    edge_forces: bool,
    #[serde(rename = "panelForces")]
    panel_forces: bool,
    pub aerofoils: Vec<Option<Aerofoil>>,
    pub solids: Vec<Solid>,
    wakes: Vec<usize>,
    begins: Vec<usize>,
    rows: Vec<Vec<usize>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Body {
    /// Points of the outline of every section in m: 4 for a rectangle, more for an ellipse.
    pub rims: Vec<Vec<[f64; 2]>>,
    pub places: Vec<f64>,
    pub rigid: bool,
    loaded: bool,
    carrier: Option<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Gauge {
    pub body: usize,
}

#[derive(Debug, Deserialize)]
pub(super) struct Hinge {
    pub body: usize,
    pub kind: String,
    axis: [f64; 3],
    pub freedom: Option<usize>,
    pub latch: bool,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mass {
    pub body: usize,
    pub place: f64,
    offset: [f64; 3],
    pub kg: f64,
}

#[derive(Debug, Deserialize)]
pub(super) struct Surface {
    pub body: usize,
    pub columns: usize,
    pub panels: usize,
    pub places: Vec<f64>,
}

/// Offsets of the parts of a frame in its array of numbers.
#[derive(Debug)]
struct Layout {
    latched: usize,
    strains: usize,
    gauges: usize,
    bodies: Vec<usize>,
    surfaces: Vec<usize>,
    gravity: usize,
    winds: usize,
    strips: usize,
    length: usize,
}

/// Run with its frames.
#[derive(Debug)]
pub(super) struct Run {
    pub about: About,
    numbers: Vec<f32>,
    layout: Layout,
}

/// State of the model at one time. Between two frames all quantities are interpolated, except latches and the wake.
pub(super) struct State<'r> {
    run: &'r Run,
    present: Vec<f64>,
    frame: usize,
}

/// Section of a body: its point on the body axis, its axes y and z, and the strain measures `(γ, κx, κy, κz)`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Section {
    pub at: Vector,
    pub y: Vector,
    pub z: Vector,
    pub measures: [f64; 4],
}

/// Wake of a surface: nodes in rows, and the circulation of the vortex rings between them.
pub(super) struct Wake<'r> {
    numbers: &'r [f32],
    pub rows: usize,
    pub columns: usize,
}

impl Section {
    /// Position of a point of the section.
    pub fn point(&self, [y, z]: [f64; 2]) -> Vector {
        self.at + y * self.y + z * self.z
    }

    /// Longitudinal strain at a point of the section.
    pub fn strain(&self, [y, z]: [f64; 2]) -> f64 {
        self.measures[0] + z * self.measures[2] - y * self.measures[3]
    }

    /// Axis x of the section.
    pub fn x(&self) -> Vector {
        self.y.cross(&self.z)
    }
}

impl Wake<'_> {
    /// Position of a node of the wake.
    pub fn node(&self, row: usize, column: usize) -> Vector {
        let first = 3 * (row * self.columns + column);
        Vector::new(self.numbers[first].into(), self.numbers[first + 1].into(), self.numbers[first + 2].into())
    }

    /// Circulation of a vortex ring in m²/s.
    pub fn circulation(&self, row: usize, column: usize) -> f64 {
        let rings = 3 * (self.rows + 1) * self.columns;
        self.numbers[rings + row * (self.columns - 1) + column].into()
    }
}

impl Layout {
    fn of(about: &About) -> Self {
        let mut next = 0;
        let mut take = |count: usize| {
            next += count;
            next - count
        };
        take(1 + about.joints.len());
        let latched = take(about.joints.len());
        let strains = take(about.gauges.len());
        take(about.energies.len());
        let gauges = take(3 * about.gauges.len());
        let bodies = about.bodies.iter().map(|body| take(PER_SECTION * body.rims.len())).collect();
        let surfaces = about.surfaces.iter().map(|surface| take(6 * surface.columns)).collect();
        take(PER_STATION * about.stations.len() + 6 * about.bodies.len());
        let gravity = take(3);
        let winds = take(3 * about.winds);
        let strips = take(about.strips);
        // internal loads and aerodynamic forces, which videos do not show
        take(about.bodies.iter().filter(|body| body.loaded).map(|body| 6 * body.rims.len()).sum());
        if about.edge_forces {
            take(about.surfaces.iter().map(|surface| 3 * surface.columns).sum());
        }
        if about.panel_forces {
            take(about.surfaces.iter().map(|surface| surface.panels * (surface.columns - 1)).sum());
        }
        let length = take(0);
        Self { latched, strains, gauges, bodies, surfaces, gravity, winds, strips, length }
    }
}

impl Run {
    /// Reads a run from the data of a page.
    ///
    /// # Errors
    /// The description and the numbers are inconsistent.
    pub fn read(packed: &PackedRun) -> Result<Self, String> {
        let torn = |what: &str| format!("the data of the page are damaged ({what}); write the page again");
        let about: About = serde_json::from_str(&packed.description).map_err(|error| torn(&error.to_string()))?;
        let bytes = STANDARD.decode(&packed.numbers).map_err(|error| torn(&error.to_string()))?;
        let numbers: Vec<f32> =
            bytes.chunks_exact(4).map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]])).collect();
        let layout = Layout::of(&about);
        let run = Self { about, numbers, layout };
        run.check().map_err(torn)?;
        Ok(run)
    }

    /// Checks that all data that are read later exist.
    fn check(&self) -> Result<(), &'static str> {
        let about = &self.about;
        let even = |body: &Body| {
            let around = body.rims.first().map_or(0, Vec::len);
            around > 0 && body.rims.len() == body.places.len() && body.rims.iter().all(|rim| rim.len() == around)
        };
        if about.begins.is_empty() || about.begins.len() != about.rows.len() {
            return Err("frames");
        }
        if about.bodies.is_empty() || !about.bodies.iter().all(even) || about.winds > about.bodies.len() {
            return Err("bodies");
        }
        let bodies = about.gauges.iter().map(|gauge| gauge.body).chain(about.hinges.iter().map(|hinge| hinge.body));
        let bodies = bodies.chain(about.masses.iter().map(|mass| mass.body));
        let mut bodies = bodies.chain(about.surfaces.iter().map(|surface| surface.body));
        if bodies.any(|body| body >= about.bodies.len()) {
            return Err("parts of bodies that do not exist");
        }
        let strips: usize = about.surfaces.iter().map(|surface| surface.columns.saturating_sub(1)).sum();
        let freedoms = about.hinges.iter().filter_map(|hinge| hinge.freedom);
        if about.surfaces.iter().any(|surface| surface.columns < 2 || surface.panels > 10_000)
            || (about.strips > 0 && about.strips != strips)
            || !freedoms.into_iter().all(|freedom| freedom < about.joints.len())
        {
            return Err("surfaces or joints");
        }
        let fit = |(surface, aerofoil): (&Surface, &Option<Aerofoil>)| {
            aerofoil.as_ref().is_none_or(|own| own.fits(surface.columns))
        };
        if about.aerofoils.len() != about.surfaces.len()
            || !about.surfaces.iter().zip(&about.aerofoils).all(fit)
            || !about.solids.iter().all(|solid| solid.is_on_one_of(about.bodies.len()))
        {
            return Err("aerofoils or solids");
        }
        for (begin, rows) in about.begins.iter().zip(&about.rows) {
            let wakes = about.wakes.iter().zip(rows);
            let wake: usize = wakes.map(|(columns, rows)| wake_size(*rows, *columns)).sum();
            let end = begin.checked_add(self.layout.length).and_then(|end| end.checked_add(wake));
            if rows.len() != about.wakes.len() || end.is_none_or(|end| end > self.numbers.len()) {
                return Err("numbers of a frame");
            }
        }
        let times = (0..self.count()).map(|frame| self.time_of(frame)).collect::<Vec<_>>();
        if times.windows(2).any(|pair| pair[1] < pair[0]) || !times.iter().all(|time_s| time_s.is_finite()) {
            return Err("times");
        }
        Ok(())
    }

    /// Number of frames.
    pub fn count(&self) -> usize {
        self.about.begins.len()
    }

    /// Time of a frame in s: the shortest decimal number with the same single-precision value, such as 0.4.
    fn time_of(&self, frame: usize) -> f64 {
        let recorded = self.numbers[self.about.begins[frame]];
        recorded.to_string().parse().unwrap_or_else(|_| recorded.into())
    }

    /// First and last time in s.
    pub fn span_s(&self) -> [f64; 2] {
        [self.time_of(0), self.time_of(self.count() - 1)]
    }

    /// State at a frame.
    pub fn at_frame(&self, frame: usize) -> State<'_> {
        self.between(frame, 0.0)
    }

    /// State at a time; before the first and after the last frame, the state of that frame.
    pub fn at(&self, time_s: f64) -> State<'_> {
        let (mut low, mut high) = (0, self.count() - 1);
        if time_s <= self.time_of(low) || low == high {
            return self.between(low, 0.0);
        }
        if time_s >= self.time_of(high) {
            return self.between(high, 0.0);
        }
        while high - low > 1 {
            let middle = (low + high) / 2;
            if self.time_of(middle) <= time_s { low = middle } else { high = middle }
        }
        let (from_s, to_s) = (self.time_of(low), self.time_of(high));
        self.between(low, (time_s - from_s) / (to_s - from_s))
    }

    fn between(&self, frame: usize, share: f64) -> State<'_> {
        let part = |frame: usize| &self.numbers[self.about.begins[frame]..][..self.layout.length];
        let (before, after) = (part(frame), part((frame + 1).min(self.count() - 1)));
        let mut present: Vec<f64> = before
            .iter()
            .zip(after)
            .map(|(before, after)| f64::from(*before) + share * (f64::from(*after) - f64::from(*before)))
            .collect();
        for joint in self.layout.latched..self.layout.strains {
            present[joint] = before[joint].into();
        }
        State { run: self, present, frame }
    }

    /// Frames at equal intervals, at most `most`, including the first and the last.
    pub fn sampled(&self, most: usize) -> impl Iterator<Item = State<'_>> {
        let (last, count) = (self.count() - 1, self.count().min(most.max(2)));
        (0..count).map(move |i| self.at_frame(last * i / (count - 1).max(1)))
    }

    /// Returns whether a body that is attached to no other moves by more than half the model's size.
    pub fn flies_away(&self) -> bool {
        let (first, last) = (self.at_frame(0), self.at_frame(self.count() - 1));
        let extent = Extents::of(first.points().into_iter()).size();
        let mut free = self.about.bodies.iter().enumerate().filter(|(_, body)| body.carrier.is_none());
        free.any(|(body, _)| (last.section(body, 0).at - first.section(body, 0).at).norm() > 0.5 * extent)
    }
}

/// Number of values of a wake.
fn wake_size(rows: usize, columns: usize) -> usize {
    (3 * (rows + 1)).saturating_mul(columns).saturating_add(rows.saturating_mul(columns.saturating_sub(1)))
}

impl State<'_> {
    fn vector(&self, place: usize) -> Vector {
        Vector::new(self.present[place], self.present[place + 1], self.present[place + 2])
    }

    /// Section of a body, with axes normalised again.
    pub fn section(&self, body: usize, index: usize) -> Section {
        let place = self.run.layout.bodies[body] + PER_SECTION * index;
        let unit = |axis: Vector| axis.try_normalize(0.0).unwrap_or(axis);
        Section {
            at: self.vector(place),
            y: unit(self.vector(place + 3)),
            z: unit(self.vector(place + 6)),
            measures: std::array::from_fn(|i| self.present[place + 12 + i]),
        }
    }

    /// Section at the middle of a body's length.
    pub fn middle_section(&self, body: usize) -> Section {
        self.section(body, self.run.about.bodies[body].rims.len() / 2)
    }

    /// Outer end of a body.
    pub fn body_end(&self, body: usize) -> Vector {
        self.section(body, self.run.about.bodies[body].rims.len() - 1).at
    }

    /// Point mass: its point on the body axis, and the position of the mass.
    pub fn mass(&self, mass: &Mass) -> [Vector; 2] {
        let places = &self.run.about.bodies[mass.body].places;
        let after = places.iter().position(|place| *place >= mass.place).unwrap_or(places.len() - 1).max(1);
        let section = if places.len() == 1 {
            self.section(mass.body, 0)
        } else {
            let share = (mass.place - places[after - 1]) / (places[after] - places[after - 1]);
            let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
            let [a, b] = [after - 1, after].map(|index| self.section(mass.body, index));
            let mix = |a: Vector, b: Vector| a + share * (b - a);
            let unit = |axis: Vector| axis.try_normalize(0.0).unwrap_or(axis);
            Section { at: mix(a.at, b.at), y: unit(mix(a.y, b.y)), z: unit(mix(a.z, b.z)), measures: a.measures }
        };
        let [x, y, z] = mass.offset;
        [section.at, section.at + x * section.x() + y * section.y + z * section.z]
    }

    /// Axis of a joint with one degree of freedom, in the root frame.
    pub fn axis(&self, hinge: &Hinge) -> Option<Vector> {
        let (section, [x, y, z]) = (self.section(hinge.body, 0), hinge.axis);
        (x * section.x() + y * section.y + z * section.z).try_normalize(1e-12)
    }

    /// Returns whether the latch of a joint with one degree of freedom is closed.
    pub fn latched(&self, freedom: usize) -> bool {
        self.present[self.run.layout.latched + freedom] > 0.5
    }

    /// Corner of a strip: edge 0 is the leading edge, 1 the trailing edge.
    pub fn corner(&self, surface: usize, column: usize, edge: usize) -> Vector {
        self.vector(self.run.layout.surfaces[surface] + 6 * column + 3 * edge)
    }

    /// Circulation of a strip in m²/s; strips are numbered over all surfaces.
    pub fn circulation(&self, strip: usize) -> f64 {
        self.present[self.run.layout.strips + strip]
    }

    /// Position of a gauge.
    pub fn gauge(&self, gauge: usize) -> Vector {
        self.vector(self.run.layout.gauges + 3 * gauge)
    }

    /// Strain at a gauge.
    pub fn strain(&self, gauge: usize) -> f64 {
        self.present[self.run.layout.strains + gauge]
    }

    /// Gravity minus the acceleration of the root, in m/s².
    pub fn gravity_m_s2(&self) -> Vector {
        self.vector(self.run.layout.gravity)
    }

    /// Undisturbed wind at the middle of a body in m/s.
    pub fn wind_m_s(&self, body: usize) -> Vector {
        self.vector(self.run.layout.winds + 3 * body)
    }

    /// Wakes of the last frame at or before this time.
    pub fn wakes(&self) -> Vec<Wake<'_>> {
        let (about, numbers) = (&self.run.about, &self.run.numbers);
        let mut place = about.begins[self.frame] + self.run.layout.length;
        let mut next = |columns: usize, rows: usize| {
            let size = wake_size(rows, columns);
            place += size;
            Wake { numbers: &numbers[place - size..place], rows, columns }
        };
        about.wakes.iter().zip(&about.rows[self.frame]).map(|(columns, rows)| next(*columns, *rows)).collect()
    }

    /// Number of the last frame at or before this time.
    pub fn frame(&self) -> usize {
        self.frame
    }

    /// Points of the model: outlines of its sections, corners of its surfaces, masses.
    pub fn points(&self) -> Vec<Vector> {
        let about = &self.run.about;
        let mut points = Vec::new();
        for (b, body) in about.bodies.iter().enumerate() {
            for (i, rim) in body.rims.iter().enumerate() {
                let section = self.section(b, i);
                points.extend(rim.iter().map(|point| section.point(*point)));
            }
        }
        for (i, surface) in about.surfaces.iter().enumerate() {
            points.extend((0..2 * surface.columns).map(|corner| self.corner(i, corner / 2, corner % 2)));
        }
        points.extend(about.masses.iter().map(|mass| self.mass(mass)[1]));
        points
    }

    /// Mean position of all sections.
    pub fn middle(&self) -> Vector {
        let sections = self.run.about.bodies.iter().enumerate();
        let places: Vec<Vector> =
            sections.flat_map(|(b, body)| (0..body.rims.len()).map(move |i| self.section(b, i).at)).collect();
        places.iter().sum::<Vector>() / places.len() as f64
    }
}

/// Box around points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extents {
    pub least: Vector,
    pub most: Vector,
}

impl Extents {
    /// Creates the box around points.
    pub fn of(points: impl Iterator<Item = Vector>) -> Self {
        let none = Self { least: Vector::repeat(f64::INFINITY), most: Vector::repeat(f64::NEG_INFINITY) };
        points.fold(none, |Self { least, most }, point| Self { least: least.inf(&point), most: most.sup(&point) })
    }

    /// Diagonal of the box in m.
    pub fn size(&self) -> f64 {
        let size = (self.most - self.least).norm();
        if size.is_finite() { size.max(1e-6) } else { 1.0 }
    }
}
