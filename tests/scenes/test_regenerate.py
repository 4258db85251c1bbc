"""The real rviz draws the golden pictures again, pixel for pixel. Needs RVIZ_PLUGIN_PREFIX: where the plugin is installed."""

import os
import pathlib
import tempfile
import unittest

from . import golden

PREFIX = os.environ.get("RVIZ_PLUGIN_PREFIX", "")
# One of each kind: several messages of a cloud, a mesh with a texture and text, a robot with a parameter and a grey picture.
CASES = ["pc2_decay_three_clouds_translucent", "scene_all_kinds_in_groups", "robot_model", "cam_encoding_mono16"]


@unittest.skipUnless(PREFIX, "RVIZ_PLUGIN_PREFIX is not set")
class Regenerate(unittest.TestCase):
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
