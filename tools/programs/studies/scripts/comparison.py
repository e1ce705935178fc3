# SPDX-License-Identifier: Apache-2.0
"""Tables and charts of drape_compare.

Reads the runs in comparison.json and adds the tables to it. Writes comparison.md, comparison.csv
and, for each table, the charts models and held_out.
"""

import collections
import json
import math

import study

# Key, label, unit of the label in SI.
NUMBERS = [
    # The fit on its own images.
    ("train_mse", "fit: silhouette MSE", 1),
    ("train_profile_rms_px", "fit: outline rms [px]", 1),
    ("train_iou", "fit: IoU", 1),
    ("train_hausdorff_m", "fit: outline Hausdorff [mm]", 1e-3),
    # Drapes drawn from the fit against held-out captures.
    ("mean_image_mse", "held out: MSE of the mean image", 1),
    ("dc_error", "held out: error of the mean DC", 1),
    ("dc_crps", "held out: CRPS of DC", 1),
    ("dc_coverage_50", "held out: DC in 50 % intervals", 1),
    ("dc_width_50", "held out: their width", 1),
    ("dc_coverage_90", "held out: DC in 90 % intervals", 1),
    ("dc_width_90", "held out: their width", 1),
    ("folds_error", "held out: error of the mean folds", 1),
    ("folds_crps", "held out: CRPS of folds", 1),
    ("folds_coverage_50", "held out: folds in 50 % intervals", 1),
    ("folds_width_50", "held out: their width", 1),
    ("folds_coverage_90", "held out: folds in 90 % intervals", 1),
    ("folds_width_90", "held out: their width", 1),
    ("feature_energy", "held out: energy score of features", 1),
    ("outline_energy_m", "held out: energy score of outlines [mm]", 1e-3),
    ("hausdorff_m", "held out: outline Hausdorff of pairs [mm]", 1e-3),
    # The calibration of bending, and the same scores without it.
    ("bend_factor_up", "calibrated: factor on bend, face up", 1),
    ("bend_factor_down", "calibrated: factor on bend, face down", 1),
    ("mean_image_mse_as_fitted", "as fitted: MSE of the mean image", 1),
    ("dc_error_as_fitted", "as fitted: error of the mean DC", 1),
    ("dc_coverage_90_as_fitted", "as fitted: DC in 90 % intervals", 1),
    ("feature_energy_as_fitted", "as fitted: energy score of features", 1),
    # The cost.
    ("fit_seconds", "fit [s]", 1),
    ("calibration_seconds", "calibration [s]", 1),
    ("prediction_seconds", "prediction [s]", 1),
    ("rollouts", "rollouts of the fit", 1),
    ("parameters", "free numbers", 1),
    ("elbo", "evidence lower bound [nat]", 1),
]
BOUNDS = {"other samples": "drapes of the training samples themselves",
          "circle": "a circle of their mean area"}


def mean(values):
    return sum(value / len(values) for value in values)


def deviation(values):
    middle = mean(values)
    squares = sum((value - middle) ** 2 for value in values)
    return math.sqrt(squares / (len(values) - 1)) if len(values) > 1 else 0.0


def group_means(pairs):
    """The mean of the values of each key, in the order of the keys, if all its values are there."""
    groups = collections.defaultdict(list)
    for key, value in pairs:
        groups[key].append(value)
    return [mean(values) for _, values in sorted(groups.items()) if None not in values]


def make_row(runs, model):
    numbers = {}
    for key, _, _ in NUMBERS:
        values = group_means((run["seed"], run.get("numbers", {}).get(key)) for run in runs)
        if values:
            numbers[key] = {"mean": mean(values), "sd": deviation(values), "seeds": len(values)}
    failed = sum("failure" in run for run in runs)
    return {"model": model, "runs": len(runs), "failed": failed, "numbers": numbers}


def capture_scores(runs):
    """The mean score over the seeds for each held-out capture, in the order of the captures."""
    return group_means(((capture["fabric"], capture["sample"], capture["capture"]),
                        capture["feature_energy"]) for run in runs for capture in run["captures"])


def choose_simplest(models):
    """The simplest model within one standard error of the best [METHODS, P45].

    models: (name, scores of the same captures), the simplest first. The standard error is that of
    the mean paired difference from the best model.
    """
    choice = {"score": "feature_energy", "captures": 0, "best": "", "chosen": "", "models": []}
    if not models:
        return choice
    best, best_scores = min(models, key=lambda model: mean(model[1]))
    choice.update(captures=len(best_scores), best=best)
    for name, scores in models:
        assert len(scores) == len(best_scores), f"{name} has other captures than {best}"
        differences = [score - least for score, least in zip(scores, best_scores)]
        difference = mean(differences)
        error = deviation(differences) / math.sqrt(len(differences))
        within = difference <= error
        choice["models"].append({"model": name, "mean_score": mean(scores),
                                 "difference_from_best": difference, "standard_error": error,
                                 "within_one_standard_error": within})
        if within and not choice["chosen"]:
            choice["chosen"] = name
    return choice


def make_table(runs, fabric, models, others):
    own = {model: [run for run in runs if run["model"] == model] for model in models + others}
    rows = [make_row(own[model], model) for model in own if own[model] or model in models]
    candidates = [(row["model"], capture_scores(own[row["model"]])) for row in rows
                  if row["model"] in models and row["runs"] > row["failed"] == 0]
    return {"fabric": fabric, "rows": rows, "choice": choose_simplest(candidates)}


def make_tables(runs, models, others):
    """One table for each fabric, then one for all."""
    fabrics = sorted({run["fabric"] for run in runs})
    tables = [make_table([run for run in runs if run["fabric"] == fabric], str(fabric), models,
                         others) for fabric in fabrics]
    return tables + ([make_table(runs, "all", models, others)] if len(fabrics) > 1 else [])


def posterior_rows(runs, models):
    """The average stiffness and its deviation by the posterior, means over the seeds."""
    rows = []
    for fabric in sorted({run["fabric"] for run in runs}):
        for model in models:
            beliefs = [run["posterior"] for run in runs
                       if (run["fabric"], run["model"]) == (fabric, model) and "posterior" in run]
            if beliefs:
                rows.append({"fabric": fabric, "model": model,
                             **{key: [mean([belief[key][i] for belief in beliefs])
                                      for i in range(2)]
                                for key in ("stretch_n_per_m", "bend_n_m")}})
    return rows


def csv_rows(tables):
    return [[table["fabric"], row["model"], key, f"{value['mean']:.9g}", f"{value['sd']:.9g}",
             value["seeds"], row["runs"], row["failed"]]
            for table in tables for row in table["rows"] for key, value in row["numbers"].items()]


def entry(row, key, unit):
    value = row["numbers"].get(key)
    if value is None:
        return "–"
    text = f"{value['mean'] / unit:.4g}"
    return text if value["seeds"] < 2 else f"{text} ± {value['sd'] / unit:.2g}"


def choice_text(choice):
    if not choice["chosen"]:
        return "No model has a score in all of its runs.\n"
    parts = []
    for model in choice["models"]:
        part = f" {model['model']} {model['mean_score']:.3f}"
        if model["model"] != choice["best"]:
            part += (f" (+{model['difference_from_best']:.3f}, standard error "
                     f"{model['standard_error']:.3f})")
        parts.append(part)
    return (f"**{choice['chosen']}** is the simplest model within one standard error of the best, "
            f"{choice['best']} (energy score of features, {choice['captures']} captures held out):"
            + ";".join(parts) + ".\n")


def title_of(table):
    return "All fabrics" if table["fabric"] == "all" else f"Fabric {table['fabric']}"


def table_text(table):
    heads = [row["model"] + (f" ({row['failed']} of {row['runs']} failed)" if row["failed"] else "")
             for row in table["rows"]]
    lines = [[label] + [entry(row, key, unit) for row in table["rows"]]
             for key, label, unit in NUMBERS]
    return (f"\n## {title_of(table)}\n\n" + study.markdown([""] + heads, lines) + "\n"
            + choice_text(table["choice"]))


def text(comparison, meanings):
    shown = [row["model"] for row in comparison["tables"][0]["rows"]]
    models = ", ".join(f"{model['name']} ({model['meaning']})" for model in meanings
                       if model["name"] in shown)
    result = ("# Comparison of models\n\n"
              "Mean ± standard deviation over the seeds. A seed draws the split and the drapes. For "
              "all fabrics, the numbers of a seed are means over the fabrics.\n"
              f"Models, the simplest first: {models}.\n"
              "The standard error is that of the mean difference from the best model over held-out "
              "captures, taken as independent. Captures of one sample repeat each other, so the "
              "error is a lower bound. A capture that several seeds hold out counts once. Only "
              "models with a score in every run are judged.\n")
    for table in comparison["tables"]:
        result += table_text(table)
    if comparison["posteriors"]:
        rows = [[str(row["fabric"]), row["model"], f"{row['stretch_n_per_m'][0]:.4g}",
                 f"{row['stretch_n_per_m'][1]:.2g}", f"{row['bend_n_m'][0]:.3g}",
                 f"{row['bend_n_m'][1]:.2g}"] for row in comparison["posteriors"]]
        result += "\n## Stiffness by the posteriors\n\n" + study.markdown(
            ["fabric", "model", "stretching [N/m]", "sd", "bending [N m]", "sd"], rows)
    for failure in comparison["failures"]:
        result += f"\nWithout a score: {failure}\n"
    return result


def points_of(table):
    """The models of a chart, with their mean numbers; `compared` as all their runs have a score."""
    errors = {model["model"]: model["standard_error"] for model in table["choice"]["models"]}
    points = []
    for row in table["rows"]:
        number = {key: value["mean"] for key, value in row["numbers"].items()}
        if "rollouts" in number and "feature_energy" in number:
            points.append({"model": row["model"], "error": errors.get(row["model"], 0.0),
                           "compared": row["model"] in errors,
                           "chosen": row["model"] == table["choice"]["chosen"], **number})
    return points


def bounds_of(table):
    """Energy scores of the predictors without a model, by name."""
    return {row["model"]: row["numbers"]["feature_energy"]["mean"] for row in table["rows"]
            if row["model"] in BOUNDS and "feature_energy" in row["numbers"]}


def draw_models(plot, table):
    """A line for each model: its held-out error, its error on its own images, its rollouts."""
    points = [point for point in points_of(table) if "train_mse" in point]
    if not points:
        return None
    figure, panels = plot.subplots(1, 3, sharey=True, figsize=(11, 5.2))
    most = max(point["feature_energy"] + point["error"] for point in points)
    for panel, key in zip(panels, ("feature_energy", "train_mse", "rollouts")):
        for height, point in enumerate(points):
            colour = "#d62728" if point["chosen"] else "#21918c"
            face = colour if point["compared"] else "none"
            error = point["error"] if key == "feature_energy" else None
            panel.errorbar(point[key], height, xerr=error, fmt="o", color=colour, mfc=face,
                           capsize=3)
    for name, energy in bounds_of(table).items():
        if energy <= 2 * most:
            panels[0].axvline(energy, color="#555555", ls="--", lw=1, label=name)
    if not all(point["compared"] for point in points):
        panels[0].plot([], [], "o", color="#21918c", mfc="none",
                       label="a run has no score: not compared")
    if panels[0].get_legend_handles_labels()[0]:
        panels[0].legend(loc="upper left", bbox_to_anchor=(-0.3, -0.12), frameon=False)
    panels[0].set(title="held-out drapes", xlabel="energy score of the features")
    panels[0].set_yticks(range(len(points)), [point["model"] for point in points])
    panels[0].invert_yaxis()
    panels[1].set(title="own silhouettes", xlabel="mean squared error of the image")
    panels[1].tick_params(axis="x", rotation=-45)
    panels[2].set(title="cost of the fit", xlabel="rollouts")
    study.scale(panels[2].xaxis, [point["rollouts"] for point in points])
    figure.suptitle(f"{title_of(table)}: the simplest model within one standard error of the best is red")
    return figure


def draw_held_out(plot, table):
    """Held-out error against the free numbers and against the time of the fit."""
    points = points_of(table)
    if not points:
        return None
    figure, panels = plot.subplots(1, 2, figsize=(11, 4.6))
    for panel, (key, label) in zip(panels, [("parameters", "free numbers of the model"),
                                            ("fit_seconds", "time of the fit [s]")]):
        panel.set(xlabel=label, ylabel="energy score of held-out drapes, lower is better")
        shown = [point for point in points if point.get(key, 0) > 0]
        if not shown:
            continue
        bounds = bounds_of(table)
        study.scale(panel.xaxis, [point[key] for point in shown])
        study.scale(panel.yaxis, [point["feature_energy"] for point in shown] + [*bounds.values()])
        panel.margins(x=0.25, y=0.12)
        for name, energy in bounds.items():
            panel.axhline(energy, color="#555555", ls="--")
            panel.annotate(BOUNDS[name], (0.02, energy), (0, 4), fontsize=9,
                           xycoords=("axes fraction", "data"), textcoords="offset points")
        places = [(point[key], point["feature_energy"]) for point in shown]
        panel.plot(*zip(*places), "o", color="#0072b2")
        study.name_points(panel, places, [point["model"] for point in shown])
    figure.suptitle("How well models predict drapes of other samples")
    return figure


def tabulate(study_folder):
    comparison = study_folder.json
    runs, meanings = comparison["runs"], comparison["models"]
    models = [model["name"] for model in meanings]
    comparison["tables"] = make_tables(runs, models, ["other samples", "normal", "circle"])
    comparison["posteriors"] = posterior_rows(runs, models)
    comparison["failures"] = [
        f"fabric {run['fabric']}, {run['model']}, seed {run['seed']}: {run['failure']}"
        for run in runs if "failure" in run]
    study_folder.write("comparison.json", json.dumps(comparison, indent=1) + "\n")
    study_folder.write_csv(
        "comparison.csv", ["fabric", "model", "number", "mean", "sd", "seeds", "runs", "failed"],
        csv_rows(comparison["tables"]))
    study_folder.write("comparison.md", text(comparison, meanings))
    print(text(comparison, meanings), end="")
    if study.pyplot is None:
        return
    for table in comparison["tables"]:
        fabric = "" if table["fabric"] == "all" else "_fabric_" + table["fabric"]
        for name, draw in (("models", draw_models), ("held_out", draw_held_out)):
            figure = draw(study.pyplot, table)
            if figure is not None:
                study_folder.save(figure, name + fabric)


if __name__ == "__main__":
    study.main(tabulate, "comparison")
