"""Linear models for control."""

from __future__ import annotations

import json
import re
import warnings
from typing import Any, Dict, List, NamedTuple, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

from . import _native
from .arguments import checked_methods
from .errors import UsageError
from .optional import needed
from .page import table
from .style import MAXIMUM_LABELS, curve, panels, style

Matrix = NDArray[np.float64]


class Signal(NamedTuple):
    """State, input or output of a linear model."""

    name: str
    """Name of the FMU variable; for a state, name of the free coordinate, or `der(…)` of it."""
    unit: str
    """Unit."""
    value: float
    """Value at the operating point."""


class DroppedMode(NamedTuple):
    """Mode of the full model that was truncated in the reduced model."""

    eigenvalue_1_s: complex
    """Eigenvalue in 1/s."""
    share: float
    """Largest gain of the mode divided by the largest gain of the full model in the range, for the worst pair of input and output."""


class Accuracy(NamedTuple):
    """Error of a reduced model from 0 to a frequency."""

    max_frequency_Hz: float
    """End of the range: `max_frequency_Hz` of the reduction; default: the fastest mode that was kept."""
    error: NDArray[np.float64]
    """Largest error divided by the largest gain in the range, from each input to each output, shape (outputs, inputs)."""
    dropped: List[DroppedMode]
    """Truncated modes in the range, slowest first, with `share` above 0.01. Not computed for models with `dt`."""


@checked_methods
class LinearModel:
    """Linear model `δẋ = A δx + B δu`, `δy = C δx + D δu` about an operating point; with `dt` in discrete time, `δx⁺ = A δx + B δu`.

    `print(model)` shows the operating point: time, joints, latches, loads and stability.
    """

    def __init__(
        self,
        A: Matrix,
        B: Matrix,
        C: Matrix,
        D: Matrix,
        *,
        states: Sequence[Signal],
        inputs: Sequence[Signal],
        outputs: Sequence[Signal],
        state: Optional[Dict[str, Any]] = None,
        about: str = "",
        dt: Optional[float] = None,
        error_bound: Optional[float] = None,
    ) -> None:
        self.A = A
        """Shape (states, states)."""
        self.B = B
        """Shape (states, inputs)."""
        self.C = C
        """Shape (outputs, states)."""
        self.D = D
        """Shape (outputs, inputs)."""
        self.states = list(states)
        """States: free coordinates, then their rates; generic names after a reduction."""
        self.inputs = list(inputs)
        """Inputs."""
        self.outputs = list(outputs)
        """Outputs."""
        self.state = state or {}
        """Operating point: `equilibrium`, `joints` (name, `angle_rad`, `motion`, `latch`), `acting` inputs, `growing_1_s`."""
        self.about = about
        """Operating point as text."""
        self.dt = dt
        """Sampling time in s; None for models in continuous time."""
        self.error_bound = error_bound
        """After `reduce`: H-infinity bound on the truncation error. None if no bound is available."""
        self.error_in_band: Optional[float] = None
        """After `reduce` with `max_frequency_Hz`: largest error up to that frequency, relative to the largest gain there from each input to
        each output."""
        self.accuracy: Optional[Accuracy] = None
        """After `reduce`: errors by input and output, and truncated modes. None for models with `dt` without `max_frequency_Hz`."""

    @classmethod
    def _of(cls, native: _native.LinearModel) -> LinearModel:
        described = json.loads(native.describe())
        A, B, C, D = native.matrices()
        states, inputs, outputs = ([Signal(**row) for row in described[key]] for key in ("states", "inputs", "outputs"))
        return cls(
            A, B, C, D, states=states, inputs=inputs, outputs=outputs, state=described["state"], about=native.about(),
            dt=described.get("step_s"),
        )

    @property
    def is_equilibrium(self) -> bool:
        """True if the operating point is a static equilibrium."""
        return bool(self.state.get("equilibrium", False))

    @property
    def joints(self) -> Dict[str, Dict[str, Any]]:
        """Joints by name: `angle_rad`, `motion` (`free`, `held`, `locked`, `prescribed`), `latch` (`closed`, `open`, `none`)."""
        return {joint["name"]: joint for joint in self.state.get("joints", [])}

    def __repr__(self) -> str:
        time = "" if self.dt is None else f", sampled every {self.dt:g} s"
        return (
            f"<foldwing.LinearModel: {len(self.A)} states, {len(self.inputs)} inputs, {len(self.outputs)} outputs{time}; "
            f"{self.about}>"
        )

    def frequency_response(self, frequency_Hz: Any) -> NDArray[np.complex128]:
        """Gains from each input to each output at frequencies in Hz, shape (frequencies, outputs, inputs).

        >>> import foldwing as fw
        >>> wing = fw.load("examples/models/folding_wing.toml")
        >>> model = wing.linearize(inputs="fold.external_torque", outputs="fold.angle", settings={"fold.release": False})
        >>> model.frequency_response([0.0, 1.0]).shape
        (2, 1, 1)
        """
        frequencies = np.atleast_1d(np.asarray(frequency_Hz, dtype=np.float64))
        s = 2j * np.pi * frequencies
        z = s if self.dt is None else np.exp(s * self.dt)
        unit = np.eye(len(self.A))
        return np.array([self.C @ np.linalg.solve(value * unit - self.A, self.B) + self.D for value in z], dtype=np.complex128)

    def plot(self, frequency_Hz: Any = None, *, axes: Any = None) -> Any:
        """Plot the Bode diagram: gain and phase in degrees from every input to every output, at most 14 pairs.

        Args:
            frequency_Hz: frequencies in Hz; default: 500 from a tenth of the slowest to twice the fastest oscillating mode.
            axes: two matplotlib axes, for gain and phase; default: a new figure.

        Returns:
            The figure.
        """
        if frequency_Hz is None:
            poles = self.poles() if self.dt is None else np.log(self.poles().astype(complex) + 1e-300) / self.dt
            modes_Hz = np.abs(poles[np.abs(poles.imag) > 1e-6]) / (2.0 * np.pi)
            low, high = (modes_Hz.min(), modes_Hz.max()) if len(modes_Hz) else (0.1, 10.0)
            end = 2.0 * high if self.dt is None else min(2.0 * high, 0.5 / self.dt)
            frequency_Hz = np.geomspace(0.1 * low, end, 500)
        frequencies = np.atleast_1d(np.asarray(frequency_Hz, dtype=np.float64))
        response = self.frequency_response(frequencies)
        pairs = [(output, input) for output in range(len(self.outputs)) for input in range(len(self.inputs))]
        with style() as pyplot:
            figure, places = panels(pyplot, 2, axes)
            for output, input in pairs[:MAXIMUM_LABELS]:
                gain = response[:, output, input]
                gain = np.where(gain == 0.0, np.nan, gain)  # zero gain cannot be drawn on a logarithmic axis and has no phase
                to, come = self.outputs[output], self.inputs[input]
                label = to.name if len(self.inputs) == 1 else f"{come.name} to {to.name}"
                curve(places[0], frequencies, np.abs(gain), label)
                known = np.isfinite(gain)
                curve(places[1], frequencies[known], np.degrees(np.unwrap(np.angle(gain[known]))), label)
            places[0].set_xscale("log")
            places[1].set_xscale("log")
            if np.any(response != 0.0):
                places[0].set_yscale("log")
            unit = f" ({self.outputs[0].unit} per {self.inputs[0].unit})" if len(pairs) == 1 else " (SI)"
            places[0].set_ylabel(f"gain{unit}")
            places[1].set_ylabel("phase (deg)")
            if len(pairs) > 1:
                places[0].legend(handles=[line for line in places[0].get_lines() if line.get_gid() == "curve"])
            if axes is None:
                source = f" from {self.inputs[0].name}" if len(self.inputs) == 1 else ""
                places[0].set_title(f"frequency response{source}")
            places[1].set_xlabel("frequency (Hz)")
        return figure

    def _repr_html_(self) -> str:
        rows = [(kind, signal.name, signal.unit, signal.value) for kind, signals in
                (("input", self.inputs), ("output", self.outputs), ("state", self.states)) for signal in signals]
        return table(repr(self)[1:-1].split(";")[0], ("", "name", "unit", "operating point"), rows, self.about)

    def poles(self) -> NDArray[np.complex128]:
        """Eigenvalues of `A`, in 1/s without `dt`, smallest first, shape (states,)."""
        poles = np.linalg.eigvals(self.A).astype(np.complex128)
        return np.asarray(poles[np.argsort(np.abs(poles), kind="stable")])

    def to_control(self) -> Any:
        """Convert to a python-control `StateSpace`, with names of letters, digits and underscores (`fold_external_torque`)."""
        control = needed("control")
        names = {key: plain_names([signal.name for signal in getattr(self, key)]) for key in ("states", "inputs", "outputs")}
        return control.StateSpace(self.A, self.B, self.C, self.D, 0 if self.dt is None else self.dt, **names)

    def discretize(self, dt: float) -> LinearModel:
        """Discretize with sampling time `dt` in s and zero-order hold: exact for piecewise constant inputs."""
        if self.dt is not None:
            raise UsageError(f"discretize: the model is already discrete, with steps of {self.dt:g} s")
        if not 0.0 < dt < float("inf"):
            raise UsageError(f"discretize({dt}): must be a positive, finite number of seconds")
        A, B = _native.discretized(self.A, self.B, dt)
        return self._with(A, B, self.C, self.D, self.states, dt, self.error_bound)

    def reduce(self, order: int, *, method: str = "balanced", max_frequency_Hz: Optional[float] = None) -> LinearModel:
        """Reduce the number of states; the static gain is kept in continuous time.

        Args:
            order: number of states.
            method: `balanced`: balanced truncation, independent of the units of inputs and outputs, with an error bound; `modal`: modal
                truncation to the slowest modes. Models with `dt` allow `balanced` only and must be stable. In continuous time, the
                unstable and undamped subsystem is kept completely.
            max_frequency_Hz: band-limited balancing up to this frequency. `error_in_band` is then the largest error in the band, relative
                to the largest gain there between the same input and output; the result can have fewer states.

        Warns if modes in the range of `accuracy` were truncated.
        """
        if method not in ("balanced", "modal"):
            raise UsageError(f"method={method!r}: allowed are balanced and modal")
        band = None if max_frequency_Hz is None else float(max_frequency_Hz)
        A, B, C, D, bound, _, measured = _native.reduced(self.A, self.B, self.C, self.D, order, method == "modal", self.dt, band)
        states = [Signal(f"{method}_{i + 1}", "1", 0.0) for i in range(len(A))]
        small = self._with(A, B, C, D, states, self.dt, bound)
        if measured is not None:
            end_Hz, error, eigenvalues_1_s, shares = measured
            dropped = [DroppedMode(complex(*value), share) for value, share in zip(eigenvalues_1_s, shares)]
            small.accuracy = Accuracy(end_Hz, error, dropped)
            if band is not None:
                small.error_in_band = float(error.max(initial=0.0))
            if dropped:
                list_Hz = ", ".join(f"{abs(mode.eigenvalue_1_s) / (2.0 * np.pi):.4g}" for mode in dropped[:3])
                rest = f" and {len(dropped) - 3} more" if len(dropped) > 3 else ""
                advice = "" if band is not None else "balance for a frequency band (max_frequency_Hz), "
                warnings.warn(
                    f"the reduced model omits modes at {list_Hz}{rest} Hz, below {end_Hz:.4g} Hz; {advice}keep more states, or take fewer inputs "
                    "and outputs",
                    stacklevel=2,
                )
        return small

    def hankel_singular_values(self) -> NDArray[np.float64]:
        """Hankel singular values with scaled inputs and outputs, largest first. Infinite for the unstable or undamped subsystem; models with
        `dt` must be stable."""
        values = _native.reduced(self.A, self.B, self.C, self.D, len(self.A), False, self.dt, None)[5]
        return np.asarray(values)

    def _with(
        self, A: Matrix, B: Matrix, C: Matrix, D: Matrix, states: Sequence[Signal], dt: Optional[float], bound: Optional[float]
    ) -> LinearModel:
        return LinearModel(
            A, B, C, D, states=states, inputs=self.inputs, outputs=self.outputs, state=self.state, about=self.about, dt=dt,
            error_bound=bound,
        )


def plain_names(names: Sequence[str]) -> List[str]:
    """Convert to unique names of letters, digits and underscores.

    >>> plain_names(["fold.external_torque", "load.outer[4].force.z", "der(outer.kappa_y[1])"])
    ['fold_external_torque', 'load_outer_4_force_z', 'der_outer_kappa_y_1']
    """
    taken: Dict[str, int] = {}
    plain = []
    for name in names:
        text = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "x"
        taken[text] = taken.get(text, 0) + 1
        plain.append(text if taken[text] == 1 else f"{text}_{taken[text]}")
    return plain
