"""The PointCloud display, for the older message."""

import math

import numpy
from sensor_msgs.msg import ChannelFloat32, PointCloud

from ..clouds import count_colors, packed, ripples, waves, with_values
from ..data import load
from ..displays import display
from ..geometry import points32
from ..messages import CUBE, header, marker, markers
from ..scene import LARGE, family, one_display

DATA = load("point_cloud1")


def point_cloud1_channel_too_short(scene):
    scene.show(display("PointCloud", {
                   "Autocompute Intensity Bounds": False, "Channel Name": "i", "Color Transformer": "Intensity",
                   "Max Color": "0; 0; 255", "Max Intensity": 10, "Min Color": "255; 0; 0", "Min Intensity": -10,
                   "Size (Pixels)": 6, "Style": "Points", "Use rainbow": False}),
               display("PointCloud",
                       {"Channel Name": "intensity", "Max Intensity": 60, "Min Intensity": 20, "Size (Pixels)": 9,
                        "Style": "Points"}, name="d", topic="/d"))
    scene.publish("/c", PointCloud(header=header(), points=points32(waves(16, 12)), channels=[
        ChannelFloat32(name="i", values=[i for i in range(7)]),
        ChannelFloat32(name="j", values=[i for i in range(192)])]))
    scene.publish("/d", PointCloud(
        header=header(), points=points32(DATA["point_cloud1_channel_too_short_d_points"]),
        channels=[ChannelFloat32(name="intensities", values=[i for i in range(192)])]))


def point_cloud1_decay_transformer_changes(scene):
    scene.show(display("PointCloud", {"Color Transformer": "RGB8", "Decay Time": 1000, "Size (m)": 0.05, "Style": "Squares"}))
    scene.publish("/c",
                  PointCloud(header=header(), points=points32(waves(16, 12)), channels=[ChannelFloat32(
                      name="rgb", values=list(packed(count_colors(192)).view("float32")))]),
                  PointCloud(header=header(), points=points32(DATA["point_cloud1_channel_too_short_d_points"]),
                             channels=[ChannelFloat32(name="intensity", values=[i for i in range(192)])]))


def point_cloud1_nan_boxes_translucent(scene):
    scene.show(display("PointCloud", {"Alpha": 0.5, "Size (m)": 0.07, "Style": "Boxes"}), display("MarkerArray"))
    scene.publish("/c", PointCloud(
        header=header(),
        points=points32(with_values(
            with_values(with_values(waves(16, 12), range(5, 192, 187), (math.nan, 0, 0)), range(50, 192, 142),
                        (None, None, math.inf)), range(90, 192, 102), (0, math.nan, -math.inf))),
        channels=[ChannelFloat32(
            name="intensity", values=DATA["point_cloud1_nan_boxes_translucent_c_channels_0_values"].tolist())]))
    scene.publish("/m", markers(marker(CUBE, at=(0, 0, 0.2), size=0.5, paint=(1, 1, 0, 0.5))))


def point_cloud1_rgb_spheres_rotated_frame(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud", {"Size (m)": 0.06, "Style": "Spheres"}))
    scene.publish("/c", PointCloud(header=header("sensor"), points=points32(waves(16, 12)), channels=[
        ChannelFloat32(name="rgb", values=list(packed(count_colors(192)).view("float32")))]))


family(one_display("PointCloud", "/c"), {
    "point_cloud1": (
        {"Alpha": 1, "Channel Name": "intensity", "Color Transformer": "Intensity", "Decay Time": 0,
         "Position Transformer": "XYZ", "Size (m)": 0.04, "Style": "Squares"},
        PointCloud(header=header(), points=points32(ripples(16, 12)), channels=[ChannelFloat32(
            name="intensity", values=list(numpy.linspace(0, 10, 192)))]), LARGE),
    "point_cloud1_defaults": (
        {},
        PointCloud(header=header(), points=points32(waves(16, 12)), channels=[ChannelFloat32(
            name="intensity", values=[i for i in range(192)])]), dict(eye=(0.7, 0.5, 0.7))),
    "point_cloud1_nan_axis": (
        {"Axis": "X", "Color Transformer": "AxisColor", "Size (m)": 0.05, "Style": "Squares", "Use Fixed Frame": False},
        PointCloud(header=header(), points=points32(DATA["point_cloud1_nan_axis_points"])))})
