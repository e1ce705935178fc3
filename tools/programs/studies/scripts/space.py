# SPDX-License-Identifier: Apache-2.0
"""Pictures and tables of drape_space.

Reads space.json and draws heat_map, map and textile_map. With --recognise it reads recognition.json
and writes recognition.md instead.
"""

import itertools
import pathlib
import sys

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


# Recognition

EXPONENTS = [0.0, 0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0]
BINS = 5  # of reliability
POSTERIOR, FEATURES, PREDICTIONS = "posterior (A)", "image features", "predicted drapes (B)"
DENSITY = "density alone, weighed to 3 %"
WEIGHING = 0.03  # standard deviation of ln density
# Rows of the table: name, factors of a product (keys of by_way) or the key itself.
ROWS = [
    (POSTERIOR, "posterior"),
    (FEATURES, "features"),
    (PREDICTIONS, ["predictions"]),
    ("A and features", ["posterior", "features"]),
    ("A and B", ["posterior", "predictions"]),
    ("B and features", ["predictions", "features"]),
    ("A, B and features", ["posterior", "predictions", "features"]),
    (DENSITY, "density"),
]


class SampleModel:
    """Samples of fabrics as normal distributions at three levels [METHODS, P62]: fabrics of a
    population, samples of a fabric with one covariance `within` for all fabrics, and what is seen
    of a sample. Without the covariance of what is seen, this is linear discriminant analysis with
    shrunk means. Expectation maximisation [Bishop 2006, chapter 9]; covariances are shrunk as if by
    one more observation of equal scatter in each direction of `scale`."""

    ITERATIONS = 60

    def __init__(self, mean, covariance, fabric, count, scale):
        shrink = self.within = np.diag(scale ** 2)
        population = mean.mean(axis=0), 10.0 * shrink
        for iteration in range(self.ITERATIONS + 1):
            seen = np.linalg.inv(self.within + covariance)
            precision = np.repeat(np.linalg.inv(population[1])[None], count, axis=0)
            pull = precision @ population[0]
            np.add.at(precision, fabric, seen)
            np.add.at(pull, fabric, np.einsum("sij,sj->si", seen, mean))
            self.covariance = np.linalg.inv(precision)
            self.mean = np.einsum("fij,fj->fi", self.covariance, pull)
            if iteration == self.ITERATIONS:
                return
            gain, off = self.within @ seen, mean - self.mean[fabric]
            scatter = np.einsum("si,sj->sij", off, off) + self.covariance[fabric]
            within = shrink + (gain @ scatter @ gain.swapaxes(1, 2) + self.within
                               - gain @ self.within).sum(axis=0)
            self.within = 0.5 * (within + within.T) / (len(mean) + 1)
            off = self.mean - self.mean.mean(axis=0)
            population = self.mean.mean(axis=0), (
                shrink + self.covariance.sum(axis=0) + off.T @ off) / (count + 1)

    def log_likelihoods(self, mean, covariance):
        """ln p(seen | fabric) of one sample under each fabric, up to a constant."""
        total = self.covariance + self.within + covariance
        off = mean - self.mean
        return -0.5 * (np.linalg.slogdet(total)[1]
                       + np.einsum("fi,fi->f", off, np.linalg.solve(total, off[..., None])[..., 0]))


def compare_with_others(seen, fabric, count, scale):
    """ln p of each sample under the model of all others [samples, fabrics]."""
    mean, covariance = (np.array([each[key] for each in seen]) for key in ("mean", "covariance"))
    logs = []
    for i in range(len(fabric)):
        others = np.arange(len(fabric)) != i
        model = SampleModel(mean[others], covariance[others], fabric[others], count, scale)
        logs.append(model.log_likelihoods(mean[i], covariance[i]))
    return np.array(logs)


def compare_densities(density, fabric, count):
    """As if each sample were weighed; a fabric has one density."""
    of_fabric = np.empty(count)
    of_fabric[fabric] = density
    return -0.5 * (np.log(of_fabric / of_fabric[fabric][:, None]) / WEIGHING) ** 2


def compare(recognition):
    """Log probabilities [samples, fabrics] by way, and the fabric of each sample."""
    samples, scales = recognition["samples"], recognition.get("scales", {})
    fabric, count = np.array([each["fabric"] for each in samples]), len(recognition["fabrics"])
    by_way = {way: compare_with_others([each["seen"][way] for each in samples], fabric, count,
                                       np.array(scale)) for way, scale in scales.items()}
    if "density" in samples[0]:
        by_way["density"] = compare_densities([each["density"] for each in samples], fabric, count)
    if "predictions" in samples[0]:
        by_way["predictions"] = np.array([each["predictions"] for each in samples])
    return by_way, fabric


def normalised(logs):
    """Log probabilities whose sum of probabilities is 1, along the last axis."""
    logs = logs - logs.max(axis=-1, keepdims=True)
    return logs - np.log(np.exp(logs).sum(axis=-1, keepdims=True))


def product(factors, fabric):
    """The product of p^weight over the factors, log probabilities [samples, fabrics].

    Each sample takes the weights of the grid with the least log loss over the other samples.
    """
    factors = [normalised(logs) for logs in factors]
    products = np.stack([
        normalised(sum(weight * logs for weight, logs in zip(reversed(weights), factors)))
        for weights in itertools.product(EXPONENTS, repeat=len(factors))])
    samples = np.arange(len(fabric))
    loss = -products[:, samples, fabric]
    best = np.argmin(loss.sum(axis=1, keepdims=True) - loss, axis=0)
    return products[best, samples]


def score(logs, fabric):
    """The row of a way: shares of the true fabric first and among three, log loss, reliability."""
    logs = normalised(logs)
    samples, count = np.arange(len(fabric)), logs.shape[1]
    true = logs[samples, fabric][:, None]
    before = np.arange(count) < fabric[:, None]
    rank = ((logs > true) | ((logs == true) & before)).sum(axis=1)
    best, sure = logs.argmax(axis=1), np.exp(logs.max(axis=1))
    confusion = np.zeros((count, count), int)
    np.add.at(confusion, (fabric, best), 1)
    bins = np.minimum(BINS - 1, (sure * BINS).astype(int))
    reliability = [(int((bins == k).sum()), sure[bins == k].mean(),
                    (best == fabric)[bins == k].mean()) for k in range(BINS) if (bins == k).any()]
    return {"samples": len(fabric), "top_1": (rank < 1).mean(), "top_3": (rank < 3).mean(),
            "log_loss": -true.mean(), "confusion": confusion, "reliability": reliability}


def score_rows(by_way, fabric):
    """(way, score) for each row whose ways are there."""
    rows = []
    for way, source in ROWS:
        if isinstance(source, str):
            if source in by_way:
                rows.append((way, score(by_way[source], fabric)))
        elif all(key in by_way for key in source):
            rows.append((way, score(product([by_way[key] for key in source], fabric), fabric)))
    return rows


def confusion_rows(confusion, names):
    for i, name in enumerate(names):
        if confusion[i].sum() == 0:
            continue
        others = [f"{names[j]}: {count}" for j, count in enumerate(confusion[i])
                  if j != i and count > 0]
        yield [name, f"{confusion[i, i]} of {confusion[i].sum()}", "; ".join(others)]


def text(rows, names, failures):
    samples = rows[0][1]["samples"]
    result = (f"# Recognition of {samples} samples of {len(names)} fabrics\n\n"
              "Each sample is left out with all its captures.\n\n")
    result += study.markdown(
        ["way", "samples", "top 1", "top 3", "log loss [nat]"],
        [[way, str(row["samples"]), f"{row['top_1']:.3f}", f"{row['top_3']:.3f}",
          f"{row['log_loss']:.3f}"] for way, row in rows])
    by_drapes = [(way, row) for way, row in rows if way != DENSITY]
    way, best = min(by_drapes, key=lambda row: row[1]["log_loss"])
    result += f'\nReliability of "{way}":\n\n' + study.markdown(
        ["samples", "mean probability of the most probable fabric", "share that is right"],
        [[str(count), f"{sure:.2f}", f"{right:.2f}"] for count, sure, right in best["reliability"]])
    result += f'\nConfusions of "{way}":\n\n' + study.markdown(
        ["fabric", "recognised", "taken for"], confusion_rows(best["confusion"], names))
    if failures:
        result += "\nWithout a result:\n\n"
        result += "".join(f"- {each['name']}: {each['reason']}\n" for each in failures)
    return result


def tabulate(folder):
    """Each sample is left out and compared with the fabrics as the other samples show them, by each
    way: the log probabilities of all fabrics up to a constant [METHODS, P62]."""
    by_way, fabric = compare(folder.json)
    names = [f"fabric {number}" for number in folder["fabrics"]]
    result = text(score_rows(by_way, fabric), names, folder["failures"])
    folder.write("recognition.md", result)
    print(result, end="")


if __name__ == "__main__":
    if pathlib.Path(sys.argv[-1], "recognition.json").exists():
        study.main(tabulate, "recognition")
    else:
        study.main(draw, "space")
