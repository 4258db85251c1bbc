"""Measures rviz with cameras in it: CameraPub, and a plain camera that works as the plugin before it did.

The plain camera (tests/rviz/rviz_plugin/driver) draws with each of rviz's frames, waits for the pixels, and publishes on rviz's main
thread, whether or not somebody subscribes. Both run in the same rviz on the same virtual screen, one after the other, with the
same cloud. What the main thread has to do for a frame is measured by the driver, from before the displays' update to after the
window was drawn.
"""

import collections
import contextlib
import os
import sys
import threading
import time

import rospy
from std_msgs.msg import String

from . import light
from .probe import INFO, NEWEST, PlainClouds, Program, SIZE_PX, Usage, picture_topic

# How a camera is named in the table, its class in rviz, and its further settings.
Kind = collections.namedtuple('Kind', 'name class_name settings')
KINDS = [
    Kind('plain, as before', 'rviz_test_driver/PlainCamera', ''),
    Kind('CameraPub', 'rviz_camera_stream/CameraPub', ', Frame Rate: -1'),
    Kind('CameraPub at 10 Hz', 'rviz_camera_stream/CameraPub', ', Frame Rate: 10'),
]
ANSWER_TIMEOUT_S = 30.0
# Few enough for a software driver to draw them in each of rviz's frames.
POINTS = 10000

CONFIG = """Visualization Manager:
  Displays:
  - {{Class: rviz/PointCloud2, Name: cloud, Enabled: true, Topic: {cloud}, Style: Flat Squares, Size (m): 0.004, Alpha: 1,
     Color Transformer: RGB8, Position Transformer: XYZ, Queue Size: 10, Decay Time: 0}}
{camera}
  - {{Class: rviz_test_driver/Driver, Name: driver, Enabled: true}}
  Global Options: {{Fixed Frame: base, Frame Rate: 30, Background Color: 48; 48; 48}}
  Views: {{Current: {{Class: rviz/Orbit, Name: Current View}}}}
  Tools: [{{Class: rviz/MoveCamera}}]
Window Geometry: {{Width: 800, Height: 500}}
"""
CAMERA = """  - {{Class: {class_name}, Name: camera, Enabled: true, Image Topic: {image}, Camera Info Topic: {info}{settings}}}"""


class Driver:
    """The display that answers questions about rviz."""

    def __init__(self):
        self.answered, self.answer = threading.Event(), ''
        self.subscriber = rospy.Subscriber('/driver/answer', String, self.receive, queue_size=10)
        self.publisher = rospy.Publisher('/driver/command', String, queue_size=10)

    def receive(self, message):
        self.answer = message.data.split('\t', 2)[2]
        self.answered.set()

    def ask(self, command):
        end = time.monotonic() + ANSWER_TIMEOUT_S
        while not (self.publisher.get_num_connections() and self.subscriber.get_num_connections()):
            if time.monotonic() > end:
                sys.exit('bench: rviz does not answer')
            time.sleep(0.05)
        self.answered.clear()
        self.publisher.publish('0\t' + command)
        if not self.answered.wait(ANSWER_TIMEOUT_S):
            sys.exit('bench: rviz does not answer')
        return self.answer

    def busy(self):
        """rviz's frames since the last time, and the seconds that its main thread spent on them."""
        frames, seconds = self.ask('busy').split()
        return int(frames), float(seconds)

    def end(self):
        self.subscriber.unregister()
        self.publisher.unregister()


def measure(bench, kind, is_watched):
    """The figures of one kind of camera in rviz."""
    probe, given = bench.probe, bench.given
    file = os.path.join(bench.folder, 'plugin.rviz')
    camera = CAMERA.format(class_name=kind.class_name, image=picture_topic(0), info=INFO, settings=kind.settings)
    with open(file, 'w') as out:
        out.write(CONFIG.format(cloud=NEWEST, camera=camera))
    with contextlib.ExitStack() as stack:
        display, _, _ = stack.enter_context(light.x_server(bench.log))
        probe.send(0)
        probe.listen([picture_topic(0)] if is_watched else [])
        environment = dict(os.environ, DISPLAY=display, LIBGL_ALWAYS_SOFTWARE='1')
        process = stack.enter_context(Program(['rviz', '--splash-screen', '', '-d', file], bench.log, environment=environment))
        driver = Driver()
        stack.callback(driver.end)
        driver.ask('busy')
        if is_watched and not probe.wait_for_picture(60):
            sys.exit('bench: {} published no picture; its log: {}'.format(kind.name, bench.log))
        # The first cloud is there, and whatever is set up once.
        probe.send_some(given.hz, 3.0)
        usage = Usage(process.pid)
        driver.busy()
        cpu_s, begin = usage.cpu_s(), time.monotonic()
        if is_watched:
            figures = probe.measure(given.hz, given.seconds, usage)
        else:
            probe.send_some(given.hz, given.seconds)
            figures = {'pictures_hz': 0.0, 'latency_ms': float('nan'), 'latency_p95_ms': float('nan')}
        took_s = time.monotonic() - begin
        frames, busy_s = driver.busy()
        figures.update(cpu_percent=100 * (usage.cpu_s() - cpu_s) / took_s, frames_hz=frames / took_s,
                       frame_ms=1000 * busy_s / max(1, frames))
        probe.listen([])
    return figures


def section(bench):
    """Each kind of camera, with one subscriber and without."""
    bench.probe.use(NEWEST, PlainClouds(POINTS), SIZE_PX)
    rows = []
    for is_watched in (True, False):
        for kind in KINDS:
            figures = measure(bench, kind, is_watched)
            rows.append(bench.row(kind, dict(figures, mark=''), watched='1' if is_watched else 'none'))
    return {'rows': rows}
