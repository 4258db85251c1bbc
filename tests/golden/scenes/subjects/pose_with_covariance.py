"""The PoseWithCovariance display."""

from geometry_msgs.msg import PoseWithCovariance, PoseWithCovarianceStamped

from ..displays import display
from ..geometry import pose
from ..messages import covariance, header, uncertain_pose
from ..scene import LARGE


def pose_with_covariance(scene):
    scene.camera(**LARGE)
    scene.show(display("PoseWithCovariance", {
        "Covariance": {"Orientation": {"Alpha": 0.5, "Color": "255; 255; 127", "Color Style": "Unique", "Frame": "Local",
                                       "Offset": 1, "Scale": 1, "Value": True},
                       "Position": {"Alpha": 0.3, "Color": "204; 51; 204", "Value": True}, "Value": True}, "Shape": "Arrow",
        "Head Length": None, "Head Radius": None, "Shaft Length": None, "Shaft Radius": None}))
    scene.publish("/p", uncertain_pose(
        covariance(0.04, 0.02, 0.01, 0.02, 0.03, 0.1, {(0, 1): 0.01}), (-0.3, 0.1, 0.2), (0, 0, 0.5)))


def pose_with_covariance_2d(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PoseWithCovariance", {"Covariance": {
                   "Orientation": {"Alpha": 0.6, "Offset": 1.2, "Scale": 1.5, "Value": True},
                   "Position": {"Scale": 2, "Value": True}, "Value": True}}))
    scene.publish("/p", uncertain_pose(covariance(0.05, 0.02, 0, 0, 0, 0.04, {(0, 1): 0.02}), (-0.4, -0.3, 0.05), (0, 0, 0.7)))


def pose_with_covariance_2d_frame_fixed_rgb(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PoseWithCovariance", {"Covariance": {
                   "Orientation": {"Color Style": "RGB", "Frame": "Fixed", "Offset": 0.8, "Value": True}, "Value": True}}))
    scene.publish("/p", uncertain_pose(covariance(0.05, 0.02, 0, 0, 0, 0.04, {(0, 1): 0.02}), (-0.4, -0.3, 0.05), (0, 0, 1.4)))


def pose_with_covariance_2d_negative_yaw(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PoseWithCovariance", {"Covariance": {
                   "Orientation": {"Offset": 0.7, "Value": True}, "Position": {"Alpha": 0.8, "Value": True}, "Value": True}}))
    scene.publish("/p",
                  uncertain_pose(covariance(0.05, 0.02, 0, 0, 0, 0.04, {(0, 1): 0.02}), (-0.4, -0.3, 0.05), (0, 0, 0.2)),
                  uncertain_pose(covariance(0.02, 0.03, -1, 0, 0, -0.04, {(0, 1): 0.005}), (0, 0.3, 0.05), (0, 0, 0.9)))


def pose_with_covariance_3d_frame_fixed(scene):
    scene.frame("sensor", at=(0.2, -0.1, 0.2), turned=(0.3, -0.2, 0.7))
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PoseWithCovariance", {
                   "Axes Length": 0.5, "Axes Radius": 0.03,
                   "Covariance": {"Orientation": {"Alpha": 1, "Color": "255; 120; 0", "Frame": "Fixed", "Offset": 0.7, "Scale": 1,
                                                  "Value": True}, "Position": {"Alpha": 1, "Color": "0; 120; 255", "Value": True},
                                  "Value": True}, "Shape": "Axes"}))
    scene.publish("/p", uncertain_pose(
        covariance(0.04, 0.01, 0.09, 0.02, 0.05, 0.01, {
            (0, 1): 0.012, (0, 2): -0.01, (1, 2): 0.02, (3, 4): 0.012, (3, 5): -0.006, (4, 5): 0.01}), (0, 0.1, 0.1),
        (0.4, -0.3, 0.8), frame="sensor"))


def pose_with_covariance_3d_rgb(scene):
    scene.frame("sensor", at=(0.2, -0.1, 0.2), turned=(0.3, -0.2, 0.7))
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PoseWithCovariance", {"Covariance": {
                   "Orientation": {"Alpha": 0.8, "Color Style": "RGB", "Offset": 0.6, "Scale": 1.5, "Value": True},
                   "Position": {"Alpha": 0.5, "Scale": 1.5, "Value": True}, "Value": True}}))
    scene.publish("/p", uncertain_pose(
        covariance(0.04, 0.01, 0.09, 0.02, 0.05, 0.01, {
            (0, 1): 0.012, (0, 2): -0.01, (1, 2): 0.02, (3, 4): 0.012, (3, 5): -0.006, (4, 5): 0.01}), (0, 0.1, 0.1),
        (0.4, -0.3, 0.8), frame="sensor"))


def pose_with_covariance_asymmetric(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PoseWithCovariance", {"Covariance": {"Orientation": {"Offset": 0.6, "Value": True}, "Value": True}}))
    scene.publish("/p", uncertain_pose(
        covariance(0.04, 0.01, 0.09, 0.02, 0.05, 0.01, {
            (0, 1): 0.006, (0, 2): 0.006, (0, 3): 0.006, (0, 4): 0.006, (0, 5): 0.006, (1, 0): -0.5, (1, 2): 0.006, (1, 3): 0.006,
            (1, 4): 0.006, (1, 5): 0.006, (2, 0): -0.5, (2, 1): -0.5, (2, 3): 0.006, (2, 4): 0.006, (2, 5): 0.006, (3, 0): -0.5,
            (3, 1): -0.5, (3, 2): -0.5, (3, 4): 0.006, (3, 5): 0.006, (4, 0): -0.5, (4, 1): -0.5, (4, 2): -0.5, (4, 3): -0.5,
            (4, 5): 0.006, (5, 0): -0.5, (5, 1): -0.5, (5, 2): -0.5, (5, 3): -0.5, (5, 4): -0.5}), (0, 0, 0.1), (0.4, -0.3, 0.8)))


def pose_with_covariance_deviation_past_89_deg(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PoseWithCovariance", {"Covariance": {
                   "Orientation": {"Alpha": 0.5, "Offset": 0.3, "Value": True}, "Value": True}}))
    scene.publish("/p", uncertain_pose(covariance(0.04, 0, 0.04, 4, 0.01, 0), (0, 0, 0.1), (0, 0, 0.4)))


def pose_with_covariance_negative_after_good(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PoseWithCovariance", {"Covariance": {
                   "Orientation": {"Offset": 0.5, "Value": True}, "Position": {"Alpha": 0.6, "Value": True}, "Value": True}}))
    scene.publish("/p",
                  uncertain_pose(covariance(0.04, 0.01, 0.09, 0.02, 0.05, 0.01, {
                                     (0, 1): 0.012, (0, 2): -0.01, (1, 2): 0.02, (3, 4): 0.012, (3, 5): -0.006, (4, 5): 0.01}),
                                 (0.3, 0.3, 0.1)),
                  uncertain_pose(covariance(0.01, 0.02, 0.03, 0.01, 0.01, 0.01, {(0, 1): 0.1, (3, 4): 0.05}), (-0.2, -0.1, 0.1),
                                 (0.4, -0.3, 0.8)))


def pose_with_covariance_negative_first(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PoseWithCovariance", {"Covariance": {
                   "Orientation": {"Offset": 0.5, "Value": True}, "Position": {"Alpha": 0.6, "Scale": 0.5, "Value": True},
                   "Value": True}}))
    scene.publish("/p", uncertain_pose(
        covariance(0.01, 0.02, 0.03, 0.01, 0.01, 0.01, {(0, 1): 0.1, (3, 4): 0.05}), (-0.2, -0.1, 0.1), (0.4, -0.3, 0.8)))


def pose_with_covariance_position_only(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PoseWithCovariance", {"Covariance": {
                   "Orientation": {"Value": False},
                   "Position": {"Alpha": 0.7, "Color": "255; 255; 0", "Scale": 1.2, "Value": True}, "Value": True}}))
    scene.publish("/p", uncertain_pose(
        covariance(0.04, 0.01, 0.09, 0.02, 0.05, 0.01, {
            (0, 1): 0.012, (0, 2): -0.01, (1, 2): 0.02, (3, 4): 0.012, (3, 5): -0.006, (4, 5): 0.01}), (0, 0, 0.1),
        (0.4, -0.3, 0.8)))


def pose_with_covariance_zero(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PoseWithCovariance", {"Covariance": {
                   "Orientation": {"Alpha": 1, "Scale": 0, "Value": True}, "Position": {"Alpha": 1, "Value": True},
                   "Value": True}}))
    scene.publish("/p", PoseWithCovarianceStamped(header=header(), pose=PoseWithCovariance(pose=pose(
        (0, 0, 0.1), (0.4, -0.3, 0.8)))))
