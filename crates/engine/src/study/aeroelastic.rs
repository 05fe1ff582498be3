//! Linear aeroelastic system: the structure with the aerodynamic loads due to its motion, and the aerodynamic lag states as further states,
//! NOTATION eqs. (L21) and (L22).

use crate::load::{SectionMotion, Wrench};
use crate::multibody::kinematics::Motion;
use crate::multibody::station;
use crate::solve::EquationsOfMotion;
use crate::solve::lagged::Lagged;
use crate::solve::linearize::SecondOrder;
use crate::study::Study;
use crate::study::differences::{Bare, pick, sixth_order};
use crate::system::PlantError;
use crate::system::air::slopes::{AirSlopes, SECTION_VARIABLES};
use crate::system::freedoms::Freedom;
use nalgebra::{DMatrix, DVector, Rotation3, Vector3};

/// Motion of a section with its accelerations.
type Section = (SectionMotion, [Vector3<f64>; 2]);

/// Linear aerodynamic response about a state, and its effect on the equations.
pub(crate) struct Aeroelastic {
    /// Derivatives of the aerodynamic response.
    pub slopes: AirSlopes,
    /// Derivative of the residual with respect to wind, angular velocity of the root frame and uniform gust.
    pub air_force: DMatrix<f64>,
    /// Derivative of the residual with respect to the rates of wind and angular velocity.
    pub air_rate_force: DMatrix<f64>,
    /// Apparent mass.
    pub mass: DMatrix<f64>,
}

impl Study<'_> {
    /// Mass, damping and stiffness including the aerodynamic ones, the aerodynamic lag states and, after them, the currents of electrical
    /// motors. Without strips, rotors and slender bodies there are no aerodynamic ones, and the aerodynamic loads are constant.
    pub(crate) fn lagged(&mut self, gusts: bool) -> Result<(Lagged, Option<Aeroelastic>), PlantError> {
        let (lagged, air) = self.lagged_in_air(gusts)?;
        Ok((self.with_currents(lagged), air))
    }

    fn lagged_in_air(&mut self, gusts: bool) -> Result<(Lagged, Option<Aeroelastic>), PlantError> {
        let second = self.second_order()?;
        if !self.system.air_is_linearised() {
            return Ok((Lagged::without(second), None));
        }
        let freedoms = self.system.freedoms();
        let sections = self.sections_at(&self.system.state.now.q.clone(), None, None);
        let by = self.section_slopes(&freedoms);
        let Some(slopes) = self.system.air_slopes(&sections, [&by[0], &by[1], &by[2]], gusts)? else {
            return Ok((Lagged::without(second), None));
        };
        let rows = slopes.load_rows;
        let force = |columns: &DMatrix<f64>| self.residual_of_loads(&columns.rows(0, rows).into_owned(), &freedoms);
        let [position, rate, acceleration] = [0, 1, 2].map(|part| force(&slopes.motion[part]));
        let SecondOrder { mass, damping, stiffness } = second;
        let apparent = (&acceleration + acceleration.transpose()) * 0.5;
        let second = SecondOrder { mass: mass + &apparent, damping: damping + rate, stiffness: stiffness + position };
        let lag_rows = |matrix: &DMatrix<f64>| matrix.rows(rows, slopes.lags.len()).into_owned();
        let system = Lagged {
            second,
            force: force(&slopes.lag),
            position: lag_rows(&slopes.motion[0]),
            rate: lag_rows(&slopes.motion[1]),
            lag: lag_rows(&slopes.lag),
        };
        let (air_force, air_rate_force) = (force(&slopes.air), force(&slopes.air_rate));
        Ok((system, Some(Aeroelastic { slopes, air_force, air_rate_force, mass: apparent })))
    }

    /// Motion of the sections for given coordinates, and for given rates and accelerations or the current ones.
    pub(super) fn sections_at(&mut self, q: &[f64], v: Option<&[f64]>, a: Option<&[f64]>) -> Vec<Section> {
        let now = self.system.state.now.clone();
        let (v, a) = (v.unwrap_or(&now.v), a.unwrap_or(&now.a));
        let equations = &mut self.system.equations;
        equations.residual(now.time_s, q, v, a, &mut self.system.scratch[0]);
        let motion = Motion { q, v, a };
        let places = &equations.model.stations[equations.load_stations..];
        let section = |place| {
            let found = station::accelerated(&equations.model, &equations.work, motion, place);
            (found.motion, [found.acceleration_m_s2, found.spin_rate_rad_s2])
        };
        places.iter().map(section).collect()
    }

    /// Derivatives of the motion of the sections with respect to coordinates, rates and accelerations of the degrees of freedom: exact,
    /// except about a moving state, for which the derivatives of velocities and accelerations with respect to the coordinates are
    /// sixth-order differences.
    pub(super) fn section_slopes(&mut self, freedoms: &[Freedom]) -> [DMatrix<f64>; 3] {
        let now = self.system.state.now.clone();
        let rest = self.system.stands_still();
        let zero = vec![0.0; now.q.len()];
        let sections = self.system.equations.model.stations.len() - self.system.equations.load_stations;
        let mut by = [0; 3].map(|_| DMatrix::zeros(SECTION_VARIABLES * sections, freedoms.len()));
        for (column, freedom) in freedoms.iter().enumerate() {
            let unit = self.direction(freedom);
            let shifted = |vector: &[f64], sign: f64| -> Vec<f64> {
                vector.iter().zip(&unit).map(|(x, unit)| x + sign * unit).collect()
            };
            // velocities about zero accelerations, and accelerations about zero rates: neither changes these derivatives, whereas
            // accelerations of thousands of m/s² would add their round-off, which sections of little rotary inertia amplify
            let ends = [1.0, -1.0].map(|sign| {
                let (v, a) = (shifted(&now.v, sign), shifted(&zero, sign));
                (
                    variables(&self.sections_at(&now.q, Some(&v), Some(&zero))),
                    variables(&self.sections_at(&now.q, Some(&zero), Some(&a))),
                )
            });
            let [above, below] = ends;
            by[1].set_column(column, &((above.0 - below.0) * 0.5));
            by[2].set_column(column, &((above.1 - below.1) * 0.5));
            if !rest {
                let mut at = |steps: f64| {
                    let q = self.displaced(freedom, steps * freedom.step);
                    variables(&self.sections_at(&q, None, None))
                };
                by[0].set_column(column, &sixth_order(&mut at, freedom.step));
            }
            // positions and rotations depend on the coordinates as velocities depend on the rates
            for section in 0..sections {
                for part in 0..6 {
                    let first = SECTION_VARIABLES * section + part;
                    by[0][(first, column)] = by[1][(first + 6, column)];
                }
            }
        }
        self.sections_at(&now.q, None, None);
        by
    }

    /// Derivative of the residual with respect to loads on the sections, column by column.
    pub(super) fn residual_of_loads(&self, columns: &DMatrix<f64>, freedoms: &[Freedom]) -> DMatrix<f64> {
        let mut bare = Bare::without_stiffness(self.system);
        let equations = &self.system.equations;
        let mut stations = vec![Wrench::default(); equations.stations.len()];
        let zero = vec![0.0; self.system.coordinates()];
        let mut forces = DMatrix::zeros(freedoms.len(), columns.ncols());
        for (column, loads) in columns.column_iter().enumerate() {
            for (station, entries) in
                stations[equations.load_stations..].iter_mut().zip(loads.as_slice().chunks_exact(6))
            {
                station.force_n.copy_from_slice(&entries[..3]);
                station.moment_n_m.copy_from_slice(&entries[3..]);
            }
            let residual = bare.of_loads(&self.system.state.now.q, &zero, &stations);
            forces.set_column(column, &pick(&residual, freedoms));
        }
        forces
    }
}

/// Velocities, angular velocities and accelerations at their indices among the variables of the sections; positions and rotations follow
/// from them.
fn variables(sections: &[Section]) -> DVector<f64> {
    let of = |(motion, [acceleration, spin_rate]): &Section| {
        let none = Rotation3::<f64>::identity().scaled_axis();
        [none, none, motion.velocity_m_s, motion.spin_rad_s, *acceleration, *spin_rate]
    };
    let entries: Vec<f64> = sections.iter().flat_map(of).flat_map(|vector| [vector.x, vector.y, vector.z]).collect();
    DVector::from_vec(entries)
}
