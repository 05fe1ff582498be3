"""The FMU from an importer's side: loading and unloading, rates of outputs, derivatives with aerodynamics, cost of a step, a light carrier.

`python3 studies/audit/fmi.py [NAME]`; `FOLDWING` names the command whose FMU is examined. Linux only (`dlclose`, `/proc`).
"""

from __future__ import annotations

import ctypes
import subprocess
import sys
import time
import xml.etree.ElementTree as xml
import zipfile
from pathlib import Path

import numpy as np
from machine import CHECKOUT, FOLDWING, WORK

MODELS = CHECKOUT / "examples/models"
OK = 0
TYPES = {"Real": ctypes.c_double, "Integer": ctypes.c_int, "Boolean": ctypes.c_int}
LOG = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, use_errno=False
)


class Callbacks(ctypes.Structure):
    """`fmi2CallbackFunctions`."""

    _fields_ = [
        ("logger", LOG),
        ("allocate", ctypes.c_void_p),
        ("free", ctypes.c_void_p),
        ("finished", ctypes.c_void_p),
        ("environment", ctypes.c_void_p),
    ]


class Archive:
    """The FMU of a shipped model, unpacked, with the value references and types of its variables."""

    def __init__(self, model: str):
        self.folder = WORK / model
        if not self.folder.exists():
            archive = WORK / f"{model}.fmu"
            package = [FOLDWING, "package", str(MODELS / f"{model}.toml"), "-o", str(archive), "--no-reference"]
            subprocess.run(package, check=True, capture_output=True)
            zipfile.ZipFile(archive).extractall(self.folder)
        root = xml.parse(self.folder / "modelDescription.xml").getroot()
        self.guid = root.get("guid")
        self.flags = root.find("CoSimulation").attrib
        rows = root.find("ModelVariables")
        self.variables = {row.get("name"): (int(row.get("valueReference")), row[0].tag) for row in rows}
        self.real_outputs = [row.get("name") for row in rows if row.get("causality") == "output" and row[0].tag == "Real"]
        self.real_inputs = [row.get("name") for row in rows if row.get("causality") == "input" and row[0].tag == "Real"]

    def load(self) -> ctypes.CDLL:
        return ctypes.CDLL(str(self.folder / f"binaries/linux64/{self.flags['modelIdentifier']}.so"))


class Instance:
    """One instance between initialisation and release."""

    def __init__(self, archive: Archive, **start):
        self.archive, self.library, self.time_s, self.messages = archive, archive.load(), 0.0, []
        self.log = LOG(lambda _, name, status, category, text: self.messages.append(text.decode()))
        self.callbacks = Callbacks(self.log, None, None, None, None)
        make = self.library.fmi2Instantiate
        make.restype = ctypes.c_void_p
        place = ("file://" + str(archive.folder / "resources")).encode()
        made = make(b"wing", 1, archive.guid.encode(), place, ctypes.byref(self.callbacks), 0, 0)
        assert made, self.messages
        self.handle = ctypes.c_void_p(made)
        for name, value in start.items():
            self.set(name, value)
        self.call("fmi2EnterInitializationMode")
        self.call("fmi2ExitInitializationMode")

    def call(self, function: str, *arguments, refusal: bool = False) -> int:
        status = getattr(self.library, function)(self.handle, *arguments)
        assert refusal or status == OK, self.messages[-1:]
        return status

    def references(self, names: list[str]) -> tuple[ctypes.Array, int]:
        return (ctypes.c_uint * len(names))(*(self.archive.variables[name][0] for name in names)), len(names)

    def get(self, *names: str) -> list[float]:
        """Values of Real variables."""
        values = (ctypes.c_double * len(names))()
        self.call("fmi2GetReal", *self.references(list(names)), values)
        return list(values)

    def set(self, name: str, value: float) -> None:
        kind = self.archive.variables[name][1]
        self.call(f"fmi2Set{kind}", *self.references([name]), ctypes.byref(TYPES[kind](value)))

    def rates(self, *names: str) -> list[float]:
        """Time derivatives of outputs."""
        values = (ctypes.c_double * len(names))()
        orders = (ctypes.c_int * len(names))(*[1] * len(names))
        self.call("fmi2GetRealOutputDerivatives", *self.references(list(names)), orders, values)
        return list(values)

    def directional(self, unknowns: list[str], known: str) -> list[float] | None:
        """Derivatives of outputs with respect to an input; None if they are rejected."""
        values, seed = (ctypes.c_double * len(unknowns))(), ctypes.c_double(1.0)
        status = self.call(
            "fmi2GetDirectionalDerivative",
            *self.references(unknowns),
            *self.references([known]),
            ctypes.byref(seed),
            values,
            refusal=True,
        )
        return list(values) if status == OK else None

    def step(self, step_s: float) -> int:
        status = self.call(
            "fmi2DoStep", ctypes.c_double(self.time_s), ctypes.c_double(step_s), ctypes.c_int(1), refusal=True
        )
        self.time_s += step_s * (status == OK)
        return status

    def to(self, time_s: float) -> Instance:
        assert self.step(time_s - self.time_s) == OK, self.messages
        return self

    def save(self) -> ctypes.c_void_p:
        state = ctypes.c_void_p()
        self.call("fmi2GetFMUstate", ctypes.byref(state))
        return state

    def restore(self, state: ctypes.c_void_p, time_s: float) -> None:
        self.call("fmi2SetFMUstate", state)
        self.time_s = time_s

    def free(self) -> None:
        getattr(self.library, "fmi2FreeInstance")(self.handle)


def unload() -> None:
    """Resident memory over 200 cycles of loading, running, freeing and unloading."""
    archive = Archive("folding_wing")
    system = ctypes.CDLL(None)
    resident_kib = lambda: int(Path("/proc/self/statm").read_text().split()[1]) * 4  # noqa: E731
    for cycle in range(220):
        instance = Instance(archive).to(0.01)
        instance.free()
        system.dlclose(ctypes.c_void_p(instance.library._handle))
        if cycle == 19:
            early_kib = resident_kib()
    print(f"unload: {(resident_kib() - early_kib) / 200:.1f} KiB stay behind after each unloading; right: 0")


def rates() -> None:
    """Time derivatives of outputs that depend on accelerations, compared with central differences of the outputs."""
    names = ["gauge.root.strain", "tip.acceleration.x", "root.force.x", "root.force.z", "root.moment.y"]
    side_s = 1e-7
    worst = {name: [] for name in names}
    for time_s in np.arange(0.0203, 0.11, 0.0053):
        instance = Instance(Archive("folding_wing")).to(time_s - side_s)
        low = np.array(instance.get(*names))
        given = np.array(instance.to(time_s).rates(*names))
        slope = (np.array(instance.to(time_s + side_s).get(*names)) - low) / (2 * side_s)
        for name, error in zip(names, abs(given / slope - 1)):
            worst[name].append(error)
        instance.free()
    for name, errors in worst.items():
        print(f"rates: {name}: median error {np.median(errors):.1e} of the slope; right: below 1e-3")


def derivatives_in_air() -> None:
    """Directional derivatives in the tunnel, compared with differences of short steps from one state."""
    archive = Archive("folding_wing_in_tunnel")
    print(f"derivatives in air: providesDirectionalDerivative = {archive.flags['providesDirectionalDerivative']}; right: false")
    instance = Instance(archive).to(0.02)
    outputs = ["root.force.z", "aero.force.z", "tip.acceleration.z"]
    given = instance.directional(outputs, "wind.velocity.z")
    if given is None:
        print(f"derivatives in air: refused: {instance.messages[-1]}")
        return
    state, sides = instance.save(), []
    for sign in (1, -1):
        instance.restore(state, 0.02)
        instance.set("wind.velocity.z", 0.01 * sign)
        sides.append(np.array(instance.to(0.02 + 1e-9).get(*outputs)))
    for name, derivative, difference in zip(outputs, given, (sides[0] - sides[1]) / 0.02):
        print(f"derivatives in air: d {name} / d wind.velocity.z = {derivative:.3e}, by steps {difference:.3e}")


def blocking_step() -> None:
    """A step of 1e-12 s under an extreme load."""
    instance = Instance(Archive("folding_wing_in_tunnel")).to(0.002)
    instance.set("load.outer[2].force.x", 1e6)
    begin = time.monotonic()
    status = instance.step(1e-12)
    told = instance.messages[-1] if instance.messages else "nothing"
    print(f"blocking step: {time.monotonic() - begin:.1f} s, status {status}: {told}; right: refused at once")


def light_carrier() -> None:
    """A fuselage that `root.force` accelerates and that moves the root: largest acceleration as a function of its mass."""
    for axes, step_s in ((("z",), 5e-4), (("z",), 5e-3), (("x", "y", "z"), 5e-4), (("x", "y", "z"), 5e-3)):
        for mass_kg in (0.5, 0.13, 0.07, 0.06, 0.05, 0.04, 0.03, 0.01):
            instance = Instance(Archive("folding_wing"))
            largest, status = 0.0, OK
            while status == OK and instance.time_s < 0.4:
                acceleration = np.array(instance.get(*(f"root.force.{axis}" for axis in axes))) / mass_kg
                largest = max(largest, abs(acceleration).max())
                for axis, value in zip(axes, acceleration):
                    instance.set(f"root.acceleration.{axis}", value)
                status = instance.step(step_s)
            told = instance.messages[-1] if status != OK else "to the end"
            print(f"light carrier: {''.join(axes)}, {step_s:g} s, {mass_kg:g} kg: up to {largest:.3g} m/s2 at {instance.time_s:.4f} s, {told}")
            instance.free()


if __name__ == "__main__":
    looks = {look.__name__: look for look in (unload, rates, derivatives_in_air, light_carrier, blocking_step)}
    for look in [looks[name] for name in sys.argv[1:]] or looks.values():
        look()
