"""One imported log: its flights, what was refused, and what was found; as text and as import.json."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .checks_columns import noise
from .flight import Flight
from .limits import can_tell, rate
from .problems import printable, valid_utf8
from .streams import QUANTITIES

FORMAT = "gustlab-import/1"
SELDOM_Hz = 4.0
MARK = {"note": "note   ", "warning": "WARNING", "error": "ERROR  "}


@dataclass
class Outcome:
    """file: the path as it was given; flights: [(name without .csv, Flight, text of the sidecar)]; refused: [(from_s, to_s, why)]; topics as in Recording."""

    file: str
    sha256: str
    kind: str
    autopilot: str
    airframe: str
    flights: list = field(default_factory=list)
    refused: list = field(default_factory=list)
    findings: list = field(default_factory=list)
    limits: list = field(default_factory=list)
    topics: list = field(default_factory=list)

    @property
    def name(self) -> str:
        """Name of the file without its folder: what is written names no place of the machine."""
        return valid_utf8(Path(self.file).name)

    def all_findings(self) -> list:
        """(name of the flight or "", finding) of the log and of its flights."""
        return [("", f) for f in self.findings] + [(name, f) for name, flight, _ in self.flights for f in flight.findings]


def rates(flight: Flight) -> dict:
    out = {}
    for name, columns in QUANTITIES.items():
        if name in ("u", "rotor"):
            columns = [c for c in flight.columns if c.startswith(name) and c[len(name):].isdigit()]
        out[name] = round(rate(flight, *columns)) if columns else 0
    return out


def as_document(outcomes: list) -> dict:
    return {"format": FORMAT, "logs": [_log(one) for one in outcomes]}


def as_json(document: dict) -> str:
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def _log(one: Outcome) -> dict:
    flights = [{"log": name + ".csv", "from_s": _s(flight.time_s[0]), "to_s": _s(flight.time_s[-1]), "rates_hz": rates(flight),
                "sources": _sources(flight), "rows": len(flight.time_s),
                "noise": {column: float(f"{value:.4g}") for column, value in noise(flight).items() if value == value}}
               for name, flight, _ in one.flights if len(flight.time_s)]
    return {"file": one.name, "kind": one.kind, "autopilot": one.autopilot, "airframe": one.airframe, "sha256": one.sha256,
            "flights": flights, "refused": [{"from_s": _s(a), "to_s": _s(b), "why": why} for a, b, why in one.refused],
            "findings": [{**({"log": name + ".csv"} if name else {}), **finding.as_dict()} for name, finding in one.all_findings()],
            "cannot_tell": one.limits}


def _s(time_s: float) -> float:
    return round(float(time_s), 3)


def _sources(flight: Flight) -> dict:
    """Quantity -> what it was read from."""
    out = {}
    for name, columns in QUANTITIES.items():
        first = columns[0] + ("1" if name in ("u", "rotor") else "")
        if first in flight.source:
            out[name] = flight.source[first]
    return out


def as_text(outcomes: list, verbose: bool = False) -> str:
    return "\n".join(line for one in outcomes for line in _lines(one, verbose)) + "\n"


def _lines(one: Outcome, verbose: bool) -> list:
    lines = [f"{printable(one.file)}: {one.autopilot or one.kind}, {one.airframe} ({one.kind})"]
    for name, flight, _ in one.flights:
        span = f"{flight.time_s[0]:.2f} to {flight.time_s[-1]:.2f} s" if len(flight.time_s) else "nothing left"
        lines.append(f"  flight {name}: {span}, {len(flight.time_s)} rows")
        lines += [f"    {quantity}: {hz:g} Hz ({_sources(flight).get(quantity, '')})"
                  for quantity, hz in rates(flight).items() if hz]
        if verbose:
            lines.append("    noise from sample to sample (SI units): " + _noise_text(noise(flight)))
        lines.append("    enough to judge: " + ("; ".join(can_tell(flight)) or "nothing"))
    lines += [f"  refused: {a:.2f} to {b:.2f} s: {why}" for a, b, why in one.refused]
    for name, finding in one.all_findings():
        repaired = " [repaired]" if finding.repaired else ""
        lines.append(f"  {MARK[finding.severity]} {finding.kind}: {finding.column} ({finding.from_s:.2f} to "
                     f"{finding.to_s:.2f} s): {finding.says}{repaired}")
    together = {}
    for limit in one.limits:
        together.setdefault(limit["why"] + (f"; {limit['setting']}" if "setting" in limit else ""), []).append(limit["effect"])
    lines += [f"  cannot tell {', '.join(effects)}: {why}" for why, effects in together.items()]
    if one.topics and (verbose or not one.flights):
        lines.append("  holds: " + _topics_text(one.topics))
    return lines


def _topics_text(topics: list) -> str:
    """The fastest first; what comes more seldom than a diagnosis could use is counted only."""
    fast = [f"{name} {hz:.0f} Hz" for name, _, hz in sorted(topics, key=lambda topic: -topic[2]) if hz >= SELDOM_Hz]
    seldom = len(topics) - len(fast)
    return ", ".join(fast + ([f"{seldom} more below {SELDOM_Hz:g} Hz"] if seldom else []))


def _noise_text(values: dict) -> str:
    return ", ".join(f"{name} {value:.2g}" for name, value in values.items() if np.isfinite(value)) or "nothing to measure"
