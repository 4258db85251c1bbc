"""Displays that a camera draws: its Visibility, groups, displays that are off, two cameras."""

import math

from ..clouds import cloud, colored_waves, corner_colors, ripples
from ..common import sphere_cube_cylinder
from ..displays import camera_pub, display, group
from ..messages import camera_info
from ..scene import LARGE


def cam_display_disabled(scene):
    scene.show(display("Grid"), display("PointCloud2", {"Size (m)": 0.05, "Enabled": False}), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_group_disabled_children_enabled(scene):
    scene.show(display("Grid"), group("G", display("PointCloud2", {"Size (m)": 0.05}), enabled=False), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_inside_a_group(scene):
    scene.show(display("Grid"),
               display("PointCloud2", {"Size (m)": 0.06, "Style": "Squares"}),
               group("Cams", camera_pub({"Visibility": {"Grid": True, "Value": True, "c": True}})))
    scene.publish("/cloud", colored_waves())


def cam_two_cameras_own_visibility(scene):
    scene.frame("two", at=(-1.2, 1.2, 1.1), turned=(-2.0584125695100033, 0, -3 * math.pi / 4))
    scene.show(display("Grid"),
               display("PointCloud2", {"Size (m)": 0.05}),
               display("MarkerArray"),
               camera_pub({"Background Color": "0; 40; 40", "Camera Info Topic": "/two/camera_info", "Display namespace": "two",
                           "Image Topic": "/two/image", "Visibility": {"Grid": True, "M": True, "Value": True, "c": False}},
                          name="Two"), camera_pub())
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())
    scene.publish("/two/camera_info", camera_info("two", (400, 300), (310, 310)))


def cam_visibility_child_off_beside_inner_group(scene):
    scene.show(display("Grid"),
               group("G", group("H", display("MarkerArray")), display("PointCloud2", {"Size (m)": 0.05})),
               camera_pub({"Visibility": {
                   "G": {"H": {"M": True, "Value": True}, "Value": True, "c": False}, "Grid": True, "Value": True}}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_visibility_group_child_off(scene):
    scene.show(display("Grid"),
               group("G", display("PointCloud2", {"Size (m)": 0.05}), group("H", display("MarkerArray"), display("Axes"))),
               camera_pub({"Visibility": {"G": {"H": {"Axes": True, "M": True, "Value": True}, "Value": True, "c": False},
                                          "Grid": True, "Value": True}}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_visibility_group_grandchild_off(scene):
    scene.show(display("Grid"),
               group("G", display("PointCloud2", {"Size (m)": 0.05}), group("H", display("MarkerArray"))),
               camera_pub({"Visibility": {
                   "G": {"H": {"M": False, "Value": True}, "Value": True, "c": True}, "Grid": True, "Value": True}}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_visibility_group_off(scene):
    scene.show(display("Grid"),
               group("G", display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray")),
               camera_pub({"Visibility": {"G": {"M": True, "Value": False, "c": True}, "Grid": True, "Value": True}}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_visibility_group_only_child_off(scene):
    scene.show(display("Grid"),
               group("G", display("PointCloud2", {"Size (m)": 0.05})),
               display("MarkerArray"),
               camera_pub({"Visibility": {"G": {"Value": True, "c": False}, "Grid": True, "M": True, "Value": True}}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_visibility_lists_nothing(scene):
    scene.show(display("Grid"),
               display("Axes"),
               display("PointCloud2", {"Size (m)": 0.05}),
               display("MarkerArray"),
               camera_pub({"Visibility": {"Value": True}}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_visibility_some(scene):
    scene.camera(**LARGE)
    scene.show(display("Grid"), display("PointCloud2"), camera_pub({"Visibility": {"Grid": True, "Value": True, "c": False}}))
    scene.publish("/cloud", cloud(ripples(40, 30), rgb=255 * corner_colors(ripples(40, 30)), is_dense=True))
