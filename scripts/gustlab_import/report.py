"""The report of an import, for people and as JSON."""

import json

from .checks_columns import noise

MARK = {"note": "note   ", "warning": "WARNING", "error": "ERROR  "}


def as_text(results: list) -> str:
    """results: (output name, Flight, sha256) of every input."""
    lines = []
    for name, flight, _ in results:
        step = flight.step_s()
        rate = f"{1.0 / step:.0f} Hz" if step else "one sample"
        span = f"{flight.time_s[0]:.2f} to {flight.time_s[-1]:.2f} s" if len(flight.time_s) else "nothing left"
        lines.append(f"{flight.file} -> {name}: {flight.rows} rows read, {len(flight.time_s)} kept, {span}, {rate}")
        lines.append("  noise (third differences): " + _noise_text(noise(flight)))
        for finding in flight.findings:
            repaired = " [repaired]" if finding.repaired else ""
            lines.append(f"  {MARK[finding.severity]} {finding.kind}: {finding.column} "
                         f"({finding.from_s:.2f} to {finding.to_s:.2f} s): {finding.says}{repaired}")
        if not flight.findings:
            lines.append("  nothing found")
    return "\n".join(lines) + "\n"


def as_json(results: list) -> str:
    """The same facts: one object per input, keys sorted, no machine path."""
    documents = [{"file": flight.file, "name": name, "sha256": sha256, "rows_read": flight.rows,
                  "rows_kept": len(flight.time_s), "step_s": round(flight.step_s(), 9),
                  "usable": all(f.severity != "error" for f in flight.findings),
                  "noise": {name: float(f"{value:.4g}") for name, value in noise(flight).items() if value == value},
                  "findings": [finding.as_dict() for finding in flight.findings]}
                 for name, flight, sha256 in results]
    return json.dumps({"format": "gustlab-import/1", "flights": documents}, indent=2, sort_keys=True) + "\n"


def _noise_text(values: dict) -> str:
    return ", ".join(f"{name} {value:.2g}" for name, value in values.items() if value == value) or "nothing to measure"
