//! Strain gauges of a machine in the equations.

use crate::beam::recovery::axial_row;
use crate::machine::{Gauge, Machine};
use crate::multibody::gauge::GaugePoint;

/// Positions and weights of the gauges per strain measure; an invalid fibre direction is read as axial.
pub(crate) fn gauge_points(machine: &Machine) -> Vec<GaugePoint> {
    let point = |gauge: &Gauge| {
        let row = gauge.row(&machine.bodies[gauge.body].section);
        let row = row.unwrap_or_else(|| axial_row(gauge.y_m, gauge.z_m));
        GaugePoint { body: gauge.body, position_m: gauge.position_m, row }
    };
    machine.gauges.iter().map(point).collect()
}
