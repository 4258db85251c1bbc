"""Messages of the scenes, with the fields that a scene usually says nothing about filled in.

ROS's message classes are used where nothing has to be filled in.
"""

import genpy
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from .geometry import color, pose, transform, vector

# The stamp of all messages, in seconds.
STAMP_SECS = 1700000000


def time_at(secs=0.0):
    """The genpy.Time that is `secs` after the scene's stamp."""
    return genpy.Time.from_sec(STAMP_SECS) + genpy.Duration.from_sec(secs)


def header(frame="base_link", secs=0.0):
    """A std_msgs/Header in `frame`, stamped `secs` after the scene's stamp."""
    return Header(stamp=time_at(secs), frame_id=frame)


def marker(kind, at=(0.0, 0.0, 0.0), turned=(0.0, 0.0, 0.0), size=(0.0, 0.0, 0.0), paint=(0.0, 0.0, 0.0, 0.0),
           frame="base_link", **fields):
    """A Marker in the namespace `m`, whose stamp is 0: placed by the last transform.

    size: its scale; paint: its colour and alpha; fields: those of Marker, as they are.
    """
    fields = {"header": Header(frame_id=frame), "ns": "m", **fields}
    return Marker(type=kind, pose=pose(at, turned), scale=vector(*size), color=color(*paint), **fields)


def markers(*each):
    """A MarkerArray."""
    return MarkerArray(markers=list(each))


def frame_at(child, parent="base_link", at=(0.0, 0.0, 0.0), turned=(0.0, 0.0, 0.0), secs=0.0):
    """A TransformStamped that places `child` in `parent`."""
    return TransformStamped(header=header(parent, secs), child_frame_id=child, transform=transform(at, turned))


def frames(*each):
    """A TFMessage of several TransformStamped."""
    return TFMessage(transforms=list(each))


def camera_info(frame, size, focal, centre=None, shift=(0.0, 0.0), **fields):
    """A CameraInfo without distortion. All lengths are in pixels.

    size: width and height. focal: that of x and of y. centre: the principal point, the picture's middle if it is None.
    shift: P's fourth column, minus the focal length times the camera's offset. fields: those of CameraInfo, instead of the
    usual ones.
    """
    width, height = size
    fx, fy = focal
    cx, cy = centre or (width / 2, height / 2)
    usual = {"D": [0.0] * 5, "K": [fx, 0, cx, 0, fy, cy, 0, 0, 1], "R": [1, 0, 0, 0, 1, 0, 0, 0, 1],
             "P": [fx, 0, cx, shift[0], 0, fy, cy, shift[1], 0, 0, 1, 0], "distortion_model": "plumb_bob",
             "header": header(frame)}
    usual.update(fields)
    return CameraInfo(width=width, height=height, **usual)


def covariance(x, y, z, roll, pitch, yaw, others=None):
    """The 36 numbers of a pose's covariance from its diagonal; others: those beside it, by row and column."""
    rows = [[0.0] * 6 for _ in range(6)]
    for index, value in enumerate((x, y, z, roll, pitch, yaw)):
        rows[index][index] = value
    for (row, column), value in (others or {}).items():
        rows[row][column] = value
    return [value for row in rows for value in row]
