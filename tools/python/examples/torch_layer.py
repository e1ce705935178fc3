# SPDX-License-Identifier: Apache-2.0
"""A drape as a layer of PyTorch: its outline as a function of factors on the tables and of the
start, differentiated by the exact adjoint. As a script: recovers the factors of three drapes by
L-BFGS.
usage: torch_layer.py <material>"""
import sys

import torch

import drapefit


class DrapeLayer(torch.autograd.Function):
    """simulator, material, log_factors [B, P], start [B, V, 3], what to read → [B, ...]"""

    @staticmethod
    def forward(ctx, simulator, material, log_factors, start, of, options):
        inputs = log_factors.detach().numpy(), start.detach().numpy()
        ctx.drapes = simulator.drape(material, *inputs, record=True, **options)
        ctx.of = of
        return torch.from_numpy(ctx.drapes.read(of))

    @staticmethod
    def backward(ctx, cotangent):
        found = ctx.drapes.vjp(cotangent.numpy(), ctx.of)
        by_inputs = torch.from_numpy(found.log_factors), torch.from_numpy(found.start)
        return None, None, *by_inputs, None, None


def main():
    material = drapefit.read_material(sys.argv[1])
    simulator = drapefit.Simulator(drapefit.disc(200))
    starts = torch.stack([torch.from_numpy(simulator.random_start(seed)) for seed in (1, 2, 3)])
    options = {"h": 0.1, "steps": 15}

    def outlines(factors):
        inputs = factors.expand(3, 2), starts
        return DrapeLayer.apply(simulator, material, *inputs, "outline", options)

    known = torch.tensor([0.1, 0.7], dtype=torch.float64)
    seen = outlines(known)
    factors = torch.zeros(2, dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.LBFGS([factors], max_iter=20, line_search_fn="strong_wolfe")

    def loss():
        optimiser.zero_grad()
        mean = torch.mean((outlines(factors) - seen) ** 2)
        mean.backward()
        return mean

    optimiser.step(loss)
    print(f"log factors {factors.tolist()}, known {known.tolist()}, loss {loss().item():.3g} px2")


if __name__ == "__main__":
    main()
