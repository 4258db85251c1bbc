"""Measures latency to light: from publishing a cloud until its colour is in the X server's screen.

A virtual X server (Xvfb) keeps its screen in a file, which a thread here reads. That costs the server nothing, and sees a picture
as soon as the server has drawn it: what follows on a real screen, its refresh and the projector's own delay, is not in it. The
floor replaces node and window by a thread that receives each cloud and writes its colour into such a file.
"""

import collections
import contextlib
import mmap
import os
import select
import struct
import sys
import tempfile
import threading
import time

import numpy
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import TimeReference

from .probe import NEWEST, SIZE_PX, Drain, Program, Usage, colour_of_pixels, picture_topic

# The topic of the probe that stands for the screen.
LIGHT = 'light'
# Period of reading the screen, by which an image may be noticed late.
PERIOD_S = 0.0002
# Half the side of the region that is read in the middle, pixels.
REACH_PX = 12

# The steps that the node measures itself.
STEPS = ['received to decoded', 'decoded to drawn', 'drawn to published']

# A route from the node to the screen: name, command, further arguments of the node, command of a viewer if it has one.
Route = collections.namedtuple('Route', 'name node arguments viewer')


class Screen:
    """The pixels of an X server's screen, or of memory that stands for one: rows of 4 bytes a pixel, blue first."""

    def __init__(self, pixels):
        self.pixels = pixels

    @staticmethod
    def of_server(file):
        """The file is in xwd's format: a header of big-endian words, colours of 12 bytes, then the pixels."""
        with open(file, 'rb') as opened:
            memory = mmap.mmap(opened.fileno(), 0, access=mmap.ACCESS_READ)
        header, width, height, line, colours = (struct.unpack_from('>I', memory, 4 * word)[0] for word in (0, 4, 5, 12, 19))
        rows = numpy.frombuffer(memory, numpy.uint8, height * line, header + 12 * colours).reshape(height, line)
        return Screen(rows[:, :4 * width].reshape(height, width, 4))

    def middle(self):
        """The pixels around the middle, a copy."""
        y, x = self.pixels.shape[0] // 2, self.pixels.shape[1] // 2
        return self.pixels[y - REACH_PX:y + REACH_PX + 1, x - REACH_PX:x + REACH_PX + 1].copy()

    def paint(self, colour):
        """For memory only."""
        self.pixels[:] = [colour & 255, colour >> 8 & 255, colour >> 16, 0]


class Watcher(threading.Thread):
    """Tells the probe whenever the middle of the screen changes."""

    def __init__(self, screen, probe):
        super().__init__(daemon=True)
        self.screen, self.probe, self.is_ending = screen, probe, False
        self.start()

    def run(self):
        last = None
        while not self.is_ending:
            middle = self.screen.middle()
            now, pixels = time.monotonic(), middle.tobytes()
            if pixels != last:
                last = pixels
                self.probe.note(colour_of_pixels(middle.reshape(-1, 4)[:, 2::-1]), LIGHT, now)
            time.sleep(PERIOD_S)

    def end(self):
        self.is_ending = True
        self.join()


class Usages:
    """The CPU time of several processes together, and the memory of all."""

    def __init__(self, pids):
        self.usages = [Usage(pid) for pid in pids]

    def cpu_s(self):
        return sum(usage.cpu_s() for usage in self.usages)

    def peak_mb(self):
        return sum(usage.peak_mb() for usage in self.usages)


class Steps:
    """The node's own figures of where the time goes: on /diagnostics, and beside the image when each was on the screen."""

    def __init__(self):
        self.diagnosed_ms, self.shown_ms = {}, []
        shown = os.path.dirname(picture_topic(0)) + '/shown'
        self.subscribers = [rospy.Subscriber('/diagnostics', DiagnosticArray, self.take, queue_size=10),
                            rospy.Subscriber(shown, TimeReference, self.take_shown, queue_size=100)]

    def take(self, message):
        for value in (value for status in message.status for value in status.values):
            for step in STEPS:
                if value.key.startswith(step) and value.value != '-':
                    self.diagnosed_ms[step] = float(value.value.split('/')[0])

    def take_shown(self, message):
        self.shown_ms.append(1000 * (message.time_ref - message.header.stamp).to_sec())

    def end(self):
        """The medians, milliseconds."""
        for subscriber in self.subscribers:
            subscriber.unregister()
        return dict(self.diagnosed_ms, **{'published to shown': float(numpy.median(self.shown_ms))})


def routes(programs, rviz):
    """The routes to the screen, rviz's where it can be compared."""
    node = [os.path.join(programs, 'camera_stream'), '--renderer', 'cpu']
    window = [os.path.join(programs, 'projector_window'), '--topic', picture_topic(0)]
    found = [
        Route('camera_stream --window', node, ['--window', 'auto'], None),
        Route('camera_stream, projector_window', node, [], window),
    ]
    here = os.path.dirname(os.path.abspath(__file__))
    image_view = [os.path.join(here, '..', '..', 'ros_pkg', 'nodes', 'image_view_anywhere'), 'image:=' + picture_topic(0)]
    return found + [Route('rviz, image_view', camera.command, [], image_view) for camera in rviz]


@contextlib.contextmanager
def x_server(log):
    """An X server of the picture's size; yields its display, its screen and its process."""
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        reading, writing = os.pipe()
        size = '{}x{}x24'.format(*SIZE_PX)
        command = ['Xvfb', '-displayfd', str(writing), '-screen', '0', size, '-nolisten', 'tcp', '-fbdir', folder]
        server = stack.enter_context(Program(command, log, inherit=[writing]))
        os.close(writing)
        with open(reading) as written:
            ready, _, _ = select.select([written], [], [], 20)
            number = written.readline().strip() if ready else ''
        if not number:
            sys.exit('bench: Xvfb did not start; log: {}'.format(log))
        yield ':' + number, Screen.of_server(os.path.join(folder, 'Xvfb_screen0')), server


def measure(bench, route, config, cloud):
    """The figures of one route."""
    probe, given = bench.probe, bench.given
    file = os.path.join(bench.folder, 'light.rviz')
    with open(file, 'w') as out:
        out.write(config)
    with contextlib.ExitStack() as stack:
        display, screen, server = stack.enter_context(x_server(bench.log))
        outside = {key: value for key, value in os.environ.items() if not key.startswith('WAYLAND_')}
        environment = dict(outside, DISPLAY=display)
        probe.use(NEWEST, cloud, SIZE_PX)
        probe.send(0)
        commands = [route.node + ['-d', file] + route.arguments] + ([route.viewer] if route.viewer else [])
        processes = [stack.enter_context(Program(command, bench.log, environment=environment)) for command in commands]
        probe.watch(LIGHT)
        watcher = Watcher(screen, probe)
        stack.callback(watcher.end)
        if not probe.wait_for_colour(60):
            sys.exit('bench: {} shows no image on the screen; log: {}'.format(route.name, bench.log))
        steps = None if route.viewer else Steps()
        of_server = Usage(server.pid)
        cpu_s = of_server.cpu_s()
        figures = probe.measure(given.hz, given.seconds, Usages([process.pid for process in processes]))
        figures['server_ms'] = 1000 * (of_server.cpu_s() - cpu_s) / max(1, figures['clouds'])
        figures['steps'] = steps.end() if steps else None
    return dict(figures, mark='')


def floor(bench, cloud):
    """The probe's own share: a thread receives each cloud and fills memory with its colour."""
    probe, given = bench.probe, bench.given
    screen = Screen(numpy.zeros((64, 64, 4), numpy.uint8))
    probe.use(NEWEST, cloud, SIZE_PX)
    probe.send(0)
    relay = Drain(NEWEST, lambda _: screen.paint(probe.newest_colour))
    probe.watch(LIGHT)
    watcher = Watcher(screen, probe)
    try:
        figures = probe.measure(given.hz, given.seconds)
    finally:
        watcher.end()
        relay.unregister()
    return figures


def section(bench, config, cloud):
    """The rows of the section."""
    result = {'floor': floor(bench, cloud), 'rows': []}
    print('floor: {latency_ms:.2f} / {latency_p95_ms:.2f} ms'.format(**result['floor']), flush=True)
    for route in routes(bench.given.programs, bench.rviz):
        result['rows'].append(bench.row(route, measure(bench, route, config, cloud)))
    return result
