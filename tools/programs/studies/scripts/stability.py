# SPDX-License-Identifier: Apache-2.0
"""The stability atlas: runs.csv, a chart per map, an overview, and the tables that are printed."""

import math
from collections import Counter

from study import aligned, main, number, pyplot

# In this order in tables: letter, and colour from green (at its place) to dark (no answer).
OUTCOMES = {
    "settled": ("S", "#1a9850"),
    "still moving": ("m", "#a6d96a"),
    "other branch": ("b", "#fee08b"),
    "folded over": ("F", "#f46d43"),
    "diverged": ("D", "#a50026"),
    "factor failed": ("X", "#762a83"),
    "not converged": ("N", "#4d4d4d"),
}
METHODS = {
    "explicit": "explicit Euler",
    "step": "one solve per step",
    "step_pcg": "one solve, conjugate gradients",
    "step_float": "one solve, single precision",
    "implicit": "implicit Euler, converged",
    "static": "Newton to rest",
    "static_mass_shift": "Newton, shift by the mass",
    "static_no_shift": "Newton, no shift",
    "static_projected": "Newton, projected elements",
}
HARDSHIPS = {
    "stiffness": {"stiffness", "stretch", "bend"},
    "density": {"density"},
    "needles": {"sliver"},
    "compressed": {"compression"},
    "tangled": {"tangle"},
    "handles": {"handle"},
}
SHARES = [(0.9, "#66bd63"), (0.7, "#b8e186"), (0.4, "#fee08b"), (0.0, "#f4a582")]


def title(study, base):
    """What is unusual beside the axes: "explicit Euler, drape, density 0.1 kg/m²"."""
    usual = study["usual"]
    words = [METHODS[base["method"]], "drape"]
    if base["law"] != usual["law"]:
        words.append("law " + base["law"])
    news = {key: base[key] for key in study["axes"] if key in base and base[key] != usual[key]}
    if "stretch" in news and news["stretch"] == news.get("bend"):
        news = {"stiffness": news["stretch"], **news}
        del news["stretch"], news["bend"]
    for key, value in news.items():
        name, _, unit = study["axes"][key].rstrip("]").partition(" [")
        factor = unit == "factor"
        words.append(f"{name} times {value:.4g}" if factor else f"{name} {value:.4g} {unit}".strip())
    return ", ".join(words)


def position(values, value):
    """Where a value lies among values that are drawn at 0, 1, 2, …"""
    scale = math.log if values[0] > 0 else float
    above = min(max(sum(v <= value for v in values), 1), len(values) - 1)
    low, high = scale(values[above - 1]), scale(values[above])
    return above - 1 + (scale(value) - low) / (high - low)


def draw_map(study, chart, cells):
    across, up = chart["across"]["values"], chart["up"]["values"]
    figure, axes = pyplot.subplots(figsize=(9.8, 6.4))
    outcomes = [cells[name]["outcome"] if name in cells else None for name in chart["runs"]]
    for outcome, (_, colour) in OUTCOMES.items():
        at = [divmod(n, len(across)) for n, found in enumerate(outcomes) if found == outcome]
        if at:
            x, y = [column - 0.5 for _, column in at], [1] * len(at)
            low = [row - 0.5 for row, _ in at]
            axes.bar(x, y, 1, low, align="edge", color=colour, label=outcome)
    line = theory_line(chart, cells)
    if line:
        axes.plot([position(across, x) for x, _ in line], [position(up, y) for _, y in line], "ko-",
                  label="2/ω, theory")
    axes.set(title=title(study, chart["base"]))
    axes.set(xlabel=chart["across"]["label"], ylabel=chart["up"]["label"])
    for values, set_ticks, turn in ((across, axes.set_xticks, 45), (up, axes.set_yticks, 0)):
        every = -(-len(values) // 15)
        ticks = range(0, len(values), every)
        set_ticks(ticks, [f"{values[i]:.4g}" for i in ticks], rotation=turn)
    axes.set(xlim=(-0.5, len(across) - 0.5), ylim=(-0.5, len(up) - 0.5))
    axes.grid(False)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1))
    study.save(figure, chart["name"])


def limits(chart, cells):
    """(value of the other axis, limit) of an explicit map."""
    if "limits" not in chart:
        return []
    other = "up" if chart["across"]["axis"] == "time_step" else "across"
    return [(value, cells[name]) for value, name in zip(chart[other]["values"], chart["limits"])
            if name in cells]


def theory_line(chart, cells):
    points = [(v, found["theory_s"]) for v, found in limits(chart, cells) if found["theory_s"]]
    return [(h, v) for v, h in points] if chart["across"]["axis"] == "time_step" else points


def hardship_of(chart):
    """The column of the overview that a map of the smooth law counts in."""
    if chart["base"]["law"] != "smooth":
        return []
    axes = {chart["across"]["axis"], chart["up"]["axis"]}
    return [name for name, members in HARDSHIPS.items() if axes & members]


def draw_overview(study, cells):
    counts = {}
    for chart in study["maps"]:
        for hardship in hardship_of(chart):
            found = (cells[name]["outcome"] for name in chart["runs"] if name in cells)
            counts.setdefault((chart["base"]["method"], hardship), Counter()).update(found)
    rows = [method for method in METHODS if any(key[0] == method for key in counts)]
    columns = [name for name in HARDSHIPS if any(key[1] == name for key in counts)]
    if not rows:
        return
    figure, axes = pyplot.subplots(figsize=(11, 1.6 + 0.36 * max(len(rows), 4)))
    for y, method in enumerate(rows):
        for x, hardship in enumerate(columns):
            found = counts.get((method, hardship))
            if not found:
                axes.text(x, y, "not run", ha="center", va="center", fontsize=9)
                continue
            share = found["settled"] / found.total()
            colour = next(colour for least, colour in SHARES if share >= least)
            axes.bar(x, 1, 1, y - 0.5, color=colour)
            failures = [key for key in OUTCOMES if key != "settled" and found[key]]
            worst = max(failures, key=lambda key: found[key], default=None)
            text = f"{100 * share:.0f} %" + (" " + OUTCOMES[worst][0] if worst else "")
            axes.text(x, y, text, ha="center", va="center")
    seen = set().union(*counts.values()) - {"settled"}
    letters = ", ".join(f"{OUTCOMES[key][0]} {key}" for key in OUTCOMES if key in seen)
    axes.set_title("Share of runs that settle, by solver and by what is varied\n"
                   "letter: the most frequent failure" + (": " + letters if letters else ""))
    axes.set_xticks(range(len(columns)), columns)
    axes.set_yticks(range(len(rows)), [METHODS[method] for method in rows])
    axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(len(rows) - 0.5, -0.5))
    axes.grid(False)
    study.save(figure, "overview")


def count_row(name, runs):
    found = Counter(run["outcome"] for run in runs)
    return [name, *(found[outcome] for outcome in OUTCOMES)]


def milliseconds(seconds):
    return "-" if seconds is None else f"{1e3 * seconds:.4f}"


def print_table(title, header, rows):
    if rows:
        print(f"\n{title}\n" + aligned(header, rows), end="")


def draw(study):
    results = study.results()
    cells = {cell["name"]: cell for cell in results}
    runs = [cell for cell in results if cell["input"]["kind"] == "run"]
    columns = ["outcome", "steps", "seconds", "residual", "speed_m_s", "distance_m"]
    study.write_csv("runs.csv", [*study["usual"], *columns], [
        [run["input"][key] for key in study["usual"]] + [run[key] for key in columns] for run in runs])
    rows = [count_row(chart["name"], [cells[name] for name in chart["runs"] if name in cells])
            for chart in study["maps"]]
    rows.append(count_row(f"all {len(runs)}", runs))
    print(aligned(["runs", *OUTCOMES], rows), end="")
    print_table("largest stable explicit step [ms]", ["map", "at", "theory", "measured"], [
        [chart["name"], number(value, 4), *(milliseconds(found[k]) for k in ("theory_s", "measured_s"))]
        for chart in study["maps"] for value, found in limits(chart, cells)])
    print_table("factor of a vibration per step",
                ["method", "h [s]", "mode", "omega [1/s]", "theory", "measured"], [
        [cell["input"]["method"], f"{cell['input']['time_step']:g}", cell["input"]["mode"],
         number(cell["omega_1_s"], 5), f"{cell['theory']:.6f}", f"{cell['measured']:.6f}"]
        for cell in results
        if cell["input"]["kind"] == "damping" and cell["omega_1_s"] is not None])
    if pyplot is None:
        return
    draw_overview(study, cells)
    for chart in study["maps"]:
        draw_map(study, chart, cells)


main(draw, "stability")
