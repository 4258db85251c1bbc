"""Messages of the scenes, with the fields that a scene usually says nothing about filled in.

ROS's message classes are used where nothing has to be filled in.
"""

import genpy
from geometry_msgs.msg import Accel, AccelStamped, PoseStamped, PoseWithCovariance, PoseWithCovarianceStamped
from geometry_msgs.msg import TransformStamped, Twist, TwistStamped, Wrench, WrenchStamped
from nav_msgs.msg import MapMetaData, OccupancyGrid
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from .geometry import color, colors, points, pose, transform, vector

# The stamp of all messages, in seconds.
STAMP_SECS = 1700000000

# The kinds of a Marker.
ARROW, CUBE, SPHERE, CYLINDER, LINE_STRIP, LINE_LIST, CUBE_LIST, SPHERE_LIST, POINTS, TEXT, MESH, TRIANGLES = range(12)


def time_at(secs=0.0):
    """The genpy.Time that is `secs` after the scene's stamp."""
    return genpy.Time.from_sec(STAMP_SECS) + genpy.Duration.from_sec(secs)


def header(frame="base_link", secs=0.0):
    """A std_msgs/Header in `frame`, stamped `secs` after the scene's stamp."""
    return Header(stamp=time_at(secs), frame_id=frame)


def marker(kind, at=(0.0, 0.0, 0.0), turned=(0.0, 0.0, 0.0), size=0.0, paint=(0.0, 0.0, 0.0, 0.0), frame="base_link", **fields):
    """A Marker in the namespace `m`, whose stamp is 0: placed by the last transform.

    size: its scale, one number if it is the same along x, y and z; paint: its colour and, if it is not 1, alpha.
    fields: `points` and `colors` as rows of numbers, `mesh` as the name of a file of the assets, and those of Marker.
    """
    fields = {"header": Header(frame_id=frame), "ns": "m", **fields}
    fields.update({name: make(fields[name]) for name, make in (("points", points), ("colors", colors)) if name in fields})
    if "mesh" in fields:
        fields["mesh_resource"] = f"package://conformance_assets/meshes/{fields.pop('mesh')}"
    scale = size if isinstance(size, tuple) else (size,) * 3
    return Marker(type=kind, pose=pose(at, turned), scale=vector(*scale), color=color(*paint), **fields)


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
    """The 36 numbers of a pose's covariance from its diagonal.

    others: those beside it, by row and column; the one on the other side of the diagonal is the same if it is not given.
    """
    rows = [[0.0] * 6 for _ in range(6)]
    for index, value in enumerate((x, y, z, roll, pitch, yaw)):
        rows[index][index] = value
    for (row, column), value in (others or {}).items():
        rows[row][column] = value
        rows[column][row] = others.get((column, row), value)
    return [value for row in rows for value in row]


def pose_stamped(at=(0.0, 0.0, 0.0), turned=(0.0, 0.0, 0.0), frame="base_link"):
    """A PoseStamped."""
    return PoseStamped(header=header(frame), pose=pose(at, turned))


def uncertain_pose(covariance, at=(0.0, 0.0, 0.0), turned=(0.0, 0.0, 0.0), frame="base_link"):
    """A PoseWithCovarianceStamped."""
    return PoseWithCovarianceStamped(header=header(frame),
                                     pose=PoseWithCovariance(pose=pose(at, turned), covariance=covariance))


def wrench_stamped(force, torque, frame="base_link"):
    """A WrenchStamped."""
    return WrenchStamped(header=header(frame), wrench=Wrench(force=vector(*force), torque=vector(*torque)))


def twist_stamped(linear, angular, frame="base_link"):
    """A TwistStamped."""
    return TwistStamped(header=header(frame), twist=Twist(linear=vector(*linear), angular=vector(*angular)))


def accel_stamped(linear, angular, frame="base_link"):
    """An AccelStamped."""
    return AccelStamped(header=header(frame), accel=Accel(linear=vector(*linear), angular=vector(*angular)))


def occupancy_grid(resolution, size, at, turned=(0.0, 0.0, 0.0), data=(), frame="base_link", **info):
    """An OccupancyGrid of cells of `resolution` metres, with its origin at `at`. size: in cells, along x and y."""
    width, height = size
    info = MapMetaData(resolution=resolution, width=width, height=height, origin=pose(at, turned), **info)
    return OccupancyGrid(header=header(frame), info=info, data=data)
