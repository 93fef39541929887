"""The recorded flights of the proof: each set is imported once."""

import subprocess
import sys
from pathlib import Path

import pytest

HOME = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(HOME / "scripts" / "prove"))

import real_flights  # noqa: E402


def test_a_set_that_was_imported_is_kept_and_one_that_was_not_finished_is_not(tmp_path, monkeypatch):
    (tmp_path / "data/arpl").mkdir(parents=True)
    (tmp_path / "data/arpl/log10.csv").write_text("")
    imported = []

    def run(command, check, stdout, stderr):
        out = Path(command[command.index("--out") + 1])
        out.mkdir(parents=True)
        (out / f"log{len(imported)}.csv").write_text("")
        imported.append(out)
        if len(imported) == 1:
            raise subprocess.CalledProcessError(1, command)

    monkeypatch.setattr(real_flights.subprocess, "run", run)
    work = tmp_path / "work"
    with pytest.raises(subprocess.CalledProcessError):
        real_flights.import_flights(tmp_path / "data", work, None)
    for _ in range(2):
        assert real_flights.import_flights(tmp_path / "data", work, None) == {"arpl": work / "arpl"}
    assert len(imported) == 2 and [path.name for path in (work / "arpl").iterdir()] == ["log1.csv"]
