"""When a falsified vehicle file counts as seen through."""

import sys
import tomllib
from copy import deepcopy
from pathlib import Path

import pytest

HOME = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(HOME / "scripts" / "prove"))

from falsify import VehicleFolder, falsifications  # noqa: E402
from semi_real import judge  # noqa: E402

RIGHT = VehicleFolder(HOME / "models" / "crazyflie_real" / "vehicle.toml")


def finding(effect, alike=(), **parameters):
    return {"effect": effect, "class": [effect, *alike], "parameters": {name: {"value": value, "std": 0.001} for name, value in parameters.items()}}


def diagnosis(*effects):
    return {"verdict": "explained", "effects": list(effects), "calibration": [], "rejected": [], "alarms": [], "log_findings": []}


def row(case, base, found):
    wrong = falsifications(RIGHT)[case]
    wrong_file = deepcopy(RIGHT)
    wrong.change(wrong_file)
    return judge(case, wrong, base, found, RIGHT, wrong_file)


def test_a_new_name_with_its_size_is_right():
    result = row("mass_-10%", diagnosis(), diagnosis(finding("mass", delta=0.111)))
    assert result["right"] and result["strictly"]
    assert result["values"][0]["wanted"] == pytest.approx(1 / 0.9 - 1)


def test_a_class_that_holds_the_name_is_right_and_another_name_is_not():
    assert row("mass_-10%", diagnosis(), diagnosis(finding("thrust_scale", ["mass"], delta=-0.1)))["right"]
    assert not row("mass_-10%", diagnosis(), diagnosis(finding("thrust_scale", delta=-0.1)))["right"]


def test_any_other_new_name_is_wrong_and_a_lost_one_is_listed():
    drag = finding("rotor_drag", at_hover=0.02)
    both = diagnosis(drag, finding("mass", delta=0.111))
    assert row("mass_-10%", diagnosis(drag), both)["strictly"]
    assert row("mass_-10%", diagnosis(), both)["new"] == ["rotor_drag"] and not row("mass_-10%", diagnosis(), both)["right"]
    without = row("mass_-10%", diagnosis(drag), diagnosis(finding("mass", delta=0.111)))
    assert without["right"] and without["lost"] == ["rotor_drag"] and not without["strictly"]


def test_a_class_excuses_one_name_and_not_a_second():
    base = diagnosis(finding("rotor_drag", ["quadratic_drag"], at_hover=0.02))
    assert row("mass_-10%", base, diagnosis(finding("quadratic_drag", ["rotor_drag"], area_xy=0.01), finding("mass", delta=0.111)))["strictly"]
    both = diagnosis(*base["effects"], finding("quadratic_drag", area_xy=0.01), finding("mass", delta=0.111))
    assert row("mass_-10%", base, both)["new"] == ["quadratic_drag"]


def test_what_was_named_before_must_move_by_the_falsification():
    base = diagnosis(finding("inertia", delta_x=0.5, delta_y=0.5, delta_z=0.2))
    assert row("inertia_-25%", base, diagnosis(finding("inertia", delta_x=1.0, delta_y=1.0, delta_z=0.6)))["right"]
    assert not row("inertia_-25%", base, base)["right"]


def test_only_the_right_rotor_is_right():
    assert row("rotor_2_+8%", diagnosis(), diagnosis(finding("rotor_loss", rotor=2, loss=0.074)))["right"]
    assert not row("rotor_2_+8%", diagnosis(), diagnosis(finding("rotor_loss", rotor=3, loss=0.074)))["right"]


def test_a_removed_effect_must_come_back(tmp_path):
    wrong = falsifications(RIGHT)["motor_lag_removed"]
    file = deepcopy(RIGHT)
    wrong.change(file)
    file.write(tmp_path)
    written = tomllib.loads((tmp_path / "vehicle.toml").read_text(encoding="utf-8"))
    assert [effect["type"] for effect in written["effect"]] == ["rotor_drag"]
    assert row("motor_lag_removed", diagnosis(), diagnosis(finding("motor_lag", time_constant=0.12)))["right"]
    assert not row("motor_lag_removed", diagnosis(), diagnosis())["right"]
