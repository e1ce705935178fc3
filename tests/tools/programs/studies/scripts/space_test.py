# SPDX-License-Identifier: Apache-2.0
"""The tree and the plane of a space of materials."""

import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

import numpy as np

SCRIPTS = pathlib.Path(__file__).resolve().parents[5] / "tools/programs/studies/scripts"
sys.path.insert(0, str(SCRIPTS))
import space  # noqa: E402


def distances(points):
    return np.linalg.norm(points[:, None] - points[None], axis=2)


INTERRUPTED = """
import study, time
def draw(study):
    study.write("table.md", "new")
    print("drawing", flush=True)
    time.sleep(9)
study.main(draw, "space")
"""


class Files(unittest.TestCase):
    def test_a_signal_leaves_the_earlier_files(self):
        for number in signal.SIGINT, signal.SIGTERM:
            with tempfile.TemporaryDirectory() as folder:
                files = {"space.json": "{}", "table.md": "earlier"}
                for name, text in files.items():
                    (pathlib.Path(folder) / name).write_text(text)
                with subprocess.Popen([sys.executable, "-c", INTERRUPTED, folder], cwd=SCRIPTS,
                                      stdout=subprocess.PIPE) as script:
                    script.stdout.readline()
                    script.send_signal(number)
                    self.assertEqual(script.wait(8), 130)
                self.assertEqual({file.name: file.read_text()
                                  for file in pathlib.Path(folder).iterdir()}, files)


class Layout(unittest.TestCase):
    def test_points_of_a_plane_keep_their_distances(self):
        points = np.random.default_rng(1).normal(size=(7, 2))
        plane = space.scale_to_plane(distances(points))
        self.assertLess(np.linalg.norm(distances(plane) - distances(points)), 1e-12)
        np.testing.assert_array_equal(space.scale_to_plane(np.zeros((1, 1))), np.zeros((1, 2)))

    def test_tree_by_average_linkage(self):
        """0, 1, 5, 6.5: two pairs, of mean distance 5.25."""
        tree, order = space.average_linkage(distances(np.array([[0.0], [5.0], [1.0], [6.5]])))
        self.assertEqual(tree, [(0, 2, 1.0), (1, 3, 1.5), (4, 5, 5.25)])
        self.assertEqual(order, [0, 2, 1, 3])

    def test_means_are_mapped_to_their_points(self):
        """Distributions of equal spread in two directions: the map is a rotation."""
        means = np.random.default_rng(2).normal(size=(5, 2))
        fabrics = [{"determined": {"mean": mean.tolist()}} for mean in means]
        points, linear, centre = space.map_of(fabrics, distances(means))
        np.testing.assert_allclose(points, (means - centre) @ linear.T, atol=1e-12)
        np.testing.assert_allclose(linear @ linear.T, np.eye(2), atol=1e-12)

    def test_an_ellipse_is_one_standard_deviation(self):
        covariance = np.array([[4.0, 1.0], [1.0, 2.0]])
        offsets = space.ellipse([3.0, -1.0], covariance) - [3.0, -1.0]
        lengths = np.einsum("ij,jk,ik->i", offsets, np.linalg.inv(covariance), offsets)
        np.testing.assert_allclose(lengths, 1.0, atol=1e-12)


if __name__ == "__main__":
    unittest.main()
