# SPDX-License-Identifier: Apache-2.0
"""Drapes, files and errors of the Python module."""
import os
import signal
import subprocess
import sys
import threading
import time
import tomllib
import unittest

import numpy as np

import drapefit
from python_fixture import SIX_WAVES, SOURCE, WOOL, PythonTest, read_json, run_program

ENDLESS = """
import os, threading, time, drapefit
simulator = drapefit.Simulator(drapefit.disc(200), threads=1)
wool, start = drapefit.read_material({material!r}), simulator.random_start(1)
def drape(): simulator.drape(wool, start=start, steps=10**8)
def wait():
    threading.Thread(target=drape, daemon=True).start()
    time.sleep(0.1)
    drape()
print("running", flush=True)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted", flush=True)
    if {call!r} == "wait()": os._exit(1)  # Python does not end beside another thread of its own
    raise
"""
ENDLESS_CALLS = ["drape()", "wait()", "drapefit.disc(60000)",
                 "drapefit.Simulator(drapefit.disc(60000))",
                 f"drapefit.wear({os.fspath(SOURCE / 'configs/garments/circle_skirt.json')!r}, wool)"]


class DrapesTest(PythonTest):
    def test_drape_is_that_of_drape_simulate(self):
        out = self.folder / "out"
        run_program("drape_simulate", "--mesh=disc:200", f"--fabric={WOOL}",
                    f"--start={SIX_WAVES}",
                    "--steps=40", "--dump_steps=40", f"--out={out}")
        results = drapefit.read_folder(out)
        drapes = self.simulator.drape(self.wool, start=self.start, steps=40)
        self.assertEqual(drapes.status, ["ok"])
        self.assert_relative(drapes.positions[0], np.array(results["state_40"]["x"]), 1e-12)
        self.assert_relative(drapes.velocities[0], np.array(results["state_40"]["v"]), 1e-12)
        features = dict(zip(drapefit.FEATURES, drapes.read("features")[0]))
        self.assertEqual(features["folds"], results["summary"]["folds"])
        self.assertAlmostEqual(features["dc"],
                               results["summary"]["dc"], delta=5e-3)
        seen = drapefit.read_silhouette(out / "silhouette.png")
        self.assertEqual(seen.coverage.shape, (256, 256))
        self.assertLess(np.abs(drapes.read("silhouette")[0] - seen.coverage).mean(), 2e-3)
        # The camera of an image has its centre where the outline has no first harmonic.
        outline = drapes.read("outline", camera=seen.camera)[0]
        self.assertLess(np.median(np.abs(outline - seen.outline())), 0.5)
        self.simulator.mesh.write(self.folder / "again.obj", drapes.positions[0])
        self.assertEqual(drapefit.read_mesh(self.folder / "again.obj").vertices.tolist(),
                         drapes.positions[0].tolist())

    def test_frames_are_the_ends_of_shorter_drapes_bit_for_bit(self):
        inputs = {"start": self.start, "velocity": 0.1 * self.random.normal(size=self.start.shape),
                  "dynamics": [1.0, 0.01, 0.5, 0.0, 0.0, 1.0]}
        drapes = self.simulator.drape(self.wool, frames=[0, 7, 20], steps=20, **inputs)
        self.assertEqual(drapes.frames.shape, (1, 3, *self.start.shape))
        for k, steps in enumerate((0, 7, 20)):
            end = self.simulator.drape(self.wool, steps=steps, **inputs)
            np.testing.assert_array_equal(drapes.frames[:, k], end.positions)
            np.testing.assert_array_equal(drapes.frame_velocities[:, k], end.velocities)

    def test_a_free_strip_falls_and_slows_down_as_by_hand(self):
        simulator = drapefit.Simulator("strip:0.2x0.05x8", {"gravity": [0, 0, -9.81]})
        velocity, damping, h = np.array([0.3, 0.0, 0.2]), np.array([0.0, 2.5]), 0.02
        drapes = simulator.drape(self.wool, velocity=np.tile(velocity, (len(simulator.mesh.vertices), 1)),
                                 dynamics=np.outer(damping, np.eye(6)[0]), h=h, steps=5)
        for found, alpha in zip(drapes.velocities, damping):
            v = velocity
            for _ in range(5):
                v = (v + h * np.array([0.0, 0.0, -9.81])) / (1 + h * alpha)
            np.testing.assert_allclose(found, np.tile(v, (len(found), 1)), atol=1e-9)

    def test_wind_carries_a_sheet_along_and_names_are_those_of_an_experiment(self):
        simulator = drapefit.Simulator("strip:0.2x0.05x8", {"gravity": [0, 0, 0]})
        named = simulator.drape(self.wool, dynamics={"air_drag": 0.6, "wind": [0, 0, 2]}, steps=200)
        same = simulator.drape(self.wool, dynamics=[0, 0, 0.6, 0, 0, 2], steps=200)
        np.testing.assert_array_equal(named.positions, same.positions)
        # v' = c·(2 − v)²/density has the solution 2 − v = 2/(1 + 2·c·t/density).
        left = 2 / (1 + 2 * 0.6 * 200 * 0.05 / self.wool.density)
        np.testing.assert_allclose(named.velocities[0, :, 2], 2 - left, atol=0.1 * left)

    def test_scenes_have_names_and_may_be_dictionaries(self):
        rows = {"gravity": [0, 0, -9.81], "handles": {"regions": [
            {"disc": {"radius": 0.004, "centre": [x, 0.1]}} for x in (0, 0.2)], "stiffness": 1e4}}
        found = [drapefit.Simulator("strip:0.2x0.2x6", scene).drape(self.wool, steps=5).positions
                 for scene in ("two_corners", SOURCE / "configs/scenes/two_corners.json", rows)]
        np.testing.assert_array_equal(found[0], found[1])
        np.testing.assert_array_equal(found[0], found[2])
        body = SOURCE / "configs/scenes/three_lobes.obj"
        drapefit.Simulator("disc:200", {"contact": {"thickness": 4e-4, "range": 5e-4,
            "stiffness": 100, "obstacles": [{"mesh": {"file": os.path.relpath(body),
                                                      "translation": np.zeros(3)}}]}})
        self.assert_refused("scene.json: key 'gravity'", drapefit.Simulator, "strip:0.2x0.2x6",
                            {"gravity": [0, 0]})

    def test_a_batch_is_equal_to_single_drapes_bit_for_bit(self):
        starts = np.stack([self.simulator.random_start(seed) for seed in range(4)])
        factors = 0.3 * self.random.normal(size=(4, 3))
        batch = self.simulator.drape(self.wool, factors, starts, steps=15)
        other = drapefit.Simulator(self.simulator.mesh, threads=1)
        cotangent = self.random.normal(size=starts.shape)
        gradient = batch.vjp(cotangent)
        for i in range(4):
            one = other.drape([self.wool], factors[i], starts[i], steps=15)
            np.testing.assert_array_equal(one.positions[0], batch.positions[i])
            for found, expected in zip(one.vjp(cotangent[i]), gradient):
                np.testing.assert_array_equal(found[0], expected[i])
        self.assertGreater(np.abs(batch.positions[0] - batch.positions[1]).max(), 1e-4)

    def test_factors_are_those_of_the_table(self):
        bend = drapefit.make_material(self.wool.density, self.wool.stretch, 2 * self.wool.bend)
        both = self.simulator.drape([self.wool, bend], start=self.start, steps=10).positions
        factor = self.simulator.drape(self.wool, np.log([2.0]), self.start, steps=10).positions
        self.assert_relative(factor[0], both[1], 1e-12)
        self.assertGreater(np.abs(both[0] - both[1]).max(), 1e-6)

    def test_contact_and_scenes(self):
        for contact in ("support", "self"):
            simulator = drapefit.Simulator(self.simulator.mesh, contact=contact)
            drapes = simulator.drape(self.wool, start=self.start, steps=40)
            self.assertEqual(drapes.status, ["ok"])
        sphere = drapefit.Simulator(drapefit.disc(200), scene=SOURCE / "configs/scenes/sphere.json")
        drapes = sphere.drape(self.wool, steps=10)
        self.assertEqual(drapes.status, ["ok"])
        self.assertGreater(np.ptp(drapes.positions[0, :, 2]), 1e-3)

    def test_a_failed_drape_has_a_status_and_nan(self):
        velocity = np.zeros((2, *self.start.shape))
        velocity[1] = 1e300
        drapes = self.simulator.drape(self.wool, start=self.start, velocity=velocity, steps=3)
        self.assertEqual(drapes.status[0], "ok")
        self.assertEqual(drapes.status[1], "step matrix not positive definite")
        self.assertEqual(drapes.found.tolist(), [True, False])
        gradient = drapes.vjp(np.ones(velocity.shape))
        for rows in (drapes.positions, drapes.read("outline"), drapes.jvp([1.0] * 39),
                     *gradient, drapes.residual):
            self.assertTrue(np.isfinite(rows[0]).all())
            self.assertTrue(np.isnan(rows[1]).all())


class FilesTest(PythonTest):
    def test_materials_read_back_to_the_same_bytes(self):
        first, second = self.folder / "first.json", self.folder / "second.json"
        self.wool.write(str(first))
        again = drapefit.read_material(first)
        again.write(str(second))
        self.assertEqual(first.read_bytes(), second.read_bytes())
        made = drapefit.make_material(again.density, again.stretch, again.bend, again.name)
        self.assertEqual(made.stretch.tolist(), self.wool.stretch.tolist())
        self.assertEqual(made.bend.tolist(), self.wool.bend.tolist())
        self.assertEqual(made.stretch.shape, (6, 4))
        self.assertEqual(made.bend.tolist(), read_json(WOOL)["bend"])

    def test_meshes_are_those_of_the_programs(self):
        mesh = drapefit.disc(200)
        run_program("drape_simulate", "--mesh=disc:200", f"--fabric={WOOL}", "--steps=0",
                    f"--out={self.folder / 'out'}")
        expected = drapefit.read_mesh(self.folder / "out/drape.obj")
        self.assertEqual(mesh.vertices.tolist(), expected.vertices.tolist())
        self.assertEqual(mesh.faces.tolist(), expected.faces.tolist())
        again = drapefit.Mesh(mesh.vertices, mesh.faces)
        self.assertEqual(again.uv.tolist(), mesh.uv.tolist())
        self.assertEqual(len(mesh.vertices), 200)

    def test_folders(self):
        self.wool.write(str(self.folder / "material.json"))
        (self.folder / "outlines.json").write_text(
            '{"format": "drapefit-outlines", "drapes": [{"radius_m": [0.1, 0.2]}]}')
        results = drapefit.read_folder(self.folder)
        self.assertEqual(results["material"].bend.tolist(), self.wool.bend.tolist())
        self.assertEqual(results["outlines"].tolist(), [[0.1, 0.2]])


    def test_wheels_are_of_the_version_of_the_project(self):
        metadata = tomllib.loads((SOURCE / "tools/python/pyproject.toml").read_text())
        self.assertEqual(metadata["project"]["version"], os.environ["DRAPE_VERSION"])


class ErrorsTest(PythonTest):
    def test_bad_input_is_a_value_error_of_one_line(self):
        drape, refused = self.simulator.drape, self.assert_refused
        refused("no such file", drapefit.read_material, "absent.json")
        refused("no such file", drapefit.read_mesh, "absent.obj")
        refused("felt: key 'bend'", drapefit.make_material, 0.2, self.wool.stretch, [[1.0]], "felt")
        refused("felt: key 'density'", drapefit.make_material, -1.0, self.wool.stretch,
                self.wool.bend, "felt")
        refused("face 1", drapefit.Mesh, np.zeros((3, 3)), [[0, 1, 2]])
        refused("[V, 3]", drapefit.Mesh, np.zeros((3, 2)), [[0, 1, 2]])
        refused("disc: 7 vertices", drapefit.disc, 7)
        refused("found no JSON file", drapefit.read_folder, self.folder)
        mesh = self.simulator.mesh
        refused("backend: unknown name 'gpu'", drapefit.Simulator, mesh, backend="gpu")
        refused("threads: expected 0", drapefit.Simulator, mesh, threads=-1)
        refused("contact: found 'all'", drapefit.Simulator, mesh, contact="all")
        refused("no such file", drapefit.Simulator, mesh, scene="absent.json")
        refused("expected one of 1, 2, 3, 7, 39", drape, self.wool, np.zeros(4))
        refused("start: found the shape (5, 3)", drape, self.wool, start=np.zeros((5, 3)))
        refused("materials: found 2", drape, [self.wool] * 2, np.zeros((3, 1)))
        refused("drapes: found", drape, [], np.zeros((0, 1)))
        refused("h: found a time step of 0 s", drape, self.wool, h=0.0)
        refused("steps: found -1", drape, self.wool, steps=-1)
        refused("solve: found 'static'", drape, self.wool, solve="static")
        refused("log_factors: found a number that is not finite", drape, self.wool, [np.nan])
        refused("frames: found 7, expected ascending", drape, self.wool, steps=5, frames=[7])
        refused("frames: found 2, expected ascending", drape, self.wool, steps=5, frames=[2, 2])
        refused("frames: found some of an equilibrium", drape, self.wool, solve="hybrid",
                frames=[0])
        refused("dynamics: found -1 for air_drag", drape, self.wool, dynamics={"air_drag": -1})
        refused("dynamics: found the key 'drag'", drape, self.wool, dynamics={"drag": 1})
        refused("dynamics: found the shape (2,)", drape, self.wool, dynamics=[1.0, 2.0])
        drapes = drape(self.wool, steps=1)
        refused("readout: found 'area'", drapes.read, "area")
        refused("num_angles: found 0", drapes.read, "outline", num_angles=0)
        refused("half_width: found 0 px", drapes.read, "silhouette", half_width=0.0)
        refused("cotangent: found the shape [1, 5]", drapes.vjp, np.zeros(5), "outline")
        refused("log_factors: found the shape (2,)", drapes.jvp, [1.0, 2.0])
        refused("start: expected 3 finite", self.simulator.start_from_outline, [0.1])
        camera = self.simulator.camera
        camera.scale = -1.0
        refused("camera", drapes.read, "outline", camera=camera)


class ThreadsTest(PythonTest):
    def test_other_threads_run_meanwhile(self):
        counted, done = [0], threading.Event()

        def count():
            while not done.wait(0.001):
                counted[0] += 1

        thread = threading.Thread(target=count)
        thread.start()
        begin = time.monotonic()
        self.simulator.drape(self.wool, start=self.start, steps=400)
        seconds, ticks = time.monotonic() - begin, counted[0]
        done.set()
        thread.join()
        self.assertGreater(ticks, 20 * seconds)

    def test_ctrl_c_ends_each_call(self):
        for call in ENDLESS_CALLS:
            with self.subTest(call), subprocess.Popen(
                    [sys.executable, "-c", ENDLESS.format(material=str(WOOL), call=call)],
                    stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=os.environ) as child:
                child.stdout.readline()
                time.sleep(0.3)
                child.send_signal(signal.SIGINT)
                begin = time.monotonic()
                try:
                    output, errors = child.communicate(timeout=60)
                finally:
                    child.kill()
                with open("/proc/loadavg") as load:
                    waiting = float(load.read().split()[3].split("/")[0]) / os.cpu_count()
                self.assertLess(time.monotonic() - begin, 2 * max(1, waiting), errors)
                self.assertIn(b"interrupted", output)


if __name__ == "__main__":
    unittest.main()
