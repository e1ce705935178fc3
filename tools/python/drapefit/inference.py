# SPDX-License-Identifier: Apache-2.0
"""The posterior of a fit for statisticians."""

import csv
import json
import pathlib

import numpy as np

LINEAR_UNITS = {"c11": "N/m", "c22": "N/m", "c12": "N/m", "shear": "N/m",
                "bend_weft": "N m", "bend_warp": "N m", "bend_bias": "N m", "bend_stiffer": "N m",
                "bend_softer": "N m"}


def read_draws(path):
    """The columns of a draws.csv of drape_export, each [chain, draw]."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    if len(rows) < 2 or rows[0][:1] != [".chain"]:
        raise ValueError(f"{path}: expected the table that drape_export --to=csv writes")
    columns = {name: np.array(values, float) for name, values in zip(rows[0], zip(*rows[1:]))}
    chains = int(columns[".chain"].max())
    return {name: values.reshape(chains, -1) for name, values in columns.items()}


def inference_data(fit, draws, prediction=None, seed=1):
    """The groups of ArviZ's InferenceData as a dictionary of xarray Datasets.

    fit: a folder of drape_fit --model=bayes; draws: the draws.csv that drape_export --to=csv makes of
    it; prediction: a folder of drape_predict; seed: of prior and posterior_predictive. All are
    independent samples, of which R-hat and effective sample sizes say nothing.

        groups = drapefit.inference_data("out/bayes", "out/export/draws.csv")
        data = arviz.InferenceData(**groups)
        for name, group in groups.items():
            group.to_netcdf("posterior.nc", group=name, mode="a")
    """
    import xarray

    def read(folder, name):
        path = pathlib.Path(folder) / name
        return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}

    def array(dims, values, units, long_name=""):
        return dims, values, {"units": units, "long_name": long_name}

    random = np.random.default_rng(seed)
    columns, stored, summary = read_draws(draws), read(fit, "posterior.json"), read(fit, "summary.json")
    sampled = ("chain", "draw")
    shape = columns[".chain"].shape
    coords = {"chain": np.arange(shape[0]), "draw": np.arange(shape[1])}
    names = stored["names"]
    factors = np.stack([columns[f"log_factor[{name}]"] for name in names], axis=2)
    covariance = np.diag(np.square(stored["prior_sd"]))
    if "fabric_prior" in stored:
        size = len(stored["fabric_prior"])
        covariance[:size, :size] = stored["fabric_prior"]
    about = "log factor on the start tables"
    posterior = {"log_factor": array((*sampled, "parameter"), factors, "1", about)} | {
        name: array(sampled, columns[name], units, "at zero strain")
        for name, units in LINEAR_UNITS.items() if name in columns}
    prior = {"log_factor": array((*sampled, "parameter"), random.multivariate_normal(
        np.zeros(len(names)), covariance, shape), "1", about)}
    constant = {"prior_sd": array("parameter", stored["prior_sd"], "1"),
                "posterior_mean": array("parameter", stored["mean"], "1"),
                "posterior_covariance": array(("parameter", "parameter_bis"), stored["covariance"], "1")}
    images = summary.get("images", [])
    coords |= {"parameter": names, "parameter_bis": names, "image": [image["name"] for image in images]}
    observed = {name: array("image", [image["metrics"][key] for image in images], "1")
                for name, key in (("drape_coefficient", "dc_image"), ("nodes", "folds_image"))
                if images}
    groups = {"posterior": posterior, "prior": prior, "constant_data": constant,
              "observed_data": observed}
    if "lp__" in columns:
        add_outlines(groups, columns, read(fit, "samples.json"), coords, array, random)
    if prediction is not None:
        drapes = [drape for drape in read(prediction, "summary.json")["drapes"] if "dc" in drape]
        groups["predictions"] = {name: array(sampled, [[drape[key] for drape in drapes]], "1")
                                 for name, key in (("drape_coefficient", "dc"), ("nodes", "folds"))}
    data = {}
    for name, variables in groups.items():
        used = {dim for dims, *_ in variables.values() for dim in ([dims] if isinstance(dims, str) else dims)}
        own = {dim: values for dim, values in coords.items() if dim in used}
        if name == "predictions":
            own = {"chain": [0], "draw": np.arange(len(drapes))}
        data[name] = xarray.Dataset(variables, own, {"inference_library": "drapefit",
                                                     "creation_library": "drapefit"})
        if "angle" in own:
            data[name]["angle"].attrs["units"] = "degree"
    return data


def add_outlines(groups, columns, samples, coords, array, random):
    """Adds the outlines of the fit's own samples and the likelihood of its images."""
    shape = columns["lp__"].shape
    dims = ("chain", "draw", "image", "angle")
    radius = np.array([image["radius_m"] for image in samples["images"]])
    sigma = np.array([image["sigma_m"] for image in samples["images"]])
    coords |= {"image": [image["name"] for image in samples["images"]],
               "angle": 360 * np.arange(radius.shape[1]) / radius.shape[1]}
    drawn = np.array([sample["radius_m"] for sample in samples["samples"][:shape[0] * shape[1]]])
    drawn = drawn.reshape(*shape, *radius.shape)
    likelihood = np.stack([columns[f"log_lik[{i + 1}]"] for i in range(radius.size)], axis=2)
    groups["posterior"]["drape_outline"] = array(dims, drawn, "m", "radius of the drape's outline")
    groups["constant_data"]["sigma"] = array("image", sigma, "m", "standard deviation of a radius")
    groups["observed_data"]["outline"] = array(("image", "angle"), radius, "m")
    groups["log_likelihood"] = {"outline": array(dims, likelihood.reshape(drawn.shape), "1",
                                                 "ln of the density of the observed radius [1/m]")}
    groups["posterior_predictive"] = {"outline": array(
        dims, drawn + sigma[:, None] * random.standard_normal(drawn.shape), "m",
        "radius of an outline as it is seen")}
    groups["sample_stats"] = {
        "lp": array(dims[:2], columns["lp__"], "1", "ln of likelihood times prior"),
        "lp_approx": array(dims[:2], columns["lp_approx__"], "1", "ln of the density sampled from")}
