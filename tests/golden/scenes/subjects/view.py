"""The view of rviz's own window, which must not matter to the camera's picture."""

from ..clouds import colored_waves
from ..common import sphere_cube_cylinder
from ..displays import display
from ..scene import ORBIT


def view_fps(scene):
    scene.rviz_view = {
        **ORBIT, "Class": "rviz/FPS", "Pitch": 0.4, "Position": {"X": 1, "Y": -2, "Z": 2}, "Value": "FPS (rviz)", "Yaw": 2.0}
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def view_orbit_from_below(scene):
    scene.rviz_view = {**ORBIT, "Distance": 9, "Pitch": -0.9, "Yaw": 3.3}
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def view_orbit_other_yaw_and_pitch(scene):
    scene.rviz_view = {**ORBIT, "Pitch": 1.3, "Yaw": 1.2}
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def view_target_frame_rotated(scene):
    scene.rviz_view = {**ORBIT, "Target Frame": "sensor"}
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def view_third_person_follower(scene):
    scene.rviz_view = {
        **ORBIT, "Class": "rviz/ThirdPersonFollower", "Pitch": 0.4, "Target Frame": "sensor",
        "Value": "ThirdPersonFollower (rviz)", "Yaw": 2.2}
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def view_top_down_ortho(scene):
    scene.rviz_view = {
        **ORBIT, "Angle": 0.7, "Class": "rviz/TopDownOrtho", "Scale": 60, "Value": "TopDownOrtho (rviz)", "X": 0.3, "Y": 0.2}
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def view_xy_orbit(scene):
    scene.rviz_view = {**ORBIT, "Class": "rviz/XYOrbit", "Pitch": 0.9, "Value": "XYOrbit (rviz)", "Yaw": 0.4}
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())
