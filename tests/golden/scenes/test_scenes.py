"""What the scenes are made of, and how two scenes and two pictures are compared."""

import copy
import math
import unittest

import numpy
from visualization_msgs.msg import Marker

from . import files, geometry, messages, recorder, scene, scores


class Comparison(unittest.TestCase):
    def setUp(self):
        self.made = scene.make("cam_upside_down")

    def difference(self, change):
        changed = copy.deepcopy(self.made.messages())
        change(changed)
        return files.difference_of_messages(changed, self.made.messages())

    def test_a_scene_is_the_same_as_itself(self):
        self.assertIsNone(self.difference(lambda messages: None))

    def test_another_number_text_time_or_topic_is_a_difference(self):
        def marker(found):
            return found[2][1].markers[0]

        self.assertIn("scale.x", self.difference(lambda found: setattr(marker(found).scale, "x", 0.400001)))
        self.assertIn("ns", self.difference(lambda found: setattr(marker(found), "ns", "other")))
        self.assertIn("type", self.difference(lambda found: setattr(marker(found), "type", Marker.CUBE)))
        self.assertIn("frame_id", self.difference(lambda found: setattr(found[1][1].header, "frame_id", "other")))
        self.assertIn("0.5 s", self.difference(lambda found: found.append((*found.pop()[:2], 0.5))))
        self.assertIn("topics", self.difference(lambda found: found.append(found[0])))

    def test_numbering_and_the_sign_of_a_quaternion_are_none(self):
        def change(found):
            found[1][1].header.seq = 7
            rotation = found[0][1].transforms[0].transform.rotation
            for axis in "xyzw":
                setattr(rotation, axis, -getattr(rotation, axis))

        self.assertIsNone(self.difference(change))

    def test_configs_differ_by_a_value_a_type_or_a_key(self):
        config = {"a": [1, {"b": 0.5}], "c": True}
        self.assertIsNone(files.difference_of_values(config, copy.deepcopy(config)))
        self.assertIn("/a/1/b", files.difference_of_values(config, {"a": [1, {"b": 0.6}], "c": True}))
        self.assertIn("/c", files.difference_of_values(config, {"a": [1, {"b": 0.5}], "c": 1}))
        self.assertIn("/d", files.difference_of_values(config, {**config, "d": 0}))


class Geometry(unittest.TestCase):
    def test_a_camera_looks_at_its_target_with_a_level_upper_edge(self):
        eye, target = (1.6, 1.1, 1.5), (0.0, 0.0, 0.15)
        rotation = geometry.look_at(eye, target)
        ahead = turned(rotation, (0, 0, 1))
        wanted = numpy.subtract(target, eye) / numpy.linalg.norm(numpy.subtract(target, eye))
        numpy.testing.assert_allclose(ahead, wanted, atol=1e-12)
        self.assertAlmostEqual(turned(rotation, (1, 0, 0))[2], 0.0)
        self.assertLess(turned(rotation, (0, 1, 0))[2], 0.0)

    def test_a_turn_is_about_the_fixed_axes_x_then_y_then_z(self):
        rotation = geometry.turn(math.pi / 2, 0.0, math.pi / 2)
        numpy.testing.assert_allclose(turned(rotation, (0, 1, 0)), (0, 0, 1), atol=1e-12)
        numpy.testing.assert_allclose(turned(rotation, (1, 0, 0)), (0, 1, 0), atol=1e-12)


def turned(rotation, vector):
    """A vector after a rotation."""
    axis = numpy.array((rotation.x, rotation.y, rotation.z))
    across = 2 * numpy.cross(axis, vector)
    return vector + rotation.w * across + numpy.cross(axis, across)


class Pictures(unittest.TestCase):
    def test_encodings_become_rgb(self):
        from sensor_msgs.msg import Image
        # One red and one blue pixel, and bytes at the end of the row.
        for encoding, pixels in {"rgb8": [9, 0, 0, 0, 0, 7], "bgr8": [0, 0, 9, 7, 0, 0], "rgba8": [9, 0, 0, 255, 0, 0, 7, 255],
                                 "bgra8": [0, 0, 9, 255, 7, 0, 0, 255]}.items():
            image = Image(width=2, height=1, step=len(pixels) + 3, encoding=encoding, data=bytes(pixels + [1, 2, 3]))
            self.assertEqual(recorder.picture_of(image).pixels.tolist(), [[[9, 0, 0], [0, 0, 7]]], encoding)
        grey = Image(width=2, height=1, step=4, encoding="mono16", data=bytes([1, 2, 3, 4]))
        self.assertEqual(recorder.picture_of(grey).pixels.tolist(), [[0x0201, 0x0403]])
        with self.assertRaises(ValueError):
            recorder.picture_of(Image(encoding="8UC1"))

    def test_scores_forgive_one_pixel_but_not_two(self):
        picture = numpy.zeros((9, 9, 3), numpy.uint8)
        picture[4, 4] = 200
        self.assertEqual(scores.scores(picture, picture), scores.Scores(0, 0, 1.0, 1.0, 1))
        self.assertEqual(scores.scores(picture, numpy.roll(picture, 1, axis=0)), scores.Scores(2, 200, 0.0, 1.0, 2))
        self.assertEqual(scores.scores(picture, numpy.roll(picture, 2, axis=0)), scores.Scores(2, 200, 0.0, 0.0, 2))

    def test_a_comparison_shows_both_pictures_and_what_is_not_close(self):
        picture = numpy.zeros((9, 9), numpy.uint16)
        picture[4, 4] = 200 * 257
        shown = scores.comparison(picture, numpy.roll(picture, 2, axis=0))
        self.assertEqual(shown.shape, (9, 27, 3))
        self.assertEqual(shown[4, 4].tolist(), [200, 200, 200])
        self.assertEqual([shown[row, 9 + 4].tolist() for row in (4, 5, 6)], [[255, 0, 255], [0, 0, 0], [255, 0, 255]])
        self.assertEqual(shown[6, 18 + 4].tolist(), [200, 200, 200])


class Messages(unittest.TestCase):
    def test_a_covariance_has_its_diagonal_and_what_is_on_both_sides_of_it(self):
        values = messages.covariance(1, 2, 3, 4, 5, 6, {(0, 5): 0.5})
        self.assertEqual((values[0], values[7], values[35], values[5], values[30]), (1, 2, 6, 0.5, 0.5))


if __name__ == "__main__":
    unittest.main()
