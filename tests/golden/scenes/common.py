"""Messages and frames that several cases share."""

import math

from geometry_msgs.msg import PoseArray
from nav_msgs.msg import Path

from .geometry import pose
from .messages import CUBE, CYLINDER, SPHERE, frame_at, frames, header, marker, markers, occupancy_grid, pose_stamped

# Each value that a cell of an OccupancyGrid can have.
EVERY_VALUE = [(i + 128) % 256 - 128 for i in range(256)]


def sphere_cube_cylinder():
    """A MarkerArray of three shapes, the last of them translucent."""
    return markers(
        marker(SPHERE, at=(-0.3, 0.3, 0.3), size=0.4, paint=(0.9, 0.9, 0.9)),
        marker(CUBE, at=(0.4, -0.3, 0.25), turned=(0.3, 0.2, 0.5), size=(0.3, 0.3, 0.5), paint=(0.2, 0.6, 1), id=1),
        marker(CYLINDER, at=(-0.4, -0.4, 0.3), turned=(0, 0.3, 0), size=(0.3, 0.3, 0.6), paint=(1, 0.5, 0.1, 0.6), id=2))


def two_cubes():
    """A MarkerArray of an opaque cube and a translucent one."""
    return markers(marker(CUBE, at=(0.2, 0.1, 0.05), size=0.4, paint=(1, 0.4, 0.1)),
                   marker(CUBE, at=(-0.4, 0.3, 0.3), size=0.3, paint=(0.1, 0.5, 1, 0.5), id=1))


def four_cubes():
    """A row of cubes in the namespaces `a` and `b`, in turn, each turned further."""
    return [
        marker(CUBE, at=(-0.6, 0, 0.2), size=0.25, paint=(1, 0, 0.3), ns="a"),
        marker(CUBE, at=(-0.2, 0, 0.2), turned=(0, 0, 0.3), size=0.25, paint=(1, 0.2, 0.3), ns="b", id=1),
        marker(CUBE, at=(0.2, 0, 0.2), turned=(0, 0, 0.6), size=0.25, paint=(1, 0.4, 0.3), ns="a", id=2),
        marker(CUBE, at=(0.6, 0, 0.2), turned=(0, 0, 0.9), size=0.25, paint=(1, 0.6, 0.3), ns="b", id=3)]


def map_of_every_value(height=0.0):
    """An OccupancyGrid with each value that a cell can have."""
    return occupancy_grid(0.1, (16, 16), (-0.8, -0.8, height), data=EVERY_VALUE)


def oval_path(aside=0.0, above=0.0, frame="base_link"):
    """A Path along three quarters of an ellipse, moved along y and z."""
    return Path(header=header(frame), poses=[
        pose_stamped((0.9 * math.cos(0.4 * i), aside + 0.7 * math.sin(0.4 * i), 0.1 + above + 0.03 * i),
                     (0, 0.2, 1.57 + 0.4 * i), frame) for i in range(13)])


def _rising_pose(i):
    return (0.6 * math.cos(5 * i / 24), 0.6 * math.sin(5 * i / 24), 0.25 * i / 24), (0, 0, 1.57 + 5 * i / 24)


def rising_path():
    """A Path that turns and rises."""
    return Path(header=header(), poses=[pose_stamped(*_rising_pose(i)) for i in range(25)])


def rising_poses():
    """The poses of the rising path as a PoseArray."""
    return PoseArray(header=header(), poses=[pose(*_rising_pose(i)) for i in range(25)])


def turning_poses():
    """A PoseArray around a circle, each pose turned differently."""
    return PoseArray(header=header(), poses=[
        pose((0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.1 + 0.05 * i), (0.2 * i, -0.3, 0.7 * i)) for i in range(8)])


def cart_frame():
    """A TFMessage with the frame `cart`."""
    return frames(frame_at("cart", "base_link", (0.4, 0.3, 0.2), (0, 0, 1)))


def arm_frame():
    """A TFMessage with the frame `arm`, on the cart."""
    return frames(frame_at("arm", "cart", (0.3, -0.2, 0.3), (0, 1, 0)))


def arm_frames(scene):
    """Places the links of `arm.urdf`."""
    scene.frame("shoulder", at=(0, -0.3, 0.1), turned=(0, 0, 0.5))
    scene.frame("upper", parent="shoulder", at=(0, 0, 0.15), turned=(0, -0.7, 0))
    scene.frame("lower", parent="upper", at=(0.5, 0, 0), turned=(0.3, 1.1, 0))
    scene.frame("hand", parent="lower", at=(0.4, 0, 0), turned=(0.5, 0.2, 0.1))
    scene.frame("root")


def lamp_frames(scene):
    """Places the links of `lamp.urdf`."""
    scene.frame("lamp_base", at=(0, -0.2, 0.05), turned=(0, 0, 0.3))
    scene.frame("lamp_arm", parent="lamp_base", at=(0, 0, 0.05), turned=(0, 0.4, 0))
    scene.frame("lamp_head", parent="lamp_arm", at=(0, 0, 0.65), turned=(0, 0.8, 0))
    scene.frame("lamp_gear", parent="lamp_base", at=(0, 0.5, 0))
