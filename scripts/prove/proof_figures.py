"""The figures of docs/PROOF.md, as small SVG files that do not change when nothing changes."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

OURS, NAIVE, SOFT = "#1f6fb2", "#c9741a", "#8894a0"
STYLE = {"svg.hashsalt": "gustlab", "svg.fonttype": "none", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False,
         "axes.edgecolor": SOFT, "xtick.color": "#444", "ytick.color": "#444", "figure.facecolor": "white", "font.family": "sans-serif",
         "figure.constrained_layout.use": True}


def save(figure, folder, name):
    figure.savefig(folder / name, metadata={"Date": None, "Creator": None}, bbox_inches="tight")
    plt.close(figure)
    return name


def error_bars(rates):
    share = np.array([r["share"] for r in rates])
    return share, np.abs(np.array([[r["low"], r["high"]] for r in rates]).T - share)


@plt.rc_context(STYLE)
def power(score, baseline, folder):
    edges = score["power"]["strength_from"]
    labels = [f"{a:g}–{b:g}" for a, b in zip(edges, edges[1:])] + [f"≥ {edges[-1]:g}"]
    figure, axes = plt.subplots(figsize=(5.2, 3.0))
    for part, colour, label, shift in ((score, OURS, "this diagnosis", -0.07), (baseline, NAIVE, "equation error, STLSQ", 0.07)):
        if part is None:
            continue
        rates = part["power"]["single_exact"]
        known = [i for i, rate in enumerate(rates) if rate["n"]]
        if known:
            share, bars = error_bars([rates[i] for i in known])
            axes.errorbar(np.array(known) + shift, share, bars, color=colour, marker="o", ms=4, capsize=2, label=label)
    axes.set_xticks(range(len(labels)), labels)
    axes.set_ylim(-0.03, 1.05)
    axes.set_xlabel("strength of the one concealed effect, in detection limits")
    axes.set_ylabel("share named exactly")
    figure.legend(*axes.get_legend_handles_labels(), frameon=False, ncols=2, loc="outside upper center")
    return save(figure, folder, "power.svg")


@plt.rc_context(STYLE)
def reliability(score, folder):
    bins = score["reliability"]["bins"]
    if not bins:
        return None
    figure, axes = plt.subplots(figsize=(3.4, 3.2))
    axes.plot([0, 1], [0, 1], color=SOFT, lw=1, ls="--")
    share, bars = error_bars([b["right"] for b in bins])
    axes.errorbar([b["said"] for b in bins], share, bars, color=OURS, marker="o", ms=4, capsize=2, ls="none")
    axes.set(xlim=(0, 1.02), ylim=(0, 1.03), xlabel="stated confidence", ylabel="share that was right")
    return save(figure, folder, "reliability.svg")


@plt.rc_context(STYLE)
def confusion(score, folder):
    named, rows = score["confusion"]["named"], score["confusion"]["concealed"]
    rows = {row: cells for row, cells in rows.items() if "below limit" not in row}
    order = sorted(rows, key=lambda r: (r.startswith("("), r))
    columns = sorted({c for row in order for c in rows[row]} & set(named), key=lambda c: (c.startswith("("), c))
    counts = np.array([[rows[row].get(column, 0) for column in columns] for row in order], float)
    shares = counts / np.maximum(counts.sum(1, keepdims=True), 1)
    figure, axes = plt.subplots(figsize=(0.26 * len(columns) + 2.2, 0.22 * len(order) + 1.6))
    axes.imshow(shares, cmap="Blues", vmin=0, vmax=1.1, aspect="auto")
    for i, j in zip(*np.nonzero(counts)):
        axes.text(j, i, f"{counts[i, j]:.0f}", ha="center", va="center", fontsize=6, color="white" if shares[i, j] > 0.6 else "black")
    axes.set_xticks(range(len(columns)), columns, rotation=90, fontsize=7)
    axes.set_yticks(range(len(order)), order, fontsize=7)
    axes.set_xlabel("named")
    axes.set_ylabel("concealed")
    return save(figure, folder, "confusion.svg")


@plt.rc_context(STYLE)
def closure(score, baseline, folder):
    parts = [(p, c, l) for p, c, l in ((score, OURS, "this diagnosis"), (baseline, NAIVE, "equation error, STLSQ"))
             if p and p["closure"]["each"]]
    if not parts:
        return None
    quantities = list(dict.fromkeys(e["quantity"] for e in parts[0][0]["closure"]["each"]))
    figure, panels = plt.subplots(1, len(quantities), figsize=(1.9 * len(quantities) + 0.8, 2.5), sharey=True, squeeze=False)
    for axes, quantity in zip(panels[0], quantities):
        for part, colour, label in parts:
            each = [e for e in part["closure"]["each"] if e["quantity"] == quantity]
            middle = np.array([e["median"] for e in each])
            bars = np.abs(np.array([[e["q25"], e["q75"]] for e in each]).T - middle)
            axes.errorbar([e["horizon_s"] for e in each], middle, bars, color=colour, marker="o", ms=4, capsize=2, label=label)
        axes.axhline(1, color=SOFT, lw=0.8, ls="--")
        axes.set(title=quantity.rsplit("_", 1)[0].replace("_", " "), xlabel="horizon [s]", ylim=(-0.2, 1.15))
    panels[0][0].set_ylabel("share of recoverable error closed")
    figure.legend(*panels[0][-1].get_legend_handles_labels(), frameon=False, ncols=2, loc="outside upper center")
    return save(figure, folder, "closure.svg")
