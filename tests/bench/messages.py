"""Messages that `./bench` and `./soak` publish."""

import rospy
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, PointCloud2, PointField

# Rotation (x, y, z, w) of an optical frame that looks along its parent's x axis.
OPTICAL = (-0.5, 0.5, -0.5, 0.5)
# Bytes of a point: x, y, z and one more field.
POINT_BYTES = 16


def transform(parent, child, xyz, rotation=(0.0, 0.0, 0.0, 1.0), stamp=None):
    """A transform, without a stamp at time 0."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id, message.header.stamp = parent, stamp or rospy.Time()
    to, by = message.transform.translation, message.transform.rotation
    to.x, to.y, to.z = xyz
    by.x, by.y, by.z, by.w = rotation
    return message


def camera_info(frame, size_px, focal_px, distortion=(0.0,) * 5):
    """A CameraInfo whose principal point is the image's middle."""
    width, height = size_px
    f, cx, cy = focal_px, width / 2.0, height / 2.0
    message = CameraInfo(width=width, height=height, distortion_model='plumb_bob', D=distortion)
    message.header.frame_id = frame
    message.K = [f, 0, cx, 0, f, cy, 0, 0, 1]
    message.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    message.P = [f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0]
    return message


def point_cloud(points, field, frame, stamp=None, data=b''):
    """An unordered cloud of points with x, y, z and another field of 32 bits."""
    message = PointCloud2(
        height=1, width=points, point_step=POINT_BYTES, row_step=POINT_BYTES * points, is_dense=True, data=data)
    message.fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate(('x', 'y', 'z', field))]
    message.header.frame_id, message.header.stamp = frame, stamp or rospy.Time()
    return message
