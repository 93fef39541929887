"""The judge's fit: records get their truth, the model is monotone, and what is left out by family is calibrated."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts" / "prove"))

from fit_judge import fit, judge_toml, probability, reliability, semi_real_records, trial_records  # noqa: E402


def made_up(count, seed=1):
    """Records whose truth is a logistic of two of three features, from four families."""
    rng = np.random.default_rng(seed)
    x = rng.random((count, 3))
    truth = rng.random(count) < 1 / (1 + np.exp(6 - 8 * x[:, 0] - 4 * x[:, 1]))
    return [{"family": f"f{n % 4}", "trial": str(n // 3), "truth": int(t), "features": dict(zip(("gain", "flights", "noise"), row))} for n, (row, t) in enumerate(zip(x, truth))]


def test_the_model_is_found_again_and_calibrated():
    sample, _, model, p = fit(made_up(4000))
    weights = dict(zip(sample.names, model[1:]))
    assert model[0] == pytest.approx(-6, abs=0.8) and weights["gain"] == pytest.approx(8, abs=1) and weights["noise"] < 0.5
    assert reliability(p, sample.y)[1] < 0.03
    assert "gain = " in judge_toml(sample, model, 0.01)


def test_more_evidence_never_lowers_the_probability():
    records = made_up(400)
    for record in records:
        record["features"]["noise"] = 1 - record["truth"]       # a feature that speaks the wrong way gets no weight
    sample, _, model, _ = fit(records)
    assert np.all(model[1:] >= 0) and model[1:][sample.names.index("noise")] == 0
    low, high = np.full(3, 0.4), np.full(3, 0.6)
    assert probability(model, high) >= probability(model, low)


def test_a_feature_that_a_record_lacks_counts_one_half():
    records = made_up(50)
    records[0]["features"]["gain"] = None
    sample, *_ = fit(records)
    assert sample.x[0][sample.names.index("gain")] == 0.5


def written(path, diagnosis):
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(diagnosis), encoding="utf-8")


def test_truth_of_trials(tmp_path):
    finding = {"effect": "mass", "class": ["mass", "thrust_scale"], "parameters": {}}
    evidence = [{"effect": "mass"}, {"effect": "rotor_loss", "rotor": 2}, {"effect": "rotor_loss", "rotor": 3}, {"effect": "gust"}, {"effect": "inertia"}]
    written(tmp_path / "set" / "trial001" / "d" / "diagnosis.json", {"effects": [finding], "evidence": evidence})
    effects = [{"effect": "thrust_scale", "parameters": {"delta": 0.1}}, {"effect": "rotor_loss", "parameters": {"rotor": 3, "loss": 0.1}}]
    answers = tmp_path / "a.jsonl"
    answers.write_text(json.dumps({"trial": "trial001", "kind": "pair", "effects": effects, "air": {"roughness": 4, "kind": "outdoor"}}) + "\n")
    records = list(trial_records(tmp_path / "set", answers, "d"))
    assert [(r["effect"], r["truth"]) for r in records] == [("mass", 1), ("rotor_loss", 0), ("rotor_loss", 1), ("inertia", 0)]
    assert records[0]["family"] == "reality 4"


@pytest.mark.parametrize("asked, wanted", [("file", [1]), ("reference", [1, 0])])
def test_truth_of_semi_real_cases(tmp_path, asked, wanted):
    folder = tmp_path / "set" / "case"
    written(folder / "diagnosis" / "diagnosis.json", {"effects": [], "evidence": [{"effect": "mass"}, {"effect": "inertia"}]})
    (folder / "truth.json").write_text(json.dumps({"truth": "mass", "rotor": None, "asked": asked, "set": "set", "name": "case", "way": "file"}))
    assert [record["truth"] for record in semi_real_records(tmp_path)] == wanted
