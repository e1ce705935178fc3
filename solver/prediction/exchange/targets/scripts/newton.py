# SPDX-License-Identifier: Apache-2.0
"""A fabric for Newton's SolverVBD and SolverSemiImplicit.

Exported by drapefit. Units: kg/m2, N/m, N m.
bend_weft is the rigidity for bending along the weft, of hinges with edges along the warp.
"""
import math

FABRIC = {}


def cloth_arguments(solver="vbd"):
    """Arguments of ModelBuilder.add_cloth_mesh; solver: "vbd" or "semi_implicit".

    The two solvers give tri_ka another meaning. Bending: see apply().
    """
    mu, lame = FABRIC["mu"], FABRIC["lambda"]
    tri_ka = {"vbd": lame, "semi_implicit": lame + mu}[solver]
    return {"density": FABRIC["density"], "tri_ke": mu, "tri_ka": tri_ka, "edge_ke": 0.0}


def rigidity(du, dv):
    """Rigidity [N m] of a hinge whose edge has this direction along (weft, warp)."""
    row = 4.0 / math.pi * abs(math.atan2(dv, du))
    row = min(row, 4.0 - row)
    rows = (FABRIC["bend_warp"], FABRIC["bend_bias"], FABRIC["bend_weft"])
    first = 0 if row < 1.0 else 1
    return rows[first] + (row - first) * (rows[first + 1] - rows[first])


def edge_ke(points, edges, uv=None):
    """Stiffness [N] of each edge (opposite 0, opposite 1, end 0, end 1) of a cloth at rest.

    uv: coordinates (weft, warp) of each point; without them the mean of all directions.
    """
    mean = (FABRIC["bend_weft"] + 2.0 * FABRIC["bend_bias"] + FABRIC["bend_warp"]) / 4.0
    values = []
    for o0, o1, i, j in edges:
        if o0 < 0 or o1 < 0:  # the hem
            values.append(0.0)
            continue
        edge = [b - a for a, b in zip(points[i], points[j])]
        length2 = sum(e * e for e in edge)
        heights = 0.0
        for o in (o0, o1):
            arm = [b - a for a, b in zip(points[i], points[o])]
            along = sum(a * e for a, e in zip(arm, edge))
            heights += math.sqrt(sum(a * a for a in arm) - along * along / length2)
        bend = mean if uv is None else rigidity(uv[j][0] - uv[i][0], uv[j][1] - uv[i][1])
        values.append(2.0 * bend / heights)
    return values


def apply(model, uv=None):
    """Sets the bending of a finalized model whose particles are one cloth at rest."""
    properties = model.edge_bending_properties.numpy()
    edges = model.edge_indices.numpy().reshape(-1, 4)
    properties[:, 0] = edge_ke(model.particle_q.numpy(), edges, uv)
    model.edge_bending_properties.assign(properties)
