# SPDX-License-Identifier: Apache-2.0
"""Fits a fabric to one silhouette, prints what the fit can tell, and writes the fitted fabric.
usage: 03_fit.py <silhouette.png> <start.json> <fitted.json>"""
import sys

import drapefit

# What to fit: a silhouette, and the tables from which the fit starts. How: by the options of
# drape_fit, with its defaults; here fewer vertices and models, for speed. Of the fabric's weight
# nothing is known here; density=0.15 would say it [kg/m2].
fit = drapefit.fit(sys.argv[1], drapefit.read_material(sys.argv[2]), mesh="disc:300",
                   simpler_models=False, threads=1)
if not fit.fitted:
    sys.exit("no drape could be fitted")
# Whether to trust it, and why not.
print(f"verdict: {fit.grade}", *fit.reasons, sep="\n  ")
# The fabric as laboratories report it, with 90 % intervals: what the drape has measured.
for row in fit.sheet:
    if row.source.startswith("measured") and row.interval:
        low, high = row.interval
        print(f"{row.name}: {row.value:.3g} {row.unit} ({low:.3g} to {high:.3g}), {row.source}")
fit.material.write(sys.argv[3])
