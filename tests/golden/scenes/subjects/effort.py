"""The Effort display: torques at the joints of a robot."""

import math

from sensor_msgs.msg import JointState

from ..common import arm_frames, lamp_frames
from ..displays import display
from ..messages import header


def effort(scene):
    scene.camera(eye=(1.7, 1.2, 1.2), target=(0, 0, 0.4), size=(640, 480), focal=(500, 500))
    lamp_frames(scene)
    scene.show(display("Effort", {
        "Alpha": 1, "History Length": 1, "Robot Description": "robot_description", "Scale": 1, "Width": 0.02}))
    scene.publish("/joint_states", JointState(
        header=header(), name=["j1", "j2"], position=[0.4, 0.8], velocity=[0, 0], effort=[6, -3]))


def effort_axes_signs_limits(scene):
    scene.camera(focal=(330, 330))
    arm_frames(scene)
    scene.show(display("Effort"))
    scene.publish("/joint_states", JointState(
        header=header(""), name=["turn", "lift", "bend", "roll"], position=[0] * 4, effort=[10, -15, 0.3, 2]))


def effort_history_length_2(scene):
    scene.camera(focal=(330, 330))
    arm_frames(scene)
    scene.show(display("Effort", {"History Length": 2}))
    scene.publish("/joint_states",
                  JointState(header=header(""), name=["turn", "lift"], position=[0, 0], effort=[10, 10]),
                  JointState(header=header(""), name=["turn"], position=[0], effort=[-20]),
                  JointState(header=header(""), name=["bend", "lift"], position=[0, 0], effort=[0.5, math.nan]))


def effort_joint_off(scene):
    scene.camera(focal=(330, 330))
    arm_frames(scene)
    scene.show(display("Effort", {"Joints": {"All Joints Enabled": True, "lift": {"Value": False}, "turn": True}}))
    scene.publish("/joint_states", JointState(
        header=header(""), name=["turn", "lift", "bend", "roll"], position=[0] * 4, effort=[10, -15, 0.3, 2]))


def effort_width_scale_past_limit_and_zero(scene):
    scene.camera(focal=(330, 330))
    arm_frames(scene)
    scene.show(display("Effort", {"Alpha": 0.3, "Scale": 0.5, "Width": 0.05}))
    scene.publish("/joint_states", JointState(
        header=header(""), name=["turn", "lift", "bend", "roll"], position=[0] * 4, effort=[90, 0, 1.7, 2]))
