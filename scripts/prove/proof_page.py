"""docs/PROOF.md from the figures that prove.py gathered."""

import re

import proof_figures
import air_trials
import semi_real_outcomes

GOALS = {"nothing concealed: no name": "≥ 99 %", "calibration scatter: no name": "≥ 99 %", "one effect: exact": "≥ 97 %", "two effects: exact": "≥ 88 %",
         "outside the catalogue: no name": "≥ 95 %",
         "outside the catalogue, visible: channel located": "the right channel"}


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "|".join([" --- "] + [" ---: "] * (len(head) - 1)) + "|"]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows]) + "\n"


def rate(r, interval=True):
    if not r["n"]:
        return "–"
    text = f"{r['k']}/{r['n']} = {100 * r['share']:.1f} %"
    return text + (f" ({100 * r['low']:.0f}–{100 * r['high']:.0f})" if interval else "")


def number(x, digits=3):
    return "–" if x is None else f"{x:.{digits}g}"


def headline(score, baseline):
    rows = []
    for label, ours in score["headline"].items():
        rows.append([label, GOALS.get(label, ""), rate(ours), rate(baseline["headline"][label]) if baseline else "–"])
    cover = score["parameters"]["coverage"]
    rows.append(["95 % intervals that cover the truth", "90–98 %", rate(cover), rate(baseline["parameters"]["coverage"]) if baseline else "–"])
    error = lambda s: f"{number(s['reliability']['expected_calibration_error'])} ({s['reliability']['findings']} names)"
    rows.append(["expected calibration error of the confidence", "≤ 0.03", error(score), error(baseline) if baseline else "–"])
    return table(["figure", "asked for", "this diagnosis", "naive baseline"], rows)


def each_effect(score, baseline):
    naive = {row["effect"]: row for row in baseline["effects"]} if baseline else {}
    rows = [[row["effect"], rate(row["recall"]), rate(row["precision"]),
             rate(naive[row["effect"]]["recall"], False) if row["effect"] in naive else "–",
             rate(naive[row["effect"]]["precision"], False) if row["effect"] in naive else "–"] for row in score["effects"]]
    return table(["effect", "recall", "precision", "naive recall", "naive precision"], rows)


def power(score):
    edges = score["power"]["strength_from"]
    head = ["strength / limit"] + [f"{a:g}–{b:g}" for a, b in zip(edges, edges[1:])] + [f"≥ {edges[-1]:g}"]
    cells = lambda rates: [f"{r['k']}/{r['n']}" if r["n"] else "" for r in rates]
    rows = [["one effect: exact", *cells(score["power"]["single_exact"])], ["any effect: named", *cells(score["power"]["named"])]]
    rows += [[effect, *cells(rates)] for effect, rates in score["power"]["effects"].items()]
    return table(head, rows)


def parameters(score):
    rows = [[row["parameter"], number(row["median_error"]),
             "–" if row["median_relative_error"] is None else f"{100 * row['median_relative_error']:.1f} %", rate(row["coverage"])]
            for row in score["parameters"]["each"]]
    return table(["parameter", "median error [SI]", "relative", "covered by its 95 % interval"], rows)


def not_right(rows):
    lines = []
    for row in rows:
        hidden = ", ".join(h["effect"] + ("" if h["strength_over_limit"] is None else f" ×{h['strength_over_limit']:.2g}") for h in row["concealed"])
        named = ", ".join(f"{n['effect']} {n['confidence']:.2f}" for n in row["named"])
        lines.append([f"{row['set']}/{row['trial']}", row["kind"], hidden or "nothing", row["verdict"], named or "nothing"])
    return table(["trial", "kind", "concealed", "verdict", "named"], lines) if lines else "None.\n"


def real(result):
    if result is None:
        return ("Not run: the recordings are not shipped. [DATA.md](DATA.md) says where each set is published, with checksums; "
                "`scripts/prove.sh --flights DIR` takes them.\n")
    rows = [[row["case"], row["wanted"], row["found"], "yes" if row["good"] else "**no**"] for row in result["cases"]]
    text = table(["recording", "should name", "named", "good"], rows)
    drone = result.get("nanodrone", {})
    if "after" in drone:
        quantities = list(drone["after"])
        rows = [[name, *(f"{value:.4f}" for value in values)] for name, values in drone["published"].items()]
        rows += [["asked for", *(f"≤ {drone['goal'][q]}" for q in quantities)], ["augmented simulation, physics alone", *(f"{drone['physics_after'][q]:.4f}" for q in quantities)],
                 ["**augmented simulation**" + (", with the recorded loop's habit" if drone["habit"] else ""), *(f"**{drone['after'][q]:.4f}**" for q in quantities)]]
        text += ("\nNanodrone, test flights, mean error 0.5 s ahead over every window (published rows: arXiv 2512.14450); fitted to the "
                 "training flights alone:\n\n" + table(["model", "position [m]", "velocity [m/s]", "attitude [rad]", "body rate [rad/s]"], rows))
    return text


def semi_real_part(real, part):
    """`part`: semi_real_outcomes.summary or semi_real_outcomes.markdown."""
    return part(real["semi_real"]) if real and real.get("semi_real") else "Not run: the recordings are not shipped.\n"


def timing(result):
    if not result["seconds"]:
        return "No diagnosis ended.\n"
    seconds = sorted(result["seconds"])
    return (f"4 flights × 25 s × 100 Hz, full catalogue, two threads, nothing else running, N = {len(seconds)}: median "
            f"{seconds[len(seconds) // 2]:.1f} s, longest {seconds[-1]:.1f} s (asked for: ≤ 5 s), peak memory "
            f"{max(result['peak_MiB']):.0f} MiB (< 1024). Same bytes with one and with two threads: "
            f"{'yes' if result['same_bytes'] else '**no**'}.\n")


def one_folder_up(text):
    """A page's text as a page of the folder above it has it: its links lead to the same files."""
    link = lambda match: match[0] if re.match(r"[a-z]+:|#", match[1]) else f"]({match[1][3:] if match[1].startswith('../') else 'proof/' + match[1]})"
    return re.sub(r"\]\(([^)]+)\)", link, text)


def write_proof(result, out):
    folder = out / "proof"
    folder.mkdir(parents=True, exist_ok=True)
    score, baseline = result["score"], result["baseline"]
    figures = {"power": proof_figures.power(score, baseline, folder), "reliability": proof_figures.reliability(score, folder),
               "confusion": proof_figures.confusion(score, folder), "closure": proof_figures.closure(score, baseline, folder)}
    image = lambda name, says: f"![{says}](proof/{figures[name]})\n" if figures[name] else "No figure: nothing to draw.\n"
    notes = folder / "notes.md"
    sets = [[name, f"`{'`, `'.join(commands)}`", f"`{digest}`"] for name, commands, digest in result["sets"]]
    confidence = [[f"{b['from']:.1f}–{b['from'] + 0.1:.1f}", f"{b['said']:.3f}", rate(b["right"])] for b in score["reliability"]["bins"]]
    closed = [[e["quantity"], f"{e['horizon_s']:g}", e["trials"], *(f"{100 * e[k]:.0f} %" for k in ("q25", "median", "q75"))]
              for e in score["closure"]["each"]]
    sample = "**A small sample (`--quick`); no figure here is quotable.**\n\n" if result["quick"] else ""
    text = f"""# How good is the diagnosis?

{sample}Written by `scripts/prove.sh`, which does all of it again; program {result['program']}. Brackets are 95 % intervals (Wilson). Exact: every effect that was
concealed is named, and nothing that was not. A wrong name is worse than no name, and a right one withheld is a failure too: both are counted. A set without a
diagnosis counts as a failure.

## Real recordings in which one thing is concealed

Flights that others recorded; motion and air stay as they were, and the truth is exact. Concealed is a wrong number in the vehicle file, a sensor's fault, or an
effect whose inputs give the same motion (`scripts/prove/semi_real.py`, which says what a limit is). Families and cases one by one stand below.

{semi_real_part(result['real'], semi_real_outcomes.summary)}
## An independent reality

Simulated by `tests/reality`, which shares no code with the diagnosis; seed {result['seed']} was used for nothing else. The answers were sealed before the first diagnosis
(SHA-256 below). {score['trials']} trials, {score['without_diagnosis']} without a diagnosis. Strengths are in detection limits: 1 is what is just visible on the trial's own
flights. The naive baseline regresses the equation error on the same catalogue (`scripts/prove/naive_baseline.py`).

{headline(score, baseline)}
## How rough the air is

Turbulence from that of a quiet room to ten times as much, steady, in bursts and as slow as outdoors; strengths are in limits in
that air. Exact: every effect above its limit, and no other name.

{air_trials.markdown(result['air'])}
{one_folder_up(notes.read_text(encoding='utf-8')) if notes.exists() else ''}
## Power against strength

{image('power', 'share of single effects named exactly against their strength')}
{power(score)}
## What is taken for what

Rows: what was concealed (above its limit); columns: what was named for it. A class of names that the data cannot tell apart
counts as the truth when it holds it.

{image('confusion', 'confusion matrix')}
{each_effect(score, baseline)}
## Parameters

{parameters(score)}
## Stated confidence

{image('reliability', 'share of names that were right against the confidence stated')}
{table(["confidence", "said", "right"], confidence)}
## Error closed on held-out flights

(before − after) / (before − floor) of open-loop predictions on the flight that was held out; the floor is what measurement
noise and an oracle that knows the answer leave. Trials with an effect above its limit; quartiles over trials.

{image('closure', 'share of the recoverable error that was closed')}
{table(["quantity", "horizon [s]", "trials", "quartile", "median", "quartile"], closed)}
## Real flights

{real(result['real'])}
## Real recordings in which one thing is concealed, by family

{semi_real_part(result['real'], semi_real_outcomes.markdown)}
## Time and memory

{timing(result['timing'])}
## Every trial that was not right

{not_right(score['not_right'])}
## Sets

{table(["set", "drawn by", "sha256 of the answers"], sets)}"""
    (out / "PROOF.md").write_text(text, encoding="utf-8")
