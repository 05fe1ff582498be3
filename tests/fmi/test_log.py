"""Log messages as importers receive them: the text is a printf format, so every percent sign must be doubled."""

import re
from pathlib import Path

import pytest
from driving import instance
from fmpy import calloc, free
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)

ENVIRONMENT = 0x1234  # passed on unchanged, never read


def recording_callbacks():
    """Callbacks that store every message as it arrives, before any formatting."""
    messages = []

    def log(environment, name, status, category, message):
        messages.append((environment, name.decode(), status, category.decode(), message.decode()))

    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(log)
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
    callbacks.componentEnvironment = ENVIRONMENT
    return callbacks, messages


def test_f30_percent_signs_are_doubled(wing):
    """F-30. In a message that quotes text with printf directives each percent sign is doubled, so that printf restores it.

    Without doubling, `%s%n` would read and write arguments that do not exist.
    """
    callbacks, messages = recording_callbacks()
    with instance(wing, callbacks=callbacks) as fmu:
        with pytest.raises(FMICallException):
            fmu.slave.setDebugLogging(True, ["100%s%n%"])
    quoting = [text for *_, text in messages if "100" in text]
    assert quoting, messages
    for text in quoting:
        assert "%" not in text.replace("%%", ""), text
        assert "100%s%n%" in text.replace("%%", "%")


def test_f31_messages_name_their_instance_and_a_declared_category(wing):
    """F-31. Messages contain the instance's name, a declared category and the importer's environment pointer.

    The message of the event gives the joint, the event and the time.
    """
    callbacks, messages = recording_callbacks()
    declared = set(re.findall(r'<Category name="(\w+)"', Path(wing.folder, "modelDescription.xml").read_text()))
    with instance(wing, name="left wing", callbacks=callbacks, logging=True) as fmu:
        fmu.initialize().advance(130, 1e-3)
        with pytest.raises(FMICallException):
            fmu.set("fold.angle_command", float("nan"))
    assert [category for *_, category, _ in messages] == ["logEvents", "logStatusDiscard"], messages
    assert re.fullmatch(r"fmi2DoStep: joint fold: latch closed at t = 0\.122\d{6} s", messages[0][-1]), messages[0]
    for environment, name, _, category, text in messages:
        assert environment == ENVIRONMENT
        assert name == "left wing"
        assert category in declared, (category, text)
        assert "%" not in text.replace("%%", ""), text


def test_f32_nothing_is_logged_when_nothing_happens(wing):
    """F-32. With logging off an ordinary run sends no messages."""
    callbacks, messages = recording_callbacks()
    with instance(wing, callbacks=callbacks) as fmu:
        fmu.initialize().advance(130, 1e-3)
    assert messages == []
