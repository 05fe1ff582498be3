//! Wind from files: full-field files of TurbSim and Bladed, and tables over time at hub height.

use crate::station_table::without_mark;
use foldwing_engine::aero::rotor::turbulence_box::TurbulenceBox;
use foldwing_engine::aero::rotor::wind::{TableRow, WindTable};

/// Maximum number of velocities in a field, which then takes 1.2 GB.
const MAXIMUM_VELOCITIES: usize = 100_000_000;

/// Error in a wind file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WindFault {
    /// The file is shorter than its header implies.
    #[error("truncated: {what} needs {needed} bytes, the file has {length}; fetch or generate the whole file again")]
    CutShort {
        /// Part that was being read.
        what: String,
        /// Number of bytes that the file needs.
        needed: usize,
        /// Number of bytes that it has.
        length: usize,
    },
    /// A value is impossible.
    #[error("{what} is {value}; {allowed}")]
    Value {
        /// Name of the field.
        what: &'static str,
        /// Its value.
        value: String,
        /// Allowed values.
        allowed: &'static str,
    },
    /// A line of a table cannot be read.
    #[error("line {line}: {reason}")]
    Line {
        /// Line, numbered from 1.
        line: usize,
        /// Cause of the error.
        reason: String,
    },
}

/// Little-endian bytes of a file, read in order.
struct Bytes<'a> {
    bytes: &'a [u8],
    place: usize,
}

impl Bytes<'_> {
    fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N], WindFault> {
        let end = self.place + N;
        let Some(Ok(found)) = self.bytes.get(self.place..end).map(<[u8; N]>::try_from) else {
            return Err(WindFault::CutShort { what: what.to_owned(), needed: end, length: self.bytes.len() });
        };
        self.place = end;
        Ok(found)
    }

    fn short(&mut self, what: &str) -> Result<i16, WindFault> {
        self.take(what).map(i16::from_le_bytes)
    }

    fn integer(&mut self, what: &str) -> Result<i32, WindFault> {
        self.take(what).map(i32::from_le_bytes)
    }

    fn real(&mut self, what: &str) -> Result<f64, WindFault> {
        self.take(what).map(|bytes| f64::from(f32::from_le_bytes(bytes)))
    }

    fn skip(&mut self, count: usize, what: &str) -> Result<(), WindFault> {
        self.remain(count, what)?;
        self.place += count;
        Ok(())
    }

    /// Checks that a number of bytes remain.
    fn remain(&self, count: usize, what: &str) -> Result<(), WindFault> {
        let needed = self.place.saturating_add(count);
        if needed <= self.bytes.len() {
            return Ok(());
        }
        Err(WindFault::CutShort { what: what.to_owned(), needed, length: self.bytes.len() })
    }
}

fn points(what: &'static str, value: i32) -> Result<usize, WindFault> {
    let fine = usize::try_from(value).ok().filter(|value| (2..=10_000_000).contains(value));
    fine.ok_or(WindFault::Value { what, value: value.to_string(), allowed: "a whole number of at least 2" })
}

fn positive(what: &'static str, value: f64) -> Result<f64, WindFault> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(WindFault::Value { what, value: value.to_string(), allowed: "a finite number > 0" })
}

fn volume(planes: usize, upward: usize, across: usize) -> Result<usize, WindFault> {
    let count = planes.saturating_mul(upward).saturating_mul(across);
    if count <= MAXIMUM_VELOCITIES {
        return Ok(count);
    }
    let allowed = "at most 1e8 velocities; use a coarser grid or a shorter time";
    Err(WindFault::Value { what: "planes times points", value: count.to_string(), allowed })
}

/// Reads a full-field file of TurbSim, `.bts`, with identifier 7, or 8 if it is periodic. Points of a tower below the grid are ignored.
///
/// # Errors
/// A truncated file, another identifier, grids of zero size, scales of zero, more than 1e8 velocities, or surplus bytes.
pub fn read_turbsim(bytes: &[u8]) -> Result<TurbulenceBox, WindFault> {
    let mut file = Bytes { bytes, place: 0 };
    let identifier = file.short("identifier")?;
    if !matches!(identifier, 7 | 8) {
        let allowed = "7 or 8 in a full field of TurbSim (.bts), -99 in one of Bladed (.wnd)";
        return Err(WindFault::Value { what: "identifier", value: identifier.to_string(), allowed });
    }
    let upward = points("points upward", file.integer("points upward")?)?;
    let across = points("points across", file.integer("points across")?)?;
    let tower = file.integer("points of the tower")?;
    let tower = usize::try_from(tower).ok().filter(|tower| *tower < 100_000).ok_or(WindFault::Value {
        what: "points of the tower",
        value: tower.to_string(),
        allowed: "a whole number of at least 0",
    })?;
    let planes = points("planes", file.integer("planes")?)?;
    let upward_m = positive("distance upward", file.real("distance upward")?)?;
    let across_m = positive("distance across", file.real("distance across")?)?;
    let plane_interval_s = positive("time between planes", file.real("time between planes")?)?;
    let carried_m_s = positive("mean wind", file.real("mean wind")?)?;
    positive("hub height", file.real("hub height")?)?;
    let bottom_m = file.real("bottom of the grid")?;
    let mut scales = [[0.0; 2]; 3];
    for scale in &mut scales {
        let slope = file.real("scales")?;
        if !(slope != 0.0 && slope.is_finite()) {
            return Err(WindFault::Value {
                what: "scale of velocities",
                value: slope.to_string(),
                allowed: "a finite number that is not 0",
            });
        }
        *scale = [slope, file.real("scales")?];
    }
    let letters = file.integer("length of the description")?;
    let letters = usize::try_from(letters).ok().filter(|letters| *letters <= 100_000).ok_or(WindFault::Value {
        what: "length of the description",
        value: letters.to_string(),
        allowed: "a whole number from 0 to 100000",
    })?;
    file.skip(letters, "the description")?;
    let count = volume(planes, upward, across)?;
    let plane_bytes = 6 * (upward * across + tower);
    file.remain(planes * plane_bytes, "the velocities")?;
    let mut velocity_m_s = Vec::with_capacity(count);
    for _ in 0..planes {
        for _ in 0..upward * across {
            let mut velocity = [0f32; 3];
            for (velocity, [slope, offset]) in velocity.iter_mut().zip(scales) {
                *velocity = ((f64::from(file.short("the velocities")?) - offset) / slope) as f32;
            }
            velocity_m_s.push(velocity);
        }
        file.skip(6 * tower, "the tower")?;
    }
    left_over(&file)?;
    Ok(TurbulenceBox {
        across,
        upward,
        planes,
        across_m,
        upward_m,
        plane_interval_s,
        bottom_m,
        carried_m_s,
        periodic: identifier == 8,
        velocity_m_s,
    })
}

/// Settings that Bladed's `.wnd` files lack; TurbSim and Bladed write them to a separate text file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BladedSettings {
    /// Height of the middle of the grid above ground in m.
    pub middle_height_m: f64,
    /// Whether lateral points are stored from port to starboard (`CLOCKWISE` in the `.sum` file), as by TurbSim.
    pub from_port: bool,
}

/// Reads a full-field file in Bladed's format, `.wnd`, with three components: turbulence model 4, as written by TurbSim. Velocities along
/// the wind are the mean plus the turbulence, without shear; the field is periodic.
///
/// # Errors
/// A truncated file, another model, grids of zero size, invalid intensities, more than 1e8 velocities, or surplus bytes.
pub fn read_bladed(bytes: &[u8], settings: BladedSettings) -> Result<TurbulenceBox, WindFault> {
    let mut file = Bytes { bytes, place: 0 };
    let identifier = file.short("identifier")?;
    if identifier != -99 {
        let allowed = "-99: a full field of Bladed (.wnd)";
        return Err(WindFault::Value { what: "identifier", value: identifier.to_string(), allowed });
    }
    let model = file.short("model of turbulence")?;
    if model != 4 {
        let allowed = "4: what TurbSim writes, and Bladed for its improved von Karman spectra";
        return Err(WindFault::Value { what: "model of turbulence", value: model.to_string(), allowed });
    }
    let components = file.integer("components")?;
    if components != 3 {
        return Err(WindFault::Value { what: "components", value: components.to_string(), allowed: "3" });
    }
    let mut intensities = [0.0; 3];
    file.skip(12, "latitude, roughness and height")?;
    for intensity in &mut intensities {
        *intensity = file.real("intensities")?;
    }
    let upward_m = positive("distance upward", file.real("distance upward")?)?;
    let across_m = positive("distance across", file.real("distance across")?)?;
    let plane_m = positive("distance of planes", file.real("distance of planes")?)?;
    let planes = points("planes", file.integer("half the planes")?.saturating_mul(2))?;
    let carried_m_s = positive("mean wind", file.real("mean wind")?)?;
    file.skip(12, "length scales along the wind")?;
    file.skip(8, "seed")?;
    let upward = points("points upward", file.integer("points upward")?)?;
    let across = points("points across", file.integer("points across")?)?;
    file.skip(24, "length scales across the wind")?;
    if let Some(bad) = intensities.iter().find(|value| !(value.is_finite() && **value >= 0.0)) {
        return Err(WindFault::Value {
            what: "intensity",
            value: bad.to_string(),
            allowed: "a finite number >= 0, in per cent",
        });
    }
    let count = volume(planes, upward, across)?;
    file.remain(6 * count, "the velocities")?;
    let mut velocity_m_s = vec![[0f32; 3]; count];
    for row in 0..planes * upward {
        for point in 0..across {
            let place = if settings.from_port { across - 1 - point } else { point };
            let velocity = &mut velocity_m_s[row * across + place];
            for (axis, value) in velocity.iter_mut().enumerate() {
                let turbulence =
                    carried_m_s * intensities[axis] / 100.0 * f64::from(file.short("the velocities")?) / 1000.0;
                *value = (if axis == 0 { carried_m_s + turbulence } else { turbulence }) as f32;
            }
        }
    }
    left_over(&file)?;
    Ok(TurbulenceBox {
        across,
        upward,
        planes,
        across_m,
        upward_m,
        plane_interval_s: plane_m / carried_m_s,
        bottom_m: settings.middle_height_m - 0.5 * (upward - 1) as f64 * upward_m,
        carried_m_s,
        periodic: true,
        velocity_m_s,
    })
}

/// Reads a full-field file of TurbSim or Bladed, distinguished by its first two bytes; `settings` apply to a file of Bladed.
///
/// # Errors
/// As for [`read_turbsim`] and [`read_bladed`].
pub fn read_field(bytes: &[u8], settings: BladedSettings) -> Result<TurbulenceBox, WindFault> {
    if is_bladed(bytes) { read_bladed(bytes, settings) } else { read_turbsim(bytes) }
}

/// Returns whether bytes are the start of a full-field file of Bladed.
pub(crate) fn is_bladed(bytes: &[u8]) -> bool {
    bytes.starts_with(&(-99i16).to_le_bytes())
}

fn left_over(file: &Bytes) -> Result<(), WindFault> {
    let rest = file.bytes.len() - file.place;
    if rest == 0 {
        return Ok(());
    }
    let allowed = "0: the header and the velocities do not belong together";
    Err(WindFault::Value { what: "bytes after the velocities", value: rest.to_string(), allowed })
}

/// Reads a table over time in AeroDyn's uniform wind format: time in s, horizontal speed in m/s, direction in deg, vertical speed in m/s,
/// horizontal linear, vertical power-law and vertical linear shear, gust in m/s; comments start with `!` or `#`. A ninth column (upflow
/// angle) must be zero.
///
/// # Errors
/// Lines with too few columns, numbers that are not finite, times that do not ascend, no rows, or a reference length that is not positive.
pub fn read_wind_table(text: &str, reference_length_m: f64) -> Result<WindTable, WindFault> {
    positive("reference length", reference_length_m)?;
    let mut rows: Vec<TableRow> = Vec::new();
    for (index, line) in without_mark(text).lines().enumerate() {
        let line_number = index + 1;
        let fault = |reason: String| WindFault::Line { line: line_number, reason };
        let code = line.split(['!', '#']).next().unwrap_or_default().trim();
        if code.is_empty() {
            continue;
        }
        let fields: Vec<&str> = code.split([' ', '\t', ',']).filter(|field| !field.is_empty()).collect();
        let mut values = [0.0; 9];
        if !(8..=9).contains(&fields.len()) {
            let reason = format!(
                "{} columns; needed are 8: time, speed, direction, vertical speed, horizontal shear, power-law exponent, vertical shear, gust",
                fields.len()
            );
            return Err(fault(reason));
        }
        for (value, field) in values.iter_mut().zip(&fields) {
            *value = field
                .parse()
                .ok()
                .filter(|value: &f64| value.is_finite())
                .ok_or_else(|| fault(format!("{field:?} is not a finite number")))?;
        }
        if values[8] != 0.0 {
            return Err(fault(format!(
                "an upflow angle of {} deg; only 0 is supported: give the vertical speed",
                values[8]
            )));
        }
        if let Some(last) = rows.last().filter(|last| last.time_s >= values[0]) {
            return Err(fault(format!("the time {} s after {} s; times must ascend", values[0], last.time_s)));
        }
        rows.push(TableRow {
            time_s: values[0],
            speed_m_s: values[1],
            direction_rad: values[2].to_radians(),
            vertical_m_s: values[3],
            horizontal_shear: values[4],
            power_exponent: values[5],
            vertical_shear: values[6],
            gust_m_s: values[7],
        });
    }
    if rows.is_empty() {
        return Err(WindFault::Line { line: text.lines().count() + 1, reason: "a table without rows".to_owned() });
    }
    Ok(WindTable { reference_length_m, rows })
}

/// Returns a full-field file in TurbSim's format (`.bts`), for use in other programs. Velocities are stored with a resolution of 1/65535 of
/// each component's range.
pub fn write_turbsim(grid: &TurbulenceBox, hub_height_m: f64) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(100 + 6 * grid.velocity_m_s.len());
    bytes.extend(if grid.periodic { 8i16 } else { 7 }.to_le_bytes());
    for count in [grid.upward, grid.across, 0, grid.planes] {
        bytes.extend((count as i32).to_le_bytes());
    }
    for value in [grid.upward_m, grid.across_m, grid.plane_interval_s, grid.carried_m_s, hub_height_m, grid.bottom_m] {
        bytes.extend((value as f32).to_le_bytes());
    }
    let scales: [[f32; 2]; 3] = std::array::from_fn(|axis| {
        let values = || grid.velocity_m_s.iter().map(|velocity| velocity[axis]);
        let (low, high) = (values().fold(f32::INFINITY, f32::min), values().fold(f32::NEG_INFINITY, f32::max));
        let slope = if high > low { 65535.0 / (high - low) } else { 1.0 };
        [slope, -32768.0 - slope * low]
    });
    scales.iter().flatten().for_each(|value| bytes.extend(value.to_le_bytes()));
    let description = b"Foldwing: Kaimal spectra, exponential coherence";
    bytes.extend((description.len() as i32).to_le_bytes());
    bytes.extend(description);
    for velocity in &grid.velocity_m_s {
        for (value, [slope, offset]) in velocity.iter().zip(scales) {
            let raw = (f64::from(*value) * f64::from(slope) + f64::from(offset)).round().clamp(-32768.0, 32767.0);
            bytes.extend((raw as i16).to_le_bytes());
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> TurbulenceBox {
        let (across, upward, planes) = (3, 2, 4);
        let velocity_m_s = (0..across * upward * planes)
            .map(|i| [10.0 + (i as f32).sin(), (i as f32).cos(), -0.25 * (2.0 * i as f32).sin()])
            .collect();
        TurbulenceBox {
            across,
            upward,
            planes,
            across_m: 5.0,
            upward_m: 4.0,
            plane_interval_s: 0.25,
            bottom_m: 80.0,
            carried_m_s: 10.0,
            periodic: true,
            velocity_m_s,
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let grid = grid();
        let read = read_turbsim(&write_turbsim(&grid, 82.0)).unwrap();
        assert_eq!((read.across, read.upward, read.planes, read.periodic), (3, 2, 4, true));
        assert_eq!((read.across_m, read.upward_m, read.plane_interval_s, read.bottom_m), (5.0, 4.0, 0.25, 80.0));
        for (a, b) in grid.velocity_m_s.iter().zip(&read.velocity_m_s) {
            for axis in 0..3 {
                assert!((a[axis] - b[axis]).abs() < 2e-5, "{a:?} {b:?}"); // half a step of a range of 2
            }
        }
    }

    /// A file truncated at any byte, or with one surplus byte, gives this error message.
    #[test]
    fn files_cut_short_are_refused_at_every_byte() {
        let bytes = write_turbsim(&grid(), 82.0);
        for length in 0..bytes.len() {
            let fault = read_turbsim(&bytes[..length]).unwrap_err();
            assert!(matches!(fault, WindFault::CutShort { .. }), "{length}: {fault}");
            assert!(fault.to_string().starts_with("truncated"));
        }
        let longer: Vec<u8> = bytes.iter().copied().chain([0]).collect();
        assert!(read_turbsim(&longer).unwrap_err().to_string().starts_with("bytes after the velocities is 1"));
        let with = |place: usize, new: &[u8]| {
            let mut changed = bytes.clone();
            changed[place..place + new.len()].copy_from_slice(new);
            read_turbsim(&changed).unwrap_err().to_string()
        };
        assert!(with(0, &9i16.to_le_bytes()).starts_with("identifier is 9"));
        assert!(with(2, &(-3i32).to_le_bytes()).starts_with("points upward is -3"));
        assert!(with(2, &i32::MAX.to_le_bytes()).starts_with("points upward is 2147483647"));
        assert!(with(10, &(-1i32).to_le_bytes()).starts_with("points of the tower is -1"));
        assert!(with(14, &9_999_999i32.to_le_bytes()).starts_with("truncated"));
        assert!(with(18, &f32::NAN.to_le_bytes()).starts_with("distance upward is NaN"));
        assert!(with(42, &0f32.to_le_bytes()).starts_with("scale of velocities is 0"));
    }

    /// Every header number that must be positive is reported by name if it is invalid.
    #[test]
    fn numbers_of_the_header_are_refused_by_their_names() {
        let bytes = write_turbsim(&grid(), 82.0);
        let places = ["distance upward", "distance across", "time between planes", "mean wind", "hub height"];
        for (i, what) in places.into_iter().enumerate() {
            for value in [0f32, -1.0, f32::INFINITY] {
                let mut changed = bytes.clone();
                changed[18 + 4 * i..22 + 4 * i].copy_from_slice(&value.to_le_bytes());
                let fault = read_turbsim(&changed).unwrap_err();
                assert_eq!(fault.to_string(), positive(what, f64::from(value)).unwrap_err().to_string());
                assert!(fault.to_string().starts_with(&format!("{what} is {value}")), "{fault}");
            }
        }
        for (place, what) in [(2, "points upward"), (6, "points across"), (10, "points of the tower"), (14, "planes")] {
            let mut changed = bytes.clone();
            changed[place..place + 4].copy_from_slice(&(-7i32).to_le_bytes());
            let fault = read_turbsim(&changed).unwrap_err().to_string();
            assert!(fault.starts_with(&format!("{what} is -7")), "{fault}");
        }
    }

    /// In a Bladed field the spacing of the planes in m is divided by the mean wind speed to obtain a time.
    #[test]
    fn planes_of_bladed_pass_with_the_mean_wind() {
        let real = |value: &f32| value.to_le_bytes();
        let whole = |value: &i32| value.to_le_bytes();
        let mut bytes: Vec<u8> = [(-99i16).to_le_bytes(), 4i16.to_le_bytes()].concat();
        bytes.extend(whole(&3));
        // latitude, roughness, height; intensities in per cent; vertical, lateral and longitudinal spacing
        bytes.extend([0f32, 0.0, 0.0, 20.0, 10.0, 5.0, 4.0, 5.0, 2.5].iter().flat_map(real));
        bytes.extend(whole(&2)); // half the number of planes
        bytes.extend([12.5f32, 0.0, 0.0, 0.0].iter().flat_map(real)); // mean wind speed, length scales
        bytes.extend([0, 1, 3, 2].iter().flat_map(whole)); // seed, number of vertical and lateral points
        bytes.extend([0u8; 24]);
        bytes.extend((0..24).flat_map(|i| [i, 2000i16, -1000]).flat_map(i16::to_le_bytes));
        let field = read_bladed(&bytes, BladedSettings { middle_height_m: 90.0, from_port: false }).unwrap();
        assert_eq!((field.planes, field.upward, field.across, field.bottom_m), (4, 3, 2, 86.0));
        assert_eq!((field.carried_m_s, field.plane_interval_s), (12.5, 0.2));
        assert_eq!(field.velocity_m_s[20], [12.55, 2.5, -0.625]); // 20 thousandths of an intensity of 20 per cent
    }

    #[test]
    fn tables_are_read_and_refused_by_line() {
        let text = "! time speed ...\n0 8 0 0 0 0.2 0 0\n\n10, 12, 5, 0.1, 0, 0.2, 0, 1 # end\n";
        let table = read_wind_table(text, 126.0).unwrap();
        assert_eq!((table.rows.len(), table.rows[1].speed_m_s, table.rows[1].gust_m_s), (2, 12.0, 1.0));
        assert_eq!(table.rows[1].direction_rad, 5f64.to_radians());
        let marked = read_wind_table("\u{feff}0 8 0 0 0 0.2 0 0\n10 12 5 0.1 0 0.2 0 1\n", 126.0).unwrap();
        assert_eq!(marked.rows, table.rows);
        for (text, expected) in [
            ("", "line 1: a table without rows"),
            ("0 8 0 0 0 0.2 0\n", "line 1: 7 columns"),
            ("0 8 0 0 0 0.2 0 0\n0 8 0 0 0 0.2 0 0\n", "line 2: the time 0 s after 0 s"),
            ("0 8 0 0 0 nan 0 0\n", "line 1: \"nan\" is not"),
            ("0 8 0 0 0 0.2 0 0 3\n", "line 1: an upflow angle of 3 deg"),
        ] {
            let fault = read_wind_table(text, 126.0).unwrap_err().to_string();
            assert!(fault.starts_with(expected), "{fault}");
        }
        assert!(read_wind_table(text, 0.0).unwrap_err().to_string().starts_with("reference length is 0"));
    }
}
