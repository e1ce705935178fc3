# SPDX-License-Identifier: Apache-2.0
"""What a picture shows beside the drape: grounds, things beside the cloth, prints, discs."""
import dataclasses
import typing

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from drapes import SUPPORT
from render import Camera, Light, at_samples, linear, smooth_noise, vertex_normals


@dataclasses.dataclass
class Scene:
    camera: Camera
    ground: typing.Callable          # (x, y [m], rng) → light [.., 3]
    cloth: typing.Callable           # what the samples of the cloth show
    disc: typing.Callable = None     # paints a disc; returns the samples that show it
    light: Light = None              # None: as it is painted
    ground_z: float = 0.0            # height of the ground [m]
    fine: int = 3                    # samples of a pixel in each direction
    occlusion: float = 0.0           # darkness of the ground beside the hem
    falloff: float = 0.0             # of the light over the picture
    falloff_angle: float = 0.0
    blur: float = 0.7                # standard deviation [px]
    exposure: float = 0.8            # light of the brightest pixels, 1: white
    noise: float = 0.008             # standard deviation, of 1
    linear_file: bool = False        # made by a program that mixes stored values


# Grounds: (x, y [m], rng) → light.

def plain_ground(colour, texture=0.02):
    def paint(x, y, rng):
        grain = 1 + texture * smooth_noise(x.shape, 2, rng) + texture * smooth_noise(
            x.shape, 40, rng)
        return linear(colour) * np.clip(grain, 0.5, 1.5)[..., None]
    return paint


def wooden_ground(colour, strength=0.12):
    def paint(x, y, rng):
        phase = rng.uniform(0, 9, 4)
        warp = 0.01 * np.sin(5 * x + phase[0]) + 0.004 * np.sin(23 * x + phase[1])
        rings = np.sin(2 * np.pi * (y + warp) / 0.023 + phase[2]) + 0.6 * np.sin(
            2 * np.pi * (y + 2 * warp) / 0.0071 + phase[3])
        return linear(colour) * (1 + strength * 0.5 * rings)[..., None]
    return paint


def ruled_ground(colour, line, step, width):
    """Millimetre paper or a cutting mat."""
    def paint(x, y, rng):
        pixel = abs(x[0, 1] - x[0, 0]) + abs(y[0, 1] - y[0, 0])
        near = np.minimum(np.abs((x + step / 2) % step - step / 2),
                          np.abs((y + step / 2) % step - step / 2))
        share = np.clip((width / 2 - near) / pixel + 0.5, 0, 1) * min(1, width / pixel)
        base = plain_ground(colour)(x, y, rng)
        return base + share[..., None] * (linear(line) - base)
    return paint


def light_table(frame, tint=(1.0, 1.0, 0.98), vignette=0.15, corner=0.0, dark=0.004):
    """A white field inside a dark frame; frame: half the sides [m], or None; corner: radius [m]."""
    def paint(x, y, rng):
        lit = 1 - vignette * (x**2 + y**2) / 0.2**2
        field = np.clip(lit, 0.2, 1)[..., None] * np.array(tint)
        if frame is None:
            return field
        pixel = abs(x[0, 1] - x[0, 0]) + abs(y[0, 1] - y[0, 0])
        beside, above = np.abs(x) - frame[0] + corner, np.abs(y) - frame[1] + corner
        out = np.hypot(np.maximum(beside, 0), np.maximum(above, 0)) + np.minimum(
            np.maximum(beside, above), 0) - corner
        share = np.clip(0.5 - out / (pixel + 0.1 * corner), 0, 1)[..., None]
        return share * field + (1 - share) * dark
    return paint


def with_things(ground, things):
    """Flat things that lie on the ground; each maps (x, y, pixel) to light and its share."""
    def paint(x, y, rng):
        light = ground(x, y, rng)
        pixel = np.hypot(x[0, 1] - x[0, 0], y[0, 1] - y[0, 0])
        for thing in things:
            colour, share = thing(x, y, pixel)
            light = light + share[..., None] * (colour - light)
        return light
    return paint


def box(x, y, place, angle, half):
    """Own coordinates of a rectangle, and how deep a point lies in it [m]."""
    c, s = np.cos(angle), np.sin(angle)
    u = c * (x - place[0]) + s * (y - place[1])
    v = -s * (x - place[0]) + c * (y - place[1])
    return u, v, np.minimum(half[0] - np.abs(u), half[1] - np.abs(v))


def ruler(place, angle, colour, length=0.31, width=0.03):
    def paint(x, y, pixel):
        u, v, depth = box(x, y, place, angle, (length / 2, width / 2))
        tick = np.abs((u + 0.005) % 0.01 - 0.005) < max(0.0005, pixel / 2)
        mark = (tick & (v > width / 2 - 0.008))[..., None]
        light = np.where(mark, 0.02, linear(colour) * np.ones((*x.shape, 1)))
        return light, np.clip(depth / pixel + 0.5, 0, 1)
    return paint


def coin(place, radius, colour):
    def paint(x, y, pixel):
        r = np.hypot(x - place[0], y - place[1])
        rim = np.abs(r - 0.88 * radius) < 0.0008
        light = linear(colour) * np.where(rim, 0.6, 1 + 0.2 * (x - place[0]) / radius)[..., None]
        return light, np.clip((radius - r) / pixel + 0.5, 0, 1)
    return paint


def label(place, angle, colour, half=(0.04, 0.02)):
    def paint(x, y, pixel):
        u, v, depth = box(x, y, place, angle, half)
        words = (np.abs((v + 0.004) % 0.008 - 0.004) < 0.001) & (
            np.sin(2 * np.pi * u / 0.006 + 9 * np.floor(v / 0.008)) > -0.4) & (depth > 0.004)
        light = np.where(words[..., None], 0.03, linear(colour) * np.ones((*x.shape, 1)))
        return light, np.clip(depth / pixel + 0.5, 0, 1)
    return paint


# Prints: places on the flat cloth [N, 2] → colours, linear [N, 3].

def plain_cloth(colour):
    return lambda uv: np.broadcast_to(linear(colour), (len(uv), 3))


def along(uv, angle):
    return uv @ [np.cos(angle), np.sin(angle)]


def stripes(first, second, width, angle):
    def paint(uv):
        return np.where((np.floor(along(uv, angle) / width) % 2 == 0)[:, None], linear(first),
                        linear(second))
    return paint


def checks(first, second, width, angle):
    """Gingham: both directions are striped, and their crossings are mixed half and half."""
    def paint(uv):
        share = 0.5 * ((np.floor(along(uv, angle) / width) % 2 == 0).astype(float) + (
            np.floor(along(uv, angle + np.pi / 2) / width) % 2 == 0))
        return linear(first) + share[:, None] * (linear(second) - linear(first))
    return paint


def dots(ground, colour, step, radius, angle):
    def paint(uv):
        a, b = along(uv, angle), along(uv, angle + np.pi / 2)
        row = np.floor(b / step)
        r = np.hypot((a + 0.5 * step * (row % 2)) % step - step / 2, b % step - step / 2)
        return np.where((r < radius)[:, None], linear(colour), linear(ground))
    return paint


def flowers(ground, colours, size, rng):
    """Flowers of five petals, with leaves between them."""
    reach = 0.2
    count = int((2 * reach / (2.2 * size))**2)
    place = rng.uniform(-reach, reach, (count, 2))
    turn, hue = rng.uniform(0, 6.28, count), rng.integers(0, len(colours), count)
    radius = size * rng.uniform(0.6, 1.1, count)
    tree = cKDTree(place)
    palette = np.array([linear(colour) for colour in colours])

    def paint(uv):
        _, which = tree.query(uv)
        d = uv - place[which]
        r, angle = np.hypot(d[:, 0], d[:, 1]), np.arctan2(d[:, 1], d[:, 0])
        petal = radius[which] * (0.65 + 0.35 * np.cos(5 * angle + turn[which]))
        light = np.where((r < petal)[:, None], palette[hue[which]], linear(ground))
        return np.where((r < 0.25 * radius[which])[:, None], linear((0.85, 0.7, 0.2)), light)
    return paint


# Cloth.

def lit_cloth(print_of, texture=0.03):
    """Cloth with a print in the light of the scene; darker where it hangs deep."""
    def paint(scene, drape, seen, hit, behind):
        normals = at_samples(seen, drape.faces, vertex_normals(drape.x, drape.faces))
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
        uv = at_samples(seen, drape.faces, drape.flat)
        height = at_samples(seen, drape.faces, drape.x[:, 2:])
        weave = 1 + texture * np.sin(uv[:, 0] * 2400) * np.sin(uv[:, 1] * 2400)
        shade = scene.light.on(normals) * weave * (1 + 2.0 * height[:, 0])
        return print_of(uv) * np.clip(shade, 0.01, None)[:, None]
    return paint


def backlit_cloth(transmission, tint, front=0.01):
    """Cloth on a light table: each layer lets a share through, less where it is steep."""
    def paint(scene, drape, seen, hit, behind):
        normals = at_samples(seen, drape.faces, vertex_normals(drape.x, drape.faces))
        layers = np.maximum(seen.layers[hit], 1) / np.clip(normals[:, 2], 0.3, 1)
        uv = at_samples(seen, drape.faces, drape.flat)
        weave = 1 + 0.03 * np.sin(uv[:, 0] * 2400) * np.sin(uv[:, 1] * 2400)
        through = np.array(tint) * (transmission**layers * weave)[:, None]
        # Light spreads in the cloth: what is behind counts by its mean.
        return np.median(behind[hit], axis=0) * through + front
    return paint


def painted_cloth(colour):
    """The same colour everywhere: a mask, or paper that was cut along the outline."""
    def paint(scene, drape, seen, hit, behind):
        return np.broadcast_to(linear(colour), (hit.sum(), 3))
    return paint


# Discs: paint on the samples and return those that show them.

def disc_radius(scene, seen):
    rows, columns = np.mgrid[0:seen.face.shape[0], 0:seen.face.shape[1]].astype(float)
    x, y = scene.camera.on_plane((columns + 0.5) / scene.fine - 0.5 + seen.left,
                                 (rows + 0.5) / scene.fine - 0.5 + seen.top, 0.0)
    return x, y, np.hypot(x, y)


def opaque_disc(colour, texture=0.02):
    def paint(scene, seen, samples):
        x, y, r = disc_radius(scene, seen)
        shine = 1 + 0.1 * (x + y) / SUPPORT + texture * gaussian_filter(
            np.sin(7919 * x + 104729 * y), 2)
        shown = r < SUPPORT
        rim = np.where(r > SUPPORT - 0.0012, 0.85, 1.0)
        samples[shown] = linear(colour) * (shine * rim)[shown][:, None]
        return shown
    return paint


def clear_disc(rim_light):
    """Acrylic: the cloth is seen through it, paler; its rim is a line, dark or bright."""
    def paint(scene, seen, samples):
        _, _, r = disc_radius(scene, seen)
        shown = r < SUPPORT
        samples[shown] = 0.88 * samples[shown] + 0.02
        rim = shown & (r > SUPPORT - 0.0022)
        samples[rim] = samples[rim] * rim_light + 0.03
        return shown
    return paint


def support_below(dark, soft):
    """The support under translucent cloth: a dark disc whose edge the cloth blurs [m]."""
    def paint(scene, seen, samples):
        _, _, r = disc_radius(scene, seen)
        share = np.clip((SUPPORT - r) / soft + 0.5, 0, 1)
        cloth = seen.face >= 0
        samples[cloth] *= (1 - share * (1 - dark))[cloth][:, None]
        return cloth & (r < SUPPORT)
    return paint


def pale_hole(colour):
    """The inner circle of a paper ring, where the ground is seen."""
    def paint(scene, seen, samples):
        _, _, r = disc_radius(scene, seen)
        shown = r < SUPPORT
        samples[shown] = linear(colour)
        return shown
    return paint
