# SPDX-License-Identifier: Apache-2.0
"""Differentiates the mean height of a drape by all 39 entries of its fabric, and checks one of the
derivatives by a difference.
usage: 02_gradient.py <fabric.json>"""
import sys

import numpy as np

import drapefit

fabric = drapefit.read_material(sys.argv[1])
simulator = drapefit.Simulator(drapefit.disc(200), threads=1)
start = simulator.random_start(seed=1)
# Three drapes: of the fabric, and of two whose first bend entry is a little larger and smaller. The
# 39 numbers are logarithms of factors on 24 entries of stretch, then 15 of bend.
entry, step = 24, 1e-4
log_factors = np.zeros((3, 39))
log_factors[1, entry], log_factors[2, entry] = step, -step
# record: keep what the adjoint needs, so that nothing is simulated again.
drapes = simulator.drape(fabric, log_factors, start, h=0.05, steps=20, record=True)
# The mean height of the vertices [m], and its gradient by their positions: 1/V for each z.
height = drapes.positions[:, :, 2].mean(axis=1)
by_positions = np.zeros(drapes.positions.shape)
by_positions[:, :, 2] = 1.0 / len(start)
# One adjoint gives the gradient by all entries, and by the start as well.
gradient = drapes.vjp(by_positions, of="positions")
exact = gradient.log_factors[0, entry]
difference = (height[1] - height[2]) / (2.0 * step)
print(f"height {height[0]:.5f} m, by the logarithm of a bend entry: adjoint {exact:.6g}, "
      f"difference {difference:.6g} m")
sys.exit(int(abs(exact - difference) > 1e-4 * abs(exact)))
