# SPDX-License-Identifier: Apache-2.0
"""Tables and charts of drape_gradients: report.md, differences, horizons and fold."""

import numpy

from study import aligned, main, markdown, pyplot

RANGE = 10  # of the speed, for the fitted exponents


def exponent(x, y):
    """b of y = a x^b by least squares of the logarithms; None for fewer than two distinct x."""
    return numpy.polyfit(numpy.log(x), numpy.log(y), 1)[0] if len(set(x)) > 1 else None


def find_approach(branch):
    """Adds how the derivative grows towards the end of a branch: the last points of a branch that
    ended, those with speed >= largest/RANGE. At a fold s* the lowest eigenvalue goes as (s* - s)^½
    and the speed as its inverse, (s* - s)^-½."""
    if "fold_estimate" not in branch:
        return branch
    points = [(abs(branch["fold_estimate"] - point["s"]), point["lowest_eigenvalue"], point["speed_m"])
              for point in branch["points"]]
    near = [point for point in points if RANGE * point[2] >= points[-1][2] and (point[1] or 0) > 0
            and point[0] > 0]
    distance, eigenvalue, speed = map(list, zip(*near)) if near else ([], [], [])
    exponents = {"exponent_by_distance": exponent(distance, speed),
                 "exponent_by_eigenvalue": exponent(eigenvalue, speed)}
    return {**branch, "approach": {"distance": distance, "lowest_eigenvalue": eigenvalue,
                                   "speed_m": speed},
            **{key: value for key, value in exponents.items() if value is not None}}


def difference_table(sweeps):
    steps = [error["step"] for error in sweeps[0]["errors"]] if sweeps else []
    rows = [[f"{step:.0e}"] + [f"{sweep['errors'][i]['error']:.1e}" if i < len(sweep["errors"]) and
                               sweep["errors"][i]["error"] is not None else "–" for sweep in sweeps]
            for i, step in enumerate(steps)]
    return ["difference step", *(sweep["of"] for sweep in sweeps)], rows


def horizon_table(series):
    return ["law", "h [s]", "steps", "size of the gradient [m]", "error"], [
        [of["law"], f"{of['h_s']:g}", steps, f"{error['size_m']:.2g}",
         "–" if error["error"] is None else f"{error['error']:.0e}"]
        for of in series for steps, error in zip(of["steps"], of["errors"])]


def branch_table(branches):
    rows = []
    for branch in branches:
        row = [branch["seed"], branch["status"]] + ["–"] * 5
        if branch["points"]:
            first, last = branch["points"][0], branch["points"][-1]
            row[2] = f"{last['s']:.5f}"
            for column, key in ((3, "lowest_eigenvalue"), (4, "speed_m")):
                row[column] = " → ".join(
                    "–" if end[key] is None else f"{end[key]:.3g}" for end in (first, last))
        if "exponent_by_distance" in branch and "exponent_by_eigenvalue" in branch:
            row[5] = f"{branch['exponent_by_distance']:.2f}"
            row[6] = f"{branch['exponent_by_eigenvalue']:.2f}"
        rows.append(row)
    return ["start", "end", "at s", "lowest eigenvalue [1/s²]", "speed [m]",
            "exponent by distance", "by eigenvalue"], rows


def lines(axes, title, xlabel, ylabel, curves):
    """curves: (label, x, y); a missing y is a gap."""
    for label, x, y in curves:
        axes.plot(x, [float("nan") if value is None else value for value in y], "o-", markersize=3,
                  label=label)
    axes.set(title=title, xlabel=xlabel, ylabel=ylabel, xscale="log", yscale="log")
    if curves:
        axes.legend(fontsize="small")


def draw_charts(study, sweeps, series, branches):
    figure, axes = pyplot.subplots(figsize=(6.4, 4.8))
    lines(axes, "Central differences against the tangent", "step of the difference [log units]",
          "relative error", [(sweep["of"], [error["step"] for error in sweep["errors"]],
                              [error["error"] for error in sweep["errors"]]) for sweep in sweeps])
    study.save(figure, "differences")
    figure, grid = pyplot.subplots(1, 2, figsize=(12.8, 4.8))
    for axes, key, title, label in (
            (grid[0], "size_m", "Size of the gradient", "|∂x/∂s|, root mean square [m]"),
            (grid[1], "error", "Error of differences", "relative error")):
        lines(axes, title, "simulated time [s]", label, [
            (f"{of['law']}, h = {of['h_s']:g} s", [of["h_s"] * steps for steps in of["steps"]],
             [error[key] for error in of["errors"]]) for of in series])
    study.save(figure, "horizons")
    figure, grid = pyplot.subplots(1, 2, figsize=(12.8, 4.8))
    for axes, key, exponent, label in (
            (grid[0], "distance", "exponent_by_distance",
             "distance s* − s to the end [log units of bend]"),
            (grid[1], "lowest_eigenvalue", "exponent_by_eigenvalue",
             "lowest eigenvalue of K by M [1/s²]")):
        lines(axes, "Towards the end of a branch", label, "|∂x/∂s|, root mean square [m]", [
            (f"start {of['seed']}, slope {of[exponent]:.2f}", of["approach"][key],
             of["approach"]["speed_m"]) for of in branches if exponent in of])
    study.save(figure, "fold")


def draw(study):
    parts = {"differences": [], "horizons": [], "branches": []}
    for cell in study["cells"]:
        part, result = cell["input"]["part"], cell["result"]
        parts[part] += result if part == "differences" else [{**cell["input"], **result}]
    parts["branches"] = [find_approach(branch) for branch in parts["branches"]]
    tables = [difference_table(parts["differences"]), horizon_table(parts["horizons"]),
              branch_table(parts["branches"])]
    study.write("report.md", "\n".join(markdown(*table) for table in tables))
    if pyplot:
        draw_charts(study, *parts.values())
    print("\n".join(aligned(*table) for table in tables), end="")


if __name__ == "__main__":
    main(draw, "gradients")
