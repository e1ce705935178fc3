# SPDX-License-Identifier: Apache-2.0
"""Tables and charts of drape_compare_optimisers: report.md, traces.csv and four charts [Dolan 2002;
More 2009]."""

import json
import math

import numpy

from study import aligned, main, markdown, pyplot

BRANCH_MM = 3  # drapes nearer than this are one branch
REACHED = 1.1  # a run reaches Levenberg-Marquardt when its cost is at most so many times that of "lm"
NEVER = math.inf


def quantile(values, share):
    """Interpolates linearly between order statistics; infinity sorts last."""
    values = sorted(values)
    place = share * (len(values) - 1)
    low = math.floor(place)
    if place == low or values[low] == values[low + 1]:
        return values[low]
    return values[low] + (place - low) * (values[low + 1] - values[low])


def quartiles(values):
    return [quantile(values, share) for share in (0.25, 0.5, 0.75)]


def spread(values, form):
    """"median [lower quartile, upper quartile]"."""
    values = quartiles(values)
    low, middle, high = ["none" if value == NEVER else format(value, form) for value in values]
    return middle if values[0] == values[2] else f"{middle} [{low}, {high}]"


class Run(dict):
    """A result of a cell with its final cost."""

    def __init__(self, cell):
        super().__init__(cell["result"], **cell["input"])
        self.trace = self["trace"]
        self.cost = self.trace[-1][2] if self.trace else NEVER
        self.shape = numpy.array(self.get("shape_um", []))

    def spent_to(self, cost, column=0):
        """What was spent (column 0: budget, 1: CPU seconds) when the cost first was at most this."""
        return next((point[column] for point in self.trace if point[2] <= cost), NEVER)

    def cost_at(self, spent):
        return next((point[2] for point in reversed(self.trace) if point[0] <= spent), NEVER)


class Race:
    """Runs by problem and method; the seeds of a method are runs of their own."""

    def __init__(self, runs):
        self.runs = {}
        for run in runs:
            self.runs.setdefault(run["problem"], {}).setdefault(run["method"], []).append(run)
        self.problems = list(self.runs)
        self.methods = list(dict.fromkeys(run["method"] for run in runs))
        self.seeds = max((len(of) for by in self.runs.values() for of in by.values()), default=0)
        self.best = {p: min(self.all(p), key=lambda run: run.cost) for p in self.problems}
        self.start = {p: next((run.trace[0][2] for run in self.all(p) if run.trace), NEVER)
                      for p in self.problems}

    def all(self, problem):
        return [run for of in self.runs[problem].values() for run in of]

    def of(self, method):
        """The runs of a method by problem and seed; one without seeds counts as often as others."""
        return [of[0] if len(of) == 1 else of[seed] for of in
                (self.runs[problem][method] for problem in self.problems) for seed in range(self.seeds)]

    def gap(self, run, cost):
        best, start = self.best[run["problem"]].cost, self.start[run["problem"]]
        return min(1.0, (cost - best) / (start - best)) if start > best else 0.0

    def gaps_at(self, method, spent):
        return [self.gap(run, run.cost_at(spent)) for run in self.of(method)]

    def spent_to_solve(self, method, tolerance, column=0):
        """What each run spent to cover all of the way to the best but this share."""
        def target(problem):
            best = self.best[problem].cost
            return best + tolerance * (self.start[problem] - best)
        return [run.spent_to(target(run["problem"]), column) for run in self.of(method)]

    def spent_to_reach_lm(self, method):
        return [run.spent_to(REACHED * self.runs[run["problem"]]["lm"][0].cost)
                for run in self.of(method)]

    def on_best_branch(self, run):
        if not run.shape.size:
            return False
        distance = run.shape - self.best[run["problem"]].shape
        return math.sqrt(3 * numpy.mean(distance**2.0)) <= 1000 * BRANCH_MM


def is_refined(method):
    return method.endswith("_lm")


def method_scores(race):
    def mean(values):
        # None is a shape without outline.
        return None if not values or None in values else sum(values) / len(values)
    for method in race.methods:
        runs = race.of(method)
        gaps = [race.gap(run, run.cost) for run in runs]
        drapes = [run for run in runs if run.shape.size]
        evaluations = sum(run["evaluations"] + run["jacobians"] for run in runs)
        yield {
            "name": method,
            "solved_at_0.1": float(numpy.mean([gap <= 0.1 for gap in gaps])),
            "solved_at_0.01": float(numpy.mean([gap <= 0.01 for gap in gaps])),
            "wins": float(numpy.mean([run.cost <= 1.001 * race.best[run["problem"]].cost
                                      for run in runs])),
            "best_branch": float(numpy.mean([race.on_best_branch(run) for run in runs])),
            "gaps": gaps,
            "mean_rms_px": mean([run["rms_px"] for run in drapes]),
            "mean_settled_rms_px": mean([run["settled_rms_px"] for run in drapes]),
            "largest_coupling": max([run["coupling"] for run in drapes], default=0),
            "failed_share": sum(run["failed"] for run in runs) / max(1, evaluations),
            "median_cpu_s": quantile([run["cpu_s"] for run in runs], 0.5),
            "median_own_cpu_s": quantile([run["cpu_s"] - run["function_cpu_s"] for run in runs], 0.5)}


def method_rows(race):
    forms = ["", ".2f", ".2f", ".2f", ".2f", ".4f", ".2f", ".2f", ".3f", ".2f", ".1f", ".1f"]
    for score in method_scores(race):
        yield [spread(value, form) if isinstance(value, list) else
               "–" if value is None else format(value, form)
               for value, form in zip(score.values(), forms)]


def budget_table(race, budgets):
    has_lm = "lm" in race.methods
    header = ["method"] + [f"gap at {budget:g}" for budget in budgets]
    header += [f"reaches {REACHED:g} × lm", "rollouts to it"] if has_lm else []
    rows = []
    for method in race.methods:
        row = [method]
        for budget in budgets:  # a refined method has its result at the end only
            row.append("–" if is_refined(method) and budget < budgets[-1]
                       else spread(race.gaps_at(method, budget), ".3f"))
        if has_lm:
            spent = race.spent_to_reach_lm(method)
            row += [f"{numpy.mean([s < NEVER for s in spent]):.2f}", spread(spent, ".0f")]
        rows.append(row)
    return markdown(header, rows)


def problem_table(race):
    rows = []
    for problem in race.problems:
        row = [problem, f"{race.start[problem]:.4g}"]
        for method in race.methods:
            runs = race.runs[problem][method]
            cost = spread([run.cost for run in runs], ".4g")
            if race.best[problem] in runs:
                cost = f"**{cost}**"
            row.append(f"{cost} ({quantile([run.get('rms_px') or 0 for run in runs], 0.5):.2f} px)")
        rows.append(row)
    return markdown(["problem", "start", *race.methods], rows)


def jacobian_cost(runs):
    """CPU seconds of a Jacobian by those of an evaluation, over all runs with both."""
    runs = [run for run in runs if run["jacobians"]]
    total = {key: sum(run[key] for run in runs) for key in
             ("jacobian_cpu_s", "function_cpu_s", "jacobians", "evaluations")}
    if not runs:
        return 0.0
    return (total["jacobian_cpu_s"] / total["jacobians"]) / (
        (total["function_cpu_s"] - total["jacobian_cpu_s"]) / total["evaluations"])


# One colour per family, darker with more numbers of the embedding; a refined method looks like its
# search.
COLOURS = {"lm": "black", "cmaes": "#984ea3", "bo": "#009e73", "rembo_2": "#9ecae1",
           "rembo_4": "#3182bd", "rembo_8": "#08306b", "rembo_ucb_4": "#3182bd",
           "hesbo_2": "#fdbe85", "hesbo_4": "#fd8d3c", "hesbo_8": "#a63603"}


def style(method):
    name = method.removesuffix("_lm") if method != "lm" else method
    return {"label": method, "color": COLOURS.get(name), "linewidth": 3 if name == "lm" else 1.5,
            "linestyle": "--" if name == "rembo_ucb_4" else "-"}


def groups(race):
    """Methods of one chart each: searches alone, and with Levenberg-Marquardt at their end."""
    alone = [m for m in race.methods if m == "lm" or not is_refined(m)]
    refined = [m for m in race.methods if m == "lm" or is_refined(m)]
    if len(alone) == len(race.methods):
        return [("", alone)]
    return [(", alone", alone), (", refined by Levenberg–Marquardt", refined)]


def count(race):
    text = f"{len(race.problems)} problem" + "s" * (len(race.problems) != 1)
    return text + (f" × {race.seeds} seeds" if race.seeds > 1 else "")


def draw_grid(study, name, panels, columns):
    """panels: functions that draw to their axes."""
    rows = math.ceil(len(panels) / columns)
    figure, grid = pyplot.subplots(rows, columns, squeeze=False,
                                   figsize=(6.4 * columns, 4.4 * rows))
    for axes, panel in zip(grid.flat, panels):
        panel(axes)
    for axes in grid.flat[len(panels):]:
        axes.axis("off")
    study.save(figure, name)


def convergence(race, group, budget):
    def panel(axes):
        spent = budget ** numpy.linspace(0, 1, 151)
        for method in group[1]:
            gaps = [quantile(race.gaps_at(method, s), 0.5) for s in spent]
            axes.plot(spent, numpy.maximum(gaps, 1e-2), **style(method))
        axes.set(title=f"Median over {count(race)}{group[0]}", xlabel="spent [rollouts]",
                 ylabel="(cost − best) / (start − best)", xscale="log", yscale="log", ylim=(1e-2, 1.5))
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return panel


def staircases(values, group, largest, title, xlabel):
    """values: what each run of a method spent, or its ratio."""
    def panel(axes):
        for method in group[1]:
            steps = sorted(value for value in values[method] if value <= largest)
            shares = numpy.arange(len(steps) + 1) / len(values[method])
            axes.step([1, *steps, largest], [*shares, shares[-1]], where="post", **style(method))
        axes.set(title=title + group[0], xlabel=xlabel, ylabel="share of the problems",
                 xscale="log", xlim=(1, largest), ylim=(0, 1.02))
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return panel


def ratios(race, tolerance, column):
    """What each run spent to solve its problem, by the least of any method."""
    spent = numpy.array([race.spent_to_solve(m, tolerance, column) for m in race.methods])
    least = spent.min(axis=0)
    return dict(zip(race.methods, numpy.where(least < NEVER, spent / numpy.where(
        least < NEVER, least, 1), NEVER)))


def draw_branches(study, race):
    figure, axes = pyplot.subplots(figsize=(max(8.2, 1.6 + 0.5 * len(race.methods)), 4.4))
    shares = [100 * numpy.mean([race.on_best_branch(run) for run in race.of(m)]) for m in race.methods]
    axes.bar_label(axes.bar(range(len(shares)), shares, color="#0072b2"), fmt="%.0f")
    axes.set_xticks(range(len(shares)), race.methods, rotation=30)
    axes.set(title="Ends on the branch of the best run", ylabel="share of the problems [%]", ylim=(0, 110))
    study.save(figure, "branches")


def draw_charts(study, race, parts, budget):
    draw_grid(study, "convergence", [convergence(race, group, budget) for group in groups(race)], 2)
    units = ("rollouts", "CPU seconds")
    draw_grid(study, "profiles", [
        staircases(ratios(race, tolerance, column), group, 100,
                   f"Problems solved to {100 * (1 - tolerance):g} % of the way to the best",
                   f"{units[column]} by those of the quickest method")
        for tolerance in (0.1, 0.01) for group in groups(race) for column in (0, 1)], 2)
    profiles = []
    for title, part in parts:
        cases = [(group, 0.1) for group in groups(part)]
        for group, tolerance in [(cases[0][0], 0.5), *cases]:
            spent = {m: part.spent_to_solve(m, tolerance) for m in part.methods}
            profiles.append(staircases(
                spent, group, budget, f"{title}, {100 * (1 - tolerance):g} % of the way to the best",
                "spent [rollouts]"))
    draw_grid(study, "data_profiles", profiles, len(profiles) // len(parts))
    draw_branches(study, race)


def draw(study):
    cells = study["cells"]
    failed = list(dict.fromkeys(cell["input"]["problem"] for cell in cells
                                if cell["result"] is None or "failure" in cell["result"]))
    runs = [Run(cell) for cell in cells if cell["input"]["problem"] not in failed]
    notes = [f"{problem}: left out, since no initial guess comes to rest" for problem in failed]
    if not runs:
        print("\n".join(notes))
        return
    race = Race(runs)
    budget = study["settings"]["budget_rollouts"]
    budgets = sorted({budget, *(b for b in study["checkpoints"] if b < budget)})
    parts = [(f"{n} numbers", Race([run for run in runs if run["num_parameters"] == n]))
             for n in dict.fromkeys(run["num_parameters"] for run in runs)]
    header = ["method", "within 10 %", "within 1 %", "best", "best branch", "gap", "rms [px]",
              "settled rms [px]", "c12²/(c11·c22)", "failed", "CPU s", "own CPU s"]
    rows = list(method_rows(race))
    study.write("report.md", markdown(header, rows) + (
        f"\nA Jacobian cost {jacobian_cost(runs):.2f} rollouts of CPU time beside its own; it was paid"
        f" with {study['settings']['jacobian_cost_units']:g}.\n\n")
        + "".join(f"{title}:\n\n{budget_table(part, budgets)}\n" for title, part in parts)
        + problem_table(race) + "".join(f"\n{note}\n" for note in notes))
    study.write_csv("traces.csv", ["problem", "method", "seed", "spent_rollouts", "cpu_s", "cost"],
                    [[run["problem"], run["method"], run["seed"], f"{point[0]:.6g}",
                      f"{point[1]:.6g}", f"{point[2]:.9g}"] for run in runs for point in run.trace])
    study.json["methods"] = [  # for other readers of the file
        {key: None if value == NEVER else value for key, value in score.items()}
        for score in method_scores(race)]
    study.write("compare_optimisers.json", json.dumps(study.json, indent=1) + "\n")
    if pyplot:
        draw_charts(study, race, parts, budget)
    print("".join(note + "\n" for note in notes) + aligned(header, rows), end="")


if __name__ == "__main__":
    main(draw, "compare_optimisers")
