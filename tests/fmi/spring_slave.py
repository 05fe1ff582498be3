"""A mass on a spring, made into an FMU by PythonFMU: one variable of each type."""

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real, String

INNER_STEPS = 10


class SpringMass(Fmi2Slave):
    """Unit mass, semi-implicit Euler with fixed internal steps."""

    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.stiffness, self.force = 40.0, 0.0
        self.position, self.velocity = 0.1, 0.0
        self.steps, self.moving, self.label = 0, False, "spring"
        tunable = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.tunable}
        discrete = {"causality": Fmi2Causality.output, "variability": Fmi2Variability.discrete}
        self.register_variable(Real("stiffness", **tunable))
        self.register_variable(Real("force", causality=Fmi2Causality.input))
        self.register_variable(Real("position", causality=Fmi2Causality.output))
        self.register_variable(Real("velocity", causality=Fmi2Causality.output))
        self.register_variable(Integer("steps", **discrete))
        self.register_variable(Boolean("moving", **discrete))
        self.register_variable(String("label", **tunable))

    def do_step(self, time_s, step_s):
        for _ in range(INNER_STEPS):
            self.velocity += (self.force - self.stiffness * self.position) * step_s / INNER_STEPS
            self.position += self.velocity * step_s / INNER_STEPS
        self.steps += 1
        self.moving = abs(self.velocity) > 1e-3
        return True
