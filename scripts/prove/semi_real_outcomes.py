"""How a semi-real case is counted, and how the counts are printed (semi_real.py has the cases)."""

import math
from collections import Counter

from outcomes import label, means, rotor_of


def alike(a, b):
    if a["effect"] == b["effect"]:
        return rotor_of(a) == rotor_of(b)
    return a["effect"] in b.get("class", ()) or b["effect"] in a.get("class", ())


def beyond(found, base):
    """Findings that the base does not have, itself or as one of its class."""
    return [effect for effect in found if not any(alike(effect, old) for old in base)]


def combined(effect, name, before, change):
    """Total of a parameter after a change: shares multiply, sizes add."""
    if name.startswith("delta"):
        return (1 + before) * (1 + change) - 1
    return 1 - (1 - before) * (1 - change) if effect == "rotor_loss" else before + change


def size_error(finding, case, before):
    """|found − wanted| over |change|, over all parameters; None when named as another of its class."""
    if finding["effect"] != case.effect:
        return None
    wrong = change = 0.0
    for name, by in case.parameters.items():
        if name == "rotor":
            continue
        wanted = combined(case.effect, name, before.get(name, 0.0), by)
        value = finding["parameters"].get(name, {"value": before.get(name, 0.0)})["value"]
        wrong, change = wrong + (value - wanted) ** 2, change + (wanted - before.get(name, 0.0)) ** 2
    return math.sqrt(wrong / change)


def over_stated(case, untouched):
    """What is concealed over the size from which on it would show in these flights, as their own diagnosis says without it (`would_show`; of what it
    names or trims, five standard errors); of several numbers the largest. 0 where it says that these logs do not tell it."""
    stated = {}
    for rejected in untouched.get("rejected", []):
        name, _, rotor = rejected["effect"].partition(" (rotor ")
        # a rotor that is not listed would show from where another one does
        if name == case.effect and (not stated or rotor.rstrip(")") == str(case.rotor)):
            stated = {key: number["value"] for key, number in rejected.get("would_show", {}).items()}
    for found in sum((untouched.get(key, []) for key in ("effects", "suspected", "calibration")), []):
        if found["effect"] == case.effect and rotor_of(found) in (None, case.rotor):
            stated = {key: 5 * number["std"] for key, number in found["parameters"].items() if number.get("std")}
    return max((abs(size) / stated[key] for key, size in case.parameters.items() if key in stated), default=0.0)


def judge(case, found, base=None, before=None, reported=()):
    """One row. Against the file: what is named beyond `base`; against reference flights: all that is named but values of every flight's
    own (a wind) that `base` names too, which are no change of the vehicle. What the flights are known to have (`reported`) is not wrong.
    outcome: exact | size (right name, wrong size) | wrong (a name that is not true) | withheld (right, suspected) | nothing | not_told (nothing,
    and the diagnosis says that these logs do not tell it)."""
    row = {"case": case.name, "set": case.set, "way": case.way, "asked": case.asked, "truth": case.truth, "times": case.times,
           "named": [label(e) for e in found["effects"]], "suspected": [label(e) for e in found.get("suspected", [])], "verdict": found["verdict"]}
    known, before = base["effects"] if base else [], before or {}
    if case.asked == "reference":
        known = [effect for effect in known if effect.get("per_flight")]
    right = lambda effect: case.truth is not None and means(effect, case.truth, case.rotor)
    # an effect that the untouched flights show as well is no hit for having the truth in its class
    hits = [effect for effect in found["effects"] if right(effect) and (effect["effect"] == case.truth or beyond([effect], known))]
    new = beyond([effect for effect in found["effects"] if not right(effect)], known)
    if base and case.asked == "file":
        # suspected on the untouched flights, named on these: the same finding on the other side of the threshold
        sure = beyond(new, base.get("suspected", []))
        row["crossed"] = [label(effect) for effect in beyond(new, sure)]
        new = sure
    # beside reference flights only what every flight has for itself, such as its wind
    true_anyway = [effect for effect in new if effect["effect"] in reported and (case.asked == "file" or effect.get("per_flight"))]
    row["reported"] = [label(effect) for effect in true_anyway]
    new = [effect for effect in new if effect not in true_anyway]
    row["wrong"] = [label(effect) for effect in new]
    if base and case.asked == "file":
        row["lost"] = [label(old) for old in beyond([e for e in known if not right(e)], found["effects"])]
    errors = [error for hit in hits if (error := size_error(hit, case, before)) is not None]
    row["size_error"] = min(errors) if errors else None
    # what the base names already must have moved by the change; its totals are `before`
    counts = bool(hits) and (not any(right(old) for old in known) or (errors and min(errors) <= 0.3))
    row["confidence"] = [hit.get("confidence") for hit in hits]
    row["rejected"] = [(r["effect"], r.get("delta_score"), r["why"]) for r in found["rejected"] if case.truth and r["effect"].startswith(case.truth)]
    if new:
        row["outcome"] = "wrong"
    elif case.truth is None:
        row["outcome"] = "exact"
    elif counts:
        row["outcome"] = "exact" if case.asked == "file" or not errors or min(errors) <= 0.3 else "size"
    elif any(right(e) for e in found.get("suspected", [])):
        row["outcome"] = "withheld"
    else:
        told = case.truth not in [e["effect"] for e in found.get("not_identifiable", [])]
        row["outcome"] = "nothing" if told else "not_told"
    return row


OUTCOMES = ("exact", "size", "wrong", "withheld", "nothing", "not_told", "failed")


def counts(rows, key, only=lambda row: True):
    lines = [f"| {key} | N | " + " | ".join(OUTCOMES) + " |", "|" + " --- |" * (len(OUTCOMES) + 2)]
    groups = sorted({str(row[key] or "nothing concealed") for row in rows if only(row)})
    for group in [*groups, "all"]:
        tally = Counter(row["outcome"] for row in rows if only(row) and group in (str(row[key] or "nothing concealed"), "all"))
        lines.append(f"| {group} | {sum(tally.values())} | " + " | ".join(str(tally[o]) for o in OUTCOMES) + " |")
    return lines


def summary(rows):
    """Counts by way of asking at twice the limit and where nothing is concealed, as shares of what was asked."""
    named = {"exact": "exact", "wrong": "a wrong name", "withheld": "only suspected", "size": "another size", "nothing": "nothing said", "not_told": "said to be not identifiable",
             "failed": "no diagnosis"}
    share = lambda part, whole: f"{part} ({100 * part / whole:.0f} %)" if part else "0"
    lines = ["| at twice its limit | N | " + " | ".join(named.values()) + " |", "|" + " --- |" + " ---: |" * (len(named) + 1),
             "| asked for | | ≥ 85 % | ≤ 3 % | | | | | |"]
    for text, chosen in (("against the vehicle file", lambda r: r["truth"] and r["asked"] == "file"),
                         ("beside reference flights", lambda r: r["truth"] and r["asked"] == "reference"), ("both", lambda r: r["truth"]),
                         ("nothing concealed", lambda r: not r["truth"])):
        tally = Counter(r["outcome"] for r in rows if chosen(r) and (r["times"] == 2 or not r["truth"]))
        if total := sum(tally.values()):
            lines.append(f"| {text} | {total} | " + " | ".join(share(tally[o], total) for o in named) + " |")
    below_two = (("below 1", 1e-12, 1.0), ("1 to 2", 1.0, 2.0))
    for key, said, head, bounds in (
            ("over_stated", "what the diagnosis of the untouched flights says beforehand: the size from which on the effect would show there (`would_show`)", "what would show",
             (("said to be not identifiable", 0.0, 1e-12), *below_two, ("2 to 4", 2.0, 4.0), ("4 and more", 4.0, math.inf))),
            ("over_thirds", "how far thirds of these flights differ: five standard errors by thirds in place of whole flights, where these are more", "that limit",
             (*below_two, ("2", 2.0, math.inf)))):
        asked = [r for r in rows if r["times"] == 2 and r.get(key) is not None]
        if asked:
            lines += ["", f"The same cases by {said}.", "", f"| concealed, over {head} | N | " + " | ".join(named.values()) + " |", "|" + " --- |" + " ---: |" * (len(named) + 1)]
        for name, least, most in bounds:
            tally = Counter(r["outcome"] for r in asked if least <= r[key] < most)
            if total := sum(tally.values()):
                lines.append(f"| {name} | {total} | " + " | ".join(share(tally[o], total) for o in named) + " |")
    return "\n".join(lines) + "\n"


def markdown(rows):
    """Counts by family, effect and way at each size, and every case that is not exact."""
    lines = []
    for asked in ("file", "reference"):
        for times in sorted({row["times"] for row in rows if row["truth"]}):
            chosen = lambda row, times=times, asked=asked: row["asked"] == asked and row["truth"] and row["times"] == times
            if any(map(chosen, rows)):
                lines += [f"### Asked against the {asked}, {times:g} × the limit", "", *counts(rows, "set", chosen), "", *counts(rows, "truth", chosen), ""]
        chosen = lambda row, asked=asked: row["asked"] == asked and not row["truth"]
        if any(map(chosen, rows)):
            lines += [f"### Asked against the {asked}, nothing to name", "", *counts(rows, "set", chosen), ""]
    for row in rows:
        if row["outcome"] not in ("exact",):
            lines.append(f"- {row['set']} {row['case']}: {row['outcome']}; named {', '.join(row.get('named', [])) or '–'}; wrong "
                         f"{', '.join(row.get('wrong', [])) or '–'}; suspected {', '.join(row.get('suspected', [])) or '–'}")
    return "\n".join(lines) + "\n"
