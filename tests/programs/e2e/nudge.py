"""Keeps the latest transform of each frame and changes the projector's settings."""
import numpy
from dynamic_reconfigure.client import Client

from python_node import *

placed, stamps, before = {}, [], numpy.eye(4)


def turn(axis, w):
    # A rotation by a quaternion.
    x, y, z = axis
    cross = numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return numpy.eye(3) + 2 * w * cross + 2 * cross @ cross


def about(i, angle): return turn([numpy.sin(angle / 2) * (i == k) for k in range(3)], numpy.cos(angle / 2))


def pose(xyz, rotation):
    m = numpy.eye(4)
    m[:3, :3], m[:3, 3] = rotation, xyz
    return m


def place(message):
    for t in message.transforms:
        v, q = t.transform.translation, t.transform.rotation
        placed[t.child_frame_id] = pose([v.x, v.y, v.z], turn([q.x, q.y, q.z], q.w))
    stamps.append(message.transforms[0].header.stamp)


listener = rospy.Subscriber('/tf_static', TFMessage, place)


def moved(): return numpy.linalg.inv(before) @ placed['proj_view']


def offset(xyz=(0, 0, 0), rpy=(0, 0, 0)):
    roll, pitch, yaw = rpy
    return numpy.abs(moved() - pose(xyz, about(2, yaw) @ about(1, pitch) @ about(0, roll))).max()
