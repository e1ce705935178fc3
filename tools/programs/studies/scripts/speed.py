# SPDX-License-Identifier: Apache-2.0
"""The table of drape_speed beside published figures: speed.md."""

from study import main, markdown, number


class Row:
    """Our measurements of one batch: for each mesh the results of its parts."""

    def __init__(self, results):
        self.meshes = {}
        for result in results:
            of = self.meshes.setdefault(result["input"]["mesh"], {})
            of[result["input"]["part"]] = result
        first = results[0]
        self.machine = first["device"]
        if "CPU thread" in self.machine and first["processor"]:
            self.machine += " of " + first["processor"]
        if first["input"]["batch"] > 1:
            self.machine += f", of {first['input']['batch']} at once"

    def each(self, part, key):
        """A number of a part for each mesh."""
        return [of[part][key] for of in self.meshes.values()]

    def forward(self):
        return self.each("forward", "seconds")

    def backward(self):
        return [both - forward for both, forward in zip(self.each("gradient", "seconds"), self.forward())]

    def megabytes(self, part):
        return " ".join(f"{peak:.0f}" for peak in self.each(part, "peak_mb"))


def part_table(title, published, key, rows, measured):
    """One of the two parts of a step, ours and that of others on meshes of as many vertices."""
    vertices = rows[0].each("forward", "vertices")
    lines = []
    for row in published["rows"]:
        if key in row:
            speeds = dict(zip(published["vertices"], row[key]))
            lines.append([row["name"], row["machine"],
                          *(number(speeds[each]) if each in speeds else "–" for each in vertices)])
    lines += [["drapefit", row.machine, *map(number, measured(row))] for row in rows]
    return markdown([title, "machine", *vertices], lines) + "\n"


def draw(study):
    batches = {}
    for result in study.results():
        batches.setdefault(result["input"]["batch"], []).append(result)
    rows = [Row(results) for results in batches.values()]
    published, settings = study["published"], study["settings"]
    text = part_table("forward [s a step], vertices:", published, "forward_s", rows, Row.forward)
    text += part_table("backward [s a step], vertices:", published, "backward_s", rows, Row.backward)
    for row in rows:
        text += (f"peak memory of the host [MB], {row.machine}: forward {row.megabytes('forward')}, "
                 f"with the gradient {row.megabytes('gradient')}\n")
    text += (f"drapefit: law {settings['law']}, {settings['steps']} steps of {settings['time_step']} s, "
             f"median of at most {settings['repeats']}; the gradient is of one scalar by the 39 numbers "
             "of a table, backward is gradient less forward\n")
    if study["has_built_in_meshes"]:
        text += ("meshes: built-in discs of about the published numbers of vertices, not the published "
                 "meshes (--mesh)\n")
    for row in published["rows"]:
        text += f"{row['name']}, {row['machine']}: {row['source']}\n"
    study.write("speed.md", text)
    print(text, end="")


if __name__ == "__main__":
    main(draw, "speed")
