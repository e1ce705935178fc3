# SPDX-License-Identifier: Apache-2.0
"""Drapes of a fabric and their exact derivatives, fits and posteriors, as numpy arrays.

Units are SI: m, s, N/m (stretch), N m (bend), kg/m2; images and outlines are in px. Shapes: B
drapes of a batch, V vertices, F faces, P factors on the tables. Bad input raises ValueError with
one line that says what was expected. A drape that fails has another status than ok or stable, and
NaN for its numbers.
"""

import collections
import contextlib
import importlib
import json
import os
import pathlib

import numpy as np

from . import _core, experiment as _experiment
from ._core import Camera, Fit, Material, Posterior, Silhouette, read_camera
from .inference import inference_data

FEATURES = tuple(_core.FEATURES)
_NOT_GIVEN = float("nan")

Gradient = collections.namedtuple("Gradient", "log_factors start velocity dynamics")
Gradient.__doc__ = """Derivatives by log_factors [B, P], start [B, V, 3], velocity [B, V, 3] and
dynamics [B, 6]."""
DYNAMICS = ("mass_damping", "stiffness_damping", "air_drag", "wind_x", "wind_y", "wind_z")


def __getattr__(name):
    if name == "torch":  # is imported only where it is used
        return importlib.import_module(".torch", __name__)
    raise AttributeError(f"module 'drapefit' has no attribute '{name}'")


def _table(key, doc):
    return property(lambda self: np.array(json.loads(self.to_json())[key]), doc=doc)


Material.density = _table("density", "kg/m2")
Material.stretch = _table("stretch", "membrane stiffness, N/m, [6, 4]")
Material.bend = _table("bend", "plate rigidity, N m, [3, 5]")


def make_material(density, stretch, bend, name="material"):
    """density; stretch [6, 4]: c11 c12 c22 c33 without strain and strained at 0, 22.5, 45, 67.5 and
    90 degrees to the weft; bend [3, 5]: at 0, 45 and 90 degrees, by curvature."""
    keys = {"format": "drapefit-material", "version": 1, "convention": "mechanical", "name": name,
            "density": float(density), "stretch": np.asarray(stretch, float).tolist(),
            "bend": np.asarray(bend, float).tolist()}
    return Material(json.dumps(keys), name)


def read_material(path):
    """The Material of a file, or of FILE#NAME where it holds several."""
    return _core.read_material(str(path))


def read_folder(path):
    """What a program wrote: the content of each JSON file by its stem, such as summary; a table of
    a material is a Material, and outlines are radii in m, [N, K]."""
    results = {}
    for file in sorted(pathlib.Path(path).glob("*.json")):
        content = json.loads(file.read_text())
        kind = content.get("format") if isinstance(content, dict) else None
        if kind == "drapefit-material":
            content = read_material(file)
        elif kind == "drapefit-outlines":
            content = np.array([drape["radius_m"] for drape in content["drapes"]])
        results[file.stem] = content
    if not results:
        raise ValueError(f"{path}: found no JSON file, expected the results of a program")
    return results


class Mesh(_core.Mesh):
    """A cloth that is flat at rest: vertices [V, 3], faces [F, 3] counter-clockwise in the material
    coordinates uv [V, 2] (weft, warp), by default x and y."""

    def __init__(self, vertices, faces, uv=None):
        vertices = np.asarray(vertices, float)
        uv = vertices[:, :2] if uv is None else uv
        super().__init__(vertices, np.asarray(faces).tolist(), np.asarray(uv, float))

    vertices = property(lambda self: self.rest.reshape(-1, 3), doc="at rest, m, [V, 3]")
    faces = property(lambda self: np.array(super().faces), doc="indices of vertices, [F, 3]")

    def write(self, path, positions=None):
        """Writes an OBJ file of these positions [V, 3], or of the flat cloth."""
        super().write(str(path), np.ravel(self.rest if positions is None else positions))


def _mesh(mesh):
    return Mesh(mesh.rest.reshape(-1, 3), mesh.faces, mesh.uv)


def read_mesh(path, round_to_float=False):
    """The cloth of an OBJ file, "disc:VERTICES" or "strip:LENGTHxWIDTHxEDGES", as the programs
    have them; round_to_float: as the law reference takes it."""
    return _mesh(_core.read_mesh(str(path), round_to_float))


def disc(vertices=600):
    """The mesh disc:VERTICES of the programs: a specimen of 30 cm for a support of 18 cm."""
    return read_mesh(f"disc:{vertices}")


def read_silhouette(path, camera_file="", specimen=_NOT_GIVEN, support=_NOT_GIVEN):
    """The Silhouette of an image; camera_file: of drape_photo; specimen, support: diameters."""
    return _core.read_silhouette(str(path), str(camera_file), specimen, support)


@contextlib.contextmanager
def _plain_errors():
    """Leaves the folder of an error's file out where it was temporary."""
    try:
        yield
    except ValueError as error:
        raise ValueError(_experiment.without_folder(error)) from None


class Simulator(_core.Simulator):
    """A cloth, a Mesh or the name of one (read_mesh), in the scene "cusick", with contact "none",
    "support" or "self", or in another: a file, the name of one of configs/scenes, such as
    "two_corners", or a dictionary of the same form. specimen, support: diameters; backend: "cpu",
    "cuda" or "auto"; threads: 0 for all cores."""

    def __init__(self, mesh, scene="cusick", law="smooth", contact="none", specimen=_NOT_GIVEN,
                 support=_NOT_GIVEN, backend="cpu", threads=0):
        self.mesh = mesh if isinstance(mesh, Mesh) else read_mesh(mesh)
        with _experiment.temporary_folder() as folder, _plain_errors():
            if isinstance(scene, dict):
                scene = _experiment.write(scene, folder, "scene.json")
            elif str(scene) != "cusick":
                scene = _experiment.scene_path(scene)
            super().__init__(self.mesh, scene, law, contact, specimen, support, backend, threads)

    def random_start(self, seed, hem_rms=3e-3):
        """Positions [V, 3]: waves of this root mean square at the hem, m."""
        return super().random_start(seed, hem_rms).reshape(-1, 3)

    def start_from_outline(self, outline, lift=0.8):
        """Positions [V, 3]: flaps that hang below an outline [K] in m, the higher the less lift."""
        return super().start_from_outline(np.asarray(outline, float), lift).reshape(-1, 3)

    def read_start(self, path):
        """Positions and velocities [V, 3] of the file of a start shape or of a state."""
        return tuple(part.reshape(-1, 3) for part in super().read_start(str(path)))

    def drape(self, material, log_factors=None, start=None, velocity=None, dynamics=None, h=0.05,
              steps=100, solve="dynamic", record=False, frames=()):
        """The Drapes of one or more inputs: material, or a list; log_factors [P] or [B, P],
        logarithms of factors on 1 (bend), 2 (stretch, bend), 3 (rows of bend), 7 (columns of
        stretch, rows of bend) or 39 numbers (all entries, the default); start and velocity [V, 3]
        or [B, V, 3], flat and 0 by default; dynamics: [6] or [B, 6], numbers in the order of
        DYNAMICS [1/s, s, kg/m3, m/s], or a dictionary with any of mass_damping, stiffness_damping,
        air_drag and wind [3], as an experiment's motion has them. Takes steps of h; solve "hybrid"
        goes from there to the equilibrium. record: keep what vjp needs, which saves it a
        simulation. frames: the numbers of steps, ascending, after which Drapes.frames is seen."""
        return Drapes(self, material, (log_factors, start, velocity, _dynamics(dynamics)),
                      (h, steps, solve, record, list(frames)))


def _dynamics(given):
    if not isinstance(given, dict):
        return given
    unknown = set(given) - {*DYNAMICS[:3], "wind"}
    if unknown:
        raise ValueError(f"dynamics: found the key {min(unknown)!r}, expected mass_damping, "
                         "stiffness_damping, air_drag or wind")
    return [*(given.get(name, 0.0) for name in DYNAMICS[:3]), *given.get("wind", (0.0, 0.0, 0.0))]


_FRAMES = {"frames": 0, "frame_velocities": 1}


class Drapes(_core.Drapes):
    """B drapes. What is read of them is named by `of`: "positions" [V, 3]; "outline" [num_angles],
    px; "features" [9], named by FEATURES; "silhouette" [H, W], the coverage by cloth with a border
    of half_width px; "frames" and "frame_velocities" [T, V, 3]. Further options: camera, which by
    default sees the specimen without perspective, num_angles=360, half_width=1."""

    def __init__(self, simulator, material, inputs, options):
        materials = [material] if isinstance(material, Material) else list(material)
        rest = simulator.mesh.vertices
        given = [np.asarray(default if value is None else value, float) for value, default in
                 zip(inputs, (np.zeros(39), rest, 0 * rest, np.zeros(6)))]
        batch = max([len(materials)] + [len(array) for array, one in zip(given, (1, 2, 2, 1))
                                        if array.ndim > one])
        self._camera = simulator.camera
        self._shapes = [(batch, *given[0].shape[-1:]), (batch, *rest.shape), (batch, *rest.shape),
                        (batch, 6)]
        self._frames = (batch, len(options[-1]), *rest.shape)
        super().__init__(simulator, materials, self._inputs(*given), *options)

    positions = property(lambda self: super().positions.reshape(self._shapes[1]), doc="m")
    velocities = property(lambda self: super().velocities.reshape(self._shapes[1]), doc="m/s")
    found = property(lambda self: np.array(super().found), doc="whether there is a drape, [B]")
    frames = property(lambda self: self.read("frames"), doc="m, [B, T, V, 3]")
    frame_velocities = property(lambda self: self.read("frame_velocities"), doc="m/s, [B, T, V, 3]")

    def _inputs(self, *arrays):
        rows = []
        for name, array, shape in zip(Gradient._fields, arrays, self._shapes):
            array = np.zeros(shape) if array is None else np.asarray(array, float)
            try:
                rows.append(np.broadcast_to(array, shape).reshape(shape[0], np.prod(shape[1:])))
            except ValueError:
                found = f"{name}: found the shape {array.shape}"
                raise ValueError(f"{found}, expected {shape} or a part of it") from None
        return _core.DrapeInputs(*rows)

    def _shaped(self, rows, of, camera=None, **_):
        camera = camera or self._camera
        image = (len(rows), camera.height, camera.width)
        return rows.reshape({"positions": self._shapes[1], "silhouette": image}.get(of, rows.shape))

    def _choice(self, of, camera=None, num_angles=360, half_width=1.0):
        return _core.ReadoutChoice(of, camera or self._camera, num_angles, half_width)

    def read(self, of="positions", **seen):
        """What `of` names, [B, ...]; NaN for a drape that it cannot be read of."""
        if of in _FRAMES:
            return super().read_frames()[_FRAMES[of]].reshape(self._frames)
        return self._shaped(super().read(self._choice(of, **seen)), of, **seen)

    def jvp(self, log_factors=None, start=None, velocity=None, dynamics=None, of="positions",
            **seen):
        """Its change [B, ...] to first order in changes of the inputs; on the CPU."""
        change = self._inputs(log_factors, start, velocity, _dynamics(dynamics))
        if of in _FRAMES:
            return super().jvp_frames(change)[_FRAMES[of]].reshape(self._frames)
        return self._shaped(super().jvp(self._choice(of, **seen), change), of, **seen)

    def vjp(self, cotangent, of="positions", **seen):
        """The Gradient of a scalar, from its gradient [B, ...] by what `of` names."""
        rows = np.asarray(cotangent, float).reshape(self._shapes[0][0], -1)
        if of in _FRAMES:
            none = np.zeros((0, 0))
            found = super().vjp_frames(*((rows, none), (none, rows))[_FRAMES[of]])
        else:
            found = super().vjp(self._choice(of, **seen), rows)
        return Gradient(*(np.array(getattr(found, name)).reshape(shape)
                          for name, shape in zip(Gradient._fields, self._shapes)))


def _text(value):
    """An option's value as on a command line."""
    if isinstance(value, bool):
        return str(value).lower()
    return ",".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)


@contextlib.contextmanager
def _experiment_file(data):
    """The path of an experiment's file, made of a dictionary."""
    with _experiment.temporary_folder() as folder, _plain_errors():
        yield str(data if isinstance(data, (str, os.PathLike)) else
                  _experiment.write(data, folder, "experiment.json"))


def fit(data, material=None, **options):
    """The Fit of a fabric to silhouettes or to an experiment.

    data: the silhouettes of one or more images, with the material from whose tables the fit starts;
    or an experiment: a dictionary of the form of the file of drape_fit --experiment
    (configs/README.md), or the path of such a file, .json. In a dictionary these may be arrays:
    markers {"places": [N, 2] or "vertices": [N], "positions": [N, 3]}; points [N, 3]; shape and
    start [V, 3]; depth [H, W], m, NaN where nothing is measured, or whole numbers of
    metres_per_count; silhouette [H, W], coverage by cloth from 0 to 1. `mesh` may be a Mesh,
    `material` a Material, a camera a Camera, a lab_test a dictionary, a scene one of
    configs/scenes by its name. Paths are relative to the current folder.
    options: those of drape_fit by their names (drape_fit --help=all), such as model="bayes",
    num_parameters=2, density=0.15, mesh="disc:1200"; threads=0 for all cores."""
    texts = {key: _text(value) for key, value in options.items()}
    is_path = isinstance(data, (str, os.PathLike))
    if isinstance(data, dict) or is_path and str(data).endswith(".json"):
        if material is not None:
            raise ValueError("material: found one beside an experiment, expected it in its key "
                             "'material'")
        with _experiment_file(data) as path:
            return _core.fit_experiment(path, texts)
    if material is None:
        raise ValueError("material: found nothing beside images, expected the start tables")
    images = [data] if is_path else data
    return _core.fit([str(image) for image in images], material, texts)


Measurement = collections.namedtuple("Measurement", "experiment name count misfit largest")
Measurement.__doc__ = """A measurement of an experiment beside the fitted cloth: how many numbers it
has, the root mean square of their residuals as their loss counts them, and the largest [sigma]."""
Fit.measurements = property(
    lambda self: [Measurement(each[0], _experiment.without_folder(each[1]), *each[2:])
                  for each in self._measurements],
    doc="each Measurement of an experiment")
FittedDynamics = collections.namedtuple("FittedDynamics", "value sd interval")
FittedDynamics.__doc__ = """What is fitted beside the tables and its interval of 90 %: a number, with
the deviation of its logarithm, or a vector [3] (wind, velocity), with the deviations [m/s]."""


def _fitted_dynamics(values, sd):
    if len(values) == 1:
        value, spread = values[0], np.exp(1.645 * sd[0])
        return FittedDynamics(value, sd[0], (value / spread, value * spread))
    value, spread = np.array(values), 1.645 * np.array(sd)
    return FittedDynamics(value, np.array(sd), (value - spread, value + spread))


Fit.dynamics = property(
    lambda self: {name: _fitted_dynamics(values, sd) for name, values, sd in self._dynamics},
    doc="by name: the FittedDynamics of an experiment")
Fit.mesh = property(lambda self: _mesh(self._mesh), doc="the Mesh of the fitted drapes")
Fit.drapes = property(lambda self: self._drapes.reshape(-1, len(self._mesh.rest) // 3, 3),
                      doc="the fitted drape of each image, or of the first experiment at rest, "
                          "m, [N, V, 3]")


class Residuals(_core.Residuals):
    """The residuals of an experiment as a function of theta [P], for an optimiser or a sampler of your
    own: log factors on the start tables, as many as num_parameters= says, and the numbers that the
    file fits beside them. Half their squares are the cost of the data; the prior is up to you.

    experiment: as fit takes it; options: as fit takes them. The cloth at rest is on the branch on
    which it falls under the start tables, pulled by its measurements."""

    def __init__(self, experiment, **options):
        with _experiment_file(experiment) as path:
            super().__init__(path, {key: _text(value) for key, value in options.items()})

    def __call__(self, theta):
        """The residuals [N], or None where a cloth is not found or has left its branch."""
        return self.evaluate(theta)

    def with_jacobian(self, theta):
        """The residuals [N] and their Jacobian [N, P], or None. The branch is followed from here."""
        return self.linearise(theta)

    def follow(self):
        """Lets the next evaluations start from the cloths of the last one."""
        self.start_from_last()


def sample_posterior(fit, count=1000, seed=1):
    """The Posterior of a fit by model bayes: samples of the fabric, as Materials, and of each quantity
    of Fit.sheet."""
    return _core.sample_posterior(fit, count, seed)


Posterior.quantities = property(
    lambda self: {quantity.key: quantity for quantity in self._quantities},
    doc="by key: name, unit, samples [count], interval, and whether the data have measured it")


WornGarment = collections.namedtuple(
    "WornGarment", "time garment garment_faces body body_faces smallest_gap intersections")
WornGarment.__doc__ = "Frames [T, V, 3], m, the smallest gap, m, and how many faces have met."


def wear(pattern, material, body="mannequin:walk", edge=0.012, frames=100, friction=0.3,
         self_contact=True, law="smooth", threads=0):
    """The WornGarment of a sewing pattern's file: frames of 0.04 s on a body of drape_garment; edge:
    of the triangles, m; friction: with the body. Raises where a step fails or it slides off."""
    time, garment, faces, wearer, *rest = _core.wear(
        str(pattern), material, str(body), edge, frames, friction, self_contact, law, threads)
    garment, wearer = (x.reshape(len(time), -1, 3) for x in (garment, wearer))
    return WornGarment(time, garment, faces, wearer, *rest)
