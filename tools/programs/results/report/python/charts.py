# SPDX-License-Identifier: Apache-2.0
"""Fields, posterior, prediction and singular values, as charts and tables."""

import io
import math
import os

import numpy as np

import page as html
from drapes import USUAL_DISCS, read_outlines, svg_path
from results import InputError, directions, find, items, number, number_text, read_json, text

BLUE, GREY = "#0072b2", "#8a8f98"
MOST_MARGINALS = 3
SHARES = (0.05, 0.25, 0.5, 0.75, 0.95)  # of the outlines within bands


def svg(draw, rows, columns, width, height):
    """The bytes of a chart that `draw` fills: an array of axes of this size each [inch]."""
    import matplotlib
    import matplotlib.figure
    style = {"svg.fonttype": "none", "svg.hashsalt": "drapefit", "font.size": 9,
             "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
             "grid.alpha": 0.3, "legend.frameon": False}
    with matplotlib.rc_context(style):
        figure = matplotlib.figure.Figure((columns * width, rows * height), layout="constrained")
        draw(figure.subplots(rows, columns, squeeze=False))
        data = io.BytesIO()
        figure.savefig(data, format="svg", dpi=150, transparent=True, metadata={"Date": None})
        return data.getvalue()


def add_chart(page, data, caption):
    return page.data_picture("svg+xml", data, caption, caption, caption)


# Fields

FIELDS = [("stretch_n_per_m", "faces", "stretching: mean of c11 and c22 [N/m]", 1),
          ("bend_n_m", "hinges", "bending: plate rigidity [µN·m]", 1e6),
          ("stretch_uncertainty", "faces", "stretching: posterior over prior deviation", 1),
          ("bend_uncertainty", "hinges", "bending: posterior over prior deviation", 1)]


def read_fields(path):
    """Name, polygons in the plane of the cloth [cm] and values of each field. The polygon of a hinge
    is the kite of its edge and the centres of its faces."""
    stored = read_json(path)
    try:
        uv = 100 * np.array(stored["uv_m"], float)
        faces, hinges = np.array(stored["faces"], int), np.array(stored["hinges"], int)
        centres = uv[faces].mean(axis=1)
        polygons = {"faces": uv[faces],
                    "hinges": np.stack([uv[hinges[:, 0]], centres[hinges[:, 2]],
                                        uv[hinges[:, 1]], centres[hinges[:, 3]]], axis=1)}
        fields = [(name, polygons[of], factor * np.array(stored[key], float))
                  for key, of, name, factor in FIELDS]
        if any(values.shape != shapes.shape[:1] or not np.isfinite(values).all() or len(values) == 0
               for _, shapes, values in fields):
            raise ValueError
        return fields
    except (ValueError, KeyError, TypeError, IndexError):
        raise InputError(f"{path}: expected the fields of drape_fit") from None


def draw_fields(fields, warp, weft):
    def draw(grid):
        import matplotlib.collections
        for axes, (name, polygons, values) in zip(grid.flat, fields):
            shown = matplotlib.collections.PolyCollection(polygons, array=values, cmap="viridis",
                                                          edgecolors="face", rasterized=True)
            axes.add_collection(shown)
            axes.autoscale_view()
            axes.set(title=name, aspect="equal", xlabel=f"{weft} [cm]", ylabel=f"{warp} [cm]")
            axes.grid(False)
            axes.figure.colorbar(shown, ax=axes)
    return svg(draw, 2, 2, 3.6, 3)


def cloth_fields(folder, page):
    file = folder.at("fields.json")
    if not folder.is_fit or not os.path.lexists(file):
        return ""
    try:
        fields = read_fields(file)
    except InputError as error:
        return html.paragraph(str(error), "missing")
    rows = [(html.header(name), *(html.numeric("%.3g" % value) for value in
                                  (values.mean(), values.std(), values.min(), values.max())))
            for name, _, values in fields]
    return add_chart(page, draw_fields(fields, *directions(folder.summary)),
                     "Stiffness over the cloth, and how far the data narrow it: 1 where they say "
                     "nothing.") + html.table(rows, ("field", "mean", "standard deviation", "least",
                                                     "most"))


# Posterior

class Posterior:
    """The normal distribution of the log factors of posterior.json."""

    def __init__(self, path):
        stored = read_json(path)
        try:
            self.hierarchy = stored["kind"] == "hierarchy"
            self.names, self.mean, self.prior_sd = (
                stored["names"], np.array(stored["mean"], float), np.array(stored["prior_sd"], float))
            if self.hierarchy:
                size = len(self.names)
                self.covariance = np.array(stored["covariance"], float).reshape(size, size)
                self.sd = np.sqrt(np.diag(self.covariance))
                if not ((self.sd > 0) & (self.prior_sd > 0)).all() or len(self.mean) != size:
                    raise ValueError
        except (ValueError, KeyError, TypeError):
            raise InputError(f"{path}: expected a posterior of drape_fit") from None


def plain_ticks(axis):
    """A few numbers without exponents, also where a logarithmic axis spans less than a decade."""
    from matplotlib import ticker
    low, high = axis.get_view_interval()
    if high < 20 * low:
        axis.set_major_locator(ticker.MaxNLocator(3))
        axis.set_minor_locator(ticker.NullLocator())
    axis.set_major_formatter(ticker.FormatStrFormatter("%g"))


def draw_density(axes, p, i):
    reach = 2.5 * p.prior_sd[i]
    x = np.linspace(-reach, reach, 81)
    for mean, sd, colour, name in [(0, p.prior_sd[i], GREY, "prior"),
                                   (p.mean[i], p.sd[i], BLUE, "posterior")]:
        axes.plot(np.exp(x), np.exp(-((x - mean) / sd) ** 2 / 2) / (sd * math.sqrt(2 * math.pi)),
                  color=colour, label=name)
    axes.set(xscale="log", ylabel="density", xlabel=f"factor on\n{p.names[i]}")
    plain_ticks(axes.xaxis)
    axes.legend(fontsize=7)


def draw_pair(axes, p, i, j):
    """Ellipses that hold half and 90 % of the pairs."""
    root = np.linalg.cholesky(p.covariance[np.ix_([i, j], [i, j])])
    angle = np.linspace(0, 2 * np.pi, 81)
    circle = np.stack([np.cos(angle), np.sin(angle)])
    for share, line in [(0.5, "-"), (0.9, "--")]:
        at = p.mean[[i, j], None] + math.sqrt(-2 * math.log(1 - share)) * (root @ circle)
        axes.plot(*np.exp(at), line, color=BLUE, label="%.0f %%" % (100 * share))
    axes.set(xscale="log", yscale="log", xlabel=f"factor on\n{p.names[i]}",
             ylabel=f"factor on\n{p.names[j]}")
    plain_ticks(axes.xaxis)
    plain_ticks(axes.yaxis)
    axes.legend(fontsize=7)


def draw_corner(p):
    """On the diagonal the densities of what the data narrow most, below it the pairs."""
    shown = np.argsort(p.sd / p.prior_sd, kind="stable")[:MOST_MARGINALS]

    def draw(axes):
        for row, j in enumerate(shown):
            for column, i in enumerate(shown):
                if row == column:
                    draw_density(axes[row][column], p, i)
                elif column < row:
                    draw_pair(axes[row][column], p, i, j)
                else:
                    axes[row][column].axis("off")
    return svg(draw, len(shown), len(shown), 2.1, 1.9)


def posterior_table(numbers):
    rows = []
    for factor in numbers:
        mean, sd, prior = (number(factor, key) for key in ("/mean", "/sd", "/prior_sd"))
        if mean is None or sd is None or not prior:
            continue
        low, median, high = (math.exp(min(700, mean + z * sd)) for z in (-1.645, 0, 1.645))
        rows.append((html.header(text(factor, "/name")), html.numeric("%.3g" % median),
                     html.numeric("%.3g … %.3g" % (low, high)), html.numeric("%.2f" % (sd / prior)),
                     html.origin("measured" if sd < 0.7 * prior else "from the prior")))
    return html.table(rows, ("entries", "median", "90 % interval", "posterior over prior deviation",
                             "where from"), "Factors on the entries of the base tables") if rows else ""


def posterior(folder, page):
    found = find(folder.summary, "/posterior")
    if not isinstance(found, dict):
        return ""
    parts = []
    k = number(found, "/pareto_k")
    if k is not None:
        parts.append(html.paragraph("Pareto k %.2f: " % k + (
            "the intervals are reliable." if k < 0.7 else "do not use these intervals.")))
    if os.path.lexists(folder.at("posterior.json")):
        try:
            stored = Posterior(folder.at("posterior.json"))
            if stored.hierarchy and len(stored.names) > 0:
                parts.append(add_chart(page, draw_corner(stored),
                                       "Densities over that of the prior, and pairs of factors: what "
                                       "the data narrow most."))
        except (InputError, np.linalg.LinAlgError) as error:
            parts.append(html.paragraph(str(error), "missing"))
    parts.append(posterior_table(items(found, "/log_factors")))
    return html.join(parts)


# Prediction

FEATURES = [("dc", "drape coefficient [%]", 100), ("folds", "nodes", 1),
            ("band_2", "waves of the outline, 2 around [mm²]", 1e6), ("band_3_5", "3 to 5 around [mm²]", 1e6),
            ("band_6_9", "6 to 9 around [mm²]", 1e6), ("band_10_15", "10 to 15 around [mm²]", 1e6)]


def draw_counts(coefficients, nodes):
    def draw(axes):
        import matplotlib.ticker
        for one, values, width, label in [(axes[0][0], coefficients, 2, "drape coefficient [%]"),
                                          (axes[0][1], nodes, 1, "nodes")]:
            bins = np.floor(np.array(values) / width + 0.5)
            at, count = np.unique(bins, return_counts=True)
            one.bar(width * at, count, 0.95 * width, color=BLUE)
            one.set(xlabel=label, ylabel="drapes")
            one.yaxis.set_major_locator(matplotlib.ticker.MaxNLocator(integer=True, nbins=5))
            one.xaxis.set_major_locator(matplotlib.ticker.MaxNLocator(integer=True, nbins=6))
    return svg(draw, 1, 2, 3.6, 2.4)


def bands(folder):
    """Half and 90 % of the outlines at each angle, and their median."""
    try:
        outlines = read_outlines(folder.at("outlines.json"))
    except InputError:  # the part with the outlines says why
        outlines = []
    if len(outlines) < 2:
        return ""
    specimen, support = (500 * size for size in folder.discs() or USUAL_DISCS)  # radii [mm]
    middle = specimen + 10
    path = {share: svg_path(1e3 * radius, middle, middle, 1)
            for share, radius in zip(SHARES, np.quantile([each[-1] for each in outlines], SHARES, axis=0))}
    return html.BLOCKS.bands(2 * middle, path[0.95] + path[0.05], path[0.75] + path[0.25], path[0.5],
                             support)


def intervals(features):
    rows = []
    for key, name, factor in FEATURES:
        feature = features.get(key)
        if isinstance(feature, dict):
            low_high = [" … ".join(number_text(feature, f"/interval_{share}/{end}", factor, "%.3g")
                                   for end in ("low", "high")) for share in (50, 90)]
            rows.append((html.header(name), html.number_cell(feature, "/mean", factor, "%.3g"),
                         html.number_cell(feature, "/sd", factor, "%.3g"),
                         *map(html.numeric, low_high)))
    return html.table(rows, ("feature", "mean", "standard deviation", "50 % in", "90 % in"))


def prediction(folder, page):
    if folder.program != "drape_predict":
        return ""
    s = folder.summary
    known = [drape for drape in items(s, "/drapes")
             if number(drape, "/dc") is not None and number(drape, "/folds") is not None]
    parts = []
    if known:
        parts.append(add_chart(page, draw_counts([100 * drape["dc"] for drape in known],
                                                 [drape["folds"] for drape in known]),
                               "Predicted drapes by drape coefficient and by number of nodes."))
    parts.append(bands(folder))
    if isinstance(find(s, "/features"), dict):
        parts.append(intervals(s["features"]))
    if find(s, "/score") is not None:
        parts.append(html.details("Scores on the held-out drapes", html.flat_table(s["score"])))
    return html.join(parts)


# Singular values

def draw_spectrum(values, limit):
    def draw(axes):
        one = axes[0][0]
        at = np.arange(1, len(values) + 1)
        for mask, colour, name in [(values > limit, BLUE, "determined by the data"),
                                   (values <= limit, GREY, "of the prior")]:
            if mask.any():
                one.plot(at[mask], values[mask], "o", color=colour, label=name)
        one.axhline(limit, color="black", linestyle="--", label="1/σ of the prior")
        one.set(xlabel="direction", ylabel="singular value", yscale="log")
        plain_ticks(one.yaxis)
        one.legend()
    return svg(draw, 1, 1, 6, 3)


def spectrum(folder, page):
    values = np.array(items(folder.summary, "/spectrum/singular_values", (int, float)), float)
    determined = number(folder.summary, "/spectrum/determined_directions")
    if not folder.is_fit or determined is None or len(values) == 0:
        return ""
    limit = 1 / (number(folder.summary, "/parameters/prior_sigma") or 1)
    rows = [(html.numeric(str(i + 1)), html.numeric("%.4g" % value),
             ("determined" if value > limit else "of the prior", "")) for i, value in enumerate(values)]
    return add_chart(page, draw_spectrum(values, limit),
                     "%.0f of %d directions of the log factors are determined: there the data say more "
                     "than the prior." % (determined, len(values))) + html.details(
                         "Singular values", html.table(rows, ("direction", "value", "")))
