# SPDX-License-Identifier: Apache-2.0
"""Tables and charts of drape_bench: runs.csv, report.md, accuracy.json, front_<error>, growth and
codes."""

import json
import math
import operator
import statistics

from study import MARKERS, main, markdown, number, pyplot

if pyplot:
    import matplotlib.colors
    import matplotlib.ticker

    matplotlib.rcParams["text.parse_math"] = False  # names of files are text

# The columns of runs.csv, beside the work and the status.
AXES = ["material", "law", "model", "draws", "mesh", "solve", "time_step", "relax_time", "tolerance",
        "mode", "backend", "threads", "batch"]
MEASURES = ["vertices", "repeats", "seconds", "seconds_spread", "cpu_seconds", "cpu_spread",
            "setup_seconds", "peak_mb", "vertex_mm", "outline_mm", "radius_mm", "dc", "dc_error",
            "folds", "derivative_error", "outline_px", "mse", "hausdorff_mm", "held_out_mse",
            "force_residual", "drift_mm"]
WORDS = ["material", "law", "model", "mesh", "solve", "mode", "backend"]  # axes known by their values

# The errors of each work; the first is that of the printed table.
ERRORS = {"forward": ["radius_mm", "outline_mm", "vertex_mm"],
          "gradient": ["derivative_error", "outline_mm"],
          "jacobian": ["derivative_error", "outline_mm"],
          "fit": ["outline_px", "mse", "hausdorff_mm", "held_out_mse"]}
ERROR_NAMES = {"vertex_mm": "rms distance of the vertices [mm]",
               "outline_mm": "rms distance of the outline [mm]",
               "radius_mm": "error of the outline's mean radius [mm]",
               "derivative_error": "relative error of the derivative by 39 log entries",
               "outline_px": "rms distance of the outline, at rest [px]",
               "hausdorff_mm": "Hausdorff distance of the outlines, at rest [mm]",
               "mse": "MSE of the silhouettes, at rest",
               "held_out_mse": "MSE of the held-out silhouettes"}

ROUNDING = 1e-6  # by which an error is no smaller than another, relative
LEAST_GAIN = 0.01  # a row of accuracy.json promises so much less than the next faster one, as a share
PUBLISHED_STEPS = 100  # of the time of a published program
# Standard deviation between the samples of a fabric, of the mean of the captures of one face, pooled
# over the five published fabrics: .023 of the drape coefficient.
SAMPLES_MM = 1.28


class Run(dict):
    """Axes and measures of a run. A number that is missing or not finite is NaN."""

    def __init__(self, cell, time):
        super().__init__(cell["input"], **cell["result"])
        self.ok = self["status"] == "ok"
        self.time = self.number(time)

    def number(self, name):
        value = self.get(name)
        return math.nan if value is None else value

    def label(self, axes):
        """"disc:600 hybrid time_step=0.1": these axes, as far as the run has them."""
        return " ".join(str(self[axis]) if axis in WORDS else f"{axis}={self[axis]:g}"
                        for axis in axes if axis in self)


class Bench:
    """All runs of a study, in its order."""

    def __init__(self, study):
        self.study = study
        self.work = study["settings"]["work"]
        self.clock = "cpu_seconds" if study["clock"] == "cpu" else "seconds"
        self.time_name = ("processor" if study["clock"] == "cpu" else "wall-clock") + " time [s]"
        self.errors = ERRORS[self.work]
        self.runs = [Run(cell, self.clock) for cell in study["cells"]]
        # The axes of which several values were run.
        self.varied = [axis for axis in AXES
                       if len({run[axis] for run in self.runs if axis in run}) > 1]

    def label(self, run):
        return run.label(self.varied)

    def method(self, run):
        """The mark of a run in a chart: its method as far as the axes vary it."""
        return run.label([axis for axis in ("model", "solve", "mode", "backend")
                          if axis in self.varied]) or run["solve"]

    def methods(self):
        return list(dict.fromkeys(self.method(run) for run in self.runs))

    def front(self, error):
        return pareto([run for run in self.runs if run.ok],
                      lambda run: (run.time, run.number(error)))

    def references(self):
        """The estimated errors of the reference of each cloth."""
        return {f"{run['material']} {run['law']} {run['model']}": run["reference_errors"]
                for run in self.runs if "reference_errors" in run}

    def reference_error(self, error):
        return max((of.get(error) or 0 for of in self.references().values()), default=0)

    def missing_references(self):
        return list(dict.fromkeys(run["failure"] for run in self.runs if "failure" in run))

    def growth(self):
        """Runs that differ only in the mesh, by their label, where there are several meshes."""
        series = {}
        for run in self.runs:
            if run.time > 0 and run.number("peak_mb") > 0:
                rest = run.label([axis for axis in self.varied if axis != "mesh"])
                series.setdefault(rest, []).append(run)
        return {name: of for name, of in series.items() if len({run["vertices"] for run in of}) > 1}

    def made_on(self):
        settings = self.study["settings"]
        keys = ["coarse_mesh", "reference", "reference_relax_mesh", "order", "branch_mm"]
        return " ".join([self.work, "start=" + self.study["start"]] + [
            key + "=" + settings[key].replace(",", "+") for key in keys if key in settings])


def pareto(items, cost_and_error):
    """The items that no other beats in both, cheapest first; of equal ones the first. Errors that
    differ by rounding alone, as those of one drape by two backends do, are equal."""
    front, least = [], math.inf
    points = [(*cost_and_error(item), at) for at, item in enumerate(items)]
    for _, error, at in sorted(point for point in points
                               if math.isfinite(point[0]) and math.isfinite(point[1])):
        if error < (1 - ROUNDING) * least:
            least = error
            front.append(items[at])
    return front


def exponent(runs, value):
    """Of the power law of a value in the number of vertices."""
    return statistics.linear_regression([math.log(run["vertices"]) for run in runs],
                                        [math.log(value(run)) for run in runs]).slope


time_of, megabytes_of = operator.attrgetter("time"), operator.itemgetter("peak_mb")


# Tables

def write_runs(bench):
    columns = [*AXES, "status", *MEASURES]
    bench.study.write_csv("runs.csv", ["# " + bench.made_on()], [
        ["work", *columns], *([bench.work, *map(run.get, columns)] for run in bench.runs)])


def front_table(bench, error):
    return [[number(run.time), number(run.number(error)), f"{run['peak_mb']:.0f}", bench.label(run)]
            for run in bench.front(error)]


def report(bench):
    text = ""
    for error in bench.errors:
        rows = front_table(bench, error)
        if rows:
            text += f"# Pareto front: {ERROR_NAMES[error]}\n\n" + markdown(
                [bench.time_name, error, "peak MB", "setting"], rows) + "\n"
    rows = [[name or "all", number(exponent(of, time_of)), number(exponent(of, megabytes_of))]
            for name, of in bench.growth().items()]
    if rows:
        text += "# Exponents of growth with the vertices\n\n" + markdown(
            ["setting", bench.time_name, "peak memory"], rows) + "\n"
    rows = [[cloth, *(number(of.get(error)) for error in bench.errors)]
            for cloth, of in bench.references().items()]
    if rows:
        text += "# Estimated errors of the references\n\n" + markdown(["cloth", *bench.errors], rows)
    return text


def printed(bench):
    error = bench.errors[0]
    text = f"{'seconds':>10} {error:>10} {'peak MB':>8}  front\n"
    for seconds, value, megabytes, label in front_table(bench, error):
        text += f"{seconds:>10} {value:>10} {megabytes:>8}  {label}\n"
    excluded = [run["status"] for run in bench.runs if not run.ok]
    text += f"{len(bench.runs)} runs, " + (
        "not on the front: " + "; ".join(f"{excluded.count(status)} {status}"
                                         for status in sorted(set(excluded)))
        if excluded else "all at rest and on the branch") + "\n"
    for cloth, of in bench.references().items():
        text += f"reference of {cloth}: estimated error {number(of.get(error))} ({error})\n"
    return text + "".join(line + "\n" for line in bench.missing_references())


# The table of --accuracy

def candidates(bench, margin):
    """What the fabrics of one setting say together: mean time, worst error. A setting that for one of
    the fabrics loses the branch or is not at rest is none."""
    fabrics = len({run["material"] for run in bench.runs})
    reference = bench.reference_error("radius_mm")
    settings = {}
    for run in bench.runs:
        if run.ok and run["solve"] != "static":
            settings.setdefault(run.label(AXES[1:]), []).append(run)
    return [{"mesh": of[0]["mesh"],
             "solve": of[0]["solve"],
             "time_step": of[0]["time_step"],
             "steps": max(1, round(of[0]["relax_time"] / of[0]["time_step"])),
             "error_mm": max(margin * (run.number("radius_mm") + reference) for run in of),
             "residual": max(run.number("force_residual") for run in of),
             "drift_mm": max(run.number("drift_mm") for run in of),
             "cost": sum(run.time for run in of) / fabrics}
            for of in settings.values() if len(of) == fabrics]


def accuracy_front(rows, solve):
    """The rows of an integrator that no other beats. What is gained by less than a percent is the
    rounding of Newton's method."""
    front = []
    for row in pareto([row for row in rows if row["solve"] == solve],
                      lambda row: (row["cost"], row["error_mm"])):
        if not front or row["error_mm"] < (1 - LEAST_GAIN) * front[-1]["error_mm"]:
            front.append(row)
    return front


def accuracy_table(bench, margin):
    """accuracy.json, which --accuracy_table reads; None where no hybrid setting has a row: a fit
    needs one of each level."""
    rows = candidates(bench, margin)
    hybrid = accuracy_front(rows, "hybrid")
    if not hybrid:
        return None
    fast, exact = hybrid[0]["error_mm"], hybrid[-1]["error_mm"]
    cost = hybrid[-1]["cost"]
    rows = [{**row, "cost": row["cost"] / cost} for row in hybrid + accuracy_front(rows, "dynamic")]
    return {"format": "drapefit-accuracy", "version": 2, "made_on": bench.made_on(),
            "max_residual": 1e-6, "max_drift_mm": 1.0, "fast_mm": fast,
            "balanced_mm": math.sqrt(fast * exact), "exact_mm": exact,
            "rows": sorted(rows, key=lambda row: row["cost"])}


# Charts

def vertex_ticks(axis, runs):
    vertices = sorted({run["vertices"] for run in runs})
    axis.set_ticks(vertices, [f"{each:.9g}" for each in vertices])
    axis.set_ticks([], minor=True)


def logarithmic(axes, xlabel, ylabel, x, y):
    axes.set(xlabel=xlabel, ylabel=ylabel, xscale="log", yscale="log")
    axes.margins(0.1)
    for axis, values in ((axes.xaxis, x), (axes.yaxis, y)):
        spread = max(values) / min(values)
        marked = (1, 1.5, 2, 3, 4, 5, 6, 8) if spread < 6 else (1, 2, 5) if spread < 300 else (1,)
        axis.set_major_locator(matplotlib.ticker.LogLocator(subs=marked))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(matplotlib.ticker.NullFormatter())


def number_front(axes, front, error):
    """The numbers of the points of the front beside them; those of points close together in one
    text."""
    groups = []
    for at, run in enumerate(front):
        point = (math.log10(run.time), math.log10(run[error]))
        if groups and max(abs(a - b) for a, b in zip(groups[-1][0], point)) < 0.07:
            groups[-1][1].append(str(at + 1))
        else:
            groups.append((point, [str(at + 1)], run))
    for _, numbers, run in groups:
        axes.annotate(",".join(numbers), (run.time, run[error]), (-5, -7), ha="right", va="center",
                      textcoords="offset points", fontsize=9)


def list_front(axes, bench, front, error):
    most = 15
    lines = ["Pareto front: seconds, error, setting"]
    lines += [f"{at + 1}  {number(run.time)}  {number(run[error])}  {bench.label(run)}"
              for at, run in enumerate(front[:most])]
    if len(front) > most:
        lines.append("… all in report.md")
    axes.axis("off")
    axes.text(0, 1, "\n".join(lines), transform=axes.transAxes, va="top", fontsize=8,
              parse_math=False)


def draw_front(bench, error):
    runs = [run for run in bench.runs if run.time > 0 and run.number(error) > 0]
    front = [run for run in bench.front(error) if run in runs]
    if not front:
        return
    figure, (axes, side) = pyplot.subplots(1, 2, figsize=(11, 6.4), width_ratios=(1.9, 1))
    figure.suptitle("Work against precision: " + bench.work)
    for at, status in enumerate(sorted({run["status"] for run in runs if not run.ok})):
        of = [run for run in runs if run["status"] == status]
        axes.plot([run.time for run in of], [run[error] for run in of], "ox"[at > 0], color="#aaaaaa",
                  fillstyle="none", label=status)
    axes.plot([run.time for run in front], [run[error] for run in front], color="#d62728",
              label="Pareto front")
    vertices = [run["vertices"] for run in runs]
    norm = matplotlib.colors.LogNorm(min(vertices), max(vertices) + 1)
    for method, marker in zip(bench.methods(), MARKERS * len(runs)):
        of = [run for run in runs if run.ok and bench.method(run) == method]
        if of:
            points = axes.scatter([run.time for run in of], [run[error] for run in of], 55,
                                  [run["vertices"] for run in of], marker, cmap="viridis", norm=norm,
                                  zorder=3, label=method)
    reference = bench.reference_error(error)
    if reference > 0:
        axes.axhline(reference, color="#555555", linestyle="--", linewidth=1,
                     label="error of the reference, estimated")
    logarithmic(axes, bench.time_name, ERROR_NAMES[error], [run.time for run in runs],
                [run[error] for run in runs])
    vertex_ticks(figure.colorbar(points, ax=axes, label="vertices").ax.yaxis, runs)
    number_front(axes, front, error)
    list_front(side, bench, front, error)
    side.legend(*axes.get_legend_handles_labels(), loc="lower left", fontsize=9)
    bench.study.save(figure, "front_" + error)


def draw_growth(bench):
    """One series a method, that of its first other settings: all are more than a picture can hold."""
    series = {}
    for name, of in bench.growth().items():
        series.setdefault(bench.method(of[0]), (name, of))
    if not series:
        return
    figure, grid = pyplot.subplots(1, 2, figsize=(11, 5.6))
    figure.suptitle("Growth with the mesh: " + bench.work)
    for axes, label, value in ((grid[0], bench.time_name, time_of),
                               (grid[1], "peak memory [MB]", megabytes_of)):
        for (name, of), marker in zip(series.values(), MARKERS * len(series)):
            axes.plot([run["vertices"] for run in of], [value(run) for run in of], "-" + marker,
                      label=f"{name}: V^{exponent(of, value):.2f}".lstrip(": "))
        all_runs = [run for _, of in series.values() for run in of]
        logarithmic(axes, "vertices", label, [run["vertices"] for run in all_runs],
                    [value(run) for run in all_runs])
        vertex_ticks(axes.xaxis, all_runs)
        axes.legend(fontsize=8, loc="upper left")
    bench.study.save(figure, "growth")


def compare_codes(bench, published):
    """Vertices, seconds and errors of each code. The cloth of the published programs is that of the
    reference law: their time is that of so many steps, their error that of our drape by that law on a
    mesh of about as many vertices, which leaves out the errors of their steps."""
    usable = [run for run in bench.runs if run.ok and run["radius_mm"] > 0]
    reference = [run for run in usable if run["law"] != "smooth"]
    if not reference:
        return {}
    codes = {}
    for run in usable:
        if run["law"] == "smooth":
            threads = run["threads"]
            machine = (f"{threads} thread{'' if threads == 1 else 's'}" if run["backend"] == "cpu"
                       else f"GPU, {run['batch']} at once")
            codes.setdefault("drapefit, " + machine, []).append(
                (run["vertices"], run.time, run["radius_mm"]))
    for row in published["rows"]:
        for vertices, seconds in zip(published["vertices"], row.get("forward_s", [])):
            alike = [run for run in reference if abs(run["vertices"] / vertices - 1) < 0.1]
            if alike:
                codes.setdefault(f"{row['name']}, {row['machine']}", []).append(
                    (vertices, PUBLISHED_STEPS * seconds, alike[0]["radius_mm"]))
    return codes


def draw_codes(bench, codes):
    figure, axes = pyplot.subplots(figsize=(11, 6.4))
    figure.suptitle("Error of a drape against its time; numbers are vertices")
    points = [point for of in codes.values() for point in of]
    for (name, of), marker in zip(codes.items(), MARKERS * len(codes)):
        axes.plot([point[1] for point in of], [point[2] for point in of], "-" + marker, label=name)
        for vertices, seconds, error in of:
            axes.annotate(f"{vertices:.0f}", (seconds, error), (5, 5), fontsize=8,
                          textcoords="offset points")
    axes.axhline(SAMPLES_MM, color="#555555", linestyle="--")
    axes.annotate("scatter between samples of a fabric", (min(point[1] for point in points), SAMPLES_MM),
                  (0, 5), textcoords="offset points")
    logarithmic(axes, bench.time_name, "error of the mean radius [mm], 1 mm is 1.7 points of DC",
                [point[1] for point in points], [point[2] for point in points])
    axes.legend(loc="lower right")
    bench.study.save(figure, "codes")


def draw(study):
    bench = Bench(study)
    write_runs(bench)
    study.write("report.md", report(bench))
    text = printed(bench)
    if bench.work == "forward":
        table = accuracy_table(bench, study["error_margin"])
        if table:
            study.write("accuracy.json", json.dumps(table, indent=2) + "\n")
        else:
            text += ("no accuracy.json: no hybrid setting keeps the branch of all fabrics and ends at "
                     "rest\n")
    print(text, end="")
    if not pyplot:
        return
    for error in bench.errors:
        draw_front(bench, error)
    draw_growth(bench)
    codes = compare_codes(bench, study["published"]) if study["published"] else {}
    if codes:
        draw_codes(bench, codes)


if __name__ == "__main__":
    main(draw, "bench")
