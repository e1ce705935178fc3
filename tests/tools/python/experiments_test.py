# SPDX-License-Identifier: Apache-2.0
"""Fits of experiments of the Python module: against the program, and twins on another mesh."""
import json
import unittest

import numpy as np

import drapefit
from python_fixture import SOURCE, PythonTest, run_program

SHIRT = SOURCE / "configs/fabrics/synthetic_shirt.json"
COTTON = SOURCE / "configs/fabrics/cotton_blue.json"
CLAMPED = {"gravity": [0, 0, -9.81],
           "handles": {"region": {"half_plane": {"offset": 0.0241}}, "stiffness": 1e4}}
HANGING = {"gravity": [9.81, 0, 0],  # along the flat strip
           "handles": {"region": {"half_plane": {"offset": 0.001}}, "stiffness": 1e4}}
CAMERA = {"kind": "orthographic", "width": 96, "height": 64, "cx": 8, "cy": 31.5, "px_per_m": 600}
QUICK = {"num_parameters": 2, "threads": 2}
FROM_ONE = {"initial_stretch": 1, "initial_bend": 1}  # without a search of the factors to start from


class ExperimentsTest(PythonTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.shirt = drapefit.read_material(SHIRT)
        cls.stiff = drapefit.make_material(0.12, cls.shirt.stretch, 20 * cls.shirt.bend)

    def clamped_strip(self, spec="strip:0.12x0.04x15"):
        """A strip of the stiff fabric that is clamped at x = 0 and at rest, and its mesh."""
        simulator = drapefit.Simulator(spec, CLAMPED, threads=2)
        drapes = simulator.drape(self.stiff, h=0.05, steps=60, solve="hybrid")
        self.assertEqual(drapes.status, ["stable"])
        return simulator.mesh, drapes.positions[0]

    def strip_experiment(self, measurement, **others):
        return {"material": self.shirt, "density": 0.12, "experiments": [
            {"name": "strip", "mesh": "strip:0.12x0.04x10", "scene": CLAMPED, "random_starts": 0,
             "measurements": [measurement], **others}]}

    def markers(self):
        mesh, x = self.clamped_strip()
        return {"places": mesh.uv, "positions": x + 1e-3 * self.random.normal(size=x.shape)}

    def test_a_fit_is_that_of_drape_fit(self):
        markers = self.markers()
        fit = drapefit.fit(self.strip_experiment({"markers": markers, "sigma": 0.001}), **QUICK)
        rows = np.hstack([markers["places"], markers["positions"]]).tolist()
        (self.folder / "markers.csv").write_text("weft_m,warp_m,x_m,y_m,z_m\n" + "".join(
            ",".join(map(repr, row)) + "\n" for row in rows))
        tree = self.strip_experiment({"markers": "markers.csv", "sigma": 0.001})
        tree["material"] = str(SHIRT)
        path = self.folder / "strip.json"
        path.write_text(json.dumps(tree))
        run_program("drape_fit", f"--experiment={path}", "--num_parameters=2", "--threads=2",
                    f"--out={self.folder / 'fit'}")
        results = drapefit.read_folder(self.folder / "fit")
        self.assertEqual(fit.material.bend.tolist(), results["material"].bend.tolist())
        self.assertEqual(fit.material.stretch.tolist(), results["material"].stretch.tolist())
        self.assertEqual(drapefit.fit(path, **QUICK).material.bend.tolist(),
                         fit.material.bend.tolist())
        summary = results["summary"]
        self.assertEqual(fit.grade, summary["verdict"]["grade"])
        measurement, = fit.measurements
        self.assertEqual(measurement.name, "markers of markers_2.csv")
        self.assertEqual(measurement.misfit, summary["measurements"][0]["misfit_sigma"])
        self.assertEqual(fit.drapes.shape, (1, len(fit.mesh.vertices), 3))

    def test_a_twin_on_another_mesh_is_recovered(self):
        fit = drapefit.fit(self.strip_experiment({"markers": self.markers(), "sigma": 0.001}),
                           **QUICK)
        self.assertTrue(fit.fitted, fit.notes)
        self.assertLess(fit.measurements[0].misfit, 1.5)
        rows = {row.key: row for row in fit.sheet}
        bend, warp = rows["bending_overall_un_m"], rows["bending_warp_un_m"]
        self.assertEqual((bend.source, warp.source), ("measured", "from the prior"))
        self.assertIsNone(warp.interval)
        # The fitted tables are those of the shirt times one factor.
        factor = fit.material.bend[0, 0] / self.shirt.bend[0, 0]
        low, high = (end * factor / bend.value for end in bend.interval)
        self.assertTrue(low < 20 < high, (low, factor, high))
        self.assertLess(high / low, 4)

    def test_residuals_serve_another_optimiser(self):
        experiment = self.strip_experiment({"markers": self.markers(), "sigma": 0.001})
        residuals = drapefit.Residuals(experiment, **QUICK)
        self.assertEqual(residuals.num_parameters, 2)
        theta = np.zeros(2)
        for _ in range(8):  # Gauss and Newton, with the prior of the fit, in steps of at most 1
            found, jacobian = residuals.with_jacobian(theta)
            step = np.linalg.solve(jacobian.T @ jacobian + np.eye(2), jacobian.T @ found + theta)
            theta = theta - step / max(1.0, np.abs(step).max())
        found, jacobian = residuals.with_jacobian(theta)
        fit = drapefit.fit(experiment, prior_sigma=1, **FROM_ONE, **QUICK)
        fitted = np.log([fit.material.stretch[0, 0] / self.shirt.stretch[0, 0],
                         fit.material.bend[0, 0] / self.shirt.bend[0, 0]])
        np.testing.assert_allclose(theta, fitted, atol=0.1)
        cost = 0.5 * (found @ found + theta @ theta)
        of_fit = 0.5 * (np.sum(residuals(fitted)**2) + fitted @ fitted)
        self.assertLess(abs(of_fit - cost), 1e-3 * cost)
        count = 3 * len(self.clamped_strip()[0].vertices)
        self.assertEqual((found.shape, jacobian.shape), ((count,), (count, 2)))
        change = 1e-4 * np.eye(2)
        slopes = [(residuals(theta + each) - residuals(theta - each)) / 2e-4 for each in change]
        np.testing.assert_allclose(jacobian, np.transpose(slopes), atol=1e-5 * np.abs(slopes).max())
        self.assertIsNone(residuals(theta + [0, 6]))  # too far to be the same branch
        self.assert_refused("theta: found 3 numbers, expected 2", residuals, np.zeros(3))

    def test_arrays_of_all_kinds_are_read(self):
        mesh, x = self.clamped_strip()
        order = np.argsort(x[:, 0])
        heights = np.interp((np.arange(96) - 8) / 600, x[order, 0], x[order, 2], right=np.nan)
        depth = np.tile(-heights, (64, 1))
        depth[:, :24] = depth[:, 50:] = depth[:22] = depth[-22:] = np.nan
        coverage = drapefit.Simulator(mesh, CLAMPED).drape(
            self.stiff, start=x, steps=0).read("silhouette", camera=self.camera())[0]
        tip = np.flatnonzero(mesh.vertices[:, 0] > 0.1199)
        chord = x[tip].mean(axis=0)
        kinds = [
            {"points": x + 5e-4 * self.random.normal(size=x.shape), "sigma": 0.002},
            {"markers": {"vertices": tip, "positions": x[tip]}, "sigma": 0.002},
            {"shape": x, "sigma": 0.002},
            {"depth": depth, "background": 0.5, "view": CAMERA, "sigma": 0.002,
             "loss": {"huber": 2}},
            {"silhouette": coverage, "view": {"camera": self.camera(), "position": np.eye(3)[2],
                                              "target": [0, 0, 0], "up": [0, 1, 0]}, "sigma": 0.3},
            {"angle": np.degrees(np.arctan2(-chord[2], chord[0])), "tip": tip, "clamp": [0, 0, 0],
             "along": [1, 0, 0], "sigma": 1}]
        experiment = self.strip_experiment({}, start=x, measurements=kinds)
        experiment["experiments"][0]["mesh"] = mesh
        experiment["material"] = drapefit.make_material(0.12, self.shirt.stretch,
                                                        8 * self.shirt.bend)
        fit = drapefit.fit(experiment, **QUICK)
        counts = [measurement.count for measurement in fit.measurements]
        seen = np.round(255 * coverage)
        across, down = np.diff(seen, axis=1) != 0, np.diff(seen, axis=0) != 0
        at_outline = (np.pad(across, ((0, 0), (0, 1))) | np.pad(across, ((0, 0), (1, 0))) |
                      np.pad(down, ((0, 1), (0, 0))) | np.pad(down, ((1, 0), (0, 0))))
        self.assertEqual(counts, [len(x), 3 * len(tip), x.size, np.isfinite(depth).sum(),
                                  at_outline.sum(), 1])
        for measurement in fit.measurements:
            self.assertLess(measurement.misfit, 1.0, measurement)
        factor = fit.material.bend[0, 0] / self.shirt.bend[0, 0]
        self.assertLess(abs(np.log(factor / 20)), 0.15)

    def camera(self):
        path = self.folder / "camera.json"
        path.write_text(json.dumps(CAMERA))
        return drapefit.read_camera(str(path))

    def test_the_posterior_of_an_experiment_is_sampled(self):
        fit = drapefit.fit(str(SOURCE / "configs/experiments/square.json"), model="bayes",
                           num_parameters=2, posterior_samples=4, posterior_iterations=4,
                           elbo_samples=25, **FROM_ONE)
        shear = drapefit.sample_posterior(fit, 400).quantities["shear_n_per_m"]
        self.assertTrue(shear.measured)
        row, = (row for row in fit.sheet if row.key == "shear_n_per_m")
        low, high = row.interval  # by the Laplace approximation: four samples are too few
        soft, stiff = np.quantile(shear.samples, [0.05, 0.95])
        self.assertTrue(low < soft < stiff < high, (row.interval, soft, stiff))
        self.assertLess(np.log(high / low) / np.log(stiff / soft), 1.6)

    def test_damping_of_a_swinging_strip_is_recovered(self):
        motion = {"steps": 400, "time_step": 0.0025, "velocity": [0, 0, 1]}
        dynamics = {"mass_damping": 2.0, "air_drag": 0.5}
        frames = [80, 160, 240, 320, 400]
        simulator = drapefit.Simulator("strip:0.2x0.05x20", HANGING, threads=2)
        velocity = np.tile([0.0, 0.0, 1.0], (len(simulator.mesh.vertices), 1))
        finer = 4  # time steps for each of the fit's
        seen = simulator.drape(self.shirt, velocity=velocity, dynamics=dynamics, h=0.0025 / finer,
                               steps=400 * finer, frames=[finer * step for step in frames]).frames[0]
        markers = [{"markers": {"places": simulator.mesh.uv[::4], "positions": x[::4]
                                + 1e-3 * self.random.normal(size=x[::4].shape)},
                    "sigma": 0.001, "step": step} for x, step in zip(seen, frames)]
        experiment = self.strip_experiment(
            {}, mesh="strip:0.2x0.05x15", scene=HANGING, measurements=markers,
            motion={**motion, "mass_damping": 1, "air_drag": 0.25})
        experiment["fit"] = list(dynamics)
        fit = drapefit.fit(experiment, **QUICK)
        self.assertTrue(fit.fitted, fit.notes)
        for name, found in fit.dynamics.items():
            low, high = found.interval
            self.assertTrue(low < dynamics[name] < high < 1.6 * low, (name, found))
        self.assertEqual(len(fit.measurements), len(frames))
        self.assertEqual(fit.drapes.shape, (0, len(fit.mesh.vertices), 3))

    def test_bad_input_is_a_value_error_of_one_line(self):
        def refused(message, measurement, **options):
            self.assert_refused(message, drapefit.fit, self.strip_experiment(measurement),
                                **options)
        points = {"points": np.zeros((3, 3)), "sigma": 1e-3}
        refused("experiment.json: key 'experiments[0].measurements[0].sigma'",
                {**points, "sigma": -1})
        refused("points: found an array of the shape [3, 2], expected [N, 3]",
                {**points, "points": np.zeros((3, 2))})
        refused("markers: found the keys ['places']", {"markers": {"places": []}, "sigma": 1})
        refused("positions: found an array of the shape [0]",
                {"markers": {"places": [], "positions": []}, "sigma": 1})
        refused("places: found an array of the shape [2, 2], expected [1, 2]",
                {"markers": {"places": np.zeros((2, 2)), "positions": [[0, 0, 0]]}, "sigma": 1})
        refused("depth: found counts from 0 to 70000", {"depth": np.array([[0, 70000]])})
        refused("depth: found 0 m, expected more", {"depth": np.array([[0.0, np.nan]])})
        refused("silhouette: found a coverage outside", {"silhouette": [[2.0]]})
        refused("no such file", {"markers": "absent.csv", "sigma": 1})
        refused("fit: unknown option 'mesh'", points, mesh="disc:100")
        refused("expected a number, a text", {**points, "loss": {"huber": {1}}})
        self.assert_refused("material: found one beside an experiment", drapefit.fit,
                            self.strip_experiment(points), self.shirt)
        self.assert_refused("material: found nothing beside images", drapefit.fit, "drape.png")
        self.assert_refused("no such file", drapefit.fit, "absent.json")


if __name__ == "__main__":
    unittest.main()
