"""The comparison of one scene: played, waited for, judged; what a failure leaves behind."""

import os
import shutil
import time
from typing import NamedTuple

import rosbag
import rospy
from PIL import Image
from golden.scenes.scores import comparison, scores

from .performance import Performance
from .stage import RVIZ

# The lowest share of close pixels that passes.
MIN_CLOSE = 0.98
# Pixels that may differ in any image: the limit of those with less than a hundred.
FEW_PIXELS = 2
# How long pictures that differ may go on to differ, once both stand still and while one of them still changes.
DIFFERENT_SECS = 30.0
RESTLESS_SECS = 200.0


class Result(NamedTuple):
    """How near one renderer's picture of one camera is to rviz's."""

    seed: int
    camera: str
    renderer: str
    classes: tuple
    strict: float
    close: float
    content: int

    @property
    def passes(self):
        return self.close >= MIN_CLOSE or round((1 - self.close) * self.content) <= FEW_PIXELS


class Comparison:
    """Compares scenes on a stage. Pictures that fail are kept in a folder."""

    def __init__(self, live, output, keeps_all=False):
        self.live, self.output, self.keeps_all = live, output, keeps_all

    def compare(self, scene):
        """Plays a scene and returns a Result for each camera and renderer."""
        with Performance(self.live, scene) as performance:
            performance.play()
            results = self.judge(performance)
            if self.keeps_all or not all(result.passes for result in results):
                self.keep(performance, results)
        return results

    def judge(self, performance):
        """The scores, as soon as all pass, or when they do not come to pass."""
        begun, different_since, judged, results = time.monotonic(), None, None, []
        while True:
            still = performance.stands_still()
            if still:
                drawn = [watch.last for watch in performance.watches.values()]
                if judged is None or any(a is not b and a.data != b.data for a, b in zip(judged, drawn)):
                    judged, results, different_since = drawn, self.scores(performance), time.monotonic()
                if all(result.passes for result in results) or time.monotonic() - different_since > DIFFERENT_SECS:
                    return results
            if time.monotonic() - begun > RESTLESS_SECS:
                return results or self.scores(performance)
            time.sleep(0.05)

    def scores(self, performance):
        scene, results = performance.scene, []
        for camera in scene.cameras:
            expected = performance.picture(RVIZ, camera)
            for renderer in self.live.renderers:
                actual = performance.picture(renderer, camera)
                if actual.shape == expected.shape:
                    found = scores(expected, actual)
                    measured = (found.strict, found.close, found.content)
                else:
                    measured = (0.0, 0.0, expected.size)
                results.append(Result(scene.seed, camera.name, renderer, tuple(scene.classes), *measured))
        return results

    def keep(self, performance, results):
        """Leaves config, bag, logs, and each picture beside rviz's: expected | difference | actual."""
        scene = performance.scene
        folder = self.output / f'seed_{scene.seed}'
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / 'scene.rviz').write_text(scene.config)
        (folder / 'faulty_messages.txt').write_text('\n'.join(scene.spoilt))
        for name, text in scene.parameters.items():
            (folder / (name.strip('/').replace('/', '_') + '.urdf')).write_text(text)
        write_bag(scene, folder / 'scene.bag')
        cameras = {camera.name: camera for camera in scene.cameras}
        for result in results:
            camera = cameras[result.camera]
            expected, actual = performance.picture(RVIZ, camera), performance.picture(result.renderer, camera)
            save(expected, folder / f'{camera.name}_{RVIZ}.png')
            save(actual, folder / f'{camera.name}_{result.renderer}.png')
            if expected.shape == actual.shape:
                save(comparison(expected, actual), folder / f'{camera.name}_{result.renderer}_difference.png')
        for program in performance.programs:
            if os.path.exists(program.log):
                shutil.copy(program.log, folder)


def save(pixels, file):
    Image.fromarray(pixels).save(file)


def write_bag(scene, file):
    """The scene's messages at their times, for `camera_stream render`."""
    with rosbag.Bag(str(file), 'w') as bag:
        for step, messages in enumerate(scene.steps):
            at = scene.stamp(step)
            bag.write('/tf', scene.transforms(step), at)
            for number, (topic, message) in enumerate(messages):
                bag.write(topic, message, at + rospy.Duration(0, 1000 * (number + 1)))
        # The time at which everything stands still.
        bag.write('/end', scene.transforms(0), rospy.Time.from_sec(scene.end_secs))
