# SPDX-License-Identifier: Apache-2.0
"""Pictures of drape_space: reads space.json and draws heat_map, map and textile_map."""

import numpy as np

import study

BLUE, RED, GREY, GREEN = "#0072b2", "#d55e00", "#b0b0b0", "#009e73"
# Bending length [m] and drape coefficient of an isotropic linear cloth on the support of BS 5058,
# means of 12 drapes by drape_equilibria [METHODS, P62]; linear to zero below the first.
ISOTROPIC = np.array([
    (0.0, 0.0), (0.0080, 0.267), (0.0100, 0.319), (0.0125, 0.398), (0.0150, 0.481), (0.0175, 0.566),
    (0.0200, 0.652), (0.0225, 0.725), (0.0250, 0.780), (0.0275, 0.816), (0.0300, 0.855),
    (0.0350, 0.912), (0.0400, 0.949), (0.0450, 0.971), (0.0500, 0.981), (0.0600, 0.987)]).T


def average_linkage(distances):
    """A tree by average linkage [Sokal 1958]: (left, right, height) for each merge.

    Cluster i < n is point i, cluster n + k is merge k. The two clusters with the least mean distance
    of their points are merged, n - 1 times.
    """
    leaves = {i: [i] for i in range(len(distances))}
    tree = []
    while len(leaves) > 1:
        clusters = list(leaves)
        height, left, right = min(
            (distances[np.ix_(leaves[a], leaves[b])].mean(), a, b)
            for i, a in enumerate(clusters) for b in clusters[i + 1:])
        leaves[len(distances) + len(tree)] = leaves.pop(left) + leaves.pop(right)
        tree.append((left, right, height))
    return tree, next(iter(leaves.values()))


def scale_to_plane(distances):
    """Classical multidimensional scaling [Torgerson 1952]: points [n, 2] about their mean.

    The coordinate of largest magnitude is positive in each column.
    """
    count = len(distances)
    centring = np.eye(count) - 1.0 / count
    values, axes = np.linalg.eigh(-0.5 * centring @ distances**2 @ centring)
    plane = np.zeros((count, 2))
    for k in range(min(2, count)):
        axis = axes[:, -1 - k]
        sign = np.sign(axis[np.argmax(np.abs(axis))]) or 1.0
        plane[:, k] = sign * np.sqrt(max(0.0, values[-1 - k])) * axis
    return plane


def map_of(fabrics, distances):
    """The points of the map, the linear map of least squares to it, and its centre."""
    points = scale_to_plane(distances)
    means = np.array([fabric["determined"]["mean"] for fabric in fabrics])
    centre = means.mean(axis=0)
    return points, np.linalg.lstsq(means - centre, points, rcond=None)[0].T, centre


def ellipse(centre, covariance):
    """One standard deviation about a point, as a closed curve [73, 2]."""
    values, axes = np.linalg.eigh(np.asarray(covariance))
    angles = np.linspace(0.0, 2 * np.pi, 73)
    circle = np.stack([np.cos(angles), np.sin(angles)])
    return np.asarray(centre) + (axes * np.sqrt(np.maximum(values, 0.0)) @ circle).T


def draw_heat_map(plot, space):
    """Hellinger metric of all pairs in the order of the tree; white without a common direction."""
    names = [fabric["name"] for fabric in space["fabrics"]]
    tree, order = average_linkage(np.array(space["wasserstein"]))
    figure, (left, right) = plot.subplots(1, 2, figsize=(11, 7.2), width_ratios=[1, 3])
    places = {fabric: (0.0, height) for height, fabric in enumerate(order)}
    for k, (a, b, height) in enumerate(tree):
        (xa, ya), (xb, yb) = places[a], places[b]
        left.plot([xa, height, height, xb], [ya, ya, yb, yb], color="black", lw=1.5)
        places[len(names) + k] = (height, 0.5 * (ya + yb))
    left.set(xlabel="W2 of the branches [log units]", yticks=[])
    left.invert_xaxis()
    left.set_ylim(len(names) - 0.5, -0.5)
    known = np.array([[np.nan if value is None else value for value in row]
                      for row in space["hellinger"]])[np.ix_(order, order)]
    image = right.imshow(known, vmin=0.0, vmax=1.0, aspect="auto")
    right.set_xticks(range(len(names)), [names[i] for i in order], rotation=60, ha="right",
                     parse_math=False)
    right.set_yticks(range(len(names)), [names[i] for i in order], parse_math=False)
    right.grid(False)
    figure.colorbar(image, label="Hellinger metric of specimens")
    return figure


def draw_map(plot, space):
    """The plane of least distortion of the Wasserstein metric, with ellipses of one deviation."""
    fabrics, added = space["fabrics"], space.get("new", [])
    points, linear, centre = map_of(fabrics, np.array(space["wasserstein"]))
    figure, axes = plot.subplots(figsize=(9, 7.6))
    for point, fabric in zip(points, fabrics):
        covariance = linear @ np.array(fabric["determined"]["covariance"]) @ linear.T
        axes.plot(*ellipse(point, covariance).T, color=GREY, lw=1)
    axes.plot(*points.T, "o", color=BLUE)
    new = [linear @ (np.array(each["determined"]) - centre) for each in added]
    for point in new:
        axes.plot(*point, "D", color=RED)
    axes.set(xlabel="first axis [log units]", ylabel="second axis [log units]")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.2)
    study.name_points(axes, [*points, *new], [each["name"] for each in [*fabrics, *added]])
    return figure


def draw_textile_map(plot, space):
    """Bending lengths along weft and warp; dashed: equal drape coefficient of isotropic cloth."""
    lengths = space["log_bending_lengths"]
    figure, axes = plot.subplots(figsize=(9, 8.6))
    centres = [100 * np.exp(each["mean"]) for each in lengths]
    curves = [100 * np.exp(ellipse(each["mean"], each["covariance"])) for each in lengths]
    least, most = 0.9 * np.min(curves), 1.1 * np.max(curves)
    for each, centre, curve in zip(lengths, centres, curves):
        axes.plot(*curve.T, color=GREY, lw=1)
        axes.plot(*centre, "D" if each["new"] else "o", color=RED if each["new"] else BLUE)
    weft = np.geomspace(least, most, 80)
    for coefficient in np.arange(1, 10) / 10:
        warp = (100 * np.interp(coefficient, *ISOTROPIC[::-1])) ** 2 / weft
        shown = (warp >= least) & (warp <= most)
        if shown.any():
            axes.plot(weft[shown], warp[shown], "--", color=GREEN, lw=0.8)
            axes.annotate(f"DC {coefficient:.1f}", (weft[shown][0], warp[shown][0]), (3, -6),
                          textcoords="offset points", fontsize=8)
    axes.set(xlabel="bending length along the weft [cm]",
             ylabel="bending length along the warp [cm]", xlim=(least, most), ylim=(least, most))
    axes.set_aspect("equal")
    study.name_points(axes, centres, [each["name"] for each in lengths])
    return figure


def draw(folder):
    if study.pyplot is None:
        return
    for name, picture in (("heat_map", draw_heat_map), ("map", draw_map),
                          ("textile_map", draw_textile_map)):
        folder.save(picture(study.pyplot, folder.json), name)


if __name__ == "__main__":
    study.main(draw, "space")
