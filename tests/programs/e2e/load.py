"""Messages of many things before the camera, of very many points, which NumPy makes, and what is seen of them."""
import numpy
from geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped, Quaternion, Vector3
from nav_msgs.msg import Path
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from python_node import *

rng = numpy.random.default_rng(7)


def pose(i, shift):
    return Pose(Point(i % 40 * 0.05 - 1 + shift, i // 40 * 0.05 - 0.6, 2), Quaternion(0, 0, 0, 1))


def cubes(count, shift):
    return MarkerArray([Marker(header=Header(frame_id='map'), ns='many', id=i, type=Marker.CUBE, pose=pose(i, shift),
                               scale=Vector3(.02, .02, .02), color=ColorRGBA(0, 1, 0, 1)) for i in range(count)])


def path(count, shift):
    return Path(Header(frame_id='map'), [PoseStamped(pose=pose(i, shift)) for i in range(count)])


def poses(count, shift):
    return PoseArray(Header(frame_id='map'), [pose(i, shift) for i in range(count)])


def points(count, shift):
    return cloud(0x0000ff, points=[(i % 100 * .02 - 1 + shift, i // 100 * .02 - 1, 2.5) for i in range(count)])


def crowd(count, kind, seen=None):
    def marker(i):
        at = Point(i % 317 * 0.01 - 1.58, i // 317 * 0.0076 - 1.2, 2.5 + i % 7 * 0.2)
        at.z *= 1 if seen in (None, i) else -1
        size = Vector3(.1, .01, .01) if kind == Marker.ARROW else Vector3(.05, .05, .05)
        text = 'item %d' % i if kind == Marker.TEXT_VIEW_FACING else ''
        return Marker(header=Header(frame_id='map'), ns='many', id=i, type=kind, scale=size, text=text,
                      pose=Pose(at, Quaternion(0, 0.6, 0, 0.8)), color=ColorRGBA(0, 1, .5, 1))
    return written(MarkerArray([marker(i) for i in range(count)]))


def longest_gap():
    first = {}
    for image in viewer.images:
        first.setdefault(image[6], image[0])
    times = sorted(first.values()) + [viewer.images[-1][0]]
    return max(b - a for a, b in zip(times, times[1:]))


def heavy_cloud(places):
    message = cloud(0, points=[])
    message.width, message.row_step = len(places), 16 * len(places)
    points = numpy.empty((len(places), 4), '<f4')
    points[:, :3] = places
    points.view('<u4')[:, 3] = numpy.arange(len(places)) * 0x3f5f7 & 0x00ffff
    message.data = points.tobytes()
    return written(message)


def spread(f, z):
    rows, columns = numpy.mgrid[0:480, 0:640].reshape(2, -1)
    return numpy.stack([(columns - 319.5) / f * z, (rows - 239.5) / f * z, numpy.full(640 * 480, z)], 1)


def in_one_place():
    return numpy.tile([0.003, -0.002, 0.06], (640 * 480, 1))


def between(count, f, near, far):
    z = rng.uniform(near, far, count)
    z += numpy.where(abs(z) < .03, numpy.copysign(.03, z), 0)
    return numpy.stack([rng.uniform(-320, 320, count) / f * z, rng.uniform(-240, 240, count) / f * z, z], 1)


def around(count):
    places = rng.uniform(-2, 2, (count, 3))
    places[:, 2] = numpy.abs(places[:, 2]) + 0.1
    places[count // 2:, 2] *= -1
    return places


def filling(count):
    corners = numpy.array([[-2, -2, 1], [0, 4, 1], [2, -2, 1]])
    return (rng.uniform(1, 3, (count, 1, 1)) * corners).reshape(-1, 3)


def of_points(kind, places, size=0.01, alpha=1):
    marker = Marker(header=Header(frame_id='map'), ns='heavy', type=kind, pose=Pose(orientation=Quaternion(0, 0, 0, 1)),
                    scale=Vector3(size, size, size), color=ColorRGBA(0, 1, .5, alpha), points=[Point(1, 2, 3)])
    data, one = serialized(marker), struct.pack('<I3d', 1, 1, 2, 3)
    assert data.count(one) == 1
    return written(marker, data.replace(one, struct.pack('<I', len(places)) + places.astype('<f8').tobytes()))


none = cloud(0, points=[])
no_marker = Marker(action=Marker.DELETEALL)


def shown():
    if viewer.last is None:
        return False
    pixels = numpy.frombuffer(viewer.last.data, 'u1').reshape(-1, 3).astype(int)
    return (numpy.abs(pixels[:, 1:] - [0, 200]).max(axis=1) > 20).sum() > 1000
