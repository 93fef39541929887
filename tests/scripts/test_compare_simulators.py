"""The comparison with other simulators: the circle, the fliers' loop, and the table. Nothing here needs the network or a simulator."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("GUSTLAB_PROGRAM", ROOT / "build" / "release" / "gustlab")
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "scripts" / "simulators")]

import circle  # noqa: E402
import compare_simulators as compare  # noqa: E402

# a simulator that is always a metre above the circle
FLIER = """
import sys
sys.path.insert(0, sys.argv.pop(1))
import circle
def prepare(drones, whole):
    print("what a library says")
    times = [0.1 * i for i in range(201)]
    return lambda: (50, times, [(x, y, z + 1.0) for (x, y, z), _, _ in map(circle.point, times)])
circle.serve(prepare, "a test")
"""
SWEEP, LOGS, *_ = compare.ROWS


def flight(simulated_s, cpu_s, wall_s=10.0, steps=100, error_m=0.25):
    return {"simulated_s": simulated_s, "cpu_s": cpu_s, "wall_s": wall_s, "steps": steps, "error_m": error_m}


def test_velocity_and_acceleration_of_the_circle_are_derivatives():
    for t in (0.0, 1.3, 7.7):
        here, before, after = circle.point(t), circle.point(t - 1e-4), circle.point(t + 1e-4)
        for order in (0, 1):
            for axis in range(3):
                slope = (after[order][axis] - before[order][axis]) / 2e-4
                assert here[order + 1][axis] == pytest.approx(slope, abs=1e-6)


def test_gustlab_flies_the_same_circle():
    text = (ROOT / "scripts" / "simulators" / "circle.toml").read_text(encoding="utf-8")
    for key, value in (("radius_m", circle.RADIUS_M), ("period_s", circle.PERIOD_S), ("duration_s", circle.DURATION_S),
                       ("settle_s", circle.DURATION_S / 2)):
        assert float(re.search(rf"^{key} = (\S+)$", text, re.M).group(1)) == value, key
    assert f"center_m = [0.0, 0.0, {circle.HEIGHT_M}]" in text


def test_flier_answers_each_line_and_keeps_what_libraries_print_apart():
    done = subprocess.run([sys.executable, "-c", FLIER, str(ROOT / "scripts" / "simulators"), "--drones", "3"], input="\n\n", text=True,
                          capture_output=True, check=True)
    ready, *flights = map(json.loads, done.stdout.splitlines())
    assert ready == {"ready": True}
    assert len(flights) == 2
    for one in flights:
        assert (one["steps"], one["simulated_s"]) == (150, 3 * circle.DURATION_S)
        assert one["error_m"] == pytest.approx(1.0)
    assert "what a library says" in done.stderr


def test_gustlab_is_counted_by_its_runs():
    one = compare.Command(PROGRAM, ("--set", "replicates=2")).fly()
    assert (one["simulated_s"], one["steps"]) == (40.0, 20000)
    assert 0.0 < one["error_m"] < 0.6
    with pytest.raises(compare.Failed, match="replicates"):
        compare.Command(PROGRAM, ("--set", "replicates=none")).fly()


def test_simulator_that_cannot_be_started_says_why(tmp_path, monkeypatch):
    (tmp_path / "broken.py").write_text("raise SystemExit('no such vehicle')")
    monkeypatch.setattr(compare, "HERE", tmp_path)
    with pytest.raises(compare.Failed, match="not flown: no such vehicle"):
        compare.Flier(sys.executable, ("broken.py",))


def test_simulator_that_fails_once_is_not_asked_again():
    class Fails:
        asked = 0

        def fly(self):
            self.asked += 1
            raise compare.Failed("not flown: out of memory")

    class Flies:
        def fly(self):
            return flight(10.0, 1.0)

    fails, said = Fails(), []
    measured = compare.measure([SWEEP, LOGS], {SWEEP: Flies(), LOGS: fails}, 3, said.append)
    assert [len(measured[0][1]), measured[1][1], fails.asked, len(said)] == [3, "not flown: out of memory", 1, 3]


def test_table_has_medians_and_ranges_and_says_what_is_missing():
    flights = [flight(1000.0, 1.0), flight(1000.0, 2.0, wall_s=20.0), flight(1000.0, 4.0, wall_s=100.0, error_m=0.5)]
    lines = compare.table([(SWEEP, flights), (LOGS, "not installed: no wheel")], {}).splitlines()
    assert lines[2] == ("| gustlab | `sweep`, 100 flights | 500 / 500 (position 100) | 500 (250 to 1 000) | 50 (25 to 100) "
                        "| 50 (10 to 100) | 0.25 |")
    assert lines[3] == "| gustlab | `sweep --logs`, 10 flights | 500 / 500 (position 100) | not installed: no wheel | | | |"
    assert lines[4] == "| gym-pybullet-drones | | | is not on PyPI: not measured | | | |"
    assert {line.count("|") for line in lines[:5]} == {8}
    assert lines[6].startswith("* gustlab, `sweep`, 100 flights: gust, ")


@pytest.mark.parametrize("value, text", [(0.1234, "0.123"), (4.5678, "4.57"), (99.96, "100"), (123.4, "123"), (2784.0, "2 780"),
                                         (1392345.0, "1 390 000")])
def test_numbers_have_three_digits(value, text):
    assert compare.three(value) == text


def test_requirements_are_pinned_and_have_the_simulator():
    for name, package, *_ in compare.ROWS:
        if name == "gustlab":
            continue
        lines = (ROOT / "scripts" / "simulators" / f"{name}.txt").read_text(encoding="utf-8").splitlines()
        assert all(re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.]+", line) for line in lines if not line.startswith("#")), name
        assert re.fullmatch(r"\d+(\.\d+)+", compare.version(name, package))
