"""Point clouds in the style Points."""

import numpy

from ..clouds import any_colors, ball, cloud, colored_waves, count_colors, packed, ripples, waves
from ..displays import display
from ..scene import LARGE, family, one_display


def pc2_points_beyond_100m(scene):
    scene.camera(eye=(2, 0, 1), target=(1, 0, 1))
    scene.show(display("PointCloud2", {"Color Transformer": "FlatColor", "Size (Pixels)": 6, "Style": "Points"}),
               display("PointCloud2",
                       {"Color": "255; 140; 0", "Color Transformer": "FlatColor", "Size (m)": 4.0, "Style": "Squares"}, name="d",
                       topic="/cloud2"))
    scene.publish("/cloud", cloud([
        (0, -6, 0), (-5, -3, 0.2), (-10, 0, 0.4), (-21, 3, 0.6), (-26, 6, 0.8), (-31, -6, 1), (-42, -3, 1.2), (-47, 0, 1.4),
        (-52, 3, 1.6), (-63, 6, 1.8), (-68, -6, 2), (-73, -3, 2.2), (-84, 0, 2.4), (-89, 3, 2.6), (-94, 6, 2.8), (-105, -6, 3),
        (-110, -3, 3.2), (-115, 0, 3.4), (-126, 3, 3.6), (-131, 6, 3.8)]))
    scene.publish("/cloud2", cloud([(-7 * i, -10 + 5 * (i % 5), -3 + 0.2 * i) for i in range(20)]))


def pc2_points_spheres_around_camera(scene):
    scene.camera(eye=(0.3, 0.2, 0.35), target=(-0.5, -0.3, 0.2))
    scene.show(display("PointCloud2", {"Size (Pixels)": 20, "Style": "Points"}),
               display("PointCloud2",
                       {"Color": "80; 160; 240", "Color Transformer": "FlatColor", "Size (m)": 0.2, "Style": "Spheres"}, name="d",
                       topic="/cloud2"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/cloud2", cloud(ball(60, 0.6)))


family(one_display("PointCloud2", "/cloud"), {
    "pc2_points_1px": ({"Size (Pixels)": 1, "Style": "Points"}, colored_waves()),
    "pc2_points_2_5px": ({"Size (Pixels)": 2.5, "Style": "Points"}, colored_waves()),
    "pc2_points_2px": ({"Size (Pixels)": 2, "Style": "Points"}, colored_waves()),
    "pc2_points_300px": ({"Size (Pixels)": 300, "Style": "Points"}, cloud(
        [(0, 0, 0.2), (0.1, -0.2, 0.1), (-0.3, 0.1, 0)], rgb=count_colors(3))),
    "pc2_points_3px_alpha_0_2": ({"Alpha": 0.2, "Style": "Points"}, cloud(waves(40, 30), rgb=count_colors(1200))),
    "pc2_points_4px": ({"Size (Pixels)": 4, "Style": "Points"}, colored_waves()),
    "pc2_points_64px": ({"Size (Pixels)": 64, "Style": "Points"}, cloud(ball(60, 0.5), rgb=count_colors(60))),
    "pc2_points_7px": ({"Size (Pixels)": 7, "Style": "Points"}, colored_waves()),
    "pc2_points_centres_outside_picture": ({"Size (Pixels)": 50, "Style": "Points"}, colored_waves(), dict(
        size=(320, 240), focal=(700, 700))),
    "pc2_points_flat": (
        {"Color Transformer": "FlatColor", "Size (Pixels)": 15, "Style": "Points"},
        cloud(ripples(16, 12), is_dense=True), LARGE),
    "pc2_points_rgb8": ({"Style": "Points"}, cloud(ripples(40, 30), rgb=any_colors(1200, 1), is_dense=True), LARGE),
    "pc2_points_rgba_alpha_per_point": ({"Size (Pixels)": 14, "Style": "Points"}, cloud(
        waves(16, 12), fields=[("rgba", "uint32", packed(count_colors(192), 40 + 1 * numpy.arange(192) % 192))])),
    "pc2_points_translucent_overlapping": (
        {"Alpha": 0.4, "Size (Pixels)": 15, "Size (m)": 0.12, "Style": "Points"}, colored_waves())})
