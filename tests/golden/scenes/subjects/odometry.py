"""The Odometry display."""

import math

from geometry_msgs.msg import PoseWithCovariance
from nav_msgs.msg import Odometry

from ..displays import display
from ..geometry import pose
from ..messages import covariance, header
from ..scene import LARGE


def odometry(scene):
    scene.camera(**LARGE)
    scene.show(display("Odometry", {
        "Angle Tolerance": 0.1, "Covariance": {"Value": False}, "Head Length": 0.2, "Head Radius": 0.08, "Keep": 100,
        "Position Tolerance": 0.1, "Shaft Length": 0.5, "Shaft Radius": 0.04, "Shape": "Arrow"}))
    scene.publish(
        "/o",
        Odometry(header=header(), child_frame_id="base", pose=PoseWithCovariance(
            pose=pose((-0.3, -0.2, 0.1), (0, 0, 0.6)), covariance=covariance(0.04, 0.02, 0.01, 0.02, 0.03, 0.1, {(0, 1): 0.01}))),
        Odometry(header=header(), child_frame_id="base", pose=PoseWithCovariance(
            pose=pose((0.3, 0.2, 0.1), (0, 0, 1.2)), covariance=covariance(0.04, 0.02, 0.01, 0.02, 0.03, 0.1, {(0, 1): 0.01}))))


def odometry_axes_tolerances(scene):
    scene.frame("sensor", at=(0.2, -0.1, 0.2), turned=(0.3, -0.2, 0.7))
    scene.show(display("Odometry", {
        "Angle Tolerance": 0.35,
        "Covariance": {"Orientation": {"Color Style": "RGB", "Offset": 0.3, "Value": True},
                       "Position": {"Scale": 0.5, "Value": True}, "Value": True}, "Keep": 0, "Position Tolerance": 0.6,
        "Queue Size": 20, "Shape": {"Axes Length": 0.25, "Axes Radius": 0.03, "Value": "Axes"}}))
    scene.publish("/o", *(Odometry(
        header=header("sensor"), child_frame_id="odo_child",
        pose=PoseWithCovariance(
            pose=pose((-1 + 0.25 * i, 0.4 * math.sin(0.7 * i), 0.1), (0, 0, 0.3 * math.cos(0.7 * i))),
            covariance=covariance(0.04, 0.01, 0.09, 0.02, 0.05, 0.01, {
                (0, 1): 0.012, (0, 2): -0.01, (1, 2): 0.02, (3, 4): 0.012, (3, 5): -0.006, (4, 5): 0.01}))) for i in range(9)))


def odometry_keep_3_covariance(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("Odometry", {
                   "Covariance": {"Orientation": {"Offset": 0.4, "Value": True}, "Position": {"Alpha": 0.5, "Value": True},
                                  "Value": True}, "Keep": 3, "Queue Size": 20,
                   "Shape": {"Alpha": 0.6, "Color": "0; 200; 120", "Head Length": 0.08, "Head Radius": 0.07, "Shaft Length": 0.2,
                             "Shaft Radius": 0.03, "Value": "Arrow"}}))
    scene.publish("/o", *(Odometry(header=header(), child_frame_id="odo_child", pose=PoseWithCovariance(
        pose=pose((-1 + 0.25 * i, 0.4 * math.sin(0.7 * i), 0.1), (0, 0, 0.3 * math.cos(0.7 * i))),
        covariance=covariance(0.004 + 0.004 * i, 0.01, 0, 0, 0, 0.05))) for i in range(9)))
