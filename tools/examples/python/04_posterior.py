# SPDX-License-Identifier: Apache-2.0
"""Samples fabrics from the posterior of one silhouette, says which quantities the silhouette has
measured and which are from the prior, and drapes some of the samples.
usage: 04_posterior.py <silhouette.png> <start.json>"""
import sys

import numpy as np

import drapefit

# Model bayes: the fit of one table, then the distribution of its free numbers. Here these are two:
# a factor on stretching and a factor on bending.
fit = drapefit.fit(sys.argv[1], drapefit.read_material(sys.argv[2]), model="bayes",
                   num_parameters=2, mesh="disc:300", simpler_models=False, threads=1)
posterior = drapefit.sample_posterior(fit, count=200, seed=1)
# A k-hat below 0.7 says that the samples are reliable.
print(f"k-hat {posterior.pareto_k:.2f}")
# Each quantity has a value for each sample. "from the prior": the silhouette does not tell.
for quantity in posterior.quantities.values():
    low, median, high = np.quantile(quantity.samples, [0.05, 0.5, 0.95])
    print(f"{quantity.name:28} {median:9.3g} ({low:.3g} to {high:.3g}) {quantity.unit}, "
          f"{quantity.source}")
# How further drapes of the fabric may look: one drape of each of eight samples.
simulator = drapefit.Simulator(fit.mesh, threads=1)
starts = [simulator.random_start(seed) for seed in range(8)]
drapes = simulator.drape(posterior.fabrics[:8], start=starts, h=0.05, steps=60)
coefficients = drapes.read("features")[:, 0]
print(f"drape coefficients of further drapes: {coefficients.min():.3f} to {coefficients.max():.3f}")
sys.exit(int(not posterior.quantities["bending_in_drape_un_m"].measured))
