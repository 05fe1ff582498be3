#!/usr/bin/env python3
"""Calls `fmi2GetDerivatives` of an unpacked FMU CALLS times, each time with different states; for `count_instructions.py`.

  python tools/call_derivatives.py FOLDER CALLS
"""
import ctypes
import math
import pathlib
import re
import sys

MODEL_EXCHANGE = 0
LOGGER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
ALLOCATE = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t)
RELEASE = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
FINISHED = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int)


class Callbacks(ctypes.Structure):
    _fields_ = [("logger", LOGGER), ("allocate", ALLOCATE), ("release", RELEASE), ("finished", FINISHED), ("environment", ctypes.c_void_p)]


def main():
    folder, calls = pathlib.Path(sys.argv[1]).resolve(), int(sys.argv[2])
    description = (folder / "modelDescription.xml").read_text()
    guid = re.search(r'guid="([^"]+)"', description)[1]
    states = len(re.findall(r"derivative=", description))
    library = ctypes.CDLL(str(next((folder / "binaries").glob("*/*"))))
    callbacks = Callbacks(LOGGER(lambda *words: print(words[4], file=sys.stderr)), ALLOCATE(), RELEASE(), FINISHED(), None)
    library.fmi2Instantiate.restype = ctypes.c_void_p
    resources = (folder / "resources").as_uri().encode()
    instance = ctypes.c_void_p(library.fmi2Instantiate(b"instance", MODEL_EXCHANGE, guid.encode(), resources, ctypes.byref(callbacks), 0, 0))
    vector = ctypes.c_double * states
    ok("fmi2SetupExperiment", library.fmi2SetupExperiment(instance, 0, ctypes.c_double(0.0), ctypes.c_double(0.0), 0, ctypes.c_double(0.0)))
    for name in ["fmi2EnterInitializationMode", "fmi2ExitInitializationMode"]:
        ok(name, getattr(library, name)(instance))
    event = (ctypes.c_int * 8)()
    ok("fmi2NewDiscreteStates", library.fmi2NewDiscreteStates(instance, event))
    ok("fmi2EnterContinuousTimeMode", library.fmi2EnterContinuousTimeMode(instance))
    start, moved, slopes = vector(), vector(), vector()
    ok("fmi2GetContinuousStates", library.fmi2GetContinuousStates(instance, start, ctypes.c_size_t(states)))
    for call in range(calls):
        for i in range(states):
            moved[i] = start[i] + 1e-6 * math.sin(call + i)
        ok("fmi2SetContinuousStates", library.fmi2SetContinuousStates(instance, moved, ctypes.c_size_t(states)))
        ok("fmi2GetDerivatives", library.fmi2GetDerivatives(instance, slopes, ctypes.c_size_t(states)))


def ok(name, status):
    if status > 1:
        sys.exit(f"{name}: status {status}")


if __name__ == "__main__":
    main()
