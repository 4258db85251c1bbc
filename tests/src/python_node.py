"""A ROS node that runs the Python code that a test sends.

Each request on standard input is a line with the number of bytes that follow, and those bytes of Python; it is evaluated
in this module. The answer on standard output is a line `ok N` or `error N`, and N bytes of text.
"""
import io
import struct
import sys
import threading
import time
import traceback
import zlib

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

publishers = {}
arrays, known = [], {}
viewer = monitor_subscriber = None
# What rospy prints must not come between the answers.
answers, sys.stdout = sys.stdout.buffer, sys.stderr
# What tests send may import it.
sys.modules["python_node"] = sys.modules[__name__]


def publisher(topic, kind, latch):
    if topic not in publishers:
        if latch:
            latch_first(topic, kind)
        publishers[topic] = rospy.Publisher(topic, kind, latch=latch, queue_size=100)
    return publishers[topic]


def latch_first(topic, kind):
    """rospy registers a publisher before it has it latch: a subscriber that connects in between would be told that it does
    not."""
    manager, impl = rospy.topics.get_topic_manager(), rospy.topics._PublisherImpl(rospy.resolve_name(topic), kind)
    if impl.resolved_name not in manager.pubs:
        impl.enable_latch()
        manager._add(impl, manager.pubs, rospy.topics.Registration.PUB)


def latch(topic, message):
    """Publishes a latched message."""
    publisher(topic, type(message), True).publish(message)


def send(topic, message):
    """Publishes a message as soon as there is a subscriber."""
    out = publisher(topic, type(message), False)
    until = time.monotonic() + 300
    while out.get_num_connections() == 0:
        if time.monotonic() > until:
            raise TimeoutError("no subscriber of " + topic)
        time.sleep(0.01)
    out.publish(message)


def trigger(service):
    rospy.wait_for_service(service, 300)
    answer = rospy.ServiceProxy(service, Trigger)()
    return answer.success, answer.message


def info(frame="eye", width=64, height=48, f=50.0, **fields):
    message = CameraInfo(width=width, height=height)
    message.header.frame_id = frame
    message.K = [f, 0, width / 2, 0, f, height / 2, 0, 0, 1]
    message.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    message.P = [f, 0, width / 2, 0, 0, f, height / 2, 0, 0, 0, 1, 0]
    for name, value in fields.items():
        setattr(message, name, value)
    return message


def cloud(color, frame="map", points=((0, 0, 2),), stamp=rospy.Time()):
    """Points of one colour, 0xRRGGBB."""
    message = PointCloud2(height=1, width=len(points), point_step=16, row_step=16 * len(points), is_dense=True)
    message.header.frame_id = frame
    message.header.stamp = stamp
    names = enumerate(["x", "y", "z", "rgb"])
    message.fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in names]
    message.data = b"".join(struct.pack("<fffI", *point, color) for point in points)
    return message


def tf(parent, child, xyz=(0, 0, 0), q=(0, 0, 0, 1), stamp=rospy.Time()):
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id = parent
    transform.header.stamp = stamp
    t, r = transform.transform.translation, transform.transform.rotation
    t.x, t.y, t.z = xyz
    r.x, r.y, r.z, r.w = q
    return TFMessage([transform])


def place_camera(**fields):
    """Publishes where the camera `eye` is, and its CameraInfo."""
    latch("/tf_static", tf("map", "eye"))
    latch("/eye/camera_info", info(**fields))


def show(color=0xFF0000, topic="/view/image", **fields):
    """Publishes the camera and a cloud of one point before it, and watches its image as `viewer`."""
    global viewer
    place_camera(**fields)
    latch("/cloud", cloud(color))
    viewer = Viewer(topic)


def monitor(topic="/diagnostics"):
    """Keeps arrivals, stamps and names of diagnostics, and the last (level, message, hardware, values) of each name."""
    global monitor_subscriber
    monitor_subscriber = rospy.Subscriber(topic, DiagnosticArray, note)


def note(array):
    arrays.append((time.time(), array.header.stamp.to_sec(), [status.name for status in array.status]))
    for status in array.status:
        level = ord(status.level) if isinstance(status.level, bytes) else status.level
        pairs = {value.key: value.value for value in status.values}
        known[status.name] = (level, status.message, status.hardware_id, pairs)


def level(name):
    return known[name][0] if name in known else None


def message(name):
    return known[name][1] if name in known else None


def values(name):
    return known[name][3] if name in known else {}


def serialized(message):
    """A message's bytes."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def written(message, data=None):
    """A message serialised once, for large ones that are sent very often, or of its type with the bytes that are given."""
    data = data or serialized(message)
    return type("Written", (type(message),), {"serialize": lambda _, buff: buff.write(data)})()


class PublishRepeatedly(threading.Thread):
    """Publishes `make(i)` at a rate from now on, until `stop()`."""

    def __init__(self, rate_hz, make, topic):
        super().__init__(daemon=True)
        self.period_secs, self.make = 1 / rate_hz, make
        self.out = publisher(topic, type(make(0)), False)
        self.ended = threading.Event()
        self.start()

    def run(self):
        i = 0
        while not self.ended.is_set():
            self.out.publish(self.make(i))
            i += 1
            self.ended.wait(self.period_secs)

    def stop(self):
        """Returns once the last message has been published."""
        self.ended.set()
        self.join()


class Viewer:
    """Subscribes to an image topic and its CameraInfo, and keeps what it received."""

    def __init__(self, topic):
        self.images = []  # (arrival, seq, stamp, frame_id, width, height, checksum)
        self.infos = []  # (arrival, seq, stamp, frame_id, width, height, publisher)
        self.colors = []  # of the pixel in the middle, each time that it changed
        self.last = None
        self.quiet_since = time.monotonic()
        self.subscribers = [
            rospy.Subscriber(topic, Image, self.see, queue_size=10, buff_size=1 << 24),
            rospy.Subscriber(topic.rsplit("/", 1)[0] + "/camera_info", CameraInfo, self.read, queue_size=10),
        ]

    def see(self, image):
        header = image.header
        self.last = image
        self.quiet_since = time.monotonic()
        color = self.pixel(image.width // 2, image.height // 2)
        if self.colors[-1:] != [color]:
            self.colors.append(color)
        record = (time.time(), header.seq, header.stamp.to_sec(), header.frame_id, image.width, image.height)
        self.images.append(record + (zlib.crc32(image.data),))

    def read(self, message):
        header = message.header
        record = (time.time(), header.seq, header.stamp.to_sec(), header.frame_id, message.width, message.height)
        self.infos.append(record + (message._connection_header["callerid"],))

    def pixel(self, u, v):
        size = self.last.step // self.last.width
        at = v * self.last.step + u * size
        return tuple(self.last.data[at : at + size])

    def middle(self):
        return self.pixel(self.last.width // 2, self.last.height // 2) if self.last else None

    def quiet_secs(self):
        """How long no image has arrived."""
        return time.monotonic() - self.quiet_since

    def forget(self):
        self.images, self.infos, self.colors, self.last = [], [], [], None

    def close(self):
        for subscriber in self.subscribers:
            subscriber.unregister()

    def save(self, path):
        with open(path, "wb") as file:
            file.write(self.last.data)


def answer(word, text):
    data = text.encode()
    answers.write(b"%s %d\n" % (word, len(data)) + data)
    answers.flush()


def serve():
    space = globals()
    while True:
        head = sys.stdin.buffer.readline()
        if not head:
            return
        request = sys.stdin.buffer.read(int(head)).decode()
        try:
            try:
                code = compile(request, "request", "eval")
            except SyntaxError:
                exec(compile(request, "request", "exec"), space)
                answer(b"ok", "")
                continue
            answer(b"ok", str(eval(code, space)))
        except Exception:
            answer(b"error", traceback.format_exc())


rospy.init_node("python_node", disable_signals=True)
answer(b"ok", "")
serve()
rospy.signal_shutdown("the test is over")
