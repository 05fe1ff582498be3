//! Largest values compared with closed forms, and errors of names.

use super::*;
use foldwing_engine::machine::{AttachedMass, Body, EndStops, Joint, Latch, Machine, Motor, Solver, Spring};
use foldwing_engine::plant::{InputColumn, InputRows, JointInputs, Parameter, Plant};
use std::f64::consts::PI;
use std::sync::Arc;

/// Numbers of an arm of inertia 1 kg·m² on a hinge.
#[derive(Clone, Copy)]
struct Arm {
    stiffness: f64,
    torque: f64,
    damping: f64,
    start_angle: f64,
    start_rate: f64,
    latch_angle: Option<f64>,
    rigid: bool,
    end_stop: Option<f64>,
}

const SWING: Arm = Arm {
    stiffness: 4.0,
    torque: 0.0,
    damping: 0.0,
    start_angle: 0.3,
    start_rate: 0.8,
    latch_angle: None,
    rigid: false,
    end_stop: None,
};

impl Arm {
    fn plant(self) -> Result<Plant, String> {
        let mass =
            AttachedMass { inertia_kg_m2: nalgebra::Matrix3::identity(), ..AttachedMass::point("mass", 0.0, 1.0) };
        let mut hinge = Joint::revolute("hinge", [0.0, 0.0, 1.0])
            .spring(Spring { stiffness_n_m_rad: self.stiffness, ..Spring::default() })
            .motor(Motor { constant_torque_n_m: self.torque, damping_n_m_s_rad: self.damping, ..Motor::default() })
            .start_angle_rad(self.start_angle)
            .start_rate_rad_s(self.start_rate);
        if let Some(angle_rad) = self.latch_angle {
            let latch = if self.rigid { Latch::rigid() } else { Latch::with_stiffness_n_m_rad(400.0) };
            hinge = hinge.latch(latch.angle_rad(angle_rad).capture_rad(0.01));
        }
        if let Some(upper_rad) = self.end_stop {
            let (stiffness_n_m_rad, damping_n_m_s_rad) = (400.0, 40.0);
            let upper_rad = Some(upper_rad);
            hinge = hinge.end_stops(EndStops { lower_rad: None, upper_rad, stiffness_n_m_rad, damping_n_m_s_rad });
        }
        let machine: Machine = Machine::builder("Swing")
            .gravity_m_s2([0.0; 3])
            .body(Body::rigid("arm"), hinge)
            .mass("arm", mass)
            .solver(Solver { tolerance: 1e-10, ..Solver::default() })
            .build()
            .map_err(|refused| refused.to_string())?;
        Ok(Plant::new(Arc::new(machine)))
    }

    fn number(self, name: &str, place: fn(&mut Self) -> &mut f64) -> Numbers {
        let mut own = self;
        let value = *place(&mut own);
        let plant = |value: f64| {
            let mut other = self;
            *place(&mut other) = value;
            other.plant()
        };
        let step = 1e-3 * if value == 0.0 { 1.0 } else { value.abs() };
        let parameter = Parameter::new(name, value, step, plant).unwrap_or_else(|error| panic!("{error}"));
        Numbers { by: vec![By { name: name.to_owned(), value, unit: "" }], parameter }
    }

    fn numbers(self) -> Vec<Numbers> {
        vec![
            self.number("stiffness", |arm| &mut arm.stiffness),
            self.number("start_angle", |arm| &mut arm.start_angle),
            self.number("start_rate", |arm| &mut arm.start_rate),
        ]
    }

    fn differentiate(self, of: &[&str], stop_s: f64, mode: Mode) -> Result<Gradients, GradientsError> {
        let plant = self.plant().unwrap_or_else(|error| panic!("{error}"));
        let of = of.iter().map(|of| (*of).to_owned()).collect();
        differentiate(plant, self.numbers(), &Options { of, stop_s: Some(stop_s), mode, ..Options::default() })
    }
}

fn close(value: f64, known: f64, what: &str) {
    assert!((value - known).abs() <= 1e-7 * known.abs().max(0.1), "{what}: {value} and {known}");
}

/// GR-10: an arm on a spring, `θ = A cos(ω t − φ)`, `A² = θ0² + (θ0'/ω)²`: largest and smallest angle over a period, and the angle of
/// largest magnitude, with their derivatives with respect to stiffness, start angle and start rate, both forward and adjoint. The run has a
/// relative error of 1e-9.
#[test]
fn largest_values_of_an_oscillation_have_the_slopes_of_its_amplitude() {
    let Arm { stiffness, start_angle, start_rate, .. } = SWING;
    let omega = stiffness.sqrt();
    let amplitude = start_angle.hypot(start_rate / omega);
    let slopes = [
        -start_rate * start_rate / (2.0 * amplitude * stiffness * stiffness),
        start_angle / amplitude,
        start_rate / (stiffness * amplitude),
    ];
    // the first largest value is positive; the smallest one follows half a period later
    let (largest_s, period_s) = ((start_rate / omega).atan2(start_angle) / omega, 2.0 * PI / omega);
    for mode in [Mode::Forward, Mode::Adjoint] {
        let found = SWING
            .differentiate(&["max(hinge.angle), min(hinge.angle)", "peak(hinge.angle)"], 0.9 * period_s, mode)
            .unwrap_or_else(|error| panic!("{error}"));
        let names: Vec<&str> = found.of.iter().map(|own| own.name.as_str()).collect();
        assert_eq!(names, ["max(hinge.angle)", "min(hinge.angle)", "peak(hinge.angle)"]);
        for (own, sign) in found.of.iter().zip([1.0, -1.0]) {
            close(own.value, sign * amplitude, &own.name);
            for (slope, known) in own.derivatives.iter().zip(slopes) {
                close(*slope, sign * known, &own.name);
            }
            let time_s = if sign > 0.0 { largest_s } else { largest_s + 0.5 * period_s };
            close(own.time_s, time_s, "time");
        }
        close(found.of[2].value.abs(), amplitude, "peak");
        assert_eq!((found.mode, found.by.len()), (mode, 3));
    }
}

/// GR-15: the largest angle of an arm with little damping is that of its first cycle, whichever of 40 cycles the samples meet closest to
/// its crest: `θ = exp(−at) (θ0 cos ωt + b sin ωt)`, `2a` is the damping divided by the inertia.
#[test]
fn the_largest_of_many_cycles_is_found() {
    let arm = Arm { damping: 2e-4, ..SWING };
    let (a, start) = (0.5 * arm.damping, arm.start_angle);
    let omega = (arm.stiffness - a * a).sqrt();
    let b = (arm.start_rate + a * start) / omega;
    let time_s = (arm.start_rate / (start * omega + a * b)).atan() / omega;
    let largest = (-a * time_s).exp() * (start * (omega * time_s).cos() + b * (omega * time_s).sin());
    let period_s = 2.0 * PI / omega;
    for cycles in [39.9, 40.3, 40.7] {
        let plant = arm.plant().unwrap_or_else(|error| panic!("{error}"));
        let of = vec!["max(hinge.angle)".to_owned()];
        let options = Options { of, stop_s: Some(cycles * period_s), ..Options::default() };
        let found = differentiate(plant, Vec::new(), &options).unwrap_or_else(|error| panic!("{error}"));
        close(found.of[0].time_s, time_s, "time");
        close(found.of[0].value, largest, "angle");
    }
}

/// GR-11: a largest value at an end of the run is the value there: at the start, with the derivatives of the start, and at the stop.
#[test]
fn largest_values_at_the_ends_of_a_run_are_the_values_there() {
    let falling = Arm { start_rate: -0.8, ..SWING };
    let found = falling.differentiate(&["max(hinge.angle)", "min(hinge.angle)", "hinge.angle"], 0.1, Mode::Forward);
    let found = found.unwrap_or_else(|error| panic!("{error}"));
    let [largest, least, last] = &found.of[..] else { panic!("{found:?}") };
    assert_eq!((largest.time_s, largest.value), (0.0, 0.3));
    largest.derivatives.iter().zip([0.0, 1.0, 0.0]).for_each(|(slope, known)| close(*slope, known, "start"));
    assert_eq!((least.time_s, least.value, &least.derivatives), (0.1, last.value, &last.derivatives));
}

/// GR-12: the largest rate of an arm that is driven against a damped end stop occurs at contact, where the acceleration jumps: this is an
/// error, not a number. The latch time and the angle at a later time have derivatives; without numbers only values are returned.
#[test]
fn a_corner_has_no_slope() {
    let driven =
        Arm { stiffness: 0.0, torque: -1.0, start_angle: 0.0, start_rate: 0.0, latch_angle: Some(0.5), ..SWING };
    let stopped = Arm { latch_angle: None, end_stop: Some(0.49), ..driven };
    let outcome = stopped.differentiate(&["max(hinge.angular_velocity)"], 1.1, Mode::Auto);
    assert!(
        matches!(&outcome, Err(GradientsError::Quantity { of, error: QuantityError::Corner { .. } }) if of == "max(hinge.angular_velocity)"),
        "{outcome:?}"
    );
    let plant = driven.plant().unwrap_or_else(|error| panic!("{error}"));
    let of = vec!["hinge.latch_time".to_owned(), "hinge.angle@0.5".to_owned()];
    let options = Options { of, stop_s: Some(1.1), ..Options::default() };
    let found = differentiate(plant, vec![driven.number("torque", |arm| &mut arm.torque)], &options);
    let found = found.unwrap_or_else(|error| panic!("{error}"));
    // the motor's torque acts against the angle: θ = −T t²/2 reaches 0.49 rad, ∂t/∂T = −t/2T
    let latch_s = 0.98f64.sqrt();
    close(found.of[0].value, latch_s, "latch time");
    close(found.of[0].time_s, latch_s, "latch time");
    close(found.of[0].derivatives[0], 0.5 * latch_s, "slope of the latch time");
    close(found.of[1].derivatives[0], -0.125, "slope of the angle");
    let plant = driven.plant().unwrap_or_else(|error| panic!("{error}"));
    let values = differentiate(plant, Vec::new(), &options).unwrap_or_else(|error| panic!("{error}"));
    assert!(values.of.iter().all(|own| own.derivatives.is_empty()) && values.of[0].value == found.of[0].value);
}

/// GR-42: a rigid latch holds an arm at the edge of its range: the derivative of the largest angle is that of the latch angle, and zero
/// with respect to the torque. The largest rate, where the impulse stops the arm, has no derivative, and neither has that at a lock which
/// an input closes.
#[test]
fn an_impulse_is_a_corner_of_the_rate() {
    let driven = Arm { stiffness: 0.0, torque: -1.0, start_angle: 0.0, start_rate: 0.0, ..SWING };
    let latched = Arm { latch_angle: Some(0.5), rigid: true, ..driven };
    let numbers = || {
        let torque = latched.number("torque", |arm| &mut arm.torque);
        [torque, latched.number("latch angle", |arm| arm.latch_angle.get_or_insert(0.5))]
    };
    let differentiate_rigid = |of: &str| {
        let options = Options { of: vec![of.to_owned()], stop_s: Some(1.3), ..Options::default() };
        let plant = latched.plant().unwrap_or_else(|error| panic!("{error}"));
        differentiate(plant, numbers().into(), &options)
    };
    let is_corner = |outcome: &Result<Gradients, GradientsError>| {
        matches!(outcome, Err(GradientsError::Quantity { error: QuantityError::Corner { .. }, .. }))
    };
    let outcome = differentiate_rigid("max(hinge.angular_velocity)");
    assert!(is_corner(&outcome), "{outcome:?}");
    let found = differentiate_rigid("max(hinge.angle), hinge.latch_time").unwrap_or_else(|error| panic!("{error}"));
    close(found.of[0].value, 0.49, "largest angle");
    assert!(found.of[0].derivatives[0].abs() < 1e-9, "{:?}", found.of[0]);
    close(found.of[0].derivatives[1], 1.0, "by the latch's angle");
    // θ = −T t²/2 reaches 0.49 rad
    let latch_s = 0.98f64.sqrt();
    close(found.of[1].derivatives[0], 0.5 * latch_s, "by the torque");
    close(found.of[1].derivatives[1], 1.0 / latch_s, "by the latch's angle");
    let locked = |of: &str| {
        let plant = driven.plant().unwrap_or_else(|error| panic!("{error}"));
        let index = plant.inputs().layout().joints.place(0, std::mem::offset_of!(JointInputs, release));
        let column = InputColumn { index, held: true, values: vec![1.0, 0.0] };
        let inputs = InputRows::new(vec![0.0, 0.5], vec![column]).unwrap_or_else(|error| panic!("{error}"));
        let options = Options { of: vec![of.to_owned()], stop_s: Some(1.1), inputs, ..Options::default() };
        differentiate(plant, vec![driven.number("torque", |arm| &mut arm.torque)], &options)
    };
    let outcome = locked("max(hinge.angular_velocity)");
    assert!(is_corner(&outcome), "{outcome:?}");
    let found = locked("hinge.angle").unwrap_or_else(|error| panic!("{error}"));
    close(found.of[0].derivatives[0], -0.125, "angle at the lock");
}

/// GR-50: mean and root mean square of the angle of an oscillation with their derivatives, both forward and adjoint, against central differences of
/// the closed forms.
#[test]
fn means_of_an_oscillation_have_the_slopes_of_their_closed_forms() {
    let stop_s = 2.2;
    let known = |[stiffness, angle, rate]: [f64; 3]| {
        let omega = f64::sqrt(stiffness);
        let (amplitude, phase) = (angle.hypot(rate / omega), (rate / omega).atan2(angle));
        let end = omega * stop_s - phase;
        let mean = amplitude / (omega * stop_s) * (end.sin() + phase.sin());
        let square = 1.0 + ((2.0 * end).sin() + (2.0 * phase).sin()) / (2.0 * omega * stop_s);
        [mean, amplitude * (0.5 * square).sqrt()]
    };
    let usual = [SWING.stiffness, SWING.start_angle, SWING.start_rate];
    for mode in [Mode::Auto, Mode::Forward, Mode::Adjoint] {
        let found = SWING
            .differentiate(&["mean(hinge.angle)", "rms(hinge.angle)"], stop_s, mode)
            .unwrap_or_else(|error| panic!("{error}"));
        for (row, own) in found.of.iter().enumerate() {
            close(own.value, known(usual)[row], &own.name);
            for (place, slope) in own.derivatives.iter().enumerate() {
                let beside = |shift: f64| {
                    let mut numbers = usual;
                    numbers[place] += shift;
                    known(numbers)[row]
                };
                close(*slope, (beside(1e-4) - beside(-1e-4)) / 2e-4, &own.name);
            }
        }
    }
    let still = Arm { start_angle: 0.0, start_rate: 0.0, ..SWING };
    let refused = still.differentiate(&["rms(hinge.angle)"], 1.0, Mode::Auto).err().map(|error| error.to_string());
    assert!(refused.as_deref().is_some_and(|message| message.contains("zero throughout")), "{refused:?}");
}

/// GR-57: energy that the damper of an arm dissipates from the rate `ω`, `ω²(1 − e^{−2dt})/2`, at a time, at the end and at its largest, by damping and rate,
/// in all modes; means of accounts are errors by name.
#[test]
fn the_energy_of_a_damper_has_the_slopes_of_its_closed_form() {
    let arm = Arm { stiffness: 0.0, damping: 0.6, start_angle: 0.0, ..SWING };
    let numbers = || vec![arm.number("damping", |arm| &mut arm.damping), arm.number("rate", |arm| &mut arm.start_rate)];
    let (stop_s, rate) = (1.4, arm.start_rate);
    let of: Vec<String> =
        ["energy.dissipated@0.5", "energy.dissipated", "max(energy.dissipated)"].map(String::from).to_vec();
    for mode in [Mode::Auto, Mode::Forward, Mode::Adjoint] {
        let plant = arm.plant().unwrap_or_else(|error| panic!("{error}"));
        let options = Options { of: of.clone(), stop_s: Some(stop_s), mode, ..Options::default() };
        let found = differentiate(plant, numbers(), &options).unwrap_or_else(|error| panic!("{error}"));
        assert!(mode != Mode::Auto || found.mode == Mode::Forward);
        for (own, time_s) in found.of.iter().zip([0.5, stop_s, stop_s]) {
            let left = f64::exp(-2.0 * arm.damping * time_s);
            assert_eq!(own.unit, "J");
            close(own.value, 0.5 * rate * rate * (1.0 - left), &own.name);
            close(own.derivatives[0], rate * rate * time_s * left, &own.name);
            close(own.derivatives[1], rate * (1.0 - left), &own.name);
        }
    }
    let refused = arm.differentiate(&["mean(energy.work)"], 1.0, Mode::Auto).err().map(|error| error.to_string());
    assert!(refused.as_deref().is_some_and(|message| message.contains("means of energy accounts")), "{refused:?}");
}

/// GR-51: impulse with which a rigid latch stops an arm under a constant torque from rest, `−√(−2 T θ)`, and its derivative with respect to the torque;
/// elastic latches have no impulse.
#[test]
fn the_impulse_of_a_latch_has_the_slopes_of_its_closed_form() {
    let latched = Arm {
        stiffness: 0.0,
        torque: -0.8,
        start_angle: 0.0,
        start_rate: 0.0,
        latch_angle: Some(0.5),
        rigid: true,
        ..SWING
    };
    let numbers = || vec![latched.number("torque", |arm| &mut arm.torque)];
    let edge = 0.49;
    let impulse = -(-2.0 * latched.torque * edge).sqrt();
    for mode in [Mode::Forward, Mode::Adjoint] {
        let plant = latched.plant().unwrap_or_else(|error| panic!("{error}"));
        let options = Options { of: vec!["hinge.latch_impulse".into()], stop_s: Some(1.5), mode, ..Options::default() };
        let found = differentiate(plant, numbers(), &options).unwrap_or_else(|error| panic!("{error}"));
        let own = &found.of[0];
        assert_eq!(own.unit, "N.m.s");
        close(own.value, impulse, "impulse");
        close(own.time_s, (-2.0 * edge / latched.torque).sqrt(), "time");
        close(own.derivatives[0], impulse / (2.0 * latched.torque), "by the torque");
    }
    let elastic = Arm { rigid: false, ..latched };
    let refused = elastic.differentiate(&["hinge.latch_impulse"], 1.5, Mode::Auto).err().map(|error| error.to_string());
    assert!(refused.as_deref().is_some_and(|message| message.contains("real output")), "{refused:?}");
    let refused = latched.differentiate(&["hinge.latch_impulse"], 0.5, Mode::Auto).err().map(|error| error.to_string());
    assert!(refused.as_deref().is_some_and(|message| message.contains("later stop time")), "{refused:?}");
}

/// Names, times and stop times that do not fit give errors that name them.
#[test]
fn results_that_do_not_exist_are_refused() {
    let refusal = |of: &str, stop_s: f64| match SWING.differentiate(&[of], stop_s, Mode::Auto) {
        Ok(found) => panic!("{of}: {found:?}"),
        Err(error) => error.to_string(),
    };
    let cases = [
        ("hinge.angel", "did you mean `hinge.angle`?"),
        ("max(hinge.angel)", "did you mean `hinge.angle`?"),
        ("hinge.angle@soon", "`soon` is not a time in s"),
        ("hinge.angle@inf", "`inf` is not a time in s"),
        ("hinge.angle@2", "the time 2 s is not within the run, 0 to 1 s"),
        ("hinge.latch_time", "real output"),
        (" , ", "there is no result"),
    ];
    for (of, words) in cases {
        let message = refusal(of, 1.0);
        assert!(message.contains(words), "{of}: {message}");
    }
    assert!(refusal("hinge.angle", 0.0).contains("the stop time 0 s is not after the start time 0 s"));
    // more results than numbers: forward; more numbers: adjoint
    let mode = |of: &[&str]| SWING.differentiate(of, 0.1, Mode::Auto).map(|found| found.mode).ok();
    assert_eq!(mode(&["hinge.angle"]), Some(Mode::Adjoint));
    assert_eq!(mode(&["hinge.angle", "hinge.angular_velocity"]), Some(Mode::Forward));
}

/// Angle of an arm of 1 kg·m² without a spring at `time_s` per unit of torque in one of the rows: the second integral of the row's
/// interpolation weight.
fn second_integral(times_s: &[f64], row: usize, time_s: f64) -> f64 {
    // from the kink where the derivative of the weight changes by `slope`, or the weight jumps by `step`
    let mut angle = 0.0;
    let mut add = |knee_s: f64, step: f64, slope: f64| {
        let past_s = time_s - knee_s;
        if past_s > 0.0 {
            angle += step * past_s * past_s / 2.0 + slope * past_s.powi(3) / 6.0;
        }
    };
    let width = |from: usize| times_s[from + 1] - times_s[from];
    if row > 0 && width(row - 1) > 0.0 {
        add(times_s[row - 1], 0.0, 1.0 / width(row - 1));
        add(times_s[row], 0.0, -1.0 / width(row - 1));
    } else {
        add(times_s[row], 1.0, 0.0);
    }
    if row + 1 < times_s.len() && width(row) > 0.0 {
        add(times_s[row], 0.0, -1.0 / width(row));
        add(times_s[row + 1], 0.0, 1.0 / width(row));
    } else if row + 1 < times_s.len() {
        add(times_s[row], -1.0, 0.0);
    }
    angle
}

/// GR-17: for an arm without a spring under a torque over time with a jump, the derivatives of its angle at a time between rows, of its
/// largest angle and of the time at which a latch closes with respect to each value of the torque are integrals in closed form; those with
/// respect to a value after the result are zero.
#[test]
fn angles_by_values_of_a_torque_over_time_are_its_integrals() {
    let times_s = [0.0, 0.3, 0.5, 0.5, 0.9, 1.2];
    let values = [-0.4, 0.9, 0.4, -2.0, -1.5, -1.0];
    let arm = Arm { stiffness: 0.0, start_angle: 0.0, start_rate: 0.3, ..SWING };
    let angle = |time_s: f64| {
        let by_torque = |(row, value): (usize, &f64)| value * second_integral(&times_s, row, time_s);
        0.3 * time_s + values.iter().enumerate().map(by_torque).sum::<f64>()
    };
    let differentiate_on = |(times_s, values): (&[f64], &[f64]), arm: Arm, of: &[&str], mode: Mode| {
        let plant = arm.plant().unwrap_or_else(|error| panic!("{error}"));
        let index = plant.inputs().layout().joints.place(0, std::mem::offset_of!(JointInputs, torque_n_m));
        let column = InputColumn { index, held: false, values: values.to_vec() };
        let inputs = InputRows::new(times_s.to_vec(), vec![column]).unwrap_or_else(|error| panic!("{error}"));
        let rows: Vec<usize> = (0..times_s.len()).collect();
        let by = rows.iter().map(|row| By { name: format!("row {row}"), value: values[*row], unit: "N.m" }).collect();
        let parameter = Parameter::of_rows("torque", (0, rows), 1e-3, || arm.plant());
        let numbers = Numbers { by, parameter: parameter.unwrap_or_else(|error| panic!("{error}")) };
        let of = of.iter().map(|of| (*of).to_owned()).collect();
        differentiate(plant, vec![numbers], &Options { of, stop_s: Some(1.1), mode, inputs })
            .unwrap_or_else(|error| panic!("{error}"))
    };
    let differentiate = |arm: Arm, of: &[&str], mode: Mode| differentiate_on((&times_s, &values), arm, of, mode);
    // between rows, and at the largest angle: its rate falls through zero
    let rate = |time_s: f64| (angle(time_s + 1e-4) - angle(time_s - 1e-4)) / 2e-4;
    let (mut from, mut to) = (0.6, 1.1);
    for _ in 0..60 {
        let middle = 0.5 * (from + to);
        if rate(middle) > 0.0 { from = middle } else { to = middle }
    }
    for mode in [Mode::Forward, Mode::Adjoint] {
        let found = differentiate(arm, &["hinge.angle@0.7", "max(hinge.angle)", "hinge.angle@0.4"], mode);
        // the search ends at a rate of 1e-9 of the range divided by the sampling interval, here 2e-7 rad/s; the angle decreases with 2
        // rad/s²
        let off_s = found.of[1].time_s - from;
        assert!(off_s.abs() < 1e-6, "time of the largest angle: off by {off_s:.1e} s");
        for (of, time_s) in found.of.iter().zip([0.7, found.of[1].time_s, 0.4]) {
            close(of.value, angle(time_s), &of.name);
            for (row, slope) in of.derivatives.iter().enumerate() {
                let known = second_integral(&times_s, row, time_s);
                assert!((slope - known).abs() < 1e-8, "{} by row {row}: {slope} and {known}", of.name);
            }
        }
        let latch_angle = 0.25;
        let arm = Arm { latch_angle: Some(latch_angle), ..arm };
        let found = differentiate(arm, &["hinge.latch_time"], mode);
        let latch_s = found.of[0].value;
        // it closes at the start of its capture range
        close(angle(latch_s), latch_angle - 0.01, "angle at the latch time");
        for (row, slope) in found.of[0].derivatives.iter().enumerate() {
            let known = -second_integral(&times_s, row, latch_s) / rate(latch_s);
            assert!((slope - known).abs() < 1e-6, "latch time by row {row}: {slope} and {known}");
        }
        // one more row on the same line, so that the first step after it ends at the crossing
        let next = times_s.partition_point(|row_s| *row_s < latch_s);
        let row_s = latch_s - 1e-4;
        let share = (row_s - times_s[next - 1]) / (times_s[next] - times_s[next - 1]);
        let (mut closer_s, mut closer) = (times_s.to_vec(), values.to_vec());
        closer_s.insert(next, row_s);
        closer.insert(next, values[next - 1] + share * (values[next] - values[next - 1]));
        let found = differentiate_on((&closer_s, &closer), arm, &["hinge.latch_time"], mode);
        close(found.of[0].value, latch_s, "the same latch time");
        for (row, slope) in found.of[0].derivatives.iter().enumerate() {
            let known = -second_integral(&closer_s, row, latch_s) / rate(latch_s);
            assert!((slope - known).abs() < 1e-6, "latch time by row {row} of {}: {slope} and {known}", closer_s.len());
        }
    }
}

/// GR-20: quaternions keep their signs along the run: an arm that rotates by three half revolutions has the smallest `cos(θ/2)` after one
/// revolution, inside the run, not at the start, as it would with the sign of the last attitude. The derivatives there are those of the
/// angle, zero.
#[test]
fn quaternions_keep_their_signs_along_the_run() {
    let arm = Arm { stiffness: 0.0, torque: 0.0, start_angle: 0.0, start_rate: 3.0 * PI, ..SWING };
    for mode in [Mode::Forward, Mode::Adjoint] {
        let found = arm.differentiate(&["min(tip.rotation.w)", "tip.rotation.w@0.5"], 1.0, mode);
        let found = found.unwrap_or_else(|error| panic!("{error}"));
        close(found.of[0].value, -1.0, "w after a turn");
        assert!((found.of[0].time_s - 2.0 / 3.0).abs() < 1e-6, "{}", found.of[0].time_s);
        close(found.of[1].value, (0.75 * PI).cos(), "w at 0.5 s");
        let rate = found.by.iter().position(|by| by.name == "start_rate").unwrap_or(0);
        close(found.of[1].derivatives[rate], -0.25 * (0.75 * PI).sin(), "w by the start rate");
    }
}
