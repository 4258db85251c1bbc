"""Markers of cube, sphere and point lists."""

import math

import numpy
from visualization_msgs.msg import Marker

from ..clouds import ball, fan, random_rows
from ..data import load
from ..displays import display
from ..geometry import colors, points
from ..messages import header, marker, markers

DATA = load("marker_lists")


def marker_cube_list_color_per_cube(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.CUBE_LIST, at=(0, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(0.15, 0.15, 0.15), paint=(1, 1, 1, 1), id=25,
        points=points(numpy.float32(ball(20, 0.6, seed=5))), colors=colors(DATA["marker_cube_list_color_per_cube_0_colors"]))))


def marker_cube_list_larger_than_one_buffer(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.CUBE_LIST, at=(0, 0, 0.2), turned=(0, 0, 0.3), size=(0.012, 0.012, 0.012), paint=(0.9, 0.6, 0.2, 0.5), id=32,
        points=points([(-0.33 + 0.03 * (i % 22), -0.33 + 0.03 * (i // 22 % 22), -0.2 + 0.03 * (i // 484))
            for i in range(11000)]))))


def marker_cube_list_larger_than_one_buffer_colors(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.CUBE_LIST, at=(0, 0, 0.2), turned=(0, 0, 0.3), size=(0.025, 0.025, 0.025), paint=(1, 1, 1, 1), id=33,
        points=points(
            [(-0.33 + 0.03 * (i % 22), -0.33 + 0.03 * (i // 22 % 22), -0.2 + 0.03 * (i // 484)) for i in range(11000)][::-1]),
        colors=colors([(0.1 + 0.04 * (i // 484), 0.9 - 0.03 * (i // 484), 0.2, 0.3) for i in range(11000)]))))


def marker_cube_list_translucent_posed(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.CUBE_LIST, at=(0, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(0.2, 0.1, 0.3), paint=(0.3, 0.8, 0.4, 0.5), id=24,
        points=points(numpy.float32(ball(20, 0.6, seed=5))))))


def marker_lists(scene):
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE_LIST, size=(0.06, 0.08, 0.1), paint=(1, 0.5, 0, 1), header=header(),
               points=points([(0.5 * math.cos(6 * i / 29), 0.5 * math.sin(6 * i / 29), 0.1 + 0.3 * i / 29) for i in range(30)]),
               colors=colors(random_rows(30, 2))),
        marker(Marker.SPHERE_LIST, at=(0, 0, 0.4), size=(0.08, 0.08, 0.08), paint=(1, 0.5, 0, 1), header=header(), id=1,
               points=points([(0.5 * math.cos(6 * i / 29), 0.5 * math.sin(6 * i / 29), 0.1 + 0.3 * i / 29) for i in range(30)]),
               colors=colors(random_rows(30, 2))),
        marker(Marker.POINTS, at=(0.3, -0.3, 0.1), size=(0.04, 0.02, 0), paint=(1, 0.5, 0, 1), header=header(), id=2,
               points=points([(0.5 * math.cos(6 * i / 29), 0.5 * math.sin(6 * i / 29), 0.1 + 0.3 * i / 29) for i in range(30)]),
               colors=colors(random_rows(30, 2)))))


def marker_lists_alpha_of_marker_and_of_colors(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.LINE_LIST, at=(0, 0, 0.3), size=(0.06, 0, 0), paint=(1, 1, 1, 0.5), id=19,
               points=points([(0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(14)]),
               colors=colors([(1, 0.5, 0.2) for i in range(14)])),
        marker(Marker.CUBE_LIST, at=(0, 0, 0.1), size=(0.1, 0.1, 0.1), paint=(1, 1, 1, 0.3), id=20,
               points=points([(0.10201343894004822, -0.07649841159582138, 0.5620033741),
                              (-0.035613980144262314, 0.015484984964132309, 0.22356292605400085),
                              (-0.4412810206413269, -0.2871411442756653, 0.0910501480102539),
                              (-0.08555378764867783, -0.30935078859329224, -0.05313597619533539),
                              (-0.044158484786748886, 0.07426488399505615, -0.2048734873533249),
                              (-0.10405879467725754, 0.17111675441265106, 0.2760317325592041),
                              (-0.31145262718200684, 0.13290244340896606, -0.20210231840610504),
                              (-0.386665940284729, -0.3934466242790222, -0.19066210091114044)]),
               colors=colors([(1, 0.5, 0.2) for i in range(8)])),
        marker(Marker.TRIANGLE_LIST, size=(0.8, 0.8, 0.8), paint=(1, 1, 1, 0.5), id=21,
               points=points(fan(6, 0.6, 0.5, wave=0.3, step=1.0472)), colors=colors([(0.2, 0.5, 1) for i in range(18)]))))


def marker_lists_negative_scale(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.POINTS, at=(0, 0, 0.2), size=(-0.2, 0.1, 0), paint=(0.3, 0.7, 1, 1), id=11,
               points=points([(0.10201343894004822, -0.07649841159582138, 0.5620033741),
                              (-0.035613980144262314, 0.015484984964132309, 0.22356292605400085),
                              (-0.4412810206413269, -0.2871411442756653, 0.0910501480102539),
                              (-0.08555378764867783, -0.30935078859329224, -0.05313597619533539),
                              (-0.044158484786748886, 0.07426488399505615, -0.2048734873533249),
                              (-0.10405879467725754, 0.17111675441265106, 0.2760317325592041),
                              (-0.31145262718200684, 0.13290244340896606, -0.20210231840610504),
                              (-0.386665940284729, -0.3934466242790222, -0.19066210091114044)])),
        marker(Marker.SPHERE_LIST, at=(0, 0.2, 0.3), size=(-0.2, 0.2, 0.2), paint=(0.7, 1, 0.3, 1), id=12,
               points=points([(0.27303701639175415, 0.19521236419677734, 0.01620626449584961),
                              (-0.177785262465477, 0.0016093869926407933, -0.05183679610490799),
                              (0.4232485890388489, -0.3370666205883026, -0.003306191647425294),
                              (-0.0836169645190239, -0.04327646270394325, 0.2061869502067566)])),
        marker(Marker.SPHERE_LIST, at=(0, 0.2, 0.1), size=(-0.2, -0.2, 0.2), paint=(0.7, 1, 1, 1), id=13,
               points=points([(-0.10405879467725754, 0.17111675441265106, 0.2760317325592041),
                              (-0.31145262718200684, 0.13290244340896606, -0.20210231840610504),
                              (-0.386665940284729, -0.3934466242790222, -0.19066210091114044),
                              (0.27303701639175415, 0.19521236419677734, 0.01620626449584961)])),
        marker(Marker.CUBE_LIST, at=(0, 0.2, 0.3), size=(-0.1, 0.1, 0.1), paint=(1, 0.2, 0.6, 1), id=14,
               points=points([(0.05567915365099907, 0.37601539492607117, -0.024472113698720932),
                              (0.5047212839126587, -0.09885836392641068, -0.15441320836544037),
                              (0.08726540952920914, 0.30790194869041443, 0.23355430364608765),
                              (0.2649879455566406, 0.23368476331233978, 0.10141211748123169),
                              (-0.11921411007642746, -0.03566266968846321, 0.5009777545928955),
                              (0.02785974182188511, -0.16504912078380585, -0.08682825416326523),
                              (-0.1877734214067459, 0.374629408121109, -0.03484344109892845),
                              (0.3382982313632965, 0.09828438609838486, 0.01868138648569584)]))))


def marker_lists_translucent_over_opaque_cube(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(0, 0, 0.1), size=(1, 1, 0.1), paint=(0.2, 0.3, 0.9, 1), id=3),
        marker(Marker.CUBE_LIST, at=(0, 0, 0.4), size=(0.15, 0.15, 0.15), paint=(1, 0.8, 0.2, 0.35), id=4,
               points=points([(0.10201343894004822, -0.07649841159582138, 0.5620033741),
                              (-0.035613980144262314, 0.015484984964132309, 0.22356292605400085),
                              (-0.4412810206413269, -0.2871411442756653, 0.0910501480102539),
                              (-0.08555378764867783, -0.30935078859329224, -0.05313597619533539),
                              (-0.044158484786748886, 0.07426488399505615, -0.2048734873533249),
                              (-0.10405879467725754, 0.17111675441265106, 0.2760317325592041),
                              (-0.31145262718200684, 0.13290244340896606, -0.20210231840610504),
                              (-0.386665940284729, -0.3934466242790222, -0.19066210091114044)])),
        marker(Marker.SPHERE_LIST, at=(0.1, 0.1, 0.4), size=(0.2, 0.2, 0.2), paint=(1, 1, 1, 1), id=5,
               points=points([(0.27303701639175415, 0.19521236419677734, 0.01620626449584961),
                              (-0.177785262465477, 0.0016093869926407933, -0.05183679610490799),
                              (0.4232485890388489, -0.3370666205883026, -0.003306191647425294),
                              (-0.0836169645190239, -0.04327646270394325, 0.2061869502067566),
                              (0.05567915365099907, 0.37601539492607117, -0.024472113698720932),
                              (0.5047212839126587, -0.09885836392641068, -0.15441320836544037)]),
               colors=colors([(1, 0.33333334, 0.75, 0.54), (0, 0.6666667, 1, 0.57), (0.5, 1, 0, 0.6), (1, 0, 0.25, 0.63),
                              (0, 0.33333334, 0.5, 0.66), (0.5, 0.6666667, 0.75, 0.69)])),
        marker(Marker.POINTS, at=(0, -0.1, 0.4), size=(0.12, 0.12, 0), paint=(0.2, 0.9, 0.3, 0.6), id=6,
               points=points([(0.08726540952920914, 0.30790194869041443, 0.23355430364608765),
                              (0.2649879455566406, 0.23368476331233978, 0.10141211748123169),
                              (-0.11921411007642746, -0.03566266968846321, 0.5009777545928955),
                              (0.02785974182188511, -0.16504912078380585, -0.08682825416326523),
                              (-0.1877734214067459, 0.374629408121109, -0.03484344109892845),
                              (0.3382982313632965, 0.09828438609838486, 0.01868138648569584)]))))


def marker_points_dark_lighter_edge(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.POINTS, at=(0, 0, 0.2), size=(0.2, 0.2, 0), paint=(0.1, 0.05, 0.2, 1), id=7,
        points=points(numpy.float32(ball(20, 0.6, seed=5))))))


def marker_points_line_strip_nan_points(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.POINTS, at=(0, 0, 0.2), size=(0.2, 0.2, 0), paint=(1, 0.6, 0.2, 1), id=13,
               points=points([(0.10201343894004822, -0.07649841159582138, 0.5620033741),
                              (-0.035613980144262314, 0.015484984964132309, 0.22356292605400085),
                              (-0.4412810206413269, -0.2871411442756653, 0.0910501480102539),
                              (-0.08555378764867783, -0.30935078859329224, -0.05313597619533539), (math.nan, 0, 0),
                              (-0.044158484786748886, 0.07426488399505615, -0.2048734873533249),
                              (-0.10405879467725754, 0.17111675441265106, 0.2760317325592041),
                              (-0.31145262718200684, 0.13290244340896606, -0.20210231840610504),
                              (-0.386665940284729, -0.3934466242790222, -0.19066210091114044)])),
        marker(Marker.LINE_STRIP, at=(0, 0, 0.4), size=(0.06, 0, 0), paint=(0.2, 0.6, 1, 1), id=14,
               points=points([(0.5, 0, 0), (0.38242109364224425, 0.3221088436188455, 0.05),
                              (0.08498357145012052, 0.49272486499423007, 0.1), (-0.2524230523, 0.43160468332443697, 0.15),
                              (-0.47111117033432903, 0.16749407507795255, 0.2), (0, math.nan, 0),
                              (-0.46822834364539817, -0.17539161384480992, 0.25), (-0.2451304106703501, -0.4357878862067939, 0.3),
                              (0.09325618471128744, -0.4912263063121663, 0.35), (0.3877829392551248, -0.3156333189361608, 0.4),
                              (0.49992931819170755, 0.008406950242174856, 0.45)])),
        marker(Marker.CUBE, size=(0.2, 0.2, 0.2), paint=(0, 1, 0, 1), id=15)))


def marker_points_translucent_alpha_counts_twice(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.POINTS, at=(0, 0, 0.2), size=(0.2, 0.2, 0), paint=(1, 0.7, 0.3, 0.5), id=29,
               points=points(numpy.float32(ball(20, 0.6, seed=5)))),
        marker(Marker.SPHERE_LIST, at=(0.3, 0.3, 0.2), size=(0.3, 0.3, 0.3), paint=(0.2, 0.7, 1, 0.5), id=30,
               points=points([(0.10201343894004822, -0.07649841159582138, 0.5620033741),
                              (-0.035613980144262314, 0.015484984964132309, 0.22356292605400085),
                              (-0.4412810206413269, -0.2871411442756653, 0.0910501480102539),
                              (-0.08555378764867783, -0.30935078859329224, -0.05313597619533539),
                              (-0.044158484786748886, 0.07426488399505615, -0.2048734873533249)]))))


def marker_points_unequal_scale(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.POINTS, at=(0, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(0.2, 0.06, 0), paint=(0.3, 0.7, 1, 1), id=28,
        points=points(numpy.float32(ball(20, 0.6, seed=5))))))


def marker_sphere_list_alpha_per_sphere(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.SPHERE_LIST, at=(0, 0, 0.2), size=(0.25, 0.25, 0.25), paint=(1, 1, 1, 1), id=26,
        points=points(numpy.float32(ball(20, 0.6, seed=5))),
        colors=colors(DATA["marker_sphere_list_alpha_per_sphere_0_colors"]))))


def marker_sphere_list_unequal_scale(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.SPHERE_LIST, at=(0, 0, 0.2), size=(0.3, 0.12, 0.2), paint=(0.9, 0.5, 0.2, 1), id=27,
        points=points(numpy.float32(ball(20, 0.6, seed=5))))))
