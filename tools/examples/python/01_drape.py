# SPDX-License-Identifier: Apache-2.0
"""Drapes a fabric, measures its outline as a laboratory does, and draws what a camera above sees.
usage: 01_drape.py <fabric.json> <picture.png>"""
import sys

import matplotlib.image

import drapefit

# A fabric: tables of stretching and bending stiffness, and a density.
fabric = drapefit.read_material(sys.argv[1])
# A scene: a disc of 30 cm of 400 vertices on a support of 18 cm, and what simulates it.
simulator = drapefit.Simulator(drapefit.disc(400), threads=1)
# A start: the flat cloth with small random waves, which select one of the many stable drapes.
start = simulator.random_start(seed=1)
# A batch of one drape: 40 steps of 0.1 s, then Newton's method to rest.
drapes = simulator.drape(fabric, start=start, h=0.1, steps=40, solve="hybrid")
if not drapes.found[0]:
    sys.exit(f"no drape: {drapes.status[0]}")
# Features of the outline, in the order of drapefit.FEATURES.
features = dict(zip(drapefit.FEATURES, drapes.read("features")[0]))
print(f"{fabric.name}: drape coefficient {features['dc']:.3f}, {features['folds']:.0f} folds")
# The silhouette: the share of each pixel that cloth covers, black where it is 1.
matplotlib.image.imsave(sys.argv[2], 1.0 - drapes.read("silhouette")[0], cmap="gray")
