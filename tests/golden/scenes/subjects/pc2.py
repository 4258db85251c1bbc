"""Point clouds (PointCloud2): layouts, faults, several clouds, decay."""

import math

import numpy

from ..clouds import (
    any_colors, ball, cloud, colored_waves, columns, corner_colors, count_colors, cut, packed, raw_cloud, ripples, waves,
    with_values)
from ..displays import camera_pub, display
from ..messages import CUBE, marker, markers
from ..scene import LARGE, family, one_display


def pc2_alpha_below_and_above_one_level(scene):
    scene.show(display("Grid"),
               display("PointCloud2", {"Alpha": 0.003, "Color Transformer": "FlatColor", "Size (m)": 0.12}),
               display("PointCloud2", {"Alpha": 0.02, "Color Transformer": "FlatColor", "Size (m)": 0.12, "Style": "Boxes"},
                       name="d", topic="/cloud2"))
    scene.publish("/cloud", cloud(waves(16, 12)))
    scene.publish("/cloud2", cloud(ball(25, 0.5)))


def pc2_alpha_just_below_1(scene):
    scene.show(display("PointCloud2", {"Alpha": 0.9999, "Size (m)": 0.12}),
               display("PointCloud2", {"Alpha": 0.99, "Color Transformer": "FlatColor", "Size (m)": 0.12}, name="d",
                       topic="/cloud2"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/cloud2", cloud(ball(25, 0.5)))


def pc2_camera_below_cloud_two_sizes(scene):
    scene.camera(eye=(0.6, -1, 1.2), target=(0, 0.1, 0.1), roll=1.1, parent="sensor")
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Size (m)": 0.04}),
               display("PointCloud2",
                       {"Color": "20; 20; 20", "Color Transformer": "FlatColor", "Size (m)": 0.1, "Style": "Boxes"}, name="d",
                       topic="/cloud2"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/cloud2", cloud(ball(20, 0.5), "sensor"))


def pc2_data_shorter_than_header(scene):
    scene.show(display("Grid"), display("PointCloud2", {"Size (m)": 0.06, "Style": "Squares"}))
    scene.publish("/cloud", cut(colored_waves(), 1000))


def pc2_decay(scene):
    scene.camera(**LARGE)
    scene.show(display("PointCloud2", {"Color": "200; 90; 30", "Color Transformer": "FlatColor", "Decay Time": 1000}))
    scene.publish("/cloud", cloud(ripples(16, 12), is_dense=True), cloud(ripples(16, 12) + (0.4, 0.2, 0.2), is_dense=True))


def pc2_decay_three_clouds_translucent(scene):
    scene.show(display("PointCloud2", {"Alpha": 0.6, "Decay Time": 1000, "Size (m)": 0.06}))
    scene.publish("/cloud",
                  cloud(waves(8, 6) + (0, 0, -0.1), rgb=count_colors(48)),
                  cloud(waves(8, 6) + (0, 0, 0.1), rgb=count_colors(48)),
                  cloud(waves(8, 6) + (0, 0, 0.3), rgb=count_colors(48)))


def pc2_float64_xyz_not_drawn(scene):
    scene.show(display("Grid"), display("PointCloud2", {"Color Transformer": "FlatColor", "Size (m)": 0.06, "Style": "Squares"}))
    scene.publish("/cloud", raw_cloud([*columns(numpy.float32(waves(16, 12)), "float64")]))


def pc2_no_decay_last_of_three_stays(scene):
    scene.show(display("PointCloud2", {"Size (m)": 0.06}))
    scene.publish("/cloud",
                  cloud(waves(8, 6) + (0, 0, -0.1), rgb=count_colors(48)),
                  cloud(waves(8, 6) + (0, 0, 0.1), rgb=count_colors(48)),
                  cloud(waves(8, 6) + (0, 0, 0.3), rgb=count_colors(48)))


def pc2_styles_occlude_each_other(scene):
    scene.show(display("Grid", {"Cell Size": 0.25}),
               display("Axes", {"Length": 0.6, "Radius": 0.05}),
               display("PointCloud2", {"Size (Pixels)": 9, "Style": "Points"}),
               display("PointCloud2",
                       {"Color": "255; 120; 20", "Color Transformer": "FlatColor", "Size (m)": 0.07, "Style": "Boxes"}, name="d",
                       topic="/cloud2"),
               display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/cloud2", cloud(ball(80, 0.6)))
    scene.publish("/m", markers(marker(
        CUBE, at=(0.2, -0.2, 0.3), turned=(0.2, 0.3, 0.4), size=(0.4, 0.3, 0.5), paint=(0.2, 0.8, 0.4))))


def pc2_two_clouds_visibility(scene):
    scene.camera(**LARGE)
    scene.show(display("PointCloud2", {"Color": "0; 200; 200", "Color Transformer": "FlatColor"}, name="shown"),
               display("PointCloud2", {"Color": "255; 0; 0", "Color Transformer": "FlatColor"}, name="hidden", topic="/cloud2"),
               camera_pub({"Visibility": {"Value": True, "hidden": False, "shown": True}}))
    scene.publish("/cloud", cloud(ripples(16, 12), is_dense=True))
    scene.publish("/cloud2", cloud(ripples(16, 12) + (0.1, 0.1, 0.2), is_dense=True))


def pc2_two_translucent_clouds_and_grid(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("Grid", {"Alpha": 0.6}),
               display("PointCloud2", {
                   "Alpha": 0.5, "Color": "255; 80; 0", "Color Transformer": "FlatColor", "Size (m)": 0.15, "Style": "Squares"}),
               display("PointCloud2",
                       {"Alpha": 0.5, "Color": "0; 200; 255", "Color Transformer": "FlatColor", "Size (m)": 0.2,
                        "Style": "Spheres"}, name="d", topic="/cloud2"))
    scene.publish("/cloud", cloud(waves(16, 12)))
    scene.publish("/cloud2", cloud(ball(60, 0.6), "sensor"))


def pc2_unknown_frame(scene):
    scene.show(display("Grid"), display("PointCloud2", {"Color Transformer": "FlatColor", "Size (m)": 0.06, "Style": "Squares"}))
    scene.publish("/cloud", cloud(waves(16, 12), "nowhere"))


family(one_display("PointCloud2", "/cloud"), {
    "pc2_20000_points": (
        {"Size (Pixels)": 2, "Style": "Points"},
        cloud(waves(200, 100), rgb=count_colors(20000)),
        dict(size=(480, 360), focal=(400, 400))),
    "pc2_alpha": (
        {"Alpha": 0.3, "Color": "255; 80; 80", "Color Transformer": "FlatColor", "Size (m)": 0.08},
        cloud(ripples(16, 12), is_dense=True), LARGE),
    "pc2_behind_and_near": (
        {"Size (Pixels)": 4, "Style": "Points"},
        cloud(numpy.concatenate([ripples(40, 30), 4 * ripples(40, 30), (120, 120, 1) * ripples(40, 30)]), rgb=any_colors(3600, 8),
              is_dense=True),
        dict(eye=(0.3, 0.2, 0.4), target=(-1.5, -0.8, 0), size=(640, 480), focal=(500, 500))),
    "pc2_equal_depth_later_wins": ({"Size (m)": 0.1}, cloud(
        [(-0.3 + 0.3 * (i % 3), -0.3 + 0.3 * (i // 3 % 3), 0.3) for i in range(18)], rgb=count_colors(18))),
    "pc2_nan_padded": (
        {},
        cloud(with_values(
                  with_values(
                      with_values(ripples(40, 30),
                                  [0, 7, 21, 28, 35, 42, 49, 56, 63, 70, 77, 84, 98, 105, 112, 119, 126, 133, 140, 147, 154, 161,
                                   175, 182, 189, 196, 203, 210, 217, 224, 231, 238, 252, 259, 266, 273, 280, 287, 294, 301, 308,
                                   315, 329, 336, 343, 350, 357, 364, 371, 378, 385, 392, 406, 413, 420, 427, 434, 441, 448, 455,
                                   462, 469, 483, 490, 497, 504, 511, 518, 525, 532, 539, 546, 560, 567, 574, 581, 588, 595, 602,
                                   609, 616, 623, 637, 644, 651, 658, 665, 672, 679, 686, 693, 700, 714, 721, 728, 735, 742, 749,
                                   756, 763, 770, 777, 791, 798, 805, 812, 819, 826, 833, 840, 847, 854, 868, 875, 882, 889, 896,
                                   903, 910, 917, 924, 931, 945, 952, 959, 966, 973, 980, 987, 994, 1001, 1008, 1022, 1029, 1036,
                                   1043, 1050, 1057, 1064, 1071, 1078, 1085, 1099, 1106, 1113, 1120, 1127, 1134, 1141, 1148, 1155,
                                   1162, 1176, 1183, 1190, 1197], (math.nan, math.nan, math.nan)),
                      [3, 25, 36, 47, 58, 69, 80, 102, 113, 124, 135, 146, 157, 179, 190, 201, 212, 223, 234, 256, 267, 278, 289,
                       300, 311, 333, 344, 355, 366, 377, 388, 410, 421, 432, 443, 454, 465, 487, 498, 509, 520, 531, 542, 564,
                       575, 586, 597, 608, 619, 641, 652, 663, 674, 685, 696, 718, 729, 740, 751, 762, 773, 795, 806, 817, 828,
                       839, 850, 872, 883, 894, 905, 916, 927, 949, 960, 971, 982, 993, 1004, 1026, 1037, 1048, 1059, 1070, 1081,
                       1103, 1114, 1125, 1136, 1147, 1158, 1180, 1191], (None, None, math.inf)), range(14, 1200, 77),
                  (math.nan, math.nan, math.inf)), rgb=255 * corner_colors(ripples(40, 30)), rows=30, point_step=32,
              offsets=[16, 20, 24, 28]), LARGE),
    "pc2_organised_padded_nan_rows": ({"Size (m)": 0.06, "Style": "Spheres"}, raw_cloud(
        [("a", "float64", numpy.full(192, 0)),
         *columns(with_values(waves(16, 12), range(0, 192, 5), (math.nan, math.nan, math.nan))),
         ("q", "uint8", numpy.full(192, 0)), ("rgb", "rgb", packed(count_colors(192)))], rows=12, point_step=32)),
    "pc2_selectable_false": ({"Selectable": False, "Size (m)": 0.07, "Style": "Squares"}, colored_waves())})
