//! Derivatives of the loads and coefficients of a rotor ([`RotorLoads`](super::loads::RotorLoads)) with respect to the loads on its sections
//! and to the disc, in closed form.

use crate::aero::flow::Flow;
use crate::aero::rotor::disc::Disc;
use crate::load::{SectionMotion, Wrench};
use nalgebra::{RowSVector, SMatrix, SVector, Vector3};
use std::f64::consts::PI;

/// Number of loads and coefficients, without the mean induction.
pub(super) const OUTPUTS: usize = 8;

/// First columns of the variables: force and moment about the hub of all sections, normal of the disc, angular velocity of the hub, mean wind
/// relative to the sections, radius.
const MOMENT: usize = 3;
const NORMAL: usize = 6;
const SPIN: usize = 9;
const WIND: usize = 12;
const RADIUS: usize = 15;
const COLUMNS: usize = 16;

type Row = RowSVector<f64, COLUMNS>;

/// Derivatives of the loads and coefficients of a rotor in a step.
pub(super) struct OutputSlopes {
    by_variables: SMatrix<f64, OUTPUTS, COLUMNS>,
    normal: Vector3<f64>,
    /// Per section: its place from the hub, and the force on it.
    sections: Vec<(Vector3<f64>, Vector3<f64>)>,
}

/// Changes of hub and disc, or their multipliers.
#[derive(Clone, Copy, Default)]
pub(super) struct DiscChange {
    pub hub_m: Vector3<f64>,
    pub hub_turn: Vector3<f64>,
    pub hub_spin_rad_s: Vector3<f64>,
    pub wind_m_s: Vector3<f64>,
    pub radius_m: f64,
}

impl OutputSlopes {
    /// At loads on sections, the hub of `motions` being the last. `like`: number of blades per modelled blade; `met_m_s`: mean wind
    /// relative to the sections.
    pub fn of(
        (disc, met_m_s): (&Disc, &Vector3<f64>),
        (motions, loads): (&[SectionMotion], &[Wrench]),
        flow: &Flow,
        like: f64,
    ) -> Self {
        let hub = &motions[motions.len() - 1];
        let sections: Vec<_> = motions[..motions.len() - 1]
            .iter()
            .zip(loads)
            .map(|(motion, load)| (motion.position_m - hub.position_m, load.force_n))
            .collect();
        let force_n: Vector3<f64> = sections.iter().map(|(_, force_n)| force_n).sum();
        let moment_n_m: Vector3<f64> =
            sections.iter().zip(loads).map(|((arm_m, force_n), load)| arm_m.cross(force_n) + load.moment_n_m).sum();
        let normal = disc.normal;
        let row = |parts: &[(usize, Vector3<f64>)]| {
            let mut row = Row::zeros();
            for (first, part) in parts {
                row.fixed_columns_mut::<3>(*first).copy_from(&part.transpose());
            }
            row
        };
        let thrust = row(&[(0, normal * like), (NORMAL, force_n * like)]);
        let torque = row(&[(MOMENT, normal * (like * disc.turn)), (NORMAL, moment_n_m * (like * disc.turn))]);
        let spin_rad_s = (hub.spin_rad_s + flow.spin_rad_s) * disc.turn;
        let speed = row(&[(NORMAL, spin_rad_s), (SPIN, normal * disc.turn)]);
        // as in the step: the wind relative to a rotor in still air is zero
        let wind_m_s = disc.loads.wind_m_s;
        let wind = if wind_m_s == 0.0 { Row::zeros() } else { row(&[(NORMAL, *met_m_s), (WIND, normal)]) };
        let [thrust_n, torque_n_m, speed_rad_s] =
            [force_n.dot(&normal) * like, moment_n_m.dot(&normal) * (like * disc.turn), disc.loads.speed_rad_s];
        let power = torque * speed_rad_s + speed * torque_n_m;
        let mut rows = [thrust, torque, power, speed, wind, Row::zeros(), Row::zeros(), Row::zeros()];
        let pressure_n = 0.5 * flow.density_kg_m3 * PI * disc.radius_m.powi(2) * wind_m_s.powi(2);
        if disc.has_wind {
            let mut radius = Row::zeros();
            radius[RADIUS] = 1.0 / disc.radius_m;
            // relative changes
            let wind = wind / wind_m_s;
            let tip_speed_ratio = speed * (speed_rad_s.signum() * disc.radius_m / wind_m_s.abs())
                + (radius - wind) * disc.loads.tip_speed_ratio;
            rows[7] = tip_speed_ratio;
            if pressure_n > 0.0 {
                let power_n_m_s = pressure_n * wind_m_s.abs();
                let power_coefficient = torque_n_m * speed_rad_s / power_n_m_s;
                rows[5] = power / power_n_m_s - (radius * 2.0 + wind * 3.0) * power_coefficient;
                rows[6] = thrust / pressure_n - (radius + wind) * (2.0 * thrust_n / pressure_n);
            }
        }
        Self { by_variables: SMatrix::from_rows(&rows), normal, sections }
    }

    /// Variations due to those of the loads, six entries per section, of the places of the sections in m and of the disc.
    pub fn forward(
        &self,
        loads: &[f64],
        places_m: impl Iterator<Item = Vector3<f64>>,
        disc: &DiscChange,
    ) -> SVector<f64, OUTPUTS> {
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for (((arm_m, force_n), load), place_m) in self.sections.iter().zip(loads.chunks_exact(6)).zip(places_m) {
            let own = Vector3::from_column_slice(&load[..3]);
            force += own;
            moment +=
                arm_m.cross(&own) + (place_m - disc.hub_m).cross(force_n) + Vector3::from_column_slice(&load[3..]);
        }
        let mut along = SVector::<f64, COLUMNS>::zeros();
        let parts = [
            (0, force),
            (MOMENT, moment),
            (NORMAL, disc.hub_turn.cross(&self.normal)),
            (SPIN, disc.hub_spin_rad_s),
            (WIND, disc.wind_m_s),
        ];
        parts.iter().for_each(|(first, part)| along.fixed_rows_mut::<3>(*first).copy_from(part));
        along[RADIUS] = disc.radius_m;
        self.by_variables * along
    }

    /// The transpose of [`Self::forward`]: adds the multipliers of the loads; returns those of the places of the sections and of the disc.
    pub fn reverse(&self, on: &[f64], loads: &mut [f64]) -> (Vec<Vector3<f64>>, DiscChange) {
        let on = self.by_variables.tr_mul(&SVector::<f64, OUTPUTS>::from_column_slice(on));
        let [force, moment, normal, hub_spin_rad_s, wind_m_s] =
            [0, MOMENT, NORMAL, SPIN, WIND].map(|first| on.fixed_rows::<3>(first).into_owned());
        let mut places = Vec::with_capacity(self.sections.len());
        for ((arm_m, force_n), load) in self.sections.iter().zip(loads.chunks_exact_mut(6)) {
            let own = force + moment.cross(arm_m);
            load[..3].iter_mut().zip(&own).for_each(|(sum, own)| *sum += own);
            load[3..].iter_mut().zip(&moment).for_each(|(sum, own)| *sum += own);
            places.push(force_n.cross(&moment));
        }
        let disc = DiscChange {
            hub_m: -places.iter().sum::<Vector3<f64>>(),
            hub_turn: self.normal.cross(&normal),
            hub_spin_rad_s,
            wind_m_s,
            radius_m: on[RADIUS],
        };
        (places, disc)
    }
}
