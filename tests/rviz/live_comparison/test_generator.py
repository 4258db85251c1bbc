"""A seed always gives the same scene, and all display classes have their turn. Needs ROS's Python packages, but no rviz."""

import io
import pathlib
import re
import unittest

from .generator import DISPLAYS, scene_of

ROOT = pathlib.Path(__file__).resolve().parents[3]
TABLE = ROOT / 'rust_core/rviz_config/src/displays/mod.rs'


def contents(scene):
    """The config, and the bytes of all messages and transforms."""
    buffer = io.BytesIO()
    for step, messages in enumerate(scene.steps):
        scene.transforms(step).serialize(buffer)
        for topic, message in messages:
            buffer.write(topic.encode())
            message.serialize(buffer)
    return scene.config, buffer.getvalue()


class Generator(unittest.TestCase):
    def test_a_seed_gives_the_same_scene_each_time(self):
        for seed in range(30):
            self.assertEqual(contents(scene_of(seed, 1000.0)), contents(scene_of(seed, 1000.0)), f'seed {seed}')

    def test_seeds_give_different_scenes(self):
        self.assertEqual(len({contents(scene_of(seed, 1000.0))[1] for seed in range(30)}), 30)

    def test_each_class_that_draws_is_among_the_displays(self):
        drawing = set(re.findall(r'"rviz/(\w+)".* Scene\(', TABLE.read_text()))
        self.assertEqual(len(drawing), len(DISPLAYS))
        shown, seed = set(), 0
        while shown != drawing and seed < 500:
            shown.update(scene_of(seed, 1000.0).classes)
            seed += 1
        self.assertEqual(shown, drawing)


if __name__ == '__main__':
    unittest.main()
