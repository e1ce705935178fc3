# SPDX-License-Identifier: Apache-2.0
"""Drapes of known drape coefficient, simulated by drape_simulate."""
import dataclasses
import json
import pathlib
import subprocess

import numpy as np

from render import Camera, rasterise

ROOT = pathlib.Path(__file__).resolve().parents[3]
SUPPORT = 0.09  # radius [m]
SIZES = (0.24, 0.30, 0.36)  # diameters [m]
# Fabrics of the configs, and three of them with other bending stiffness.
FABRICS = [(name, 1.0) for name in (
    'cotton_blue', 'cotton_pink', 'cotton_white', 'synthetic_felt', 'synthetic_knit',
    'synthetic_shirt', 'synthetic_wool', 'viscose_white', 'wool_red')]
FABRICS += [('synthetic_wool', 6.0), ('synthetic_shirt', 3.0), ('cotton_pink', 0.5)]


@dataclasses.dataclass
class Drape:
    """A drape at rest, over a support whose axis is z; its upper rim is at z = 0."""
    name: str
    size: float           # diameter of the flat specimen [m]
    x: np.ndarray         # places of the vertices [m], shape [V, 3]
    flat: np.ndarray      # the same on the flat cloth [m], shape [V, 2]
    faces: np.ndarray     # shape [F, 3]
    coefficient: float    # of the vertical projection [%]


def coefficient_of_area(area, size):
    """The drape coefficient [%] of a projected area [m2]."""
    inner = np.pi * SUPPORT**2
    return 100 * (area - inner) / (np.pi * size**2 / 4 - inner)


def read_drape(path, name, size):
    x, flat, faces = [], [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ['v']:
            x.append([float(word) for word in words[1:4]])
        elif words[:1] == ['vt']:
            flat.append([float(word) for word in words[1:3]])
        elif words[:1] == ['f']:
            faces.append([int(word.split('/')[0]) - 1 for word in words[1:4]])
    x, flat, faces = np.array(x), np.array(flat), np.array(faces)
    # The area is counted here, not taken from the program that is measured.
    scale = 4000.0
    camera = Camera.flat(int(1.25 * size * scale), int(1.25 * size * scale), scale)
    area = (rasterise(camera, x, faces, 1).face >= 0).sum() / scale**2
    return Drape(name, size, x, flat, faces, coefficient_of_area(area, size))


def simulate(programs, folder, seed):
    """Simulates each fabric in each size, from random starts; keeps what is there already."""
    drapes = []
    for number, (fabric, stiffer) in enumerate(FABRICS):
        for size in SIZES:
            name = f'{fabric}_{stiffer:g}_{100 * size:.0f}'
            out = folder / name
            if not (out / 'drape.obj').exists():
                run_simulation(programs, out, fabric, stiffer, size,
                               np.random.default_rng([seed, number, int(100 * size)]))
            drapes.append(read_drape(out / 'drape.obj', name, size))
    return drapes


def run_simulation(programs, out, fabric, stiffer, size, rng):
    out.mkdir(parents=True, exist_ok=True)
    material = json.loads((ROOT / 'configs/fabrics' / f'{fabric}.json').read_text())
    material['bend'] = (stiffer * np.array(material['bend'])).tolist()
    (out / 'fabric.json').write_text(json.dumps(material))
    modes = [{'k': int(k), 'amplitude_m': rng.uniform(0.5e-3, 4e-3), 'phase': rng.uniform(0, 6.28)}
             for k in rng.choice(np.arange(2, 10), 4, replace=False)]
    (out / 'start.json').write_text(
        json.dumps({'format': 'drapefit-start-shape', 'version': 1, 'modes': modes}))
    subprocess.run([programs / 'drape_simulate', '--mesh=disc:1200', f'--fabric={out}/fabric.json',
                    '--min_relative_stiffness=0.1', f'--start={out}/start.json',
                    f'--specimen={size}', '--solve=hybrid', '--steps=80', f'--out={out}'],
                   stdout=subprocess.DEVNULL, check=True)
