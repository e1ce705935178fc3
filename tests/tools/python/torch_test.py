# SPDX-License-Identifier: Apache-2.0
"""Drapes as a layer of PyTorch, against differences. Skipped, with the reason, without PyTorch."""
import subprocess
import sys
import unittest

import numpy as np

import drapefit
from python_fixture import PythonTest

try:
    import torch
except ImportError as error:
    print("needs PyTorch:", error)
    sys.exit(77)


class TorchTest(PythonTest):
    def setUp(self):
        super().setUp()
        torch.manual_seed(3)
        self.strip = drapefit.Simulator("strip:0.1x0.04x3", {
            "gravity": [0, 0, -9.81], "handles": {"vertices": [0, 4], "stiffness": 1e3}}, threads=1)

    def test_gradcheck_of_all_inputs(self):
        """Differences of every output by every input."""
        shape = self.strip.mesh.vertices.shape
        start = torch.tensor(self.strip.mesh.vertices) + 1e-3 * torch.randn(shape).double()
        inputs = [0.1 * torch.randn(2, 2).double(), start, 0.1 * torch.randn(2, *shape).double(),
                  torch.tensor([1.0, 0.01, 0.5, 1.0, 0.0, 0.5]).double()]
        for of in ("positions", "frames", "frame_velocities"):
            layer = drapefit.torch.DrapeLayer(self.strip, self.wool, of=of, h=0.02, steps=4,
                                              frames=[2, 4])
            given = [each.clone().requires_grad_() for each in inputs]
            self.assertTrue(torch.autograd.gradcheck(layer, given, eps=1e-7, atol=1e-5, rtol=1e-4))

    def test_equilibria_and_readouts_have_gradients(self):
        layer = drapefit.torch.DrapeLayer(self.simulator, self.wool, of="outline", h=0.1, steps=60,
                                          solve="hybrid", seen={"num_angles": 24})
        factors = torch.zeros(2, dtype=torch.float32, requires_grad=True)
        outline = layer(factors, start=torch.tensor(self.start))
        self.assertEqual((outline.shape, outline.dtype), ((1, 24), torch.float32))
        outline.square().sum().backward()
        drapes = self.simulator.drape(self.wool, [0.0, 0.0], self.start, h=0.1, steps=60,
                                      solve="hybrid")
        radii = drapes.read("outline", num_angles=24)
        expected = drapes.vjp(2 * radii, of="outline", num_angles=24).log_factors[0]
        self.assertEqual(factors.grad.dtype, torch.float32)
        self.assert_relative(factors.grad.numpy(), expected, 1e-5)

    def test_an_optimiser_finds_a_factor(self):
        layer = drapefit.torch.DrapeLayer(self.strip, self.wool, h=0.02, steps=10)
        seen = layer(torch.tensor([0.0, 0.7]).double())
        factor = torch.zeros(2, dtype=torch.float64, requires_grad=True)
        optimiser = torch.optim.LBFGS([factor], max_iter=30, line_search_fn="strong_wolfe")

        def closure():
            optimiser.zero_grad()
            loss = 1e6 * (layer(factor) - seen).square().sum()
            loss.backward()
            return loss

        optimiser.step(closure)
        np.testing.assert_allclose(factor.detach().numpy(), [0.0, 0.7], atol=1e-3)

    def test_without_pytorch_the_message_says_what_to_install(self):
        code = "import sys; sys.modules['torch'] = None; import drapefit; drapefit.torch"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        self.assertIn("ImportError: drapefit.torch needs PyTorch: install", done.stderr)


if __name__ == "__main__":
    unittest.main()
