"""A node of `./soak` that publishes: `sensors`, `scene` (with TF and the cameras), or `vandal`, which publishes invalid messages.

    python3 -m soak.publisher GROUP SEED

Each line on standard input is a command, a JSON list of a method's name and its arguments; the answer is a line of JSON. The node
ends with its standard input.
"""

import contextlib
import heapq
import itertools
import json
import math
import queue
import random
import sys
import threading
import time

import rosgraph
import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, PointCloud2
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import InteractiveMarkerInit, InteractiveMarkerUpdate, Marker, MarkerArray

from . import scene
from .damage import damaged, serialized, with_stamp
from .scene import CAMERAS, HANDLES, SENSORS, SOURCES, SCENE

TF_HZ, INFO_HZ, HANDLES_HZ = 20, 1, 2
# Messages of each cloud, made beforehand and sent in rotation.
CLOUDS = 6


class Publisher:
    """Publishes on a schedule and does what the commands say, all on one thread."""

    def __init__(self, seed):
        self.seed, self.publishers, self.jobs, self.types = seed, {}, [], {}
        self.order = itertools.count()
        self.is_paused, self.rate, self.sources = False, 1.0, []
        self.prepare()
        threading.Thread(target=self.stay_registered, daemon=True).start()

    def prepare(self):
        pass

    def advertise(self, topic, kind, latch=False):
        self.publishers[topic] = rospy.Publisher(topic, kind, latch=latch, queue_size=50, tcp_nodelay=True)
        self.types[topic] = kind._type
        return self.publishers[topic]

    def repeat(self, hz, call, is_sensor=False):
        heapq.heappush(self.jobs, (time.monotonic() + random.random() / hz, next(self.order), hz, call, is_sensor))

    def stay_registered(self):
        """rospy does not register again at a master that was restarted."""
        master, name = rosgraph.Master(rospy.get_name()), rospy.get_name()
        while True:
            time.sleep(0.5)
            try:
                try:
                    master.lookupNode(name)
                except rosgraph.MasterError:
                    for topic, kind in list(self.types.items()):
                        master.registerPublisher(topic, kind, rospy.get_node_uri())
            except (OSError, rosgraph.MasterException):
                pass

    def run(self, commands):
        while True:
            now = time.monotonic()
            while self.jobs and self.jobs[0][0] <= now:
                due, _, hz, call, is_sensor = heapq.heappop(self.jobs)
                call()
                period = 1 / (hz * (self.rate if is_sensor else 1.0))
                # What could not be sent in time is left out.
                heapq.heappush(self.jobs, (max(due + period, now), next(self.order), hz, call, is_sensor))
            timeout = self.jobs[0][0] - time.monotonic() if self.jobs else 1.0
            with contextlib.suppress(queue.Empty):
                command = commands.get(timeout=max(0.0, timeout))
                if command is None:
                    return
                try:
                    answer = getattr(self, command[0])(*command[1:])
                except Exception as error:  # pylint: disable=broad-except
                    answer = {'error': '{}: {}'.format(type(error).__name__, error)}
                print(json.dumps(answer), flush=True)

    # --- commands

    def pause(self):
        """Nothing is published any more but the cameras' lenses and a robot that stands still."""
        self.is_paused = True

    def resume(self):
        self.is_paused = False

    def set_rate(self, factor):
        """How often clouds are sent, as a multiple of the usual."""
        self.rate = factor

    def cut(self, times, topics):
        """Closes the connections of some topics, or of all."""
        closed = 0
        for topic, publisher in self.publishers.items():
            if not topics or topic in topics:
                for connection in list(publisher.impl.connections)[:times]:
                    connection.close()
                    closed += 1
        return closed

    def unconnected(self):
        return [topic for topic, publisher in self.publishers.items() if publisher.get_num_connections() == 0]

    def check(self, part, seed, secs, nsecs):
        """Publishes what a picture check shows; updates come as part 1, when what they update was received."""
        stamp = rospy.Time(secs, nsecs)
        self.publish_check(part, seed, stamp)
        for source in self.sources:
            if int(source.topic.endswith('_updates')) == part:
                for message in scene.check_messages(source, seed, stamp):
                    self.publishers[source.topic].publish(message)

    def publish_check(self, part, seed, stamp):
        pass


class Sensors(Publisher):
    """Clouds, scans and depth images."""

    def prepare(self):
        self.sources = [source for source in SOURCES if source.group == SENSORS]
        for source in self.sources:
            self.advertise(source.topic, source.kind)
            rng = scene.generator(self.seed, source.topic)
            if source.topic == scene.BEACON:
                self.repeat(source.hz, lambda source=source, rng=rng: self.send(source, source.make(rng, rospy.Time())))
            else:
                made = [serialized(source.make(rng, rospy.Time())) for _ in range(CLOUDS)]
                self.repeat(source.hz, lambda source=source, turn=itertools.cycle(made): self.send(
                    source, with_stamp(next(turn), rospy.Time.now())), True)

    def send(self, source, message):
        if not self.is_paused:
            self.publishers[source.topic].publish(message)


class Scene(Publisher):
    """All that is small, TF and the cameras' lenses."""

    def prepare(self):
        self.sources = [source for source in SOURCES if source.group == SCENE]
        self.begin, self.tf_silent_until, self.infos = time.monotonic(), 0.0, {}
        self.advertise('/tf', TFMessage)
        self.advertise('/tf_static', TFMessage, True).publish(scene.static_frames())
        for name in CAMERAS:
            self.advertise('/soak/{}/info'.format(name), CameraInfo, True)
            self.repeat(INFO_HZ, lambda name=name: self.send_info(name))
            self.send_info(name)
        self.repeat(TF_HZ, self.send_frames)
        self.handles = scene.Handles('soak')
        self.advertise(HANDLES, InteractiveMarkerUpdate)
        self.advertise(HANDLES + '_full', InteractiveMarkerInit, True).publish(self.handles.init())
        rng = scene.generator(self.seed, HANDLES)
        self.repeat(HANDLES_HZ, lambda: self.send_handles(rng))
        self.repeat(HANDLES_HZ, lambda: self.publishers[HANDLES].publish(self.handles.keep_alive()))
        for source in self.sources:
            self.advertise(source.topic, source.kind, source.latch)
            rng = scene.generator(self.seed, source.topic)
            self.repeat(source.hz, lambda source=source, rng=rng: self.send(source, rng))

    def send(self, source, rng):
        if not self.is_paused:
            self.publishers[source.topic].publish(source.make(rng, rospy.Time.now()))

    def send_frames(self, stamp=None):
        now = time.monotonic()
        if now >= self.tf_silent_until:
            seconds = 1.0 if self.is_paused else now - self.begin
            self.publishers['/tf'].publish(scene.moving_frames(seconds, stamp or rospy.Time.now()))

    def send_info(self, name):
        message = self.infos.get(name) or scene.camera_info(name)
        message.header.stamp = rospy.Time.now()
        self.publishers['/soak/{}/info'.format(name)].publish(message)

    def send_handles(self, rng, stamp=None):
        if stamp or not self.is_paused:
            self.publishers[HANDLES].publish(self.handles.update(rng, stamp or rospy.Time(), bool(stamp)))
            self.publishers[HANDLES + '_full'].publish(self.handles.init())

    def publish_check(self, part, seed, stamp):
        if part == 0:
            # Exactly at the stamp of the messages, so that nothing is interpolated.
            self.send_frames(stamp)
            self.send_handles(scene.generator(seed, HANDLES), stamp)

    def silence_tf(self, seconds):
        self.tf_silent_until = time.monotonic() + seconds

    def set_info(self, name, width, height, frame, broken):
        """Another lens of a camera; `broken` is what is wrong with it."""
        message = scene.camera_info(name, (width, height) if width else None, frame)
        projection = list(message.P)
        if broken == 'nan':
            projection[0] = math.nan
        elif broken == 'zero':
            message.width = 0
        elif broken == 'too large':
            message.width, message.height = 4000000000, 4000000000
        elif broken == 'no projection':
            projection = [0.0] * 12
        message.P = projection
        self.infos[name] = message
        self.send_info(name)

    def reset_info(self, name):
        self.infos.pop(name, None)
        self.send_info(name)


class Vandal(Publisher):
    """Publishes wrong messages, floods and frames that do not exist."""

    def prepare(self):
        for source in SOURCES:
            self.advertise(source.topic, source.kind)
        self.advertise(HANDLES, InteractiveMarkerUpdate)
        self.advertise('/tf', TFMessage)

    def wait(self, topic):
        until = time.monotonic() + 5
        while self.publishers[topic].get_num_connections() == 0 and time.monotonic() < until:
            time.sleep(0.02)
        return self.publishers[topic]

    def damage(self, topic, kind, seed, count):
        """Messages of one topic that are damaged in one way."""
        rng = random.Random(seed)
        if topic == HANDLES:
            make = scene.Handles('vandal').update
        else:
            make = next(source.make for source in SOURCES if source.topic == topic)
        values = scene.generator(seed, topic)
        publisher = self.wait(topic)
        for _ in range(count):
            publisher.publish(damaged(make(values, rospy.Time.now()), kind, rng))
            time.sleep(0.02)

    def unknown_frame(self, frame, count):
        for _ in range(count):
            for topic, kind in (('/soak/spheres', PointCloud2), ('/soak/pose', PoseStamped), ('/soak/odometry', Odometry)):
                make = next(source.make for source in SOURCES if source.topic == topic and source.kind is kind)
                message = make(scene.generator(count, topic), rospy.Time.now())
                message.header.frame_id = frame
                self.publishers[topic].publish(message)
            time.sleep(0.05)

    def made_up_frames(self, hz, seconds, seed):
        """Frames that nobody has heard of, some of them below others that do not exist."""
        publisher, until = self.wait('/tf'), time.monotonic() + seconds
        for number in itertools.count():
            if time.monotonic() > until:
                return number
            now = rospy.Time.now()
            parents = ('map', 'base_link', 'nowhere', 'made_up_{}_{}'.format(seed, number - 1))
            publisher.publish(TFMessage([scene.transform(
                parents[number % 4], 'made_up_{}_{}'.format(seed, number), (number % 7 - 3, number % 5, 2), stamp=now)]))
            time.sleep(1 / hz)

    def bad_frames(self, seed, count):
        """Transforms that no tree can take."""
        rng, publisher = random.Random(seed), self.wait('/tf')
        for _ in range(count):
            now = rospy.Time.now()
            bad = rng.choice([
                scene.transform('map', 'base_link', (math.nan, 0, 0), stamp=now),
                scene.transform('map', 'base_link', (0, 0, 0), (0, 0, 0, 0), now),
                scene.transform('map', 'base_link', (0, 0, 0), (math.inf, 0, 0, 1), now),
                scene.transform('base_link', 'base_link', (0, 0, 0), stamp=now),
                scene.transform('', 'base_link', (0, 0, 0), stamp=now),
                scene.transform('map', '', (0, 0, 0), stamp=now),
                scene.transform('map', 'base_link', (9, 9, 9), stamp=now - rospy.Duration(60)),
                scene.transform('map', 'x' * 5000, (0, 0, 0), stamp=now),
            ])
            publisher.publish(TFMessage([bad]))
            time.sleep(0.02)

    def many_markers(self, count, seconds):
        """Thousands of markers, which are deleted all at once."""
        rng, publisher = scene.generator(count, 'many'), self.wait('/soak/markers')
        markers = [scene.marker(rng, rospy.Time(), 'many', number) for number in range(count)]
        for one in markers:
            one.type = Marker.CUBE
            one.points = []
        publisher.publish(MarkerArray(markers))
        time.sleep(seconds)
        gone = Marker(action=3)
        gone.header.frame_id = 'map'
        publisher.publish(MarkerArray([gone]))

    def missing_meshes(self, addresses):
        publisher = self.wait('/soak/marker')
        for number, address in enumerate(addresses):
            one = scene.marker(scene.generator(number, address), rospy.Time(), 'missing', number)
            one.type, one.mesh_resource, one.mesh_use_embedded_materials = Marker.MESH_RESOURCE, address, True
            publisher.publish(one)
            time.sleep(0.05)


def main():
    group, seed = sys.argv[1], int(sys.argv[2])
    rospy.init_node('soak_' + group, disable_signals=True)
    commands = queue.Queue()
    publisher = {SENSORS: Sensors, SCENE: Scene, 'vandal': Vandal}[group](seed)

    def read():
        for line in sys.stdin:
            commands.put(json.loads(line))
        commands.put(None)

    threading.Thread(target=read, daemon=True).start()
    print(json.dumps('ready'), flush=True)
    publisher.run(commands)
    rospy.signal_shutdown('the soak is over')


if __name__ == '__main__':
    main()
