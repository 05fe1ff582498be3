"""Models with the names of 0.1.0, for comparisons with commands of that version."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from old_names import COLUMNS, Command, in_old_names, table  # noqa: E402

MODEL = """\
[section.s]
youngs_modulus_Pa = 60e9
[body.b]
axis = { eta = [0.0, 1.0], twist_deg = [0, 1] }
[joint.motor]
child = "b"
[joint.motor.motor]
command_deg = 1.0
[joint.fold]
motor = { stiffness_N_m_rad = 1.0 }
table_ends = "extrapolate"
[failure.f]
kind = "motor_loss"
[control_surface.aileron]
body = "b"
[simulation]
stop_time_s = 1.0
"""


def test_keys_values_and_tables_are_those_of_the_old_reader():
    old = in_old_names(MODEL)
    assert old == (
        MODEL.replace("youngs_modulus_Pa", "young_Pa").replace("eta =", "share =").replace("[joint.motor.motor]", "[joint.motor.drive]")
        .replace("motor = {", "drive = {").replace("extrapolate", "onward").replace("motor_loss", "drive_dies")
        .replace("[control_surface.", "[flap.").replace("[simulation]", "[experiment]"))


def test_every_row_of_the_table_is_read():
    assert len(table("KEYS")) >= 29 and len(table("VALUES")) >= 16


def test_columns_of_an_old_command_get_the_names_of_today():
    old = Command.__new__(Command)
    old.is_old = True
    names = {"fold.torque": "fold.external_torque", "rotor.torque": "rotor.torque", "root.force.x": "root.force.x", "tip_b.position.x": "tip.b.position.x",
             "fold.applied_torque": "fold.total_torque", "section_load.q.force.x": "internal_load.q.force.x", "energy.drive": "energy.motor"}
    assert {name: old.column(name) for name in names} == names
    assert len(COLUMNS) == 6
