"""Messages that several cases share."""

import math

from geometry_msgs.msg import PoseArray, PoseStamped
from nav_msgs.msg import MapMetaData, OccupancyGrid, Path
from visualization_msgs.msg import InteractiveMarkerUpdate, Marker

from .geometry import pose
from .messages import frame_at, frames, header, marker, markers


def sphere_cube_cylinder():
    """A MarkerArray of three shapes, the last of them translucent."""
    return markers(
        marker(Marker.SPHERE, at=(-0.3, 0.3, 0.3), size=(0.4, 0.4, 0.4), paint=(0.9, 0.9, 0.9, 1)),
        marker(Marker.CUBE, at=(0.4, -0.3, 0.25), turned=(0.3, 0.2, 0.5), size=(0.3, 0.3, 0.5), paint=(0.2, 0.6, 1, 1), id=1),
        marker(Marker.CYLINDER, at=(-0.4, -0.4, 0.3), turned=(0, 0.3, 0), size=(0.3, 0.3, 0.6), paint=(1, 0.5, 0.1, 0.6), id=2))


def no_update():
    """The first InteractiveMarkerUpdate of the server `/s`, which keeps its connection alive."""
    return InteractiveMarkerUpdate(server_id="/s", seq_num=1)


def two_cubes():
    """A MarkerArray of an opaque cube and a translucent one."""
    return markers(marker(Marker.CUBE, at=(0.2, 0.1, 0.05), size=(0.4, 0.4, 0.4), paint=(1, 0.4, 0.1, 1)),
                   marker(Marker.CUBE, at=(-0.4, 0.3, 0.3), size=(0.3, 0.3, 0.3), paint=(0.1, 0.5, 1, 0.5), id=1))


def map_of_every_value():
    """An OccupancyGrid with each value that a cell can have."""
    return OccupancyGrid(
        header=header(), info=MapMetaData(resolution=0.1, width=16, height=16, origin=pose((-0.8, -0.8, 0))),
        data=[(i + 128) % 256 - 128 for i in range(256)])


def raised_map_of_every_value():
    """The map of every value, 0.1 m higher."""
    return OccupancyGrid(
        header=header(), info=MapMetaData(resolution=0.1, width=16, height=16, origin=pose((-0.8, -0.8, 0.1))),
        data=[(i + 128) % 256 - 128 for i in range(256)])


def four_cubes():
    """A MarkerArray of a row of cubes in the namespaces `a` and `b`, in turn."""
    return markers(
        marker(Marker.CUBE, at=(-0.6, 0, 0.2), size=(0.25, 0.25, 0.25), paint=(1, 0, 0.3, 1), ns="a"),
        marker(Marker.CUBE, at=(-0.2, 0, 0.2), turned=(0, 0, 0.3), size=(0.25, 0.25, 0.25), paint=(1, 0.2, 0.3, 1), ns="b", id=1),
        marker(Marker.CUBE, at=(0.2, 0, 0.2), turned=(0, 0, 0.6), size=(0.25, 0.25, 0.25), paint=(1, 0.4, 0.3, 1), ns="a", id=2),
        marker(Marker.CUBE, at=(0.6, 0, 0.2), turned=(0, 0, 0.9), size=(0.25, 0.25, 0.25), paint=(1, 0.6, 0.3, 1), ns="b", id=3))


def oval_path():
    """A Path along three quarters of an ellipse."""
    return Path(header=header(), poses=[PoseStamped(header=header(), pose=pose(
        (0.9 * math.cos(0.4 * i), 0.7 * math.sin(0.4 * i), 0.1 + 0.03 * i), (0, 0.2, 1.57 + 0.4 * i))) for i in range(13)])


def oval_path_of_sensor():
    """The oval path in the frame `sensor`."""
    return Path(header=header("sensor"), poses=[PoseStamped(header=header("sensor"), pose=pose(
        (0.9 * math.cos(0.4 * i), 0.7 * math.sin(0.4 * i), 0.1 + 0.03 * i), (0, 0.2, 1.57 + 0.4 * i))) for i in range(13)])


def rising_path():
    """A Path that turns and rises."""
    return Path(header=header(), poses=[PoseStamped(header=header(), pose=pose(
        (0.6 * math.cos(5 * i / 24), 0.6 * math.sin(5 * i / 24), 0.25 * i / 24), (0, 0, 1.57 + 5 * i / 24))) for i in range(25)])


def oval_path_aside():
    """The oval path, moved along y."""
    return Path(header=header(), poses=[PoseStamped(header=header(), pose=pose(
        (0.9 * math.cos(0.4 * i), 0.3 + 0.7 * math.sin(0.4 * i), 0.1 + 0.03 * i), (0, 0.2, 1.57 + 0.4 * i))) for i in range(13)])


def oval_path_above():
    """The oval path, moved along z."""
    return Path(header=header(), poses=[PoseStamped(header=header(), pose=pose(
        (0.9 * math.cos(0.4 * i), 0.7 * math.sin(0.4 * i), 0.4 + 0.03 * i), (0, 0.2, 1.57 + 0.4 * i))) for i in range(13)])


def rising_poses():
    """The poses of the rising path as a PoseArray."""
    return PoseArray(header=header(), poses=[pose(
        (0.6 * math.cos(5 * i / 24), 0.6 * math.sin(5 * i / 24), 0.25 * i / 24), (0, 0, 1.57 + 5 * i / 24)) for i in range(25)])


def turning_poses():
    """A PoseArray around a circle, each pose turned differently."""
    return PoseArray(header=header(), poses=[pose(
        (0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.1 + 0.05 * i), (0.2 * i, -0.3, 0.7 * i)) for i in range(8)])


def cart_frame():
    """A TFMessage with the frame `cart`."""
    return frames(frame_at("cart", "base_link", (0.4, 0.3, 0.2), (0, 0, 1)))


def arm_frame():
    """A TFMessage with the frame `arm`, on the cart."""
    return frames(frame_at("arm", "cart", (0.3, -0.2, 0.3), (0, 1, 0)))
