# SPDX-License-Identifier: Apache-2.0
"""The painter of pictures against closed forms: a flat disc of cloth of known radius."""
import pathlib
import tempfile
import unittest

import numpy as np
from PIL import Image, ImageOps

import drapes
import kinds
import pictures
import render
import scenes
from render import Camera, Light

EYE, TILT = (0.1, -0.05, 1.0), np.radians([4.0, -6.0])


def flat_cloth(size=0.30, corners=720):
    """A disc in the plane of the support: its drape coefficient is 100 %."""
    angle = 2 * np.pi * np.arange(corners) / corners
    x = np.vstack([[0, 0, 0], np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1) * size / 2])
    number = np.arange(corners)
    faces = np.stack([0 * number, 1 + number, 1 + (number + 1) % corners], 1)
    return drapes.Drape('flat', size, x, x[:, :2], faces, 100.0)


def scene_of(camera, **changes):
    return scenes.Scene(camera, scenes.plain_ground((0.9, 0.9, 0.9), 0), scenes.lit_cloth(
        scenes.plain_cloth((0.2, 0.3, 0.5))), scenes.opaque_disc((0.9, 0.1, 0.1)),
                        Light(2.0, 0.5, 0.8, 0.01), **changes)


class PainterTest(unittest.TestCase):

    def test_area_of_flat_disc_is_its_drape_coefficient(self):
        cloth = flat_cloth()
        seen = render.rasterise(Camera.flat(700, 700, 2000), cloth.x, cloth.faces, 2)
        area = (seen.face >= 0).sum() / (2 * 2000)**2
        self.assertAlmostEqual(drapes.coefficient_of_area(area, 0.30), 100, delta=0.1)
        self.assertEqual(seen.layers.max(), 1)

    def test_point_on_plane_is_inverse_of_projection(self):
        for camera in (Camera.phone(1600, 1200, 26, EYE, TILT),
                       Camera.flat(800, 600, 1500, (0.01, 0.02), 0.7)):
            place, _ = camera.project(np.array([[0.07, -0.11, -0.2]]))
            x, y = camera.on_plane(place[:, 0], place[:, 1], -0.2)
            np.testing.assert_allclose([x[0], y[0]], [0.07, -0.11], atol=1e-9)

    def test_phone_magnifies_by_focal_length_over_distance(self):
        camera = Camera.phone(1600, 1200, 26, (0, 0, 1.25), np.zeros(2))
        place, _ = camera.project(np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0.25]]))
        focal = 26 * 2000 / 43.2666
        np.testing.assert_allclose(place - place[0], [[0, 0], [0.1 * focal / 1.25, 0],
                                                      [0, -0.1 * focal]], atol=1e-9)

    def test_cloth_towards_light_is_brighter_by_the_ratio(self):
        for ratio in (1.5, 2.0, 4.0):
            light = Light(ratio, 0.9, np.radians(50), 0.01)
            side = np.sin(np.radians(60)) * np.array([np.cos(0.9), np.sin(0.9)])
            towards, away = light.on(np.array([[*side, 0.5], [*-side, 0.5]]))
            # A little more than the ratio: steep cloth sees less of the light from everywhere.
            self.assertGreater(towards / away, 0.99 * ratio)
            self.assertLess(towards / away, 1.3 * ratio)

    def test_shadow_falls_away_from_the_light(self):
        camera, cloth = Camera.flat(900, 900, 1500), flat_cloth()
        shadow = render.shadow_on_ground(camera, cloth, Light(3, 0.0, np.radians(45), 1e-4), -0.1)
        columns = np.nonzero(shadow > 0.5)[1]
        self.assertAlmostEqual((columns.mean() - camera.middle[0]) / 1500, -0.1, delta=0.001)
        self.assertAlmostEqual((shadow > 0.5).sum() / 1500**2, np.pi * 0.15**2, delta=2e-4)

    def test_border_has_contrast_unless_colours_are_alike(self):
        rng = np.random.default_rng(1)
        for ground, low, high in (((0.9, 0.9, 0.9), 60, 256), ((0.2, 0.3, 0.5), 0, 40)):
            scene = scene_of(Camera.flat(500, 500, 1500), noise=0.0)
            scene.ground, scene.light = scenes.plain_ground(ground, 0), Light(1, 0, 1.2, 0.01)
            light, share, disc = render.render(scene, flat_cloth(), rng)
            contrast = render.border_contrast(render.develop(scene, light, share, rng), share, disc)
            self.assertTrue(low <= np.median(contrast) < high, np.median(contrast))

    def test_file_shows_what_was_painted_however_it_was_held(self):
        values = np.zeros((30, 40, 3), np.uint8)
        values[:10, :10] = 255
        for orientation in (1, 3, 6, 8):
            picture = kinds.Picture('kind', None, None, 'phone', focal_35mm=26, quality=95,
                                    orientation=orientation)
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / 'a.jpg'
                pictures.save(picture, values, path)
                image = Image.open(path)
                self.assertEqual(image.getexif().get_ifd(0x8769)[0xA405], 26)
                upright = np.asarray(ImageOps.exif_transpose(image))
            self.assertEqual(upright.shape, values.shape)
            self.assertLess(np.abs(upright.astype(float) - values).mean(), 10)

    def test_verdicts(self):
        row = {'dc': 40.0}
        for dc, sd, notes, verdict in ((40.5, 0.2, [], 'right'), (41, 0.2, [], 'silent'),
                                       (41, 0.2, ['shadow'], 'noted'), (40.9, None, [], 'right'),
                                       (41.1, None, [], 'silent')):
            self.assertEqual(pictures.judge(row, {'code': 0, 'dc': dc, 'sd': sd, 'notes': notes}),
                             verdict)
        self.assertEqual(pictures.judge(row, {'code': 2}), 'refused')
        self.assertEqual(pictures.judge(row, {'code': 139}), 'broken')


if __name__ == '__main__':
    unittest.main()
