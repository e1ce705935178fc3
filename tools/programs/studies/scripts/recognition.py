# SPDX-License-Identifier: Apache-2.0
"""Scores of drape_space --recognise: reads recognition.json and writes recognition.md.

Each sample has, by way, the log probabilities of all fabrics up to a constant.
"""

import itertools

import numpy as np

import study

EXPONENTS = [0.0, 0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0]
BINS = 5  # of reliability
POSTERIOR, FEATURES, PREDICTIONS = "posterior (A)", "image features", "predicted drapes (B)"
DENSITY = "density alone, weighed to 3 %"
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
    samples = folder["samples"]
    fabric = np.array([sample["fabric"] for sample in samples])
    by_way = {way: np.array([sample["by_way"][way] for sample in samples])
              for way in samples[0]["by_way"]}
    names = [f"fabric {number}" for number in folder["fabrics"]]
    result = text(score_rows(by_way, fabric), names, folder["failures"])
    folder.write("recognition.md", result)
    print(result, end="")


if __name__ == "__main__":
    study.main(tabulate, "recognition")
