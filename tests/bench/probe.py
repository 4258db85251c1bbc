"""Measures running cameras from outside: publishes clouds, receives pictures, reads the CPU time and memory of processes.

A probe publishes TF, a CameraInfo and a cloud whose colour changes with every message. Latency is the time from the call that
publishes a cloud to the arrival of the first picture with that colour in its middle (with several cameras: of the last such
picture). It includes the probe's own share, which is measured as the floor: the cloud goes to a subscriber that answers with a
message of a picture's size.
"""

import contextlib
import io
import os
import re
import signal
import socket
import statistics
import struct
import subprocess
import threading
import time
import warnings
import xmlrpc.client
from typing import Any

import numpy
import rosgraph
import rosgraph.network
import rospy
import tf2_ros
from dynamic_reconfigure.msg import Config, IntParameter, StrParameter
from dynamic_reconfigure.srv import Reconfigure
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2

from .messages import OPTICAL, camera_info, point_cloud, transform

SIZE_PX = (1280, 800)
COLOURS = [0xff0000, 0x00ff00, 0x0000ff, 0xffff00, 0xff00ff, 0x00ffff]
# Latched, with a queue of one in which a newer cloud replaces an older one, as in a camera driver.
NEWEST = '/bench/cloud'
# Publishing waits until the last subscriber has taken the cloud.
ONE_BY_ONE = '/bench/large_cloud'
# As NEWEST, but not latched: a stream that the camera need not receive while nobody watches.
STREAM = '/bench/stream'
INFO = '/bench/info'


def picture_topic(number):
    """Each picture has its own namespace, because its CameraInfo is published next to it."""
    return '/bench/camera{}/image'.format(number)


def focal_px(size_px):
    """A focal length that grows with the image, so that the cloud fills the same part of any size."""
    return 1900.0 * (size_px[0] * size_px[1] / float(SIZE_PX[0] * SIZE_PX[1])) ** 0.5


def surface(points):
    """The points of a wavy surface, as a depth camera sees them."""
    columns = max(1, int(round((points * 4 / 3.0) ** 0.5)))
    rows = max(1, points // columns)
    u, v = numpy.meshgrid((numpy.arange(columns) + 0.5) / columns - 0.5, (numpy.arange(rows) + 0.5) / rows - 0.5)
    z = 1.5 + 0.1 * numpy.sin(16 * u) * numpy.cos(16 * v)
    data = numpy.zeros(rows * columns, [('x', '<f4'), ('y', '<f4'), ('z', '<f4'), ('rgb', '<u4')])
    data['x'], data['y'], data['z'] = (1.12 * u * z).ravel(), (0.84 * v * z).ravel(), z.ravel()
    return data


class PlainClouds:
    """The surface in each colour, as messages that rospy serialises each time one is published."""

    def __init__(self, points):
        self.messages = {}
        data = surface(points)
        for colour in COLOURS:
            data['rgb'] = colour
            self.messages[colour] = point_cloud(len(data), 'rgb', 'depth', data=data.tobytes())

    def paint(self, colour):
        self.message = self.messages[colour]

    def send(self, publisher):
        self.message.header.stamp = rospy.Time.now()
        publisher.publish(self.message)


class SerializedCloud:
    """The surface as serialised bytes, so that publishing costs the script as little as possible.

    Only its middle changes colour: painting ten million points would take too long.
    """

    def __init__(self, points):
        data = surface(points)
        data['rgb'] = 0xffffff
        message = io.BytesIO()
        point_cloud(len(data), 'rgb', 'depth').serialize(message)
        # A message without points ends with the data's length and is_dense.
        front = message.getvalue()[:-5] + struct.pack('<I', data.nbytes)
        self.bytes = bytearray(struct.pack('<I', len(front) + data.nbytes + 1) + front + data.tobytes() + b'\1')
        sent = numpy.frombuffer(self.bytes, data.dtype, len(data), 4 + len(front))
        self.middle = sent['rgb'][int(0.4 * len(data)):int(0.6 * len(data)) + 1]

    def paint(self, colour):
        self.middle[:] = colour

    def send(self, publisher):
        stamp = rospy.Time.now()
        # The stamp follows the message's length and the sequence number.
        struct.pack_into('<II', self.bytes, 8, stamp.secs, stamp.nsecs)
        for connection in list(publisher.impl.connections):
            # rospy removes the connection of a subscriber that ended.
            with contextlib.suppress(rospy.exceptions.TransportException, OSError):
                connection.write_data(self.bytes)


class Drain(threading.Thread):
    """Receives a topic's messages without decoding them and calls back for each one."""

    def __init__(self, topic, take):
        super().__init__(daemon=True)
        self.take_message = take
        name = '/bench_drain'
        node: Any = xmlrpc.client.ServerProxy(rosgraph.Master(name).lookupNode(rospy.get_name()))
        _, _, (_, host, port) = node.requestTopic(name, topic, [['TCPROS']])
        self.socket = socket.create_connection((host, port))
        wanted = {'callerid': name, 'topic': topic, 'type': PointCloud2._type, 'md5sum': PointCloud2._md5sum}
        rosgraph.network.write_ros_handshake_header(self.socket, wanted)
        rosgraph.network.read_ros_handshake_header(self.socket, io.BytesIO(), 2 ** 16)
        self.start()

    def run(self):
        length, rest = bytearray(4), bytearray(2 ** 20)
        while self.read(length, 4):
            if not self.read(rest, struct.unpack('<I', length)[0]):
                return
            self.take_message(None)

    def read(self, into, count):
        """Receives count bytes; more than fit overwrite each other. False if the connection closed."""
        while count > 0:
            received = self.socket.recv_into(into, min(count, len(into)))
            if received == 0:
                return False
            count -= received
        return True

    def unregister(self):
        self.socket.shutdown(socket.SHUT_RDWR)
        self.join()
        self.socket.close()


def colour_of(message):
    """The cloud's colour, shaded or not, in a picture's middle; None if the cloud is not there."""
    rows = numpy.frombuffer(message.data, numpy.uint8).reshape(message.height, message.step)
    y, x = message.height // 2, message.width // 2
    return colour_of_pixels(rows[y - 12:y + 13, 3 * (x - 12):3 * (x + 13)].reshape(-1, 3))


def colour_of_pixels(middle):
    """The cloud's colour, shaded or not, in some pixels; None if the cloud is not among them."""
    bright = middle > 90
    clear = (bright != (middle < 60)).all(axis=1) & bright.any(axis=1)
    if not clear.any():
        return None
    red, green, blue = bright[clear.argmax()]
    return 0xff0000 * int(red) + 0xff00 * int(green) + 0xff * int(blue)


class Compressed:
    """Subscribes to the compressed pictures of a topic, and tells how much later than the probe's raw ones they arrive."""

    def __init__(self, probe, topic, settings):
        topic += '/compressed'
        values = Config(ints=[IntParameter(name, value) for name, value in settings.items() if isinstance(value, int)],
                        strs=[StrParameter(name, value) for name, value in settings.items() if isinstance(value, str)])
        rospy.ServiceProxy(topic + '/set_parameters', Reconfigure)(values)
        self.arrivals, self.bytes = {}, 0
        self.raw = probe.stamps = {}
        self.subscriber = rospy.Subscriber(topic, CompressedImage, self.take, queue_size=1, buff_size=2 ** 24, tcp_nodelay=True)

    def take(self, message):
        self.arrivals[message.header.stamp.to_nsec()] = time.monotonic()
        self.bytes += len(message.data)

    def figures(self):
        self.subscriber.unregister()
        later_ms = sorted(1000 * (when - self.raw[stamp]) for stamp, when in self.arrivals.items() if stamp in self.raw)
        times = sorted(self.arrivals.values())
        return {
            'packed_hz': (len(times) - 1) / (times[-1] - times[0]) if times[1:] else float('nan'),
            'later_ms': statistics.median(later_ms) if later_ms else float('nan'),
            'kilobytes': self.bytes / 1000.0 / max(1, len(times)),
        }


class Usage:
    """CPU time and memory of a process."""

    def __init__(self, pid):
        self.pid = pid

    def cpu_s(self):
        """CPU time of all its threads, ended ones included, from the clock that clock_getcpuclockid names."""
        return time.clock_gettime((~self.pid << 3) | 2)

    def percent(self, seconds):
        """CPU load in percent of one core, measured over the next seconds."""
        cpu_s, begin = self.cpu_s(), time.monotonic()
        time.sleep(seconds)
        return 100 * (self.cpu_s() - cpu_s) / (time.monotonic() - begin)

    def peak_mb(self):
        with open('/proc/{}/status'.format(self.pid)) as status:
            return int(re.search(r'VmHWM:\s*(\d+)', status.read()).group(1)) / 1024.0


class Probe:
    """Publishes clouds and waits for their pictures."""

    def __init__(self):
        rospy.init_node('bench', disable_signals=True)
        self.frames = tf2_ros.StaticTransformBroadcaster()
        now = rospy.Time.now()
        self.frames.sendTransform([transform('base', 'projector', (0, 0, 1), OPTICAL, now),
                                   transform('base', 'depth', (0, 0.05, 1), OPTICAL, now)])
        self.info = rospy.Publisher(INFO, CameraInfo, queue_size=1, latch=True)
        with warnings.catch_warnings():
            # rospy warns about queue_size=None, but it is what makes publishing block.
            warnings.simplefilter('ignore')
            self.clouds = {
                NEWEST: rospy.Publisher(NEWEST, PointCloud2, queue_size=1, latch=True),
                ONE_BY_ONE: rospy.Publisher(ONE_BY_ONE, PointCloud2, queue_size=None),
                STREAM: rospy.Publisher(STREAM, PointCloud2, queue_size=1),
            }
        self.use(NEWEST, None, SIZE_PX)
        self.changed = threading.Condition()
        self.subscribers = []
        # When the raw picture of a stamp arrived, if anybody wants to know.
        self.stamps = None
        # The floor's pictures are empty: any picture counts as the answer to the oldest cloud.
        self.is_floor = False
        self.forget()

    def use(self, topic, cloud, size_px, distortion=(0.0,) * 5):
        """From now on publishes this cloud on this topic, and a CameraInfo of this size with this D."""
        self.publisher, self.cloud = self.clouds[topic], cloud
        self.info.publish(camera_info('projector', size_px, focal_px(size_px), distortion))

    def forget(self):
        with self.changed:
            # In flight: colours and times of clouds that are published but not yet in a picture.
            self.arrivals, self.latencies_s, self.in_flight = [], [], []
            self.new_at, self.shown = [], {}

    def listen(self, topics):
        """Subscribes to these topics instead of the previous ones."""
        for subscriber in self.subscribers:
            subscriber.unregister()
        with self.changed:
            self.forget()
            self.topics = topics
        self.subscribers = [
            rospy.Subscriber(topic, Image, self.take, topic, queue_size=1, buff_size=2 ** 26, tcp_nodelay=True)
            for topic in topics]

    def watch(self, name):
        """Waits for what `note` is told under this name, instead of pictures on topics."""
        self.listen([])
        self.topics = [name]

    def take(self, message, topic):
        now = time.monotonic()
        if self.stamps is not None:
            with self.changed:
                self.stamps[message.header.stamp.to_nsec()] = now
        if not self.is_floor:
            self.note(colour_of(message), topic, now)
            return
        with self.changed:
            colour = self.in_flight[0][0] if self.in_flight else None
        self.note(colour, topic, now)

    def note(self, colour, topic, now):
        """A picture with this colour in its middle (None: without the cloud) arrived."""
        with self.changed:
            if topic not in self.topics:
                # It was under way when its topic was given up.
                return
            self.arrivals.append(now)
            if colour is not None and self.shown.get(topic) != colour:
                self.shown[topic] = colour
                if topic == self.topics[-1]:
                    self.new_at.append(now)
            for index, (sent, when) in enumerate(self.in_flight):
                if all(self.shown.get(other) == sent for other in self.topics):
                    self.latencies_s.append(now - when)
                    del self.in_flight[:index + 1]
                    break
            self.changed.notify_all()

    def send(self, number, keep=0):
        """Publishes the cloud in this number's colour. Gives up on all but the last `keep` in flight; returns how many."""
        colour = self.newest_colour = COLOURS[number % len(COLOURS)]
        self.cloud.paint(colour)
        with self.changed:
            missed = max(0, len(self.in_flight) - keep)
            del self.in_flight[:missed]
            self.in_flight.append((colour, time.monotonic()))
        self.cloud.send(self.publisher)
        return missed

    def wait_for_picture(self, timeout_s):
        """Whether a picture arrived. On a topic that is not latched, a cloud is published once a subscriber connects."""
        until = time.monotonic() + timeout_s
        if self.publisher is self.clouds[ONE_BY_ONE]:
            while self.publisher.get_num_connections() == 0:
                if time.monotonic() > until:
                    return False
                time.sleep(0.05)
            self.send(0)
        with self.changed:
            return self.changed.wait_for(lambda: self.arrivals, until - time.monotonic())

    def wait_for_colour(self, timeout_s):
        """Whether the last topic showed the cloud."""
        with self.changed:
            return self.changed.wait_for(lambda: self.shown.get(self.topics[-1]) is not None, timeout_s)

    def wait_for_disconnection(self):
        """Waits until nobody subscribes to the clouds."""
        until = time.monotonic() + 10
        is_direct = self.publisher is self.clouds[ONE_BY_ONE]
        while is_direct and self.publisher.get_num_connections() > 0 and time.monotonic() < until:
            # rospy notices a closed connection only when it publishes.
            self.cloud.send(self.publisher)
            time.sleep(0.05)

    def send_some(self, hz, seconds, window=2):
        """Publishes clouds at a rate; returns how many, and how many of them no picture showed.

        hz None: as fast as pictures arrive, with at most `window` clouds in flight (2: one waits while another is drawn).
        """
        sent, missed, begin = 0, 0, time.monotonic()
        while time.monotonic() < begin + seconds:
            if hz is None:
                with self.changed:
                    self.changed.wait_for(lambda: len(self.in_flight) < window, 10.0)
            missed += self.send(sent, window - 1 if hz is None else 0)
            sent += 1
            if hz is not None:
                time.sleep(max(0.0, begin + sent / hz - time.monotonic()))
        return sent, missed

    def measure(self, hz, seconds, usage=None, window=2):
        """Publishes clouds as `send_some` does; returns the figures by name."""
        for number in (-2, -1):
            self.send(number)
            time.sleep(0.5)
        with self.changed:
            self.changed.wait_for(lambda: not self.in_flight, 5.0)
        self.forget()
        cpu_s, begin = usage.cpu_s() if usage else 0.0, time.monotonic()
        sent, missed = self.send_some(hz, seconds, window)
        took_s = time.monotonic() - begin
        with self.changed:
            pictures, new_at = len(self.arrivals), self.new_at
            latencies_ms = sorted(1000 * latency for latency in self.latencies_s)
        figures = {
            'clouds': sent, 'missed': missed, 'new_hz': (len(new_at) - 1) / (new_at[-1] - new_at[0]) if new_at[1:] else 0.0,
            'pictures_hz': pictures / took_s / len(self.topics),
            'latency_ms': statistics.median(latencies_ms) if latencies_ms else float('nan'),
            'latency_p95_ms': latencies_ms[-1 - len(latencies_ms) // 20] if latencies_ms else float('nan'),
        }
        if usage:
            cpu_s = usage.cpu_s() - cpu_s
            figures['cpu_ms'] = 1000 * cpu_s / pictures if pictures else float('nan')
            figures['cpu_per_cloud_ms'] = 1000 * cpu_s / sent
            figures['peak_mb'] = usage.peak_mb()
        return figures

    def floor(self, topic, cloud, hz, seconds, size_px=SIZE_PX, cameras=1):
        """The probe's own share of the latency: a subscriber answers each cloud with empty pictures.

        For plain clouds it is rospy's; serialised ones, which may be large, are received without even a copy.
        """
        width, height = size_px
        topics = [picture_topic(number) for number in range(cameras)]
        answers = [rospy.Publisher(topic, Image, queue_size=1) for topic in topics]
        empty = Image(height=height, width=width, encoding='rgb8', step=3 * width, data=bytes(3 * width * height))

        def answer(_):
            for publisher in answers:
                publisher.publish(empty)

        if isinstance(cloud, SerializedCloud):
            relay = Drain(topic, answer)
        else:
            relay = rospy.Subscriber(topic, PointCloud2, answer, queue_size=1, buff_size=2 ** 26, tcp_nodelay=True)
        self.use(topic, cloud, size_px)
        self.is_floor = True
        self.listen(topics)
        time.sleep(1.0)
        figures = self.measure(hz, seconds)
        self.is_floor = False
        self.listen([])
        for one in [relay] + answers:
            one.unregister()
        self.wait_for_disconnection()
        return figures


class Program:
    """A program in its own process group, which ends with the block."""

    def __init__(self, command, log, inherit=(), environment=None):
        """Its output goes to the end of the file `log`; it inherits the file descriptors in `inherit`."""
        self.command, self.log, self.inherit, self.environment = command, log, inherit, environment

    def __enter__(self):
        with open(self.log, 'ab') as log:
            self.process = subprocess.Popen(
                self.command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True,
                pass_fds=self.inherit, env=self.environment)
        return self.process

    def __exit__(self, *_):
        for name in (signal.SIGINT, signal.SIGKILL):
            try:
                os.killpg(self.process.pid, name)
                self.process.wait(10)
                return
            except ProcessLookupError:
                self.process.wait()
                return
            except subprocess.TimeoutExpired:
                pass
