"""How a diagnosis of a trial is counted, and how the counts are printed: of trials in which the names of what is concealed are known."""

from collections import Counter


def rotor_of(effect):
    rotor = effect["parameters"].get("rotor")
    return rotor and int(rotor["value"])


def label(effect):
    return effect["effect"] + (f"#{rotor_of(effect)}" if rotor_of(effect) else "")


def means(effect, truth, rotor):
    """Whether a finding names the truth, itself or in its class."""
    if effect["effect"] == truth:
        return rotor in (None, rotor_of(effect))
    return truth in effect.get("class", ()) or f"{truth}#{rotor}" in effect.get("class", ())


def truth_names(hidden):
    return [e["effect"] + (f"#{e['rotor']}" if e["rotor"] else "") for e in hidden]


def counted(found, names, right, show, some_of_them, nothing_named, enough=False):
    """verdict, what was named, suspected and wrong, and the outcome; failed without a diagnosis. names: (effect, rotor) of each that is wanted;
    right: whether a finding is true; show: how it is printed; some_of_them, nothing_named: the names of these outcomes; enough: a name is not needed."""
    if found is None:
        return {"outcome": "failed"}
    suspected, wrong = found.get("suspected", []), [show(finding) for finding in found["effects"] if not right(finding)]
    named = [any(means(finding, *name) for finding in found["effects"]) for name in names]
    if wrong:
        outcome = "wrong"
    elif enough or all(named):
        outcome = "exact"
    elif any(named):
        outcome = some_of_them
    else:
        outcome = "withheld" if any(map(right, suspected)) else nothing_named
    return {"verdict": found["verdict"], "named": list(map(show, found["effects"])), "suspected": list(map(show, suspected)), "wrong": wrong, "outcome": outcome}


def table(title, groups, outcomes, last, cell):
    """Lines of Markdown: how often each outcome, by group; cell(rows): what stands in the column `last`, None where that is not known."""
    lines = [f"| {title} | N | " + " | ".join(outcomes) + f" | {last} |", "|" + " --- |" * (len(outcomes) + 3)]
    for name, chosen in groups:
        tally, text = Counter(row["outcome"] for row in chosen), cell(chosen)
        lines.append(f"| {name} | {len(chosen)} | " + " | ".join([*(str(tally[o]) for o in outcomes), text or "–"]) + " |")
    return [*lines, ""]


def by_value(rows, key):
    return [(value, [row for row in rows if row[key] == value]) for value in sorted({row[key] for row in rows})]


def by_effect(rows):
    return by_value([{**row, "effect": row["truth"][0].split("#")[0]} for row in rows], "effect")


def others(rows, setting, said, sized):
    """A line for every trial that is not exact; setting: the keys that say where it flew; said: the keys of its names; sized(name, row, k): what is
    concealed, with its size."""
    return [f"- {row['trial']} {', '.join(row[key] for key in setting)}: {row['outcome']}; "
            f"there {', '.join(sized(name, row, k) for k, name in enumerate(row['truth'])) or 'nothing'}; "
            f"{'; '.join(f'{key} ' + (', '.join(row.get(key, [])) or '–') for key in said)}; verdict {row.get('verdict', '–')}"
            for row in rows if row["outcome"] != "exact"]
