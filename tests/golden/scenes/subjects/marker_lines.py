"""Markers of line strips and line lists."""

import math

from visualization_msgs.msg import Marker

from ..clouds import random_rows
from ..data import load
from ..displays import display
from ..geometry import colors, points
from ..messages import header, marker, markers

DATA = load("marker_lines")


def marker_line_list_odd_point_count(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.LINE_LIST, size=(0.05, 0, 0), paint=(1, 1, 1, 1), id=34, points=points([
            (0.5, 0, 0), (0.38242109364224425, 0.3221088436188455, 0.05), (0.08498357145012052, 0.49272486499423007, 0.1),
            (-0.2524230523, 0.43160468332443697, 0.15), (-0.47111117033432903, 0.16749407507795255, 0.2)])),
        marker(Marker.LINE_LIST, at=(0, 0, 0.3), size=(0.05, 0, 0), paint=(1, 0.4, 0.4, 1), id=35,
               points=points([(0.5, 0, 0), (0.38242109364224425, 0.3221088436188455, 0.05),
                              (0.08498357145012052, 0.49272486499423007, 0.1), (-0.2524230523, 0.43160468332443697, 0.15)]))))


def marker_line_list_translucent_crossing(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.LINE_LIST, at=(0, 0, 0.2), size=(0.15, 0, 0), paint=(1, 1, 1, 0.7), id=1,
        points=points([(-0.6, -0.4, 0), (0.6, 0.4, 0), (0.6, -0.4, 0), (-0.6, 0.4, 0), (0, 0.6, 0), (0, -0.6, 0)]),
        colors=colors([(1, 0, 0, 0.7), (1, 0.6, 0, 0.7), (0.8, 1, 0, 0.7), (0, 1, 0.5, 0.7), (0, 0.4, 1, 0.7),
                       (0.7, 0, 1, 0.7)]))))


def marker_line_list_triangles_nan_points(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.LINE_LIST, at=(0, 0, 0.4), size=(0.06, 0, 0), paint=(0.2, 0.6, 1, 1), id=16,
               points=points([
                   (0.5, 0, 0), (0.38242109364224425, 0.3221088436188455, 0.05), (0.08498357145012052, 0.49272486499423007, 0.1),
                   (-0.2524230523, 0.43160468332443697, 0.15), (-0.47111117033432903, 0.16749407507795255, 0.2), (0, math.nan, 0),
                   (-0.2451304106703501, -0.4357878862067939, 0.3), (0.09325618471128744, -0.4912263063121663, 0.35),
                   (0.3877829392551248, -0.3156333189361608, 0.4), (0.49992931819170755, 0.008406950242174856, 0.45)])),
        marker(Marker.TRIANGLE_LIST, size=(0.8, 0.8, 0.8), paint=(1, 1, 0, 1), id=17, points=points(
            DATA["marker_line_list_triangles_nan_points_1_points"])),
        marker(Marker.CUBE, size=(0.2, 0.2, 0.2), paint=(0, 1, 0, 1), id=18)))


def marker_line_strip_color_and_alpha_per_point(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.LINE_STRIP, size=(0.1, 0, 0), paint=(1, 1, 1, 1), id=17,
               points=points([(0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(14)]),
               colors=colors([(0, 0.33333334, 0, 0.3), (0.5, 0.6666667, 0.25, 0.35), (1, 1, 0.5, 0.4), (0, 0, 0.75, 0.45),
                              (0.5, 0.33333334, 1, 0.5), (1, 0.6666667, 0, 0.55), (0, 1, 0.25, 0.6), (0.5, 0, 0.5, 0.65),
                              (1, 0.33333334, 0.75, 0.7), (0, 0.6666667, 1, 0.75), (0.5, 1, 0, 0.8), (1, 0, 0.25, 0.85),
                              (0, 0.33333334, 0.5, 0.9), (0.5, 0.6666667, 0.75, 0.95)])),
        marker(Marker.LINE_LIST, at=(0, 0, 0.5), size=(0.05, 0, 0), paint=(1, 1, 1, 1), id=18,
               points=points([(0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(14)]),
               colors=colors([(0, 0.33333334, 0, 0.3), (0.5, 0.6666667, 0.25, 0.35), (1, 1, 0.5, 0.4), (0, 0, 0.75, 0.45),
                              (0.5, 0.33333334, 1, 0.5), (1, 0.6666667, 0, 0.55), (0, 1, 0.25, 0.6), (0.5, 0, 0.5, 0.65),
                              (1, 0.33333334, 0.75, 0.7), (0, 0.6666667, 1, 0.75), (0.5, 1, 0, 0.8), (1, 0, 0.25, 0.85),
                              (0, 0.33333334, 0.5, 0.9), (0.5, 0.6666667, 0.75, 0.95)]))))


def marker_line_strip_crossing_colors_differ(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.LINE_STRIP, at=(0, 0, 0.2), size=(0.15, 0, 0), paint=(1, 1, 1, 0.7),
        points=points([(-0.6, -0.4, 0), (0.6, 0.4, 0), (0.6, -0.4, 0), (-0.6, 0.4, 0), (0, 0.6, 0), (0, -0.6, 0)]),
        colors=colors([(1, 0, 0, 0.7), (1, 0.6, 0, 0.7), (0.8, 1, 0, 0.7), (0, 1, 0.5, 0.7), (0, 0.4, 1, 0.7),
                       (0.7, 0, 1, 0.7)]))))


def marker_line_strip_folds_back_translucent(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.LINE_STRIP, size=(0.12, 0, 0), paint=(0.4, 0.8, 1, 0.6), id=1,
        points=points([(-0.6 + 0.1 * i, 0.35 - 0.7 * (i % 2), 0.05 * i) for i in range(12)]))))


def marker_line_strip_over_16384_points(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.LINE_STRIP, size=(0.05, 0, 0), paint=(1, 0.6, 0.2, 1), id=31,
        points=points(DATA["marker_line_strip_over_16384_points_0_points"]))))


def marker_line_strip_past_the_camera(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.LINE_STRIP, size=(0.2, 0, 0), paint=(0.3, 0.9, 0.9, 1), id=29, points=points([
            (-2, -1.5, 0), (0, 0, 0.4), (1.5, 1, 1.2), (3, 2.4, 2.4)])),
        marker(Marker.LINE_LIST, size=(0.05, 0, 0), paint=(1, 0.4, 0.1, 1), id=30, points=points([
            (-1, 0.5, 0), (3, 2, 1.5), (0, -1, 0), (3, 1, 2)]))))


def marker_line_strip_repeated_ends(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(marker(
        Marker.LINE_STRIP, size=(0.1, 0, 0), paint=(0.9, 0.5, 0.2, 1),
        points=points([(-0.5, -0.3, 0), (-0.5, -0.3, 0), (0.1, 0.1, 0.2), (0.5, -0.2, 0.3), (0.5, -0.2, 0.3)]))))


def marker_line_strip_sharp_corners(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.LINE_STRIP, size=(0.12, 0, 0), paint=(0.9, 0.2, 0.2, 1), id=19, points=points([
            (-0.6, -0.5, 0), (0.5, -0.4, 0.1), (-0.5, -0.2, 0.2), (-0.5, -0.2, 0.2), (0.6, 0.3, 0.2)])),
        marker(Marker.LINE_STRIP, size=(0.004, 0, 0), paint=(1, 1, 0, 1), id=20, points=points([(
            0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(14)])),
        marker(Marker.LINE_LIST, at=(0, 0, 0.1), size=(0.02, 0, 0), paint=(0, 1, 0.4, 1), id=21,
               points=points([(0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(6)]))))


def marker_lines(scene):
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.LINE_STRIP, size=(0.03, 0, 0), paint=(1, 1, 0, 1), header=header(), points=points([(
            0.5 * math.cos(6 * i / 29), 0.5 * math.sin(6 * i / 29), 0.1 + 0.3 * i / 29) for i in range(30)])),
        marker(Marker.LINE_LIST, at=(0, 0, 0.3), size=(0.02, 0, 0), paint=(1, 1, 1, 1), header=header(), id=1,
               points=points([(0.5 * math.cos(6 * i / 29), 0.5 * math.sin(6 * i / 29), 0.1 + 0.3 * i / 29) for i in range(30)]),
               colors=colors(random_rows(30, 2))),
        marker(Marker.LINE_STRIP, at=(0.2, 0.2, 0.5), turned=(0.3, 0, 0), size=(0.05, 0, 0), paint=(1, 1, 1, 1), header=header(),
               id=2,
               points=points([(0.5 * math.cos(6 * i / 29), 0.5 * math.sin(6 * i / 29), 0.1 + 0.3 * i / 29) for i in range(30)]),
               colors=colors(random_rows(30, 2)))))


def marker_lines_translucent_wide(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.LINE_STRIP, size=(0.08, 0, 0), paint=(1, 0.6, 0.1, 0.5), id=15, points=points([(
            0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(14)])),
        marker(Marker.LINE_LIST, at=(0, 0, 0.3), turned=(0.5, 0, 0), size=(0.06, 0, 0), paint=(0.1, 0.6, 1, 0.6), id=16,
               points=points([(0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(10)]))))


def marker_lines_with_scale_y_and_z(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.LINE_LIST, size=(0.05, 0.5, 2), paint=(1, 0.5, 0.5, 1), id=22, points=points([(
            0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(14)])),
        marker(Marker.LINE_STRIP, at=(0.2, 0, 0.1), turned=(0.4, 0.3, 0.8), size=(0.03, 1, 1), paint=(0.5, 0.5, 1, 1), id=23,
               points=points([(0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(14)]))))
