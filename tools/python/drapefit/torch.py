# SPDX-License-Identifier: Apache-2.0
"""Drapes as a layer of PyTorch. PyTorch is no requirement of drapefit: import drapefit.torch."""

try:
    import torch
    from torch.autograd.function import once_differentiable
except ImportError as error:
    raise ImportError("drapefit.torch needs PyTorch: install python3-torch of Debian, or torch of "
                      "PyPI") from error


class _Drape(torch.autograd.Function):
    @staticmethod
    def forward(ctx, layer, *inputs):
        ctx.inputs = inputs
        ctx.layer = layer
        arrays = [None if each is None else each.detach().cpu().double().numpy() for each in inputs]
        ctx.drapes = layer.simulator.drape(layer.material, *arrays, **layer.options,
                                           record=any(ctx.needs_input_grad))
        given = [each for each in inputs if each is not None] or [torch.zeros(0).double()]
        return torch.as_tensor(ctx.drapes.read(layer.of, **layer.seen)).to(given[0])

    @staticmethod
    @once_differentiable
    def backward(ctx, cotangent):
        gradient = ctx.drapes.vjp(cotangent.cpu().double().numpy(), ctx.layer.of, **ctx.layer.seen)
        return None, *(torch.as_tensor(part).sum_to_size(each.shape).to(each) if wanted else None
                       for part, each, wanted in
                       zip(gradient, ctx.inputs, ctx.needs_input_grad[1:]))


class DrapeLayer(torch.nn.Module):
    """Maps log_factors [P] or [B, P], and if wanted start, velocity and dynamics, as
    Simulator.drape has them, to what `of` names of their drapes [B, ...] (Drapes), such as
    "positions", "outline" or "frames". `backward` is Drapes.vjp, computed in double precision on
    the simulator's backend; the result has the type and the device of the first input.
    A drape that fails is NaN, and so is its gradient: look at torch.isfinite before a step.

        layer = DrapeLayer(simulator, wool, of="frames", h=0.02, steps=20, frames=[10, 20])
        loss = (layer(log_factors) - seen).square().sum()
        loss.backward()
    """

    def __init__(self, simulator, material, of="positions", seen=None, **options):
        """seen: the options of Drapes.read, such as {"camera": …}; options: those of
        Simulator.drape, such as h and steps."""
        super().__init__()
        self.simulator, self.material, self.of = simulator, material, of
        self.seen, self.options = seen or {}, options

    def forward(self, log_factors=None, start=None, velocity=None, dynamics=None):
        return _Drape.apply(self, log_factors, start, velocity, dynamics)
