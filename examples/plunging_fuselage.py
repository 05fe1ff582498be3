"""A fuselage that moves vertically, as an FMU: `pythonfmu build -f plunging_fuselage.py` (`pip install pythonfmu`). Used by
plunging_aircraft_ssp.py."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Fuselage(Fmi2Slave):
    """Rigid body of `mass` in kg under gravity and the forces of two wings in N; height in m, velocity in m/s, acceleration in m/s2."""

    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.mass, self.gravity = 3.0, 9.81
        self.right_force, self.left_force = 0.0, 0.0
        self.height, self.velocity, self.acceleration = 0.0, 0.0, 0.0
        for name in ("mass", "gravity"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))
        for name in ("right_force", "left_force"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("height", "velocity", "acceleration"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def do_step(self, time_s, step_s):
        # the forces of the last communication point: first order
        self.acceleration = (self.right_force + self.left_force) / self.mass - self.gravity
        self.height += step_s * self.velocity + 0.5 * step_s**2 * self.acceleration
        self.velocity += step_s * self.acceleration
        return True
