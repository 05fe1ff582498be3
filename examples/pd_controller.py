"""A controller of a hinge as an FMU: `pythonfmu build -f pd_controller.py` (`pip install pythonfmu`). Used by controlled_wing_ssp.py."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Controller(Fmi2Slave):
    """Torque in N·m that turns a hinge to `target`: spring in N·m/rad and damper in N·m·s/rad, limited in N·m."""

    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.angle, self.rate, self.torque = 0.0, 0.0, 0.0
        self.target, self.stiffness, self.damping, self.limit = 0.0, 0.02, 0.0, 0.15
        for name in ("target", "stiffness", "damping", "limit"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))
        self.register_variable(Real("angle", causality=Fmi2Causality.input))
        self.register_variable(Real("rate", causality=Fmi2Causality.input))
        self.register_variable(Real("torque", causality=Fmi2Causality.output))

    def do_step(self, time_s, step_s):
        torque = self.stiffness * (self.target - self.angle) - self.damping * self.rate
        self.torque = max(-self.limit, min(self.limit, torque))
        return True
