"""Point clouds in the styles Squares, Flat Squares, Spheres and Boxes."""

import math

import numpy

from ..clouds import ball, cloud, colored_waves, corner_colors, count_colors, packed, ripples, waves
from ..displays import camera_pub, display
from ..geometry import quaternion
from ..scene import LARGE, family, one_display


def pc2_boxes_rgb8_rotated_frame(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Size (m)": 0.08, "Style": "Boxes"}))
    scene.publish("/cloud", cloud(waves(16, 12), "sensor", rgb=count_colors(192)))


def pc2_flat_squares_rotated_frame(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Size (m)": 0.08}))
    scene.publish("/cloud", cloud(waves(16, 12), "sensor", rgb=count_colors(192)))


def pc2_spheres_frame_on_its_side(scene):
    scene.frame("side", at=(0, 0, 0.3), turned=(-math.pi / 2, 0, -math.pi / 2))
    scene.show(display("PointCloud2", {
        "Color": "200; 200; 60", "Color Transformer": "FlatColor", "Size (m)": 0.12, "Style": "Spheres"}))
    scene.publish("/cloud", cloud(ball(60, 0.6), "side"))


def pc2_squares_boxes_across_near_plane(scene):
    scene.camera(eye=(0.3, 0.2, 0.35), target=(-0.5, -0.3, 0.2))
    scene.show(display("PointCloud2", {"Size (m)": 0.3, "Style": "Squares"}),
               display("PointCloud2",
                       {"Color": "80; 160; 240", "Color Transformer": "FlatColor", "Size (m)": 0.2, "Style": "Boxes"}, name="d",
                       topic="/cloud2"),
               camera_pub({"Near Clip Distance": 0.1}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/cloud2", cloud(ball(40, 0.6)))


def pc2_squares_centres_outside_picture_culled(scene):
    scene.show(display("Grid"),
               display("PointCloud2", {"Size (m)": 0.8}),
               display("PointCloud2", {"Color": "255; 160; 0", "Color Transformer": "FlatColor", "Size (m)": 0.6}, name="d",
                       topic="/cloud2"))
    scene.publish("/cloud", cloud([(0, 1.45, 0.1), (0.1, 1.5, 0.1)], rgb=count_colors(2)))
    scene.publish("/cloud2", cloud([(0.1, -1.4, 0.1), (0, 0, 0.1)]))


family(one_display("PointCloud2", "/cloud"), {
    "pc2_boxes_flat": (
        {"Color": "250; 120; 50", "Color Transformer": "FlatColor", "Size (m)": 0.05, "Style": "Boxes"},
        cloud(ripples(16, 12), is_dense=True), LARGE),
    "pc2_boxes_large_from_above_and_inside": (
        {"Size (m)": 0.35, "Style": "Boxes"},
        cloud(ball(14, 0.7), rgb=count_colors(14)),
        dict(eye=(0.9, 0.7, 1.3))),
    "pc2_boxes_rgba": ({"Size (m)": 0.09, "Style": "Boxes"}, cloud(
        waves(16, 12), fields=[("rgba", "uint32", packed(count_colors(192), 40 + 1 * numpy.arange(192) % 192))])),
    "pc2_boxes_translucent_overlapping": (
        {"Alpha": 0.4, "Size (Pixels)": 15, "Size (m)": 0.12, "Style": "Boxes"}, colored_waves()),
    "pc2_flat_squares_rgb8": ({}, cloud(ripples(40, 30), rgb=255 * corner_colors(ripples(40, 30)), is_dense=True), LARGE),
    "pc2_flat_squares_rgba_alpha_per_point": ({"Size (m)": 0.13}, cloud(
        waves(16, 12), fields=[("rgba", "uint32", packed(count_colors(192), 40 + 1 * numpy.arange(192) % 192))])),
    "pc2_spheres_close_up_overlapping": ({"Size (m)": 0.12, "Style": "Spheres"}, colored_waves(), dict(eye=(0.9, 0.6, 0.7))),
    "pc2_spheres_dark_and_bright": ({"Size (m)": 0.25, "Style": "Spheres"}, cloud(ball(25, 0.8, seed=3), rgb=[(
        10 * i, 250 - 10 * i, 3 * i) for i in range(25)])),
    "pc2_spheres_flat": (
        {"Color": "50; 120; 250", "Color Transformer": "FlatColor", "Size (m)": 0.06, "Style": "Spheres"},
        cloud(ripples(16, 12), is_dense=True), LARGE),
    "pc2_spheres_rgba_at_alpha_0_7": ({"Alpha": 0.7, "Size (m)": 0.13, "Style": "Spheres"}, cloud(
        waves(16, 12), fields=[("rgba", "uint32", packed(count_colors(192), 40 + 1 * numpy.arange(192) % 192))])),
    "pc2_spheres_translucent_overlapping": (
        {"Alpha": 0.4, "Size (Pixels)": 15, "Size (m)": 0.12, "Style": "Spheres"}, colored_waves()),
    "pc2_spheres_two_pixels_wide": ({"Size (m)": 0.012, "Style": "Spheres"}, cloud(waves(40, 30), rgb=count_colors(1200))),
    "pc2_squares_below_one_pixel": ({"Size (m)": 0.004, "Style": "Squares"}, cloud(waves(40, 30), rgb=count_colors(1200))),
    "pc2_squares_brightness_where_edge_turns": ({"Size (m)": 0.13, "Style": "Squares"}, cloud(
        waves(8, 6), rgb=[(56 + i,) * 3 for i in range(48)])),
    "pc2_squares_camera_along_y": (
        {"Size (m)": 0.1, "Style": "Squares"},
        cloud([(-0.45 + 0.3 * (i % 4), -0.3 + 0.2 * (i // 4), 0.2 * (i % 3)) for i in range(16)], rgb=count_colors(16)),
        dict(eye=(0, -1.6, 0.2), target=(0, 0.4, 0.2))),
    "pc2_squares_dark_lighter_edge": (
        {"Color": "60; 40; 20", "Color Transformer": "FlatColor", "Size (m)": 0.08, "Style": "Squares"}, cloud(waves(16, 12))),
    "pc2_squares_flat": (
        {"Color": "115; 210; 22", "Color Transformer": "FlatColor", "Style": "Squares"},
        cloud(ripples(16, 12), is_dense=True), LARGE),
    "pc2_squares_from_below": ({"Size (m)": 0.07, "Style": "Squares"}, colored_waves(), dict(
        eye=(0.05, 0.1, -1.2), turned=quaternion(0.017848608523500887, 5.268356063861754e-09, 0.9998407008987856, 0.0))),
    "pc2_squares_rgb8_bright_and_dark": ({"Size (m)": 0.07, "Style": "Squares"}, colored_waves()),
    "pc2_squares_translucent_overlapping": (
        {"Alpha": 0.4, "Size (Pixels)": 15, "Size (m)": 0.12, "Style": "Squares"}, colored_waves())})
