# SPDX-License-Identifier: Apache-2.0
"""Fits the bending stiffness of a fabric to the silhouette of one drape.
usage: fit_silhouette.py <image> <material of the density of the fabric> <fitted material>"""
import sys

import numpy as np
from scipy.optimize import least_squares

import drapefit

image, table = drapefit.read_silhouette(sys.argv[1]), drapefit.read_material(sys.argv[2])
outline = image.outline()
simulator = drapefit.Simulator(drapefit.disc(400))
start = simulator.start_from_outline(outline / image.camera.pixels_per_metre)
seen = {"of": "outline", "camera": image.camera}


def drape(log_factor):
    return simulator.drape(table, log_factor, start, h=0.1, steps=100, solve="hybrid")


fit = least_squares(lambda q: drape(q).read(**seen)[0] - outline, [0.0], bounds=(-3, 3),
                    jac=lambda q: drape(q).jvp([1.0], **seen).T, xtol=1e-3)
bend = table.bend * np.exp(fit.x[0])
drapefit.make_material(table.density, table.stretch, bend, "fit").write(sys.argv[3])
rms = np.sqrt(2 * fit.cost / outline.size)
print(f"factor on bend {np.exp(fit.x[0]):.3f}, outline to {rms:.2f} px rms in {fit.nfev} drapes")
