"""Plays a scene to rviz and takes the picture that its CameraPub publishes.

A `SceneNode` is the ROS node that publishes a scene's messages and watches an image topic. A picture is taken once it has
stopped changing, which is counted in frames of rviz, not in seconds: on a slow machine rviz draws fewer frames, and each of
them takes in the messages that have arrived before it.

A Python process can be a node of one master only, so there is one SceneNode in a process, for one stage.
"""

import os
import threading
import time
import warnings
from typing import NamedTuple

import numpy

from .processes import wait_until

TIMEOUT_SECS = 120.0
# Frames of rviz after each message, so that it is taken in before the next one comes.
FRAMES_BETWEEN_MESSAGES = 3
# Equal frames after the last message until a picture counts as finished, and the time that they take at least.
EQUAL_FRAMES = 12
SETTLE_SECS = 0.6
# How long a frame is waited for after a message: the first after a CameraInfo, and any other. Not each message brings one,
# and before a CameraInfo there are none.
FIRST_FRAME_PATIENCE_SECS = 5.0
FRAME_PATIENCE_SECS = 0.3
# An rviz that publishes no picture for so long has stopped for good.
FROZEN_SECS = 8.0

# An interactive marker server's whole state: rviz subscribes to it when the first update arrives, until it has one message.
PASSING_SUBSCRIPTION = ("visualization_msgs/InteractiveMarkerInit",)

CHANNELS = {"rgb8": "RGB", "rgba8": "RGBA", "bgr8": "BGR", "bgra8": "BGRA", "mono8": "L", "mono16": "L"}


class Picture(NamedTuple):
    """A published image: `pixels` is height × width × 3 (RGB) of 8 bits, or height × width of 8 or 16 bits."""

    pixels: numpy.ndarray
    encoding: str
    frame_id: str


def picture_of(message):
    """The Picture of a sensor_msgs/Image. Alpha is left out, because golden pictures have none."""
    channels = CHANNELS.get(message.encoding)
    if channels is None:
        raise ValueError(f"the image has the encoding {message.encoding!r}, expected one of {', '.join(CHANNELS)}")
    depth = numpy.dtype("u1" if message.encoding != "mono16" else ">u2" if message.is_bigendian else "<u2")
    rows = numpy.frombuffer(message.data, numpy.uint8).reshape(message.height, message.step)
    used = message.width * len(channels) * depth.itemsize
    pixels = numpy.ascontiguousarray(rows[:, :used]).view(depth).reshape(message.height, message.width, len(channels))
    if channels == "L":
        return Picture(pixels[:, :, 0].astype(depth.newbyteorder("=")), message.encoding, message.header.frame_id)
    order = [channels.index(channel) for channel in "RGB"]
    return Picture(numpy.ascontiguousarray(pixels[:, :, order]), message.encoding, message.header.frame_id)


class PictureWatch:
    """The pictures of one topic: the last one, how many there were, and how many equal ones at the end."""

    def __init__(self, topic, programs=()):
        """Subscribes, and waits until there is a publisher. programs: those that must not end meanwhile."""
        import rospy
        from sensor_msgs.msg import Image
        self._lock = threading.Lock()
        self.last, self.last_secs, self.count, self.equal = None, 0.0, 0, 0
        self._subscriber = rospy.Subscriber(topic, Image, self._received, queue_size=5, buff_size=1 << 25)
        wait_until(lambda: self._subscriber.get_num_connections(), TIMEOUT_SECS, f"nobody publishes {topic}", programs)

    def _received(self, message):
        with self._lock:
            # A change of the size alone leaves as many bytes where width and height are exchanged.
            last = self.last
            same = (last is not None and last.data == message.data and last.width == message.width
                    and last.encoding == message.encoding)
            self.last, self.last_secs = message, time.monotonic()
            self.count, self.equal = self.count + 1, self.equal + 1 if same else 1

    def start_counting(self):
        """Forgets how many equal pictures there were, and returns the number of all."""
        with self._lock:
            self.equal = 0
            return self.count

    def close(self):
        self._subscriber.unregister()


class SceneNode:
    """The node `/scene` on a stage's master."""

    def __init__(self, stage):
        os.environ.update({name: stage.environment[name] for name in ("ROS_MASTER_URI", "ROS_HOME", "ROS_HOSTNAME")})
        import rospy
        self.stage = stage
        rospy.init_node("scene", disable_signals=True, disable_rosout=True)

    def play(self, messages, programs, watch, optional=False, frozen=False):
        """Publishes the messages, latched, once rviz has subscribed to their topics, and waits until the picture stands still.

        messages: (topic, message) in their order.
        programs: those that must not end meanwhile.
        watch: the PictureWatch of the camera's topic.
        optional: rviz need not subscribe to each of the topics, as when a display is switched off.
        frozen: as of `picture`.
        Returns the Picture. Raises TimeoutError when a topic gets no subscriber, or no picture comes.
        """
        import rospy
        types = {topic: type(message) for topic, message in messages}
        # The topics of which a subscriber has received the latched message.
        reached = set()

        class Listener(rospy.SubscribeListener):
            def peer_subscribe(self, topic_name, *_):
                reached.add(topic_name)

        with warnings.catch_warnings():
            # Without a queue, a message has been written to the connection when `publish` returns. rospy warns of that.
            warnings.simplefilter("ignore", SyntaxWarning)
            publishers = {
                topic: rospy.Publisher(topic, kind, latch=True, queue_size=None, subscriber_listener=Listener())
                for topic, kind in types.items()}
        try:
            passing = {topic for topic, kind in types.items() if kind._type in PASSING_SUBSCRIPTION}
            for topic in publishers.keys() - passing:
                wait_until(lambda topic=topic: self._is_connected(topic, publishers[topic], optional), TIMEOUT_SECS,
                           f"rviz has not connected to {topic}", programs)
            for topic, message in messages:
                publishers[topic].publish(message)
                self._wait_for_frames(watch, message)
            wait_until(lambda: passing <= reached, TIMEOUT_SECS, f"rviz has not connected to {passing}", programs)
            return self.picture(watch, programs, frozen)
        finally:
            for publisher in publishers.values():
                publisher.unregister()

    def _is_connected(self, topic, publisher, optional):
        wanted = sum(len(nodes) for name, nodes in self.stage.system_state()[1] if name == topic)
        return publisher.get_num_connections() >= (wanted if optional else max(wanted, 1))

    @staticmethod
    def _wait_for_frames(watch, message):
        first = watch.count
        patience = FRAME_PATIENCE_SECS
        if first == 0 and message._type == "sensor_msgs/CameraInfo":
            patience = FIRST_FRAME_PATIENCE_SECS
        seen, end = first, time.monotonic() + patience
        while watch.count < first + FRAMES_BETWEEN_MESSAGES and time.monotonic() < end:
            if watch.count > seen:
                seen, end = watch.count, time.monotonic() + FRAME_PATIENCE_SECS
            time.sleep(0.005)

    @staticmethod
    def picture(watch, programs=(), frozen=False):
        """The picture once it stands still, counted from now.

        frozen: rviz is known to stop meanwhile; then it is the last picture.
        """
        start, begin = watch.start_counting(), time.monotonic()

        def stands_still():
            secs = time.monotonic() - max(begin, watch.last_secs)
            if frozen and watch.last is not None and secs > FROZEN_SECS:
                return True
            # The first frame may have been drawn before the last message arrived.
            return (watch.equal >= EQUAL_FRAMES and watch.count > start + EQUAL_FRAMES
                    and time.monotonic() - begin > SETTLE_SECS)

        wait_until(stands_still, TIMEOUT_SECS,
                   f"the picture does not stand still ({watch.count - start} pictures received)", programs)
        return picture_of(watch.last)
