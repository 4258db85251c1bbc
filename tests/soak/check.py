"""The picture checks of `./soak`: the node's pictures must be byte for byte what `camera_stream render` draws of the same
messages.

A check stops all that moves, publishes messages that replace everything from before (`scene.check_messages`), writes the
same messages to a bag, and compares the pictures of all cameras. Nothing is left out: clouds that decay and frames that nobody
publishes any more disappear while the check waits; the robot stands still and its frames are published on, so that they do not
fade.
"""

import os
import subprocess
import time

import numpy
import rosbag
import rospy
from PIL import Image as Pillow

from . import scene
from .processes import Failure, wait_until
from .scene import CAMERAS, HANDLES, SENSORS, SOURCES, SCENE

# Equal images in a row that end a check, and the earliest end: invented frames have expired by then.
EQUAL, SETTLED_S = 5, scene.FRAME_TIMEOUT_S + 1.0
PATIENCE_S = 60.0
RENDER_S = 300.0


def later(stamp, seconds):
    return stamp + rospy.Duration(seconds)


def write_bag(file, seed, stamp):
    """The messages of a check in the order in which they take effect."""
    at = iter(range(1, 1000))
    with rosbag.Bag(file, 'w') as bag:
        def write(topic, message):
            bag.write(topic, message, later(stamp, 0.001 * next(at)))
        write('/tf_static', scene.static_frames())
        write('/tf', scene.moving_frames(1.0, stamp))
        for name in CAMERAS:
            write('/soak/{}/info'.format(name), scene.camera_info(name))
        handles = scene.Handles('soak')
        write(HANDLES + '_full', handles.init())
        write(HANDLES, handles.keep_alive())
        write(HANDLES, handles.update(scene.generator(seed, HANDLES), stamp, True))
        for part in (0, 1):
            for source in SOURCES:
                if int(source.topic.endswith('_updates')) == part:
                    for message in scene.check_messages(source, seed, stamp):
                        write(source.topic, message)
        write('/tf', scene.moving_frames(1.0, later(stamp, 0.9)))


class Checks:
    """Compares pictures, and keeps those that differ."""

    def __init__(self, run, folder):
        self.run, self.folder = run, folder
        self.passed, self.failed, self.took_s = 0, 0, []
        self.urdf = os.path.join(folder, 'robot.urdf')
        with open(self.urdf, 'w') as out:
            out.write(scene.URDF)

    def offline(self, camera, bag):
        """Width, height and pixels that are drawn of a bag."""
        png = os.path.join(self.folder, camera + '.png')
        command = [self.run.program, 'render', '--renderer', self.run.given.renderer, '-d', self.run.config_file, '--bag', bag,
                   '--camera', camera, '--param', 'robot_description=' + self.urdf, '-o', png]
        drawn = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               timeout=RENDER_S)
        if drawn.returncode:
            raise Failure('{}: {}'.format(' '.join(command), drawn.stdout.decode(errors='replace')[-500:]))
        picture = numpy.asarray(Pillow.open(png).convert('RGB'))
        return picture.shape[1], picture.shape[0], picture.tobytes()

    def live(self, camera):
        """Width, height and pixels of the node's last picture."""
        file = os.path.join(self.folder, 'live')
        last = self.run.watch.viewers.last[camera]
        self.run.watch.viewers.save(camera, file)
        with open(file, 'rb') as pixels:
            return last.width, last.height, pixels.read()

    def differing(self, expected):
        """The cameras whose pictures are not the expected ones, or have not been so long enough."""
        equal = self.run.watch.viewers.equal
        return [name for name in CAMERAS if equal[name] < EQUAL or self.live(name) != expected[name]]

    def check(self, seed):
        """One check; whether the pictures are equal."""
        begin, helpers = time.monotonic(), self.run.helpers
        for group in (SENSORS, SCENE):
            helpers[group].ask('pause')
        # Rates and connections are those of before the faults again.
        if not wait_until(lambda: not any(helpers[group].ask('unconnected') for group in (SENSORS, SCENE)), PATIENCE_S, 0.2):
            missing = [topic for group in (SENSORS, SCENE) for topic in helpers[group].ask('unconnected')]
            self.run.watch.findings.add('the node has not subscribed to ' + ', '.join(missing))
        time.sleep(0.7)
        now = time.time()
        stamp = rospy.Time(int(now), int((now % 1) * 1e9))
        for part in (0, 1):
            for group in (SCENE, SENSORS):
                helpers[group].ask('check', part, seed, stamp.secs, stamp.nsecs)
            time.sleep(0.5)
        bag = os.path.join(self.folder, 'check.bag')
        write_bag(bag, seed, stamp)
        expected = {name: self.offline(name, bag) for name in CAMERAS}
        time.sleep(max(0.0, begin + SETTLED_S - time.monotonic()))
        is_equal = wait_until(lambda: self.run.stop.is_set() or not self.differing(expected), PATIENCE_S, 0.25)
        self.took_s.append(time.monotonic() - begin)
        if is_equal:
            self.passed += 1
        else:
            self.failed += 1
            self.keep(seed, bag, expected)
        for group in (SENSORS, SCENE):
            helpers[group].ask('resume')
        return is_equal

    def keep(self, seed, bag, expected):
        """Saves the pictures that differ, their difference, the config and the bag."""
        folder = os.path.join(self.run.given.report, 'check_{}'.format(self.passed + self.failed))
        os.makedirs(folder, exist_ok=True)
        os.replace(bag, os.path.join(folder, 'check.bag'))
        with open(self.run.config_file) as config, open(os.path.join(folder, 'scene.rviz'), 'w') as out:
            out.write(config.read())
        notes = []
        for name in CAMERAS:
            pictures = {'expected': expected[name], 'live': self.live(name)}
            if pictures['expected'] == pictures['live']:
                notes.append('{}: equal, {} in a row'.format(name, self.run.watch.viewers.equal[name]))
                continue
            for kind, (width, height, pixels) in pictures.items():
                if len(pixels) == 3 * width * height and pixels:
                    Pillow.frombytes('RGB', (width, height), pixels).save(os.path.join(folder, '{}_{}.png'.format(name, kind)))
            notes.append(self.describe(folder, name, pictures['expected'], pictures['live']))
        self.run.watch.findings.add('picture check {} (seed {}): {}; see {}'.format(
            self.passed + self.failed, seed, '; '.join(notes), folder))

    @staticmethod
    def describe(folder, name, expected, live):
        if expected[:2] != live[:2] or len(expected[2]) != len(live[2]):
            return '{}: {}x{} instead of {}x{}'.format(name, live[0], live[1], expected[0], expected[1])
        width, height, _ = expected
        arrays = [numpy.frombuffer(one[2], numpy.uint8).reshape(height, width, 3).astype(int) for one in (expected, live)]
        difference = numpy.abs(arrays[0] - arrays[1])
        Pillow.fromarray(numpy.minimum(255, 4 * difference).astype(numpy.uint8)).save(
            os.path.join(folder, '{}_difference.png'.format(name)))
        return '{}: {} of {} pixels differ, by {} at most'.format(
            name, int(difference.any(axis=2).sum()), width * height, int(difference.max()))
