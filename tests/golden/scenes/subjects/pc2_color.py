"""Point clouds: the colour transformers."""

import math

import numpy

from ..clouds import cloud, colored_waves, columns, corner_colors, count_colors, packed, raw_cloud, ripples, waves, with_values
from ..data import load
from ..displays import display
from ..scene import LARGE, family, one_display

DATA = load("pc2_color")


def pc2_axis_x_fixed(scene):
    scene.camera(**LARGE)
    scene.frame("sensor", at=(0.1, 0, 0.1), turned=(0.2, -0.1, 0.5))
    scene.show(display("PointCloud2", {
        "Autocompute Value Bounds": {"Max Value": 0.5, "Min Value": -0.7, "Value": False}, "Axis": "X",
        "Color Transformer": "AxisColor", "Use Fixed Frame": False}))
    scene.publish("/cloud", cloud(ripples(40, 30), "sensor", is_dense=True))


def pc2_axis_x_fixed_frame_rotated_cloud(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Axis": "X", "Color Transformer": "AxisColor", "Size (m)": 0.05}))
    scene.publish("/cloud", cloud(waves(16, 12), "sensor"))


def pc2_axis_y_cloud_frame_rotated_cloud(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {
        "Axis": "Y", "Color Transformer": "AxisColor", "Size (m)": 0.05, "Use Fixed Frame": False}))
    scene.publish("/cloud", cloud(waves(16, 12), "sensor"))


def pc2_axis_y_fixed_frame_rotated_cloud(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Axis": "Y", "Color Transformer": "AxisColor", "Size (m)": 0.05}))
    scene.publish("/cloud", cloud(waves(16, 12), "sensor"))


def pc2_axis_z_fixed_frame_rotated_cloud(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Axis": "Z", "Color Transformer": "AxisColor", "Size (m)": 0.05}))
    scene.publish("/cloud", cloud(waves(16, 12), "sensor"))


def pc2_rgbf32_out_of_range_rotated_frame(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Color Transformer": "RGBF32", "Size (m)": 0.06, "Style": "Squares"}))
    scene.publish("/cloud", cloud(waves(16, 12), "sensor", fields=[
        ("r", "float32", count_colors(192)[:, 0] / 200), ("g", "float32", count_colors(192)[:, 1] / 255),
        ("b", "float32", count_colors(192)[:, 2] / 255 - 0.2)]))


family(one_display("PointCloud2", "/cloud"), {
    "pc2_axis_x_nan_points": (
        {"Axis": "X", "Color Transformer": "AxisColor", "Size (m)": 0.06, "Style": "Squares"},
        cloud(with_values(waves(16, 12), range(0, 192, 6), (math.nan, math.nan, math.nan)))),
    "pc2_axis_y_boxes": (
        {"Axis": "Y", "Color Transformer": "AxisColor", "Size (m)": 0.07, "Style": "Boxes"}, cloud(waves(16, 12))),
    "pc2_axis_z": (
        {"Autocompute Value Bounds": {"Max Value": 10, "Min Value": -10, "Value": True}, "Axis": "Z",
         "Color Transformer": "AxisColor"},
        cloud(ripples(40, 30), is_dense=True), LARGE),
    "pc2_axis_z_infinite_points": (
        {"Axis": "Z", "Color Transformer": "AxisColor", "Size (m)": 0.06, "Style": "Squares"},
        cloud(with_values(with_values(waves(16, 12), range(5, 192, 187), (math.inf, math.inf, math.inf)), range(17, 192, 175),
                          (None, None, -math.inf)))),
    "pc2_axis_z_values_beyond_bounds": (
        {"Autocompute Value Bounds": {"Max Value": 0.25, "Min Value": 0.15, "Value": False}, "Axis": "Z",
         "Color Transformer": "AxisColor", "Size (m)": 0.05}, cloud(waves(16, 12))),
    "pc2_both_rgb_and_rgba": ({"Size (m)": 0.06, "Style": "Squares"}, cloud(waves(16, 12), fields=[
        ("rgb", "rgb", packed(count_colors(192))), ("rgba", "uint32", packed(count_colors(192)[:, [2, 0, 1]], 120))])),
    "pc2_intensity_all_equal": ({"Color Transformer": "Intensity", "Size (m)": 0.05}, cloud(
        waves(16, 12), fields=[("intensity", "float32", numpy.full(192, 7.5))])),
    "pc2_intensity_channel_missing": ({"Color Transformer": "Intensity", "Size (m)": 0.06, "Style": "Squares"}, colored_waves()),
    "pc2_intensity_colors": (
        {"Autocompute Intensity Bounds": False, "Channel Name": "intensity", "Color Transformer": "Intensity",
         "Max Color": "250; 220; 0", "Max Intensity": 200, "Min Color": "10; 40; 200", "Min Intensity": 50, "Use rainbow": False},
        cloud(ripples(40, 30), fields=[("intensity", "float32", numpy.linspace(0, 250, 1200))], is_dense=True), LARGE),
    "pc2_intensity_float64_rainbow": (
        {"Channel Name": "range", "Color Transformer": "Intensity", "Size (m)": 0.05},
        cloud(waves(16, 12), fields=[("range", "float64", numpy.linalg.norm(numpy.float32(waves(16, 12)), axis=1))])),
    "pc2_intensity_int16_fixed_bounds": (
        {"Autocompute Intensity Bounds": False, "Channel Name": "i", "Color Transformer": "Intensity", "Max Intensity": 60,
         "Min Intensity": -50, "Size (m)": 0.06, "Style": "Boxes"},
        cloud(waves(16, 12), fields=[("i", "int16", -96 + 1 * numpy.arange(192))])),
    "pc2_intensity_int32_negative": (
        {"Channel Name": "v", "Color Transformer": "Intensity", "Size (Pixels)": 5, "Style": "Points"},
        cloud(waves(16, 12), fields=[("v", "int32", -70000 + 1000 * numpy.arange(192))])),
    "pc2_intensity_int8_channel_intensities": (
        {"Channel Name": "intensity", "Color Transformer": "Intensity", "Size (m)": 0.05, "Style": "Squares"},
        cloud(waves(16, 12), fields=[("intensities", "int8", numpy.arange(192).astype("int8"))])),
    "pc2_intensity_max_below_min": (
        {"Autocompute Intensity Bounds": False, "Color Transformer": "Intensity", "Max Intensity": 10, "Min Intensity": 40,
         "Size (m)": 0.05},
        cloud(waves(16, 12), fields=[("intensity", "float32", 1 * numpy.arange(192) % 50)])),
    "pc2_intensity_nan": ({"Color Transformer": "Intensity", "Size (m)": 0.05}, cloud(
        waves(16, 12), fields=[("intensity", "float32", DATA["pc2_intensity_nan_intensity"])])),
    "pc2_intensity_nan_two_colors": (
        {"Autocompute Intensity Bounds": False, "Color Transformer": "Intensity", "Max Color": "0; 255; 90", "Max Intensity": 40,
         "Min Color": "255; 0; 60", "Min Intensity": 5, "Size (m)": 0.05, "Use rainbow": False},
        cloud(waves(16, 12), fields=[("intensity", "float32", DATA["pc2_intensity_nan_intensity"])])),
    "pc2_intensity_of_z_channel": (
        {"Channel Name": "z", "Color Transformer": "Intensity", "Size (m)": 0.05, "Style": "Spheres"}, cloud(waves(16, 12))),
    "pc2_intensity_rainbow": (
        {"Autocompute Intensity Bounds": True, "Channel Name": "intensity", "Color Transformer": "Intensity"},
        cloud(ripples(40, 30), fields=[("intensity", "float32", numpy.linspace(0, 250, 1200))], is_dense=True), LARGE),
    "pc2_intensity_uint16_inverted_rainbow": (
        {"Autocompute Intensity Bounds": False, "Channel Name": "ring", "Color Transformer": "Intensity", "Invert Rainbow": True,
         "Max Intensity": 140, "Min Intensity": 20, "Style": "Squares"},
        cloud(waves(16, 12), fields=[("ring", "uint16", numpy.arange(192))], point_step=17)),
    "pc2_intensity_uint8_two_colors": (
        {"Channel Name": "label", "Color Transformer": "Intensity", "Max Color": "255; 240; 30", "Min Color": "20; 60; 250",
         "Size (m)": 0.06, "Style": "Spheres", "Use rainbow": False},
        raw_cloud([("label", "uint8", 7 * numpy.arange(192) % 256), *columns(waves(16, 12))])),
    "pc2_mono8_of_rgb": ({"Color Transformer": "MONO8", "Size (m)": 0.06}, colored_waves()),
    "pc2_mono8_of_rgba": ({"Color Transformer": "MONO8", "Size (m)": 0.09, "Style": "Spheres"}, cloud(
        waves(16, 12), fields=[("rgba", "uint32", packed(count_colors(192), 40 + 1 * numpy.arange(192) % 192))])),
    "pc2_rgb8_of_uint32": ({"Size (m)": 0.06, "Style": "Squares"}, cloud(
        waves(16, 12), fields=[("rgb", "uint32", packed(count_colors(192), 77))])),
    "pc2_rgbf32": (
        {"Color Transformer": "RGBF32"},
        cloud(ripples(40, 30),
              fields=[("r", "float32", corner_colors(ripples(40, 30))[:, 0]),
                      ("g", "float32", corner_colors(ripples(40, 30))[:, 1]),
                      ("b", "float32", corner_colors(ripples(40, 30))[:, 2])], is_dense=True), LARGE),
    "pc2_transformer_rgb8_without_rgb": ({"Size (m)": 0.05}, cloud(
        waves(16, 12), fields=[("intensity", "float32", numpy.arange(192))])),
    "pc2_transformer_unset_cloud_with_rgb": (
        {"Size (m)": 0.05, "Color Transformer": None, "Position Transformer": None}, colored_waves()),
    "pc2_transformer_unset_cloud_with_xyz": (
        {"Size (m)": 0.05, "Color Transformer": None, "Position Transformer": None}, cloud(waves(16, 12)))})
