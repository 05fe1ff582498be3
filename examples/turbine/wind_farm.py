"""Controller and wake of two turbines in a row, as an FMU: `pythonfmu build -f wind_farm.py nrel_controller.py` (`pip install pythonfmu`).
Used by two_turbines_ssp.py."""

import math
from collections import deque

from nrel_controller import RATED_POWER_W, Controller
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

GEAR_RATIO = 97.0
ROTOR_RADIUS_M = 63.0
TURBINES = ("front", "back")


def deficit(thrust_coefficient, spacing_m, expansion):
    """Deficit of the wind behind a rotor as a fraction of the wind, uniform over the wake: N. O. Jensen, A note on wind generator
    interaction, Risø-M-2411 (1983), with the thrust coefficient of I. Katić, J. Højstrup and N. O. Jensen, A simple model for cluster
    efficiency, EWEC'86: `(1 − √(1 − C_T)) / (1 + k x/R)²`. `expansion` is the widening `k` of the wake's radius per distance, 0.075 on land.
    Momentum theory holds up to a thrust coefficient of 1, to which larger ones are limited."""
    return (1.0 - math.sqrt(1.0 - min(max(thrust_coefficient, 0.0), 1.0))) / (1.0 + expansion * spacing_m / ROTOR_RADIUS_M) ** 2


class Farm:
    """Two reference controllers that share a demanded power, and the wake of the front turbine, which arrives after `spacing_m / wind_m_s`.
    All steps are equal.

    Each turbine is to deliver half of `demand_W`, plus the shortfall of the other one, up to its rated power. Powers are mechanical, at the
    generators.
    """

    def __init__(self, wind_m_s, demand_W, spacing_m, expansion, speed_rad_s):
        self.wind_m_s, self.demand_W, self.spacing_m, self.expansion = wind_m_s, demand_W, spacing_m, expansion
        self.controllers = {name: Controller(GEAR_RATIO * speed_rad_s[name], rated_W=self.share_W(0.0)) for name in TURBINES}
        self.power_W = dict.fromkeys(TURBINES, math.inf)
        self.wind = dict.fromkeys(TURBINES, wind_m_s)
        self.wake = deque()  # deficits that are on their way, in steps

    def share_W(self, lack_W):
        """Power for a turbine if the other one delivers `lack_W` less than its half."""
        return min(0.5 * self.demand_W + max(lack_W, 0.0), RATED_POWER_W)

    def step(self, speed_rad_s, thrust_coefficient, step_s):
        """Advances by `step_s` seconds: speeds of the shafts in rad/s by turbine, thrust coefficient of the front rotor."""
        for name, other in zip(TURBINES, reversed(TURBINES)):
            self.controllers[name].rated_W = self.share_W(0.5 * self.demand_W - self.power_W[other])
        for name in TURBINES:
            generator_rad_s = GEAR_RATIO * speed_rad_s[name]
            torque_N_m, _ = self.controllers[name].step(generator_rad_s, step_s)
            self.power_W[name] = torque_N_m * generator_rad_s
        self.wake.append(deficit(thrust_coefficient, self.spacing_m, self.expansion))
        if len(self.wake) * step_s >= self.spacing_m / self.wind_m_s:
            self.wind["back"] = self.wind_m_s * (1.0 - self.wake.popleft())


class WindFarm(Fmi2Slave):
    """[`Farm`] with a getter for each output: torques and speeds of the slow shafts in N·m and rad/s, pitch in rad, wind in m/s, power in
    W."""

    PARAMETERS = {"wind": 11.4, "demand": 8e6, "spacing": 378.0, "expansion": 0.075, "start_speed_front": 1.267, "start_speed_back": 1.267}
    INPUTS = [f"speed_{name}" for name in TURBINES] + ["thrust_coefficient_front"]

    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.farm = None  # until the first step
        for name, value in self.PARAMETERS.items():
            setattr(self, name, value)
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed))
        for name in self.INPUTS:
            setattr(self, name, 0.0)
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in TURBINES:
            for output, value in (("torque", self.torque), ("pitch", self.pitch), ("wind", self.wind_at)):
                self.register_variable(Real(f"{output}_{name}", causality=Fmi2Causality.output, getter=lambda value=value, name=name: value(name)))

    def state(self):
        """The current farm; before the first step, when importers already read outputs, a farm with the current parameters."""
        if self.farm is not None:
            return self.farm
        start = {name: getattr(self, f"start_speed_{name}") for name in TURBINES}
        return Farm(self.wind, self.demand, self.spacing, self.expansion, start)

    def torque(self, name):
        return -GEAR_RATIO * self.state().controllers[name].torque_N_m

    def pitch(self, name):
        return self.state().controllers[name].pitch_rad

    def wind_at(self, name):
        return self.state().wind[name]

    def do_step(self, time_s, step_s):
        self.farm = self.state()
        speeds = {name: getattr(self, f"speed_{name}") for name in TURBINES}
        if any(speeds.values()):  # otherwise nothing has arrived yet: inputs are 0 in the first step of FMPy
            self.farm.step(speeds, self.thrust_coefficient_front, step_s)
        return True
