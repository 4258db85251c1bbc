"""The Path display."""

import math

from nav_msgs.msg import Path

from ..common import oval_path, rising_path
from ..displays import display
from ..messages import ARROW, header, marker, markers, pose_stamped
from ..scene import LARGE, family, one_display


def nav_path_arrows(scene):
    scene.camera(**LARGE)
    scene.show(display("Path", {"Color": "0; 0; 255", "Line Style": "Billboards", "Line Width": 0.03}, name="nav path",
                       topic="/plan"),
               display("MarkerArray", {"Marker Topic": "/visualization_marker_array"}, name="arrows"))
    scene.publish("/plan", Path(header=header(), poses=[pose_stamped((-0.8 + 0.02 * i, 0.3 * math.sin(i / 12), 0))
                                                        for i in range(80)]))
    scene.publish("/visualization_marker_array", markers(
        marker(ARROW, size=(0.04, 0.08, 0.08), paint=(1, 1, 0), header=header(), points=[
            (-0.8, 0, 0), (-0.64, 0.18551094092092105, 0)]),
        marker(ARROW, size=(0.04, 0.08, 0.08), paint=(1, 1, 0), header=header(), id=1, points=[
            (-0.62, 0.20449162800700024, 0), (-0.46, 0.296443655912387, 0)]),
        marker(ARROW, size=(0.04, 0.08, 0.08), paint=(1, 1, 0), header=header(), id=2, points=[
            (-0.44, 0.29924849598121633, 0), (-0.28, 0.24829810563778815, 0)]),
        marker(ARROW, size=(0.04, 0.08, 0.08), paint=(1, 1, 0), header=header(), id=3, points=[
            (-0.26, 0.2334219590663764, 0), (-0.1, 0.06691026420286443, 0)]),
        marker(ARROW, size=(0.04, 0.08, 0.08), paint=(1, 1, 0), header=header(), id=4, points=[
            (-0.08, 0.042336002417960164, 0), (0.08, -0.15038311457650338, 0)]),
        marker(ARROW, size=(0.04, 0.08, 0.08), paint=(1, 1, 0), header=header(), id=5, points=[
            (0.1, -0.1714683956227031, 0), (0.26, -0.2869775662072725, 0)]),
        marker(ARROW, size=(0.04, 0.08, 0.08), paint=(1, 1, 0), header=header(), id=6, points=[
            (0.28, -0.2932590353, 0), (0.44, -0.26957346704421886, 0)]),
        marker(ARROW, size=(0.04, 0.08, 0.08), paint=(1, 1, 0), header=header(), id=7, points=[
            (0.46, -0.25768034802797757, 0), (0.62, -0.10751024415268508, 0)])))


def path_arrows_offset_rotated_frame(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("Path", {
        "Head Diameter": 0.06, "Head Length": 0.06, "Offset": {"X": 0.2, "Y": 0, "Z": -0.1}, "Pose Color": "0; 255; 120",
        "Pose Style": "Arrows", "Shaft Diameter": 0.03, "Shaft Length": 0.12}))
    scene.publish("/p", oval_path(frame="sensor"))


def path_billboards_arrows_rotated_frame(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("Path", {
        "Head Diameter": 0.08, "Head Length": 0.1, "Line Style": "Billboards", "Pose Style": "Arrows", "Shaft Diameter": 0.04}))
    scene.publish("/p", oval_path(frame="sensor"))


def path_buffer_length_2(scene):
    scene.show(display("Path", {"Buffer Length": 2}))
    scene.publish("/p", oval_path(), oval_path(aside=0.3), oval_path(above=0.3))


def path_buffer_length_3_billboards_axes(scene):
    scene.show(display("Path", {
        "Buffer Length": 3, "Length": 0.12, "Line Style": "Billboards", "Line Width": 0.02, "Pose Style": "Axes",
        "Radius": 0.01}))
    scene.publish("/p", oval_path(), oval_path(aside=0.3), oval_path(above=0.3))


def path_invalid_leaves_the_axes_it_replaces(scene):
    scene.show(display("Path", {"Buffer Length": 2, "Length": 0.12, "Pose Style": "Axes", "Radius": 0.01}))
    invalid = oval_path(above=0.3)
    invalid.poses[1].pose.position.z = math.inf
    scene.publish("/p", oval_path(), oval_path(aside=0.3), invalid)


def path_arrows_quaternions_not_unit_length(scene):
    scene.show(display("Path", {"Head Diameter": 0.06, "Pose Style": "Arrows", "Shaft Diameter": 0.02, "Shaft Length": 0.2}))
    path = oval_path()
    for index, stamped in enumerate(path.poses):
        q, factor = (stamped.pose.orientation, 0.5 + 0.15 * index)
        q.x, q.y, q.z, q.w = (factor * part for part in (q.x, q.y, q.z, q.w))
    scene.publish("/p", path)


def path_of_none_one_and_two_poses(scene):
    scene.show(display("Path", {"Pose Style": "Axes"}, name="a", topic="/a"),
               display("Path", name="b", topic="/b"),
               display("Path", {"Line Style": "Billboards", "Line Width": 0.05}, name="d", topic="/d"))
    scene.publish("/a", Path(header=header(), poses=[pose_stamped((0.9, 0, 0.1), (0, 0.2, 1.57))]))
    scene.publish("/b", Path(header=header()))
    scene.publish("/d", Path(header=header(), poses=[
        pose_stamped((-0.026279570071159934, 0.6997015221290536, 0.22), (0, 0.2, 3.17)),
        pose_stamped((-0.3745321528924282, 0.6365081987779772, 0.25), (0, 0.2, 3.57))]))


family(one_display("Path", "/p"), {
    "path_arrows_default_sizes": ({"Pose Style": "Arrows"}, oval_path()),
    "path_billboards_arrows": (
        {"Color": "0; 160; 255", "Head Diameter": 0.07, "Head Length": 0.08, "Line Style": "Billboards", "Line Width": 0.04,
         "Offset": {"X": 0.1, "Y": 0, "Z": 0.1}, "Pose Color": "255; 85; 255", "Pose Style": "Arrows", "Shaft Diameter": 0.03,
         "Shaft Length": 0.1}, rising_path(), LARGE),
    "path_billboards_translucent_wide": (
        {"Alpha": 0.5, "Color": "0; 200; 255", "Line Style": "Billboards", "Line Width": 0.1}, oval_path()),
    "path_billboards_wide_sharp_corners": (
        {"Color": "255; 80; 160", "Line Style": "Billboards", "Line Width": 0.09},
        Path(header=header(), poses=[pose_stamped((-0.8 + 0.15 * i, 0.3 - 0.6 * (i % 2), 0.02 * i)) for i in range(11)])),
    "path_lines": ({"Color": "25; 255; 0", "Line Style": "Lines"}, rising_path(), LARGE),
    "path_lines_thin_arrows": (
        {"Alpha": 0.6, "Head Diameter": 0.06, "Head Length": 0.08, "Pose Color": "255; 255; 0", "Pose Style": "Arrows",
         "Shaft Diameter": 0.02, "Shaft Length": 0.2}, oval_path()),
    "path_lines_translucent_offset": (
        {"Alpha": 0.4, "Color": "255; 160; 0", "Offset": {"X": 0.1, "Y": -0.2, "Z": 0.3}}, oval_path()),
    "path_pose_axes": ({"Length": 0.2, "Pose Style": "Axes", "Radius": 0.02}, oval_path())})
