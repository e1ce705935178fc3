# SPDX-License-Identifier: Apache-2.0
"""Fits, posteriors and garments of the Python module."""
import unittest

import numpy as np

import drapefit
from python_fixture import SIX_WAVES, SOURCE, WOOL, PythonTest, run_program

QUICK = {"mesh": "disc:150", "coarse_mesh": "disc:100", "initial_stretch": [1],
         "initial_bend": [0.5, 1], "initial_lifts": [0.5, 1], "candidates_per_round": [3, 2, 1],
         "iterations": [4, 4, 6], "num_parameters": 2, "simpler_models": False, "threads": 2}


class FitsTest(PythonTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.simulator = drapefit.Simulator(drapefit.disc(150), threads=2)

    def silhouette(self):
        run_program("drape_simulate", "--mesh=disc:150", f"--fabric={WOOL}",
                    f"--start={SIX_WAVES}", "--solve=hybrid", "--time_step=0.1", "--steps=60",
                    f"--out={self.folder / 'drape'}")
        return self.folder / "drape/silhouette.png"

    def test_a_fit_is_that_of_drape_fit(self):
        image = self.silhouette()
        fit = drapefit.fit(image, self.wool, density=0.2, **QUICK)
        self.assertTrue(fit.fitted)
        flags = [f"--{key}={drapefit._text(value)}" for key, value in QUICK.items()]
        run_program("drape_fit", f"--images={image}", f"--fabric={WOOL}", "--density=0.2", *flags,
                    f"--out={self.folder / 'fit'}")
        results = drapefit.read_folder(self.folder / "fit")
        self.assertEqual(fit.material.bend.tolist(), results["material"].bend.tolist())
        self.assertEqual(fit.material.stretch.tolist(), results["material"].stretch.tolist())
        self.assertEqual(fit.material.density, 0.2)
        self.assertEqual(fit.grade, results["summary"]["verdict"]["grade"])
        self.assertEqual(fit.drapes.shape, (1, 150, 3))
        self.assertEqual(len(fit.mesh.vertices), 150)
        sources = {row.key: row.source for row in fit.sheet}
        self.assertEqual(sources["mass_g_per_m2"], "given")
        self.assertEqual(sources["bending_in_drape_un_m"], "measured")
        bend, = (row for row in fit.sheet if row.key == "bending_in_drape_un_m")
        self.assertTrue(bend.interval[0] < bend.value < bend.interval[1])

    def test_a_posterior_says_what_is_measured(self):
        fit = drapefit.fit([self.silhouette()], self.wool, model="bayes", posterior_samples=4,
                           posterior_iterations=4, elbo_samples=25, **QUICK)
        posterior = drapefit.sample_posterior(fit, 50, seed=3)
        again = drapefit.sample_posterior(fit, 50, seed=3)
        self.assertEqual(len(posterior.fabrics), 50)
        self.assertEqual(posterior.fabrics[7].bend.tolist(), again.fabrics[7].bend.tolist())
        bend = posterior.quantities["bending_in_drape_un_m"]
        self.assertTrue(bend.measured)
        self.assertEqual((bend.samples.shape, bend.unit), ((50,), "µN·m"))
        self.assertGreater(np.ptp(bend.samples), 0.0)
        shear = posterior.quantities["shear_n_per_m"]
        self.assertFalse(shear.measured)
        self.assertEqual(shear.source, "from the prior")
        drapes = self.simulator.drape(posterior.fabrics[:2], start=fit.drapes[0], h=0.1, steps=5)
        self.assertEqual(drapes.status, ["ok", "ok"])
        self.assert_refused("expected one by model bayes", drapefit.sample_posterior,
                            drapefit.fit(self.silhouette(), self.wool, **QUICK))

    def test_bad_input_is_a_value_error_of_one_line(self):
        self.assert_refused("found nothing", drapefit.fit, [], self.wool)
        self.assert_refused("no such file", drapefit.fit, "absent.png", self.wool)
        self.assert_refused("fit: unknown option 'colour'", drapefit.fit, [], self.wool, colour=1)
        self.assert_refused("fit: unknown option 'out'", drapefit.fit, [], self.wool, out="out")
        self.assert_refused("option 'mesh_size'", drapefit.fit, [], self.wool, mesh_size=[1, 2])
        self.assert_refused("no such file", drapefit.wear, "absent.json", self.wool)


class GarmentsTest(PythonTest):
    def test_a_skirt_is_worn(self):
        skirt = SOURCE / "configs/garments/circle_skirt.json"
        worn = drapefit.wear(skirt, self.wool, body="mannequin:stand", edge=0.08, frames=2, threads=2)
        self.assertEqual(worn.garment.shape[0], 3)
        self.assertEqual(worn.body.shape[::2], (3, 3))
        self.assertAlmostEqual(worn.time[-1], 0.08)
        self.assertGreater(worn.smallest_gap, 0.0)
        self.assertLess(np.max(worn.garment_faces), worn.garment.shape[1])
        self.assertLess(np.max(worn.body_faces), worn.body.shape[1])


if __name__ == "__main__":
    unittest.main()
