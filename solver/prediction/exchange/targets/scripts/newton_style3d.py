# SPDX-License-Identifier: Apache-2.0
"""A fabric for Newton's SolverStyle3D.

Exported by drapefit. Units: kg/m2, N/m, N m.
bend_weft is the rigidity for bending along the weft, of hinges with edges along the warp.
"""
FABRIC = {}


def cloth_arguments():
    """Arguments of newton.solvers.style3d.add_cloth_mesh beside the mesh and its panels.

    panel_verts are the coordinates (weft, warp) in metres, as the vt of drapefit's OBJ files.
    The energy of a hinge there is 3/2 k l^2 / (A0 + A1) theta^2, so k is a third of the rigidity.
    """
    import warp as wp

    return {
        "density": FABRIC["density"],
        "tri_aniso_ke": wp.vec3(*tri_aniso_ke()),
        "edge_aniso_ke": wp.vec3(*edge_aniso_ke()),
    }


def tri_aniso_ke():
    """Along weft, along warp, shear [N/m]."""
    return FABRIC["c11"], FABRIC["c22"], FABRIC["shear"]


def edge_aniso_ke():
    """For bending along weft, warp and bias [N m]."""
    return FABRIC["bend_weft"] / 3.0, FABRIC["bend_warp"] / 3.0, FABRIC["bend_bias"] / 3.0
