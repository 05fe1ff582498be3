//! Points in blocks of lanes, and vortex sheets of quadrilateral rings in flat lists.

use nalgebra::Vector3;

/// Number of points that are evaluated together.
pub const LANES: usize = 8;

/// One coordinate of `LANES` points.
type Lane = [f64; LANES];

/// Three coordinates of `LANES` points.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(align(64))]
pub struct Block {
    /// Coordinates: one lane array each for x, y and z.
    pub xyz: [Lane; 3],
}

impl Block {
    /// Returns the coordinates of one point.
    pub fn get(&self, lane: usize) -> Vector3<f64> {
        Vector3::new(self.xyz[0][lane], self.xyz[1][lane], self.xyz[2][lane])
    }

    /// Sets one point.
    pub fn set(&mut self, lane: usize, point: &Vector3<f64>) {
        for (coordinates, value) in self.xyz.iter_mut().zip(point.iter()) {
            coordinates[lane] = *value;
        }
    }

    /// Adds `factor` times another block.
    #[inline(always)]
    pub(super) fn add(&mut self, factor: f64, other: &Self) {
        for (sums, values) in self.xyz.iter_mut().zip(&other.xyz) {
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += factor * value;
            }
        }
    }

    /// Returns the block mirrored at the plane through the origin with this unit normal.
    #[inline(always)]
    pub(super) fn mirrored(&self, normal: &Vector3<f64>) -> Self {
        let mut image = *self;
        for lane in 0..LANES {
            let along = self.xyz[0][lane] * normal.x + self.xyz[1][lane] * normal.y + self.xyz[2][lane] * normal.z;
            for (coordinates, component) in image.xyz.iter_mut().zip(normal.iter()) {
                coordinates[lane] -= 2.0 * along * component;
            }
        }
        image
    }
}

/// Number of blocks needed for a number of points.
pub fn blocks(points: usize) -> usize {
    points.div_ceil(LANES)
}

/// Layout of the nodes, rings and segments of a sheet in flat lists. A sheet has rows of rings; row 0 is the foremost. A ring's circulation
/// is positive along its leading segment, from column to column, and then aft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sheet {
    /// Number of rows of rings.
    pub rows: usize,
    /// Number of rings in a row.
    pub strips: usize,
    /// Index of the first node.
    pub first_node: usize,
    /// Offset of nodes from one row to the next.
    pub node_stride: usize,
    /// Index of the first ring, which is also that of the first spanwise segment.
    pub first_ring: usize,
    /// Offset of rings from one row to the next.
    pub ring_stride: usize,
    /// Whether the rings of the last row have the circulations of the row before: the segments between the two rows then have none.
    pub joined_rear: bool,
}

impl Sheet {
    /// Index of a ring.
    #[inline(always)]
    pub fn ring(&self, row: usize, strip: usize) -> usize {
        self.first_ring + row * self.ring_stride + strip
    }

    /// Returns the sheet with one more row of rings behind the last, with the same circulations.
    pub fn with_rear_row(self) -> Self {
        Self { rows: self.rows + 1, joined_rear: true, ..self }
    }

    /// Whether the spanwise segments in a row of nodes have circulation.
    #[inline(always)]
    pub fn has_spanwise(&self, row: usize) -> bool {
        !self.joined_rear || row + 1 != self.rows
    }

    /// Index of a node, which is also the index of the chordwise segment that starts there.
    #[inline(always)]
    pub fn node(&self, row: usize, column: usize) -> usize {
        self.first_node + row * self.node_stride + column
    }
}

/// Net circulations of all segments of one or more sheets, in m²/s.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Filaments {
    /// Circulations of the segments from column to column; there is one more row of them than of rings.
    pub spanwise: Vec<f64>,
    /// Circulations of the segments from row to row, indexed by their first node.
    pub chordwise: Vec<f64>,
}

impl Filaments {
    /// Allocates memory for at most this number of nodes, and of rings with one additional row.
    pub fn new(rings: usize, nodes: usize) -> Self {
        Self { spanwise: vec![0.0; rings], chordwise: vec![0.0; nodes] }
    }

    /// Computes the net circulation of every segment from the rings on its two sides.
    pub fn gather(&mut self, sheet: &Sheet, circulation_m2_s: &[f64]) {
        let ring = |row, strip| circulation_m2_s[sheet.ring(row, strip)];
        for row in 0..=sheet.rows {
            for strip in 0..sheet.strips {
                let behind = if row < sheet.rows { ring(row, strip) } else { 0.0 };
                let ahead = if row > 0 { ring(row - 1, strip) } else { 0.0 };
                self.spanwise[sheet.ring(row, strip)] = behind - ahead;
            }
        }
        for row in 0..sheet.rows {
            for column in 0..=sheet.strips {
                let outer = if column < sheet.strips { ring(row, column) } else { 0.0 };
                let inner = if column > 0 { ring(row, column - 1) } else { 0.0 };
                self.chordwise[sheet.node(row, column)] = inner - outer;
            }
        }
    }
}
