//! Induced velocity of one annulus of a rotor: Ning's residual, with a bracket that always contains a root.
//!
//! Sources: Ning, *A simple solution method for the blade element momentum equations with guaranteed convergence*, Wind
//! Energy 17 (2014); Buhl, NREL/TP-500-36834 (2005), for the thrust of heavily loaded annuli; Prandtl's losses as in
//! Glauert.

use crate::aero::pieces::Pieces;
use crate::aero::polar::{Polar, PolarRow};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_8, PI, TAU};

/// Smallest flow angle considered, in rad; at zero the momentum balance is singular.
const MINIMUM_ANGLE_RAD: f64 = 1e-6;
/// Exponent of Prandtl's loss below which a node counts as an end of the blade: about 1e-10 of the blade length.
const MINIMUM_EXPONENT: f64 = 1e-10;
/// Maximum number of iterations of the root finder; bisection alone would need 52.
const MAXIMUM_ITERATIONS: usize = 100;
/// Width of the bracket in rad at which the root finder stops.
const TOLERANCE_RAD: f64 = 1e-14;

/// First step of the secant method, relative to the root.
const FIRST_SECANT: f64 = 1e-5;
/// Change relative to the root behind which it is exact to round-off.
const LAST_SECANT: f64 = 1e-11;
/// The same with which the iteration has converged, because round-off may keep it from the smaller one.
const LARGEST_LAST_SECANT: f64 = 1e-8;
/// Maximum number of its steps.
const MOST_SECANTS: usize = 30;
/// Load parameter `k` above which an annulus is heavily loaded, eq. (B5).
const HEAVY: f64 = 2.0 / 3.0;

/// Smallest speed in m/s by which the pitch rate of a section is divided: thin-aerofoil theory holds for small ratios.
const MINIMUM_SPEED_M_S: f64 = 1.0;

/// Load of a node where Prandtl's loss is complete, exactly at the tip or at the hub.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EndRule {
    /// No load, because the circulation is zero there.
    #[default]
    ZeroLoad,
    /// The wind is stopped (a = 1) and the section carries the load due to its motion in the plane of rotation, as in AeroDyn.
    Stopped,
}

/// Geometry of the annulus of a blade node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Annulus {
    /// Solidity `B c/(2π r)`.
    pub solidity: f64,
    /// Exponent `B (R − r)/(2 r)` of Prandtl's tip loss; infinite without it.
    pub tip_exponent: f64,
    /// Exponent `B (r − r_h)/(2 r_h)` of the hub loss; infinite without it.
    pub hub_exponent: f64,
}

impl Annulus {
    /// Annulus of a node at a radius, with tip and hub loss, eq. (B4).
    pub fn new(blades: usize, chord_m: f64, radius_m: f64, hub_radius_m: f64, tip_radius_m: f64) -> Self {
        let half = 0.5 * blades as f64;
        Self {
            solidity: half * chord_m / (PI * radius_m),
            tip_exponent: half * (tip_radius_m - radius_m) / radius_m,
            hub_exponent: if hub_radius_m > 0.0 {
                half * (radius_m - hub_radius_m) / hub_radius_m
            } else {
                f64::INFINITY
            },
        }
    }

    /// Prandtl's loss factor of tip and hub for the sine of a flow angle, eq. (B4).
    pub fn loss(&self, sine: f64) -> f64 {
        let part = |exponent: f64| {
            // acos(e^-x), accurate for small x too
            let fall = (-(exponent.max(0.0) / sine.abs())).exp_m1();
            FRAC_2_PI * (-fall * (2.0 + fall)).sqrt().atan2(1.0 + fall)
        };
        part(self.tip_exponent) * part(self.hub_exponent)
    }

    /// Whether the loss is complete at every flow angle.
    pub fn is_end(&self) -> bool {
        self.tip_exponent.min(self.hub_exponent) < MINIMUM_EXPONENT
    }
}

/// Inflow of a section without induction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    /// Velocity of the air along the normal of the annulus, positive from the windward side, in m/s.
    pub axial_m_s: f64,
    /// Velocity of the air in the plane of rotation, opposite to the section's motion, in m/s.
    pub tangential_m_s: f64,
    /// Angle from the plane of rotation to the chord line in rad, positive if it reduces the angle of attack.
    pub chord_angle_rad: f64,
}

/// Induction at a section in its annulus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Annular {
    /// Axial induced velocity in m/s, opposite to the wind: `a Vx`.
    pub axial_loss_m_s: f64,
    /// Tangential induced velocity in m/s, in the direction of the relative wind due to rotation: `a' Vy`.
    pub swirl_m_s: f64,
    /// Whether the momentum balance was solved; otherwise there is no induction, or the node is an end of the blade.
    pub balanced: bool,
}

impl Annular {
    /// State without induction.
    pub const FREE: Self = Self { axial_loss_m_s: 0.0, swirl_m_s: 0.0, balanced: false };
}

/// Angles, relative speed and static coefficients of a section in the frame of the annulus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionState {
    /// Relative speed in m/s.
    pub speed_m_s: f64,
    /// Angle from the plane of rotation to the relative velocity in rad.
    pub flow_angle_rad: f64,
    /// Angle of attack in rad, between −π and π.
    pub attack_rad: f64,
    /// Static coefficients at the angle of attack.
    pub row: PolarRow,
}

impl SectionState {
    /// Evaluates a section for the given velocities.
    pub fn of(axial_m_s: f64, tangential_m_s: f64, chord_angle_rad: f64, polar: &Polar) -> Self {
        Self::on([axial_m_s, tangential_m_s], chord_angle_rad, polar, &mut Pieces::Free)
    }

    /// The same on pieces of the polar.
    pub fn on([axial_m_s, tangential_m_s]: [f64; 2], chord_angle_rad: f64, polar: &Polar, pieces: &mut Pieces) -> Self {
        let flow_angle_rad = axial_m_s.atan2(tangential_m_s);
        let attack_rad = pieces.near(turn_back(flow_angle_rad - chord_angle_rad));
        let row = pieces.row(polar, attack_rad);
        Self { speed_m_s: axial_m_s.hypot(tangential_m_s), flow_angle_rad, attack_rad, row }
    }

    /// Returns this section while it pitches about its span, nose up, at `turning_m_s`: pitch rate in rad/s times chord in m. The angle of
    /// attack is that at three quarters of the chord, the direction of the force that at the quarter chord; the moment is damped, eq.
    /// (B25).
    pub fn turning(self, turning_m_s: f64, polar: &Polar, pieces: &mut Pieces) -> Self {
        let ratio = turning_m_s / pieces.most(self.speed_m_s, MINIMUM_SPEED_M_S);
        let attack_rad = pieces.near(turn_back(self.attack_rad + 0.5 * ratio));
        let row = pieces.row(polar, attack_rad);
        Self { attack_rad, row: PolarRow { moment: row.moment - FRAC_PI_8 * ratio, ..row }, ..self }
    }

    /// Force per span divided by `ρ`, along the wind and in the driving direction (opposite to `tangential_m_s`), in m³/s².
    pub fn force_m3_s2(&self, chord_m: f64) -> [f64; 2] {
        let (sine, cosine) = self.flow_angle_rad.sin_cos();
        let pressure = 0.5 * chord_m * self.speed_m_s * self.speed_m_s;
        [
            pressure * (self.row.lift * cosine + self.row.drag * sine),
            pressure * (self.row.lift * sine - self.row.drag * cosine),
        ]
    }
}

/// Reduces an angle to the range from −π to π, because polars cover one revolution, eq. (B2).
pub fn turn_back(angle_rad: f64) -> f64 {
    angle_rad - TAU * (angle_rad / TAU).round()
}

/// Solves the momentum balance of an annulus, eqs. (B3)–(B6). Inflow from behind or from the trailing edge is solved as its mirror image.
///
/// For a thrust coefficient above 2, Buhl's parabola has no windmill state; the annulus is then in the propeller-brake state, with reversed
/// flow through it. The induction jumps between the two, as in momentum theory. Without wind the annulus hovers. If there is no balance,
/// the induction is zero and `balanced` is false.
pub fn balance(annulus: &Annulus, polar: &Polar, approach: &Approach) -> Annular {
    balance_on(annulus, polar, approach, &mut Pieces::Free)
}

/// The same on pieces of its functions.
pub fn balance_on(annulus: &Annulus, polar: &Polar, approach: &Approach, pieces: &mut Pieces) -> Annular {
    balance_by((annulus, polar), approach, false, pieces)
}

/// Solves the momentum balance as AeroDyn does, eq. (B23), for comparison: in the windmill state if its residual has a root there, which
/// drag always provides, with axial induction factors from −1 to 1.5 and tangential ones from −1 to 1.
pub fn aerodyn_balance(annulus: &Annulus, polar: &Polar, approach: &Approach, pieces: &mut Pieces) -> Annular {
    let free = balance_by((annulus, polar), approach, true, pieces);
    let [axial_loss_m_s, swirl_m_s] = aerodyn_limited([free.axial_loss_m_s, free.swirl_m_s], approach, pieces);
    Annular { axial_loss_m_s, swirl_m_s, ..free }
}

/// Limits axial and tangential induced velocities in m/s as AeroDyn does for this inflow: axial induction factors from −1 to 1.5,
/// tangential ones from −1 to 1. AeroDyn applies the limits also to lagged velocities.
pub fn aerodyn_limited([axial_loss_m_s, swirl_m_s]: [f64; 2], approach: &Approach, pieces: &mut Pieces) -> [f64; 2] {
    let mut within = |loss_m_s: f64, of_m_s: f64, largest: f64| {
        let ends = [-of_m_s, largest * of_m_s];
        let above_m_s = pieces.most(loss_m_s, ends[0].min(ends[1]));
        pieces.least(above_m_s, ends[0].max(ends[1]))
    };
    [within(axial_loss_m_s, approach.axial_m_s, 1.5), within(swirl_m_s, approach.tangential_m_s, 1.0)]
}

fn balance_by(
    (annulus, polar): (&Annulus, &Polar),
    approach: &Approach,
    windmill_first: bool,
    pieces: &mut Pieces,
) -> Annular {
    let Approach { axial_m_s, tangential_m_s, chord_angle_rad } = *approach;
    let speed_m_s = axial_m_s.hypot(tangential_m_s);
    if annulus.is_end() || speed_m_s == 0.0 {
        return Annular::FREE;
    }
    let mirror = [
        // in still air the sign follows from the direction of the thrust
        if pieces.holds(axial_m_s < 0.0 || (axial_m_s == 0.0 && normal_at_rest(polar, approach) > 0.0)) {
            -1.0
        } else {
            1.0
        },
        if pieces.holds(tangential_m_s < 0.0) { -1.0 } else { 1.0 },
    ];
    let mut balance = Balance {
        annulus,
        polar,
        chord_angle_rad,
        mirror,
        windmill_first,
        // without the sign of a zero
        axial: mirror[0] * axial_m_s / speed_m_s + 0.0,
        tangential: mirror[1] * tangential_m_s / speed_m_s + 0.0,
        held: None,
    };
    match balance.flow_angle_on(pieces) {
        Some(angle_rad) => {
            let [axial, tangential] = balance.passing(angle_rad);
            Annular {
                axial_loss_m_s: axial_m_s - mirror[0] * axial * speed_m_s,
                swirl_m_s: mirror[1] * tangential * speed_m_s - tangential_m_s,
                balanced: true,
            }
        }
        None => Annular::FREE,
    }
}

/// Force coefficient along the wind at a flow angle of zero.
pub(super) fn normal_at_rest(polar: &Polar, approach: &Approach) -> f64 {
    let Approach { tangential_m_s, chord_angle_rad, .. } = *approach;
    let row = polar.at(turn_back(0f64.atan2(tangential_m_s) - chord_angle_rad));
    if tangential_m_s < 0.0 { -row.lift } else { row.lift }
}

/// An annulus with inflow from the windward side and the leading edge; velocities are relative to the speed of the inflow.
struct Balance<'a> {
    annulus: &'a Annulus,
    polar: &'a Polar,
    chord_angle_rad: f64,
    mirror: [f64; 2],
    /// Whether a root in the windmill state is preferred for any thrust.
    windmill_first: bool,
    axial: f64,
    tangential: f64,
    held: Option<Held>,
}

/// The smooth piece on which an annulus lies.
#[derive(Clone, Copy)]
struct Held {
    /// Interval of the polar.
    interval: usize,
    /// Angle of attack in rad near which it continues.
    attack_rad: f64,
    /// Whether it is heavily loaded, eq. (B5).
    heavy: bool,
}

impl Balance<'_> {
    /// [`Self::flow_angle_rad`] on pieces: kept, the root is the one near the known root.
    fn flow_angle_on(&mut self, pieces: &mut Pieces) -> Option<f64> {
        match pieces {
            Pieces::Free => self.flow_angle_rad(),
            Pieces::Record(_) => {
                let found = self.flow_angle_rad();
                if pieces.holds(found.is_some()) {
                    let angle_rad = found?;
                    let (attack_rad, heavy) =
                        (self.attack_rad(angle_rad.sin(), angle_rad.cos()), self.is_heavy(angle_rad));
                    pieces.row(self.polar, attack_rad);
                    pieces.holds(heavy);
                    pieces.note(attack_rad);
                    pieces.note(angle_rad);
                }
                found
            }
            Pieces::Keep { .. } => {
                if !pieces.holds(false) {
                    return None;
                }
                let (interval, heavy) = (pieces.choice(0), pieces.holds(false));
                let (attack_rad, known_rad) = (pieces.known()?, pieces.known()?);
                self.held = Some(Held { interval, attack_rad, heavy });
                Some(self.root_near(known_rad))
            }
        }
    }

    /// Root near a known one, by the secant method to round-off; NaN if the piece does not continue to a root.
    fn root_near(&self, known_rad: f64) -> f64 {
        let (mut before_rad, mut root_rad) = (known_rad + FIRST_SECANT * known_rad.abs().max(FIRST_SECANT), known_rad);
        let (mut before, mut now) = (self.residual(before_rad), self.residual(root_rad));
        let mut last_rad = f64::INFINITY;
        for _ in 0..MOST_SECANTS {
            if now == 0.0 {
                return root_rad;
            }
            let change_rad = now * (before_rad - root_rad) / (now - before);
            if !change_rad.is_finite() {
                break;
            }
            (before_rad, before) = (root_rad, now);
            root_rad += change_rad;
            now = self.residual(root_rad);
            last_rad = change_rad.abs();
            // the next change would be that of round-off
            if last_rad <= LAST_SECANT * root_rad.abs() {
                break;
            }
        }
        if last_rad <= LARGEST_LAST_SECANT * root_rad.abs() { root_rad } else { f64::NAN }
    }

    /// Whether the annulus is heavily loaded at a flow angle, eq. (B5).
    fn is_heavy(&self, angle_rad: f64) -> bool {
        let (sine, cosine) = angle_rad.sin_cos();
        let loss = self.annulus.loss(sine);
        let k = self.annulus.solidity / (4.0 * loss * sine.abs()) * self.coefficients(sine, cosine)[0] / sine.abs();
        sine > 0.0 && k > HEAVY
    }

    /// Angle of attack in rad, between −π and π, at a flow angle of the mirrored section.
    fn attack_rad(&self, sine: f64, cosine: f64) -> f64 {
        let [side, turn] = self.mirror;
        turn_back((side * sine).atan2(turn * cosine) - self.chord_angle_rad)
    }

    /// Flow angle at which blade load and momentum balance.
    fn flow_angle_rad(&self) -> Option<f64> {
        let rooted = self.windmill_first && self.residual(MINIMUM_ANGLE_RAD) < 0.0;
        if rooted || self.brake_wind().is_none_or(|largest| largest < self.axial) {
            let quarter = self.residual(FRAC_PI_2);
            let [low, high] =
                if quarter > 0.0 { [MINIMUM_ANGLE_RAD, FRAC_PI_2] } else { [FRAC_PI_2, PI - MINIMUM_ANGLE_RAD] };
            self.root(low, high)
        } else {
            self.root(-FRAC_PI_2, -MINIMUM_ANGLE_RAD)
        }
    }

    /// Largest wind of the propeller-brake state, eq. (B6): beyond it the thrust at a flow angle of zero is below the end of Buhl's parabola,
    /// so that there is a windmill state. `None` without thrust.
    fn brake_wind(&self) -> Option<f64> {
        let normal = self.coefficients(0.0, 1.0)[0];
        if normal <= 0.0 { None } else { Some((0.5 * self.annulus.solidity * normal).sqrt() * self.tangential) }
    }

    /// Force coefficients of the mirrored section along the wind and in the driving direction.
    fn coefficients(&self, sine: f64, cosine: f64) -> [f64; 2] {
        let [side, turn] = self.mirror;
        let attack_rad = self.attack_rad(sine, cosine);
        let PolarRow { lift, drag, .. } = match &self.held {
            None => self.polar.at(attack_rad),
            Some(held) => {
                let turns = ((held.attack_rad - attack_rad) / TAU).round();
                self.polar.in_interval(held.interval, attack_rad + TAU * turns)
            }
        };
        let (sine, cosine) = (side * sine, turn * cosine);
        [side * (lift * cosine + drag * sine), turn * (lift * sine - drag * cosine)]
    }

    /// `sin φ/(1 − a)` and `cos φ/(1 + a')`, eqs. (B3)–(B5): multiplied by the relative speed they give the wind and the speed of rotation.
    fn sides(&self, sine: f64, cosine: f64) -> [f64; 2] {
        let loss = self.annulus.loss(sine);
        let [normal, drive] = self.coefficients(sine, cosine);
        let share = self.annulus.solidity / (4.0 * loss * sine.abs());
        let k = share * normal / sine.abs();
        let axial = if sine < 0.0 {
            sine * (1.0 - k)
        } else {
            sine * windmill(k, loss, self.held.map_or(k > HEAVY, |held| held.heavy))
        };
        [axial, cosine - share * drive]
    }

    /// Ning's residual times `|sin φ|`, eq. (B3).
    fn residual(&self, angle_rad: f64) -> f64 {
        let (sine, cosine) = angle_rad.sin_cos();
        let [axial, tangential] = self.sides(sine, cosine);
        (self.tangential * axial - self.axial * tangential) * sine.abs()
    }

    /// Velocities through the annulus at its flow angle, relative to the speed of the inflow.
    fn passing(&self, angle_rad: f64) -> [f64; 2] {
        let (sine, cosine) = angle_rad.sin_cos();
        let [axial, tangential] = self.sides(sine, cosine);
        let speed = 1.0 / axial.hypot(tangential);
        [speed * sine, speed * cosine]
    }

    /// Root between two angles by Chandrupatla's method, which bisects where inverse quadratic interpolation is not safe. `None` if the
    /// residual has the same sign at both ends, or if the root is not a physical state.
    fn root(&self, low: f64, high: f64) -> Option<f64> {
        let (mut a, mut b) = (high, low);
        let (mut fa, mut fb) = (self.residual(a), self.residual(b));
        // there is no root either if the product is NaN
        if fa * fb > 0.0 || (fa * fb).is_nan() {
            return None;
        }
        let (mut c, mut fc);
        let mut share = 0.5;
        for _ in 0..MAXIMUM_ITERATIONS {
            let x = a + share * (b - a);
            let fx = self.residual(x);
            if (fx > 0.0) == (fa > 0.0) {
                (c, fc) = (a, fa);
            } else {
                (c, b, fc, fb) = (b, a, fb, fa);
            }
            (a, fa) = (x, fx);
            let (best, f_best) = if fa.abs() < fb.abs() { (a, fa) } else { (b, fb) };
            let limit = TOLERANCE_RAD / (b - a).abs();
            if limit > 0.5 || f_best == 0.0 {
                let (sine, cosine) = best.sin_cos();
                let [axial, tangential] = self.sides(sine, cosine);
                return (axial + tangential > 0.0).then_some(best);
            }
            let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
            share = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
                fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
            } else {
                0.5
            };
            share = share.clamp(limit, 1.0 - limit);
        }
        None
    }
}

/// `1/(1 − a)` of an annulus with flow in the direction of the wind, eqs. (B3) and (B5); continuous at 2/3. NaN where the relation of heavily
/// loaded annuli is continued beyond its end, at a load `2Fk` of `F(4/3 − F)`.
fn windmill(k: f64, loss: f64, heavy: bool) -> f64 {
    if !heavy {
        return 1.0 + k;
    }
    let load = 2.0 * loss * k;
    let g1 = load - (10.0 / 9.0 - loss);
    let root = (load - loss * (4.0 / 3.0 - loss)).sqrt();
    // (g1 − √g2)/g3 is 0/0 at g3 = 0; g1² − g2 = g3 (load − 4/9) gives a form without the quotient
    let a = if g1 > 0.0 { (load - 4.0 / 9.0) / (g1 + root) } else { (g1 - root) / (load - (25.0 / 9.0 - 2.0 * loss)) };
    1.0 / (1.0 - a)
}

#[cfg(test)]
#[path = "induction_tests.rs"]
mod tests;
