# SPDX-License-Identifier: Apache-2.0
"""Dresses a mannequin in a garment of a fabric and draws it.
usage: 06_garment.py <pattern.json> <fabric.json> <picture.png>"""
import sys

from matplotlib.figure import Figure

import drapefit

# A pattern: panels and the seams that join them. A body: a mannequin that can stand, walk, turn or
# jump. The panels become triangles with edges of 4 cm. 5 frames of 0.04 s.
worn = drapefit.wear(sys.argv[1], drapefit.read_material(sys.argv[2]), body="mannequin:stand",
                     edge=0.04, frames=5, threads=1)
# Positions of all frames, of the garment and of the body: [frames, V, 3].
print(f"{worn.garment.shape[1]} vertices, {worn.time[-1]:.2f} s, hem at "
      f"{worn.garment[-1, :, 2].min():.2f} m, at least {1e3 * worn.smallest_gap:.1f} mm from the body")
# A picture of body and garment, half from the left.
figure = Figure()
axes = figure.add_subplot(projection="3d", elev=10, azim=-60)
for positions, faces, colour in ((worn.body[-1], worn.body_faces, "tan"),
                                 (worn.garment[-1], worn.garment_faces, "steelblue")):
    axes.plot_trisurf(*positions.T, triangles=faces, color=colour)
axes.set_aspect("equal")
axes.set_axis_off()
figure.savefig(sys.argv[3], bbox_inches="tight")
sys.exit(int(worn.intersections > 0))
