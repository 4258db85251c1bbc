"""The bags are what the scenes make, and the real rviz draws the pictures again, pixel for pixel. Only in `./test full`."""

import os
import pathlib
import tempfile
import unittest

from . import golden, scene

PREFIX = os.environ.get("RVIZ_PLUGIN_PREFIX", "")
# One of each kind: several messages of a cloud, a mesh with a texture and text, a robot with a parameter and a grey picture.
CASES = ["pc2_decay_three_clouds_translucent", "scene_all_kinds_in_groups", "robot_model", "cam_encoding_mono16"]


@unittest.skipUnless(os.environ.get("MANY_SEEDS"), "MANY_SEEDS is not set: only in ./test full")
class Regenerate(unittest.TestCase):
    def test_every_case_has_a_function_and_every_function_a_case(self):
        self.assertEqual(sorted(golden.descriptions()), list(scene.all_cases()))

    def test_bags_are_what_the_scenes_make(self):
        different = {name: said for name in scene.all_cases() if (said := golden.differences(name))}
        self.assertEqual(different, {}, "tests/golden/regenerate CASE writes the bag of a scene that was changed")

    @unittest.skipUnless(PREFIX, "RVIZ_PLUGIN_PREFIX is not set: where the plugin is installed")
    def test_pictures_are_the_same(self):
        with tempfile.TemporaryDirectory(prefix="test_regenerate_") as folder:
            recorder = golden.Recorder(folder, pathlib.Path(PREFIX).resolve())
            self.addCleanup(recorder.end)
            for name in CASES:
                with self.subTest(name):
                    expected = golden.expected_picture(name)
                    pixels, run = recorder.record_until(name, expected)
                    self.assertIsNotNone(run, f"{(pixels != expected).sum()} channels differ")
            recorder.end()


if __name__ == "__main__":
    unittest.main()
