"""Flights as a new user makes them: what is drawn and what counts."""

import sys
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts" / "prove"))

from everyday_trials import EFFECTS, TURNING, VEHICLES, draw, experiment, judge, markdown  # noqa: E402


def named(*effects, verdict="explained"):
    return {"verdict": verdict, "effects": [{"effect": effect, "parameters": {}, "class": [effect, *others]} for effect, *others in effects], "suspected": []}


def test_a_trial_is_drawn_again_alike_and_all_kinds_come():
    drawn = [draw(3, number) for number in range(300)]
    assert drawn == [draw(3, number) for number in range(300)]
    assert {each["vehicle"] for each in drawn} == set(VEHICLES) and {each["effect"] for each in drawn} == set(EFFECTS)
    assert all(len(set(each["trajectories"])) == 2 for each in drawn)


def test_the_experiment_holds_what_is_concealed_and_what_was_drawn():
    for number in range(120):
        drawn = draw(3, number, TURNING if number % 2 else EFFECTS)
        text, hidden = experiment(drawn, 2.0, 0.1, 0.3)
        said = tomllib.loads(text)
        kinds = [effect["type"] for effect in said["effect"]]
        assert kinds[:len(hidden)] == [effect["type"] for effect in hidden]
        assert ("measurement_noise" in kinds) == (drawn["noise"] == "noise") and ("gust" in kinds) == (drawn["gust"] == "gust")
        assert all(effect["at_hover"] == 0.4 for effect in hidden if effect["type"] == "rotor_drag")   # 0.05 of the weight beyond the file's
        assert ("log_rate_hz" in said) == (drawn["log"] != "at the loop's rate")


def test_what_counts():
    drawn = {**draw(3, 0), "effect": "rotor_loss", "gust": "gust"}
    hidden = EFFECTS["rotor_loss"](1.0, 1.0)
    right, other = ({"effect": "rotor_loss", "parameters": {"rotor": {"value": rotor}}, "class": ["rotor_loss"]} for rotor in (2, 3))
    for found, outcome in ((None, "failed"), (named(), "nothing"), ({**named(), "effects": [right]}, "exact"),
                           ({**named(("gust",)), "suspected": [right]}, "withheld"), ({**named(), "effects": [other]}, "wrong"),
                           (named(("mass",)), "wrong"), (named(("center_of_mass", "rotor_loss#2")), "exact")):
        assert judge(drawn, hidden, found)["outcome"] == outcome
    assert judge({**drawn, "gust": "calm"}, hidden, named(("gust",)))["outcome"] == "wrong"
    nothing = {**drawn, "effect": "none"}
    assert judge(nothing, [], named(verdict="consistent"))["outcome"] == "exact"
    wind = judge({**drawn, "effect": "steady_wind"}, EFFECTS["steady_wind"](1.0, 1.0), named(("rotor_drag",), verdict="insufficient_data"))
    assert wind["outcome"] == "some" and "| all | 1 | 0 | 1 | 0 | 0 | 0 | 0 | 1 |" in markdown([wind])
