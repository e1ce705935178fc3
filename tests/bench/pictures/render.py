# SPDX-License-Identifier: Apache-2.0
"""Pictures of drapes, as a camera stores them: light adds up in each pixel.

World: metres, z up, z = 0 at the support. Colours are linear light, 0 … 1, red green blue.
"""
import dataclasses

import numpy as np
from scipy.ndimage import gaussian_filter, maximum_filter, zoom


class Camera:
    """Picture coordinates (column, row) from the world: pinhole or orthographic."""

    def __init__(self, width, height, focal, eye, turn, scale):
        self.width, self.height = width, height  # [px]
        self.focal, self.eye, self.turn = focal, eye, turn  # [px], [m], world from camera
        self.scale = scale  # of an orthographic camera [px/m]
        self.middle = np.array([0.5 * (width - 1), 0.5 * (height - 1)])

    @staticmethod
    def flat(width, height, scale, place=(0, 0), angle=0.0):
        """Looks straight down by parallel light; `angle` turns the picture."""
        c, s = np.cos(angle), np.sin(angle)
        return Camera(width, height, 0, np.array([*place, 0.0]),
                      np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), scale)

    @staticmethod
    def phone(width, height, focal_35mm, eye, tilt):
        """Pinhole above the drape, turned by `tilt` [rad] about x and y."""
        focal = focal_35mm * np.hypot(width, height) / 43.2666
        angle = np.hypot(*tilt)
        axis = np.array([tilt[0], tilt[1], 0]) / max(angle, 1e-12)
        cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
        return Camera(width, height, focal, np.array(eye), turn, 0)

    def project(self, x):
        """[N, 3] → columns and rows [px] [N, 2], and what grows towards the camera [N]."""
        own = (x - self.eye) @ self.turn
        if self.scale:
            return self.middle + own[:, :2] * [self.scale, -self.scale], own[:, 2]
        seen = self.focal * own[:, :2] / own[:, 2:]
        return self.middle + seen * [-1, 1], -1 / own[:, 2]

    def on_plane(self, columns, rows, z):
        """The points of the height z that the pixels see: x and y [m]."""
        across, up = columns - self.middle[0], self.middle[1] - rows
        if self.scale:
            own = np.stack([across, up], -1) / self.scale
            place = own @ self.turn[:2, :2].T
            return place[..., 0] + self.eye[0], place[..., 1] + self.eye[1]
        ray = np.stack([across / self.focal, up / self.focal, -np.ones_like(across)], -1)
        ray = ray @ self.turn.T
        far = (z - self.eye[2]) / ray[..., 2]
        return self.eye[0] + far * ray[..., 0], self.eye[1] + far * ray[..., 1]

    def pixels_per_metre(self, z=0.0):
        return self.scale or self.focal / (self.eye[2] - z)


@dataclasses.dataclass
class Seen:
    """What each sample of a window of the picture sees; `fine` samples a pixel and direction."""
    top: int                 # first row and column of the window [px]
    left: int
    face: np.ndarray         # −1: nothing
    weights: np.ndarray      # of the second and third corner, shape [.., 2]
    layers: np.ndarray       # of cloth that the ray crosses


def rasterise(camera, x, faces, fine, margin=2):
    place, near = camera.project(x)
    low = np.floor(place.min(0)).astype(int) - margin
    high = np.ceil(place.max(0)).astype(int) + margin + 1
    left, top = np.maximum(low, 0)
    right, bottom = np.minimum(high, [camera.width, camera.height])
    shape = (fine * (bottom - top), fine * (right - left))
    face = np.full(shape, -1, np.int32)
    weights = np.zeros((*shape, 2), np.float32)
    nearest = np.full(shape, -np.inf)
    layers = np.zeros(shape, np.float32)
    # Samples lie at the middles of the parts of a pixel.
    p = (place - [left, top] + 0.5) * fine - 0.5
    for number, (a, b, c) in enumerate(faces):
        corners = p[[a, b, c]]
        first = np.maximum(np.ceil(corners.min(0)).astype(int), 0)
        last = np.minimum(np.floor(corners.max(0)).astype(int), [shape[1] - 1, shape[0] - 1])
        if (last < first).any():
            continue
        (ax, ay), (bx, by), (cx, cy) = corners
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if abs(area) < 1e-9:
            continue
        dx = np.arange(first[0], last[0] + 1) - ax
        dy = (np.arange(first[1], last[1] + 1) - ay)[:, None]
        v = (dx * (cy - ay) - dy * (cx - ax)) / area
        w = (dy * (bx - ax) - dx * (by - ay)) / area
        inside = (v >= 0) & (w >= 0) & (v + w <= 1)
        window = (slice(first[1], last[1] + 1), slice(first[0], last[0] + 1))
        layers[window] += inside
        height = near[a] + v * (near[b] - near[a]) + w * (near[c] - near[a])
        inside &= height > nearest[window]
        nearest[window][inside] = height[inside]
        face[window][inside] = number
        weights[window][inside] = np.stack([v, w], -1)[inside]
    return Seen(top, left, face, weights, layers)


def at_samples(seen, faces, values):
    """Values of the vertices [V, n] at the samples that see cloth, shape [N, n]."""
    hit = seen.face >= 0
    corners = faces[seen.face[hit]]
    v, w = seen.weights[hit].astype(np.float64).T[..., None]
    return (1 - v - w) * values[corners[:, 0]] + v * values[corners[:, 1]] + w * values[
        corners[:, 2]]


def vertex_normals(x, faces):
    edges = x[faces[:, 1:]] - x[faces[:, :1]]
    area = np.cross(edges[:, 0], edges[:, 1])
    normals = np.zeros_like(x)
    for k in range(3):
        np.add.at(normals, faces[:, k], area)
    normals *= np.sign(normals[:, 2:] + 1e-12)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


@dataclasses.dataclass
class Light:
    """From one side: cloth that hangs towards it is about `ratio` times as bright as away from
    it, at a slope of 60 degrees."""
    ratio: float
    azimuth: float
    elevation: float      # [rad]
    soft: float           # width of a shadow's edge [m]

    def direction(self):
        flat = np.cos(self.elevation)
        return np.array([flat * np.cos(self.azimuth), flat * np.sin(self.azimuth),
                         np.sin(self.elevation)])

    def ambient(self):
        """The share that comes from everywhere, of the light on a table."""
        steep = np.radians(60)
        towards = np.cos(self.azimuth), np.sin(self.azimuth)
        to = self.direction()
        facing, away = (max(0.0, side * np.sin(steep) * (to[:2] @ towards) + np.cos(steep) * to[2])
                        / to[2] for side in (1, -1))
        share = (self.ratio * away - facing) / ((1 - facing) - self.ratio * (1 - away))
        return float(np.clip(share, 0.02, 1.0))

    def on(self, normals):
        share = self.ambient()
        direct = np.maximum(normals @ self.direction(), 0) / self.direction()[2]
        return share * (0.5 + 0.5 * normals[..., 2]) + (1 - share) * direct


def smooth_noise(shape, grain, rng):
    """Values of standard deviation 1 that vary over `grain` [px]."""
    coarse = rng.normal(size=[int(n / grain) + 3 for n in shape])
    values = zoom(coarse, grain, order=1)[:shape[0], :shape[1]]
    return values / max(values.std(), 1e-9)


def stored(light):
    """sRGB values 0 … 1 of linear light."""
    light = np.clip(light, 0, None)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light**(1 / 2.4) - 0.055)


def linear(colour):
    colour = np.asarray(colour, float)
    return np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055)**2.4)


def shadow_on_ground(camera, drape, light, ground_z):
    """The share of the direct light that each pixel of the ground lacks."""
    to = light.direction()
    cast = drape.x - to * ((drape.x[:, 2:] - ground_z) / to[2])
    mask = np.zeros((camera.height, camera.width), np.float32)
    seen = rasterise(camera, cast, drape.faces, 1)
    rows, columns = seen.face.shape
    mask[seen.top:seen.top + rows, seen.left:seen.left + columns] = seen.face >= 0
    return gaussian_filter(mask, max(0.3, light.soft * camera.pixels_per_metre(ground_z)))


def render(scene, drape, rng):
    """The picture [height, width, 3] in linear light, and the shares of cloth or disc and of the
    disc alone in each pixel."""
    camera, fine = scene.camera, scene.fine
    rows, columns = np.mgrid[0:camera.height, 0:camera.width].astype(float)
    gx, gy = camera.on_plane(columns, rows, scene.ground_z)
    picture = scene.ground(gx, gy, rng).astype(np.float32)
    if scene.light:
        share = scene.light.ambient()
        lit = share + (1 - share) * (1 - shadow_on_ground(camera, drape, scene.light,
                                                          scene.ground_z))
        picture *= lit[..., None]
    seen = rasterise(camera, drape.x, drape.faces, fine)
    height, width = (n // fine for n in seen.face.shape)
    window = (slice(seen.top, seen.top + height), slice(seen.left, seen.left + width))
    behind = picture[window].repeat(fine, 0).repeat(fine, 1)
    hit = seen.face >= 0
    samples = behind.copy()
    samples[hit] = scene.cloth(scene, drape, seen, hit, behind)
    disc = scene.disc(scene, seen, samples) if scene.disc else np.zeros_like(hit)
    covered = hit | disc
    pool = (height, fine, width, fine)
    if scene.occlusion:
        mask = np.zeros(picture.shape[:2], np.float32)
        mask[window] = covered.reshape(pool).mean((1, 3))
        dark = gaussian_filter(mask, 0.025 * camera.pixels_per_metre())
        picture *= (1 - scene.occlusion * dark)[..., None]
        samples[~covered] *= (1 - scene.occlusion * dark[window]).repeat(fine, 0).repeat(
            fine, 1)[~covered][:, None]
    picture[window] = samples.reshape(*pool, 3).mean((1, 3))
    shares = np.zeros((2, *picture.shape[:2]), np.float32)
    for share, shown in zip(shares, (covered, disc)):
        share[window] = shown.reshape(pool).mean((1, 3))
    return picture, *shares


def develop(scene, picture, share, rng):
    """8-bit values of the picture: uneven light, blur, exposure of ground and cloth, noise."""
    height, width = picture.shape[:2]
    ramp = np.linspace(-0.5, 0.5, width) * np.cos(scene.falloff_angle) + (
        np.linspace(-0.5, 0.5, height) * np.sin(scene.falloff_angle))[:, None]
    picture = picture * (1 + scene.falloff * ramp)[..., None]
    picture = gaussian_filter(picture, (scene.blur, scene.blur, 0))
    if scene.exposure < 1:  # else a light table, which may be too bright, or a mask
        bright = max(np.percentile(picture.max(2), 99), np.percentile(
            picture[share > 0.5].max(1), 97))
        picture = picture * min(scene.exposure / max(bright, 1e-3), 4.0)
    else:
        picture = picture * scene.exposure
    values = picture if scene.linear_file else stored(picture)
    noise = rng.normal(size=values.shape) * scene.noise
    return (255 * np.clip(values + noise, 0, 1) + 0.5).astype(np.uint8)


def border_contrast(image, share, disc, distance=3):
    """Differences of the picture across the border of the cloth, in 8-bit values, for each pixel
    of the border: largest of the channels. Left out is the border beside the disc, where the cloth
    is a strip of less than 2 `distance`."""
    smooth = gaussian_filter(image.astype(float), (1, 1, 0))
    soft = gaussian_filter(share, 2.0)
    gy, gx = np.gradient(soft)
    size = np.hypot(gx, gy)
    border = (np.abs(soft - 0.5) < 0.1) & (size > 0.02)
    apart = border & (maximum_filter(disc, 4 * distance + 1) < 0.5)
    rows, columns = np.nonzero(apart if apart.sum() > 40 else border)
    if len(rows) == 0:
        return np.zeros(1)
    across = np.stack([gy, gx])[:, rows, columns] / size[rows, columns]

    def at(step):
        row, column = np.rint(np.stack([rows, columns]) + step * across).astype(int)
        return smooth[np.clip(row, 0, image.shape[0] - 1), np.clip(column, 0, image.shape[1] - 1)]
    return np.abs(at(distance) - at(-distance)).max(1)
