"""Points, turns, poses and colours of messages, from plain numbers.

Lengths are in metres and angles in radians. Turns are fixed-axis roll, pitch and yaw, as in URDF.
"""

import math

import numpy
from geometry_msgs.msg import Point, Point32, Pose, Quaternion, Transform, Vector3
from std_msgs.msg import ColorRGBA


def point(x=0.0, y=0.0, z=0.0):
    """A geometry_msgs/Point."""
    return Point(float(x), float(y), float(z))


def vector(x=0.0, y=0.0, z=0.0):
    """A geometry_msgs/Vector3."""
    return Vector3(float(x), float(y), float(z))


def quaternion(x=0.0, y=0.0, z=0.0, w=0.0):
    """A geometry_msgs/Quaternion of these numbers, whatever its length."""
    return Quaternion(float(x), float(y), float(z), float(w))


def turn(roll=0.0, pitch=0.0, yaw=0.0):
    """The geometry_msgs/Quaternion of a turn about the fixed axes x, then y, then z."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(angle / 2), math.cos(angle / 2)) for angle in (roll, pitch, yaw))
    return Quaternion(sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy,
                      cr * cp * cy + sr * sp * sy)


def pose(at=(0.0, 0.0, 0.0), turned=(0.0, 0.0, 0.0)):
    """A geometry_msgs/Pose. turned: roll, pitch and yaw, or a Quaternion."""
    return Pose(point(*at), _rotation(turned))


def transform(at=(0.0, 0.0, 0.0), turned=(0.0, 0.0, 0.0)):
    """A geometry_msgs/Transform. turned: roll, pitch and yaw, or a Quaternion."""
    return Transform(vector(*at), _rotation(turned))


def _rotation(turned):
    return turned if isinstance(turned, Quaternion) else turn(*turned)


def points(rows):
    """A list of geometry_msgs/Point from rows of x, y, z."""
    return [point(*row) for row in rows]


def points32(rows):
    """A list of geometry_msgs/Point32 from rows of x, y, z."""
    return [Point32(*map(float, row)) for row in rows]


def color(red=0.0, green=0.0, blue=0.0, alpha=1.0):
    """A std_msgs/ColorRGBA, channels usually from 0 to 1."""
    return ColorRGBA(float(red), float(green), float(blue), float(alpha))


def colors(rows):
    """A list of std_msgs/ColorRGBA from rows of red, green, blue and, if it is not 1, alpha."""
    return [color(*row) for row in rows]


def look_at(eye, target, roll=0.0):
    """The Quaternion of a camera's optical frame (x right, y down, z ahead) at `eye`, looking at `target`.

    The picture's upper edge is level, turned clockwise about the view by `roll`. A view along z has x to its right.
    """
    ahead = numpy.subtract(target, eye).astype(float)
    ahead /= numpy.linalg.norm(ahead)
    right = numpy.cross(ahead, (0.0, 0.0, 1.0))
    if numpy.linalg.norm(right) < 1e-9:
        right = numpy.array((1.0, 0.0, 0.0))
    right /= numpy.linalg.norm(right)
    down = numpy.cross(ahead, right)
    right, down = math.cos(roll) * right + math.sin(roll) * down, math.cos(roll) * down - math.sin(roll) * right
    return _quaternion_of(numpy.column_stack((right, down, ahead)))


def _quaternion_of(matrix):
    """The Quaternion, with a w that is not negative, of a 3 × 3 rotation matrix."""
    size = [math.sqrt(max(0.0, 1 + matrix[0, 0] * a + matrix[1, 1] * b + matrix[2, 2] * c)) / 2
            for a, b, c in ((1, -1, -1), (-1, 1, -1), (-1, -1, 1), (1, 1, 1))]
    # From the largest component, the others follow without loss.
    largest = int(numpy.argmax(size))
    x, y, z, w = size
    off = {name: matrix[i, j] + sign * matrix[j, i] for name, (i, j, sign) in {
        "xw": (2, 1, -1), "yw": (0, 2, -1), "zw": (1, 0, -1), "xy": (0, 1, 1), "xz": (0, 2, 1), "yz": (1, 2, 1)}.items()}
    if largest == 0:
        y, z, w = off["xy"] / (4 * x), off["xz"] / (4 * x), off["xw"] / (4 * x)
    elif largest == 1:
        x, z, w = off["xy"] / (4 * y), off["yz"] / (4 * y), off["yw"] / (4 * y)
    elif largest == 2:
        x, y, w = off["xz"] / (4 * z), off["yz"] / (4 * z), off["zw"] / (4 * z)
    else:
        x, y, z = off["xw"] / (4 * w), off["yw"] / (4 * w), off["zw"] / (4 * w)
    sign = -1.0 if w < 0 else 1.0
    return Quaternion(sign * x, sign * y, sign * z, sign * w)
