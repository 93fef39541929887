"""What counts as exact in air of every roughness."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts" / "prove"))

from air_trials import AIR_TRIALS, ROUGHNESS, air_parts, judge, markdown  # noqa: E402


def answer(*effects, air="steady"):
    return {"effects": [{"effect": name, "parameters": {}, "strength_over_limit": over} for name, over in effects], "air": {"roughness": 4.0, "kind": air}}


def named(*names):
    return {"effects": [{"effect": name, "class": [name], "parameters": {}} for name in names]}


def test_all_above_the_limit_and_nothing_else():
    assert judge(answer(("mass", 2.0)), named("mass")) == (True, [])
    assert judge(answer(("mass", 2.0)), named()) == (False, [])
    assert judge(answer(("mass", 2.0), ("inertia", 0.5)), named("mass")) == (True, [])
    assert judge(answer(("mass", 2.0), ("inertia", 0.5)), named("mass", "inertia")) == (True, [])
    assert judge(answer(("mass", 2.0)), named("mass", "rotor_drag")) == (False, ["rotor_drag"])
    assert judge(answer(), None) == (False, [])


def test_a_gust_is_excused_outdoors_alone():
    assert judge(answer(air="outdoor"), named("gust"))[0]
    assert not judge(answer(), named("gust"))[0]


def test_every_kind_meets_every_roughness():
    parts = [arguments for _, arguments in air_parts(AIR_TRIALS)]
    met = {(arguments[1], float(arguments[3])) for arguments in parts}
    assert met == {(kind, roughness) for kind in AIR_TRIALS for roughness in ROUGHNESS}


def test_the_table_counts_each_roughness_once():
    rows = [{"kind": "single", "roughness": r, "air": "steady", "exact": e, "wrong": []} for r, e in ((1.0, True), (1.0, False), (4.0, True))]
    assert "| 1 × | 1 of 2 | 0 of 0 |" in markdown(rows) and "| all | 2 of 3 |" in markdown(rows)
