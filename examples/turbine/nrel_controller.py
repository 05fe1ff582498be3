"""Controller of the NREL 5 MW reference turbine: generator torque as a function of speed, and collective pitch.

Written from the equations and Table 7-2 of Jonkman, Butterfield, Musial and Scott, Definition of a 5-MW Reference Wind Turbine
for Offshore System Development, NREL/TP-500-38060 (2009), chapter 7. Values are from that table unless noted otherwise.
"""

import math

RPM = math.pi / 30.0  # rad/s

CORNER_HZ = 0.25  # corner frequency of the low-pass filter of the generator speed
RATED_SPEED_RAD_S = 1173.7 * RPM  # generator speed: set point of pitch control
RATED_POWER_W = 5.296610e6  # mechanical power at the generator
SQUARE_GAIN_N_M_RPM2 = 0.0255764  # region 2: torque divided by the square of the speed, maximum power
CUT_IN_RPM = 670.0  # end of region 1: no torque below this speed (section 7.2)
REGION_2_RPM = 871.0  # start of region 2, 30 % above this (section 7.2)
REGION_3_RPM = 1161.963  # start of region 3, 99 % of the rated speed
SLIP = 0.10  # region 2½: an induction machine with this slip
MAXIMUM_TORQUE_N_M = 47_402.91  # 10 % above rated
MAXIMUM_TORQUE_RATE_N_M_S = 15_000.0
REGION_3_PITCH_RAD = math.radians(1.0)  # above this pitch, constant power at any speed

PROPORTIONAL_S = 0.01882681  # rad of pitch per rad/s of speed, at pitch 0
INTEGRAL = 0.008068634  # rad of pitch per rad of generator rotation
DOUBLED_RAD = math.radians(6.302336)  # pitch at which the sensitivity of power to pitch is twice that at pitch 0
MINIMUM_PITCH_RAD, MAXIMUM_PITCH_RAD = 0.0, math.radians(90.0)
MAXIMUM_PITCH_RATE_RAD_S = math.radians(8.0)


def torque_N_m(speed_rad_s, pitch_rad, rated_W=RATED_POWER_W):
    """Generator torque in N·m at a filtered generator speed in rad/s and a pitch in rad: regions 1 to 3 of section 7.2."""
    rpm = speed_rad_s / RPM
    if pitch_rad >= REGION_3_PITCH_RAD or rpm >= REGION_3_RPM:
        return rated_W / max(speed_rad_s, CUT_IN_RPM * RPM)  # 3: constant power
    if rpm <= CUT_IN_RPM:
        return 0.0  # 1: start-up
    if rpm < REGION_2_RPM:  # 1½: linear transition to region 2
        return SQUARE_GAIN_N_M_RPM2 * REGION_2_RPM**2 * (rpm - CUT_IN_RPM) / (REGION_2_RPM - CUT_IN_RPM)
    # 2½: linear from zero torque at the synchronous speed to that of region 3; it intersects the quadratic law between the two
    synchronous_rpm = REGION_3_RPM / (1.0 + SLIP)
    slope = rated_W / (REGION_3_RPM * RPM) / (REGION_3_RPM - synchronous_rpm)
    return max(SQUARE_GAIN_N_M_RPM2 * rpm**2, slope * (rpm - synchronous_rpm))


class Controller:
    """Discrete-time controller: low-pass filter, torque control, PI pitch control with gain scheduling on pitch.

    `pitch_rad` is the initial pitch, which initialises the integrator; `rated_W` the mechanical power in region 3.
    """

    def __init__(self, speed_rad_s, pitch_rad=0.0, rated_W=RATED_POWER_W):
        self.rated_W = rated_W
        self.speed_rad_s = speed_rad_s
        self.pitch_rad = pitch_rad
        self.torque_N_m = torque_N_m(speed_rad_s, pitch_rad, rated_W)
        self.integral_rad = pitch_rad / (gain(pitch_rad) * INTEGRAL)

    def step(self, speed_rad_s, step_s):
        """Torque in N·m and pitch command in rad for the next `step_s` seconds, from the generator's speed in rad/s."""
        kept = math.exp(-2.0 * math.pi * CORNER_HZ * step_s)  # section 7.1, eq. (7-1)
        self.speed_rad_s = (1.0 - kept) * speed_rad_s + kept * self.speed_rad_s

        wanted = min(torque_N_m(self.speed_rad_s, self.pitch_rad, self.rated_W), MAXIMUM_TORQUE_N_M)
        self.torque_N_m = approach(self.torque_N_m, wanted, MAXIMUM_TORQUE_RATE_N_M_S * step_s)

        now = gain(self.pitch_rad)
        error = self.speed_rad_s - RATED_SPEED_RAD_S
        bounds = (bound / (now * INTEGRAL) for bound in (MINIMUM_PITCH_RAD, MAXIMUM_PITCH_RAD))
        self.integral_rad = clamp(self.integral_rad + error * step_s, *bounds)  # anti-windup: limited with the pitch
        wanted = now * (PROPORTIONAL_S * error + INTEGRAL * self.integral_rad)
        wanted = clamp(wanted, MINIMUM_PITCH_RAD, MAXIMUM_PITCH_RAD)
        self.pitch_rad = approach(self.pitch_rad, wanted, MAXIMUM_PITCH_RATE_RAD_S * step_s)
        return self.torque_N_m, self.pitch_rad


def gain(pitch_rad):
    """Gain-scheduling factor: the sensitivity of power to pitch increases with pitch (section 7.3)."""
    return 1.0 / (1.0 + pitch_rad / DOUBLED_RAD)


def clamp(value, low, high):
    """Limit a value to its bounds."""
    return min(max(value, low), high)


def approach(value, wanted, largest):
    """Rate limiter: move a value towards the target by at most `largest`."""
    return value + clamp(wanted - value, -largest, largest)
