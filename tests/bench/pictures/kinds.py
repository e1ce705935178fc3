# SPDX-License-Identifier: Apache-2.0
"""The kinds of pictures: what varies in each, by random numbers with a fixed seed."""
import dataclasses

import numpy as np

import scenes
from render import Camera, Light
from scenes import Scene

GREYS = (0.06, 0.25, 0.5, 0.75, 0.95)
CLOTHS = ((0.16, 0.2, 0.45), (0.62, 0.14, 0.16), (0.12, 0.12, 0.13), (0.93, 0.9, 0.82),
          (0.2, 0.45, 0.25), (0.85, 0.7, 0.2), (0.55, 0.5, 0.62), (0.8, 0.55, 0.6),
          (0.95, 0.95, 0.94), (0.4, 0.3, 0.22))
LIGHT_GROUNDS = ((0.85, 0.84, 0.8), (0.66, 0.7, 0.72), (0.75, 0.66, 0.52), (0.93, 0.93, 0.93))
DARK_GROUNDS = ((0.2, 0.24, 0.22), (0.12, 0.2, 0.32), (0.3, 0.2, 0.14), (0.1, 0.1, 0.1))


@dataclasses.dataclass
class Picture:
    """How a picture is made and how a laboratory would measure it."""
    kind: str
    drape: object
    scene: Scene
    view: str                  # phone: perspective, measured by the disc; flat: of known scale
    specimen: float = None     # diameter that the user gives [m]; None: the default of 0.30
    focal_35mm: int = 0        # in the file
    dpi: float = 0             # in the file
    scale_given: bool = True   # flat: the user gives the scale
    mode: str = 'RGB'          # of the file
    suffix: str = 'jpg'
    quality: int = 90
    orientation: int = 1
    inverted: bool = False     # white on black
    expect: str = 'measure'    # or refuse: nothing right can be said


class Maker:
    """Random choices of one picture."""

    def __init__(self, rng, drapes):
        self.rng, self.drapes = rng, drapes

    def one(self, choices):
        return choices[self.rng.integers(len(choices))]

    def between(self, low, high):
        return self.rng.uniform(low, high)

    def drape(self, size=0.30):
        return self.one([drape for drape in self.drapes if abs(drape.size - size) < 1e-6])

    def light(self, low=1.0, high=4.0, soft=(0.01, 0.05), elevation=(35, 65)):
        return Light(self.between(low, high), self.between(0, 2 * np.pi),
                     np.radians(self.between(*elevation)), self.between(*soft))

    def contrasting(self):
        """Colours of cloth, ground and disc that a person would choose."""
        cloth = np.array(self.one(CLOTHS))
        ground = np.array(self.one(DARK_GROUNDS if cloth.mean() > 0.45 else LIGHT_GROUNDS))
        disc = (0.12, 0.12, 0.12) if cloth.mean() > 0.45 else (0.88, 0.87, 0.85)
        return cloth, ground, disc

    def phone_camera(self, tilt=8.0):
        """About 1 m above, aimed at the support; some with the second lens."""
        focal = int(self.one((24, 26, 26, 27, 28, 48, 52)))
        width = 1600 if focal < 40 else 1200
        angle, towards = np.radians(self.between(0, tilt)), self.between(0, 2 * np.pi)
        tilt_xy = angle * np.array([np.cos(towards), np.sin(towards)])
        height = self.between(0.85, 1.2)
        eye = (height * tilt_xy[1] + self.between(-0.03, 0.03),
               -height * tilt_xy[0] + self.between(-0.03, 0.03), height)
        return Camera.phone(width, width * 3 // 4, focal, eye, tilt_xy), focal

    def flat_camera(self, size=0.30, scale=None, room=(1.12, 1.4)):
        """Parallel light or a scanner: of known scale, turned a little."""
        scale = scale or self.between(1400, 2600)
        side = size * self.between(*room)
        width, height = int(scale * side * self.one((1.0, 1.0, 1.33))), int(scale * side)
        spare = 0.4 * (side - size)
        place = self.between(-spare, spare), self.between(-spare, spare)
        return Camera.flat(width, height, scale, place, self.between(0, 2 * np.pi))

    def phone(self, kind, drape, cloth, ground, disc, light, **changes):
        camera, focal = self.phone_camera(changes.pop('tilt', 8.0))
        picture = {key: changes.pop(key) for key in list(changes)
                   if key in Picture.__dataclass_fields__}
        look = dict(ground_z=self.between(-0.28, -0.12), occlusion=self.between(0.1, 0.5),
                    falloff=self.between(0, 0.25), falloff_angle=self.between(0, 6.28),
                    blur=self.between(0.5, 1.0), exposure=self.between(0.55, 0.88),
                    noise=self.between(0.003, 0.012))
        scene = Scene(camera, ground, cloth, disc, light, **{**look, **changes})
        settings = dict(focal_35mm=focal, quality=int(self.between(85, 95)),
                        orientation=int(self.one((1, 1, 3, 6, 8))))
        return Picture(kind, drape, scene, 'phone', **{**settings, **picture})

    def flat(self, kind, drape, cloth, ground, disc, light, **changes):
        camera = changes.pop('camera', None) or self.flat_camera(drape.size)
        changes.pop('tilt', None)
        picture = {key: changes.pop(key) for key in list(changes)
                   if key in Picture.__dataclass_fields__}
        look = dict(ground_z=self.between(-0.2, -0.1), occlusion=self.between(0, 0.3),
                    falloff=self.between(0, 0.15), falloff_angle=self.between(0, 6.28),
                    blur=self.between(0.6, 1.2), exposure=self.between(0.55, 0.88),
                    noise=self.between(0.003, 0.012), fine=2)
        scene = Scene(camera, ground, cloth, disc, light, **{**look, **changes})
        return Picture(kind, drape, scene, 'flat',
                       **{**dict(quality=int(self.between(80, 95))), **picture})

    def shot(self, view, *arguments, **changes):
        return (self.phone if view == 'phone' else self.flat)(*arguments, **changes)


def light_sides(m, view):
    """One-sided light of 1:1 to 4:1, plain cloth of any colour on a ground that differs."""
    cloth, ground, disc = m.contrasting()
    return m.shot(view, f'{view}: light from one side', m.drape(), scenes.lit_cloth(
        scenes.plain_cloth(cloth)), scenes.plain_ground(ground), scenes.opaque_disc(disc),
                  m.light())


def greys(m, view):
    """White to black cloth on white to black ground, the same grey among them."""
    cloth, ground = np.array([m.one(GREYS)] * 3), np.array([m.one(GREYS)] * 3)
    tint = m.rng.uniform(-0.03, 0.03, 3)
    disc = m.one([grey for grey in GREYS if abs(grey - cloth[0]) > 0.3])
    return m.shot(view, f'{view}: greys on greys', m.drape(), scenes.lit_cloth(
        scenes.plain_cloth(np.clip(cloth + tint, 0.02, 0.98))), scenes.plain_ground(ground),
                  scenes.opaque_disc([disc] * 3), m.light(1.0, 2.5))


def prints(m, view):
    """Stripes, checks, dots and flowers."""
    cloth, ground, disc = m.contrasting()
    second = np.array(m.one([c for c in CLOTHS if np.abs(np.array(c) - cloth).max() > 0.25 and
                             np.abs(np.array(c) - ground).max() > 0.2]))
    angle = m.between(0, np.pi)
    print_of = m.one((
        lambda: scenes.stripes(cloth, second, m.between(0.004, 0.02), angle),
        lambda: scenes.checks(cloth, second, m.between(0.004, 0.015), angle),
        lambda: scenes.dots(cloth, second, m.between(0.012, 0.03), m.between(0.003, 0.008), angle),
        lambda: scenes.flowers(cloth, [second, m.one(CLOTHS)], m.between(0.01, 0.025), m.rng)))()
    return m.shot(view, f'{view}: prints', m.drape(), scenes.lit_cloth(print_of),
                  scenes.plain_ground(ground), scenes.opaque_disc(disc), m.light(1.0, 3.0))


def shadows(m, view):
    """A dark shadow with a clear edge beside the cloth, as a lamp or the sun casts it."""
    cloth, ground, disc = m.contrasting()
    if m.rng.random() < 0.7:  # a light ground shows it best
        cloth, ground, disc = np.array(m.one([c for c in CLOTHS if np.mean(c) < 0.5])), m.one(
            LIGHT_GROUNDS), (0.88, 0.87, 0.85)
    return m.shot(view, f'{view}: cast shadow', m.drape(), scenes.lit_cloth(
        scenes.plain_cloth(cloth)), scenes.plain_ground(ground), scenes.opaque_disc(disc),
                  m.light(2.0, 4.0, (0.001, 0.006), (40, 65)))


def discs(m, view):
    """Discs on the cloth: black, white, clear."""
    cloth, ground, _ = m.contrasting()
    disc = m.one((lambda: scenes.opaque_disc((0.05, 0.05, 0.05)),
                  lambda: scenes.opaque_disc((0.96, 0.96, 0.95)),
                  lambda: scenes.clear_disc(m.one((0.45, 1.5)))))()
    return m.shot(view, f'{view}: black, white and clear discs', m.drape(), scenes.lit_cloth(
        scenes.plain_cloth(cloth)), scenes.plain_ground(ground), disc, m.light(1.0, 2.0))


def beside(m, view):
    """Rulers, labels and coins beside the cloth."""
    cloth, ground, disc = m.contrasting()
    drape = m.drape()
    things, start = [], m.between(0, 2 * np.pi)
    for number, thing in enumerate(m.rng.permutation(3)[:m.rng.integers(1, 4)]):
        at = start + 2.1 * number
        far = m.between(0.19, 0.24) if view == 'phone' else m.between(0.168, 0.18)
        place = far * np.array([np.cos(at), np.sin(at)])
        things.append((lambda: scenes.ruler(place, at + np.pi / 2, m.one(
            ((0.9, 0.85, 0.4), (0.75, 0.75, 0.78), (0.8, 0.65, 0.45))), width=0.025),
                       lambda: scenes.coin(place, m.between(0.0095, 0.013), m.one(
                           ((0.7, 0.55, 0.3), (0.65, 0.65, 0.66)))),
                       lambda: scenes.label(place, at + np.pi / 2, (0.93, 0.93, 0.9),
                                            (0.03, 0.011)))[thing]())
    extra = {} if view == 'phone' else {'camera': m.flat_camera(0.38, room=(1.05, 1.2))}
    return m.shot(view, f'{view}: rulers, labels, coins', drape, scenes.lit_cloth(
        scenes.plain_cloth(cloth)), scenes.with_things(scenes.plain_ground(ground), things),
                  scenes.opaque_disc(disc), m.light(1.0, 2.0), **extra)


def grounds(m, view):
    """Wood, millimetre paper, a cutting mat."""
    cloth, ground, disc = m.contrasting()
    dark = np.mean(ground) < 0.4
    ground = m.one((
        lambda: scenes.wooden_ground((0.33, 0.22, 0.14) if dark else (0.78, 0.66, 0.5)),
        lambda: scenes.ruled_ground((0.15, 0.3, 0.22), (0.75, 0.8, 0.7), 0.01, 0.0008) if dark
        else scenes.ruled_ground((0.95, 0.94, 0.9), (0.9, 0.6, 0.5), 0.01, 0.0006)))()
    return m.shot(view, f'{view}: wood, ruled paper, cutting mat', m.drape(), scenes.lit_cloth(
        scenes.plain_cloth(cloth)), ground, scenes.opaque_disc(disc), m.light(1.0, 2.0))


def backlit(m, view, frame):
    """Translucent cloth with an opaque disc on a light table."""
    size = m.one((0.24, 0.30, 0.30, 0.30, 0.36))
    half = (0.5 * size + m.between(0.012, 0.05) + (0.03 if view == 'phone' else 0)) * np.array(
        [1, m.between(1.0, 1.15)])
    table = scenes.light_table(half if frame else None, vignette=m.between(0, 0.15),
                               tint=m.one(((1, 1, 1), (1, 0.98, 0.93), (0.94, 0.97, 1))),
                               corner=m.one((0.0, m.between(0.01, 0.05))))
    disc = scenes.opaque_disc((0.06, 0.06, 0.06))
    cloth = scenes.backlit_cloth(m.between(0.06, 0.75), m.one(((1, 1, 1), (1, 0.95, 0.88),
                                                             (0.85, 0.92, 1), (1, 0.8, 0.8))))
    changes = dict(occlusion=0, exposure=m.between(0.85, 1.3), specimen=size)
    if view == 'flat':
        disc = m.one((disc, scenes.support_below(m.between(0.02, 0.3), m.between(0.001, 0.008))))
        camera = m.flat_camera(size, scale=m.between(1200, 2600), room=(1.3, 1.5) if frame else (
            1.12, 1.3))
        camera.eye[:2] *= 0.5
        changes.update(camera=camera)
    return m.shot(view, f'{view}: light table' + (' with a dark frame' if frame else ''),
                  m.drape(size), cloth, table, disc, None, **changes)


def sizes(m, view, right):
    """Specimens of 24, 30 and 36 cm, with the right diameter given or a wrong one."""
    size = m.one((0.24, 0.36))
    given = size
    if not right:
        size = m.one((0.24, 0.30, 0.36))
        given = m.one([other for other in (0.24, 0.30, 0.36) if abs(other - size) > 0.01])
        if m.rng.random() < 0.5 and size != 0.30:
            given = 0.30  # forgotten
    cloth, ground, disc = m.contrasting()
    return m.shot(view, f'{view}: size, {"right" if right else "wrong"}', m.drape(size),
                  scenes.lit_cloth(scenes.plain_cloth(cloth)), scenes.plain_ground(ground),
                  scenes.opaque_disc(disc), m.light(1.0, 2.0), specimen=given,
                  expect='measure' if right else 'refuse')


def poor(m, view):
    """Tilt of up to 12 degrees (phones), noise, strong JPEG, blur."""
    cloth, ground, disc = m.contrasting()
    return m.shot(view, f'{view}: tilt, noise, blur, strong JPEG', m.drape(), scenes.lit_cloth(
        scenes.plain_cloth(cloth)), scenes.plain_ground(ground), scenes.opaque_disc(disc),
                  m.light(1.0, 2.5), tilt=12.0, noise=m.between(0.015, 0.04),
                  blur=m.between(1.0, 1.8), quality=int(m.between(50, 75)))


def masks(m, view, inverted):
    """Black and white: made by another program, of one or eight bits."""
    drape = m.drape()
    dark, light = m.one(((0.0, 1.0), (0.0, 1.0), (0.1, 0.93)))
    cloth, ground = (light, dark) if inverted else (dark, light)
    return m.flat('flat: masks, ' + ('white on black' if inverted else 'black on white'), drape,
                  scenes.painted_cloth([cloth] * 3), scenes.plain_ground([ground] * 3, 0), None,
                  None, camera=m.flat_camera(0.30, scale=m.between(719.5, 2400)), falloff=0,
                  blur=m.one((0.01, 0.6)), exposure=1.0, noise=0, occlusion=0,
                  linear_file=True,
                  mode=m.one(('L', '1', 'RGB')), suffix='png', inverted=inverted)


def rings(m, view):
    """A paper ring, cut along the outline and along the support, on a scanner."""
    drape = m.drape()
    paper, lid = m.one((((0.93, 0.92, 0.88), (0.12, 0.12, 0.12)),
                        ((0.45, 0.62, 0.8), (0.96, 0.96, 0.96)),
                        ((0.3, 0.3, 0.3), (0.95, 0.95, 0.95)),
                        ((0.85, 0.75, 0.55), (0.08, 0.09, 0.12))))
    dpi = int(m.one((75, 100)))
    return m.flat('flat: paper rings, scanned', drape, scenes.painted_cloth(paper),
                  scenes.plain_ground(lid, 0.01), scenes.pale_hole(lid), None, dpi=dpi,
                  camera=m.flat_camera(0.30, scale=dpi / 0.0254), occlusion=0.1, falloff=0,
                  exposure=0.85)


def scans(m, view):
    """A cut-out or a print of the outline on a scanner; its file tells the dots an inch."""
    drape = m.drape()
    paper, lid = m.one((((0.2, 0.2, 0.2), (0.95, 0.95, 0.95)),
                        ((0.93, 0.92, 0.88), (0.15, 0.15, 0.15)),
                        ((0.7, 0.3, 0.25), (0.96, 0.96, 0.94))))
    dpi = int(m.one((72, 100, 100)))
    return m.flat('flat: scans, scale by their dpi', drape, scenes.painted_cloth(paper),
                  scenes.plain_ground(lid, 0.01), None, None, dpi=dpi, scale_given=False,
                  camera=m.flat_camera(0.30, scale=dpi / 0.0254), occlusion=0.1, falloff=0,
                  exposure=0.85)


KINDS = (
    [(light_sides, (view,)) for view in ('phone', 'flat')]
    + [(greys, (view,)) for view in ('phone', 'flat')]
    + [(prints, (view,)) for view in ('phone', 'flat')]
    + [(shadows, (view,)) for view in ('phone', 'flat')]
    + [(discs, (view,)) for view in ('phone', 'flat')]
    + [(beside, (view,)) for view in ('phone', 'flat')]
    + [(grounds, (view,)) for view in ('phone', 'flat')]
    + [(sizes, (view, right)) for right in (True, False) for view in ('phone', 'flat')]
    + [(backlit, ('phone', True)), (backlit, ('flat', False)), (backlit, ('flat', True))]
    + [(poor, (view,)) for view in ('phone', 'flat')]
    + [(masks, ('flat', False)), (masks, ('flat', True)), (rings, ('flat',)), (scans, ('flat',))])
