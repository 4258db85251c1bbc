"""Point clouds in the styles Squares, Flat Squares, Spheres and Boxes."""

import math

import numpy

from ..clouds import ball, cloud, corner_colors, count_colors, packed, ripples, waves
from ..displays import camera_pub, display
from ..geometry import quaternion


def pc2_boxes_flat(scene):
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(display("PointCloud2", {
        "Color": "250; 120; 50", "Color Transformer": "FlatColor", "Size (m)": 0.05, "Style": "Boxes"}))
    scene.publish("/cloud", cloud(ripples(16, 12), is_dense=True))


def pc2_boxes_large_from_above_and_inside(scene):
    scene.camera(eye=(0.9, 0.7, 1.3))
    scene.show(display("PointCloud2", {"Size (m)": 0.35, "Style": "Boxes"}))
    scene.publish("/cloud", cloud(ball(14, 0.7), fields=[("rgb", "rgb", packed(count_colors(14)))]))


def pc2_boxes_rgb8_rotated_frame(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Size (m)": 0.08, "Style": "Boxes"}))
    scene.publish("/cloud", cloud(waves(16, 12), "sensor", fields=[("rgb", "rgb", packed(count_colors(192)))]))


def pc2_boxes_rgba(scene):
    scene.show(display("PointCloud2", {"Size (m)": 0.09, "Style": "Boxes"}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgba", "uint32", packed(
        count_colors(192), 40 + 1 * numpy.arange(192) % 192))]))


def pc2_boxes_translucent_overlapping(scene):
    scene.show(display("PointCloud2", {"Alpha": 0.4, "Size (Pixels)": 15, "Size (m)": 0.12, "Style": "Boxes"}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))


def pc2_flat_squares_rgb8(scene):
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(display("PointCloud2"))
    scene.publish("/cloud", cloud(
        ripples(40, 30), fields=[("rgb", "rgb", packed(255 * corner_colors(ripples(40, 30))))], is_dense=True))


def pc2_flat_squares_rgba_alpha_per_point(scene):
    scene.show(display("PointCloud2", {"Size (m)": 0.13}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgba", "uint32", packed(
        count_colors(192), 40 + 1 * numpy.arange(192) % 192))]))


def pc2_flat_squares_rotated_frame(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Size (m)": 0.08}))
    scene.publish("/cloud", cloud(waves(16, 12), "sensor", fields=[("rgb", "rgb", packed(count_colors(192)))]))


def pc2_spheres_close_up_overlapping(scene):
    scene.camera(eye=(0.9, 0.6, 0.7))
    scene.show(display("PointCloud2", {"Size (m)": 0.12, "Style": "Spheres"}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))


def pc2_spheres_dark_and_bright(scene):
    scene.show(display("PointCloud2", {"Size (m)": 0.25, "Style": "Spheres"}))
    scene.publish("/cloud", cloud(ball(25, 0.8, seed=3), fields=[("rgb", "rgb", packed([(10 * i, 250 - 10 * i, 3 * i)
        for i in range(25)]))]))


def pc2_spheres_flat(scene):
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(display("PointCloud2", {
        "Color": "50; 120; 250", "Color Transformer": "FlatColor", "Size (m)": 0.06, "Style": "Spheres"}))
    scene.publish("/cloud", cloud(ripples(16, 12), is_dense=True))


def pc2_spheres_frame_on_its_side(scene):
    scene.frame("side", at=(0, 0, 0.3), turned=(-math.pi / 2, 0, -math.pi / 2))
    scene.show(display("PointCloud2", {
        "Color": "200; 200; 60", "Color Transformer": "FlatColor", "Size (m)": 0.12, "Style": "Spheres"}))
    scene.publish("/cloud", cloud(ball(60, 0.6), "side"))


def pc2_spheres_rgba_at_alpha_0_7(scene):
    scene.show(display("PointCloud2", {"Alpha": 0.7, "Size (m)": 0.13, "Style": "Spheres"}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgba", "uint32", packed(
        count_colors(192), 40 + 1 * numpy.arange(192) % 192))]))


def pc2_spheres_translucent_overlapping(scene):
    scene.show(display("PointCloud2", {"Alpha": 0.4, "Size (Pixels)": 15, "Size (m)": 0.12, "Style": "Spheres"}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))


def pc2_spheres_two_pixels_wide(scene):
    scene.show(display("PointCloud2", {"Size (m)": 0.012, "Style": "Spheres"}))
    scene.publish("/cloud", cloud(waves(40, 30), fields=[("rgb", "rgb", packed(count_colors(1200)))]))


def pc2_squares_below_one_pixel(scene):
    scene.show(display("PointCloud2", {"Size (m)": 0.004, "Style": "Squares"}))
    scene.publish("/cloud", cloud(waves(40, 30), fields=[("rgb", "rgb", packed(count_colors(1200)))]))


def pc2_squares_boxes_across_near_plane(scene):
    scene.camera(eye=(0.3, 0.2, 0.35), target=(-0.5, -0.3, 0.2))
    scene.show(display("PointCloud2", {"Size (m)": 0.3, "Style": "Squares"}),
               display("PointCloud2",
                       {"Color": "80; 160; 240", "Color Transformer": "FlatColor", "Size (m)": 0.2, "Style": "Boxes"}, name="d",
                       topic="/cloud2"),
               camera_pub({"Near Clip Distance": 0.1}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/cloud2", cloud(ball(40, 0.6)))


def pc2_squares_brightness_where_edge_turns(scene):
    scene.show(display("PointCloud2", {"Size (m)": 0.13, "Style": "Squares"}))
    scene.publish("/cloud", cloud(waves(8, 6), fields=[("rgb", "rgb", packed([(56 + i,) * 3 for i in range(48)]))]))


def pc2_squares_camera_along_y(scene):
    scene.camera(eye=(0, -1.6, 0.2), target=(0, 0.4, 0.2))
    scene.show(display("PointCloud2", {"Size (m)": 0.1, "Style": "Squares"}))
    scene.publish("/cloud", cloud(
        [(-0.45 + 0.3 * (i % 4), -0.3 + 0.2 * (i // 4), 0.2 * (i % 3)) for i in range(16)],
        fields=[("rgb", "rgb", packed(count_colors(16)))]))


def pc2_squares_centres_outside_picture_culled(scene):
    scene.show(display("Grid"),
               display("PointCloud2", {"Size (m)": 0.8}),
               display("PointCloud2", {"Color": "255; 160; 0", "Color Transformer": "FlatColor", "Size (m)": 0.6}, name="d",
                       topic="/cloud2"))
    scene.publish("/cloud", cloud([(0, 1.45, 0.1), (0.1, 1.5, 0.1)], fields=[("rgb", "rgb", packed(count_colors(2)))]))
    scene.publish("/cloud2", cloud([(0.1, -1.4, 0.1), (0, 0, 0.1)]))


def pc2_squares_dark_lighter_edge(scene):
    scene.show(display("PointCloud2", {
        "Color": "60; 40; 20", "Color Transformer": "FlatColor", "Size (m)": 0.08, "Style": "Squares"}))
    scene.publish("/cloud", cloud(waves(16, 12)))


def pc2_squares_flat(scene):
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(display("PointCloud2", {"Color": "115; 210; 22", "Color Transformer": "FlatColor", "Style": "Squares"}))
    scene.publish("/cloud", cloud(ripples(16, 12), is_dense=True))


def pc2_squares_from_below(scene):
    scene.camera(eye=(0.05, 0.1, -1.2), turned=quaternion(0.017848608523500887, 5.268356063861754e-09, 0.9998407008987856, 0.0))
    scene.show(display("PointCloud2", {"Size (m)": 0.07, "Style": "Squares"}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))


def pc2_squares_rgb8_bright_and_dark(scene):
    scene.show(display("PointCloud2", {"Size (m)": 0.07, "Style": "Squares"}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))


def pc2_squares_translucent_overlapping(scene):
    scene.show(display("PointCloud2", {"Alpha": 0.4, "Size (Pixels)": 15, "Size (m)": 0.12, "Style": "Squares"}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
