"""Markers of line strips and line lists."""

import math

from ..clouds import random_rows, spiral
from ..data import load
from ..messages import CUBE, LINE_LIST, LINE_STRIP, TRIANGLES, header, marker
from ..scene import LARGE, Scene, family

DATA = load("marker_lines")


def marker_lines(scene):
    scene.camera(**LARGE)
    scene.show_markers(
        marker(LINE_STRIP, size=(0.03, 0, 0), paint=(1, 1, 0), header=header(), points=[(
            0.5 * math.cos(6 * i / 29), 0.5 * math.sin(6 * i / 29), 0.1 + 0.3 * i / 29) for i in range(30)]),
        marker(LINE_LIST, at=(0, 0, 0.3), size=(0.02, 0, 0), paint=(1, 1, 1), header=header(), id=1,
               points=[(0.5 * math.cos(6 * i / 29), 0.5 * math.sin(6 * i / 29), 0.1 + 0.3 * i / 29) for i in range(30)],
               colors=random_rows(30, 2)),
        marker(LINE_STRIP, at=(0.2, 0.2, 0.5), turned=(0.3, 0, 0), size=(0.05, 0, 0), paint=(1, 1, 1), header=header(), id=2,
               points=[(0.5 * math.cos(6 * i / 29), 0.5 * math.sin(6 * i / 29), 0.1 + 0.3 * i / 29) for i in range(30)],
               colors=random_rows(30, 2)))


family(Scene.show_markers, {
    "marker_line_list_odd_point_count": [
        marker(LINE_LIST, size=(0.05, 0, 0), paint=(1, 1, 1), id=34, points=[
            (0.5, 0, 0), (0.38242109364224425, 0.3221088436188455, 0.05), (0.08498357145012052, 0.49272486499423007, 0.1),
            (-0.2524230523, 0.43160468332443697, 0.15), (-0.47111117033432903, 0.16749407507795255, 0.2)]),
        marker(LINE_LIST, at=(0, 0, 0.3), size=(0.05, 0, 0), paint=(1, 0.4, 0.4), id=35, points=[
            (0.5, 0, 0), (0.38242109364224425, 0.3221088436188455, 0.05), (0.08498357145012052, 0.49272486499423007, 0.1),
            (-0.2524230523, 0.43160468332443697, 0.15)])],
    "marker_line_list_translucent_crossing": [marker(
        LINE_LIST, at=(0, 0, 0.2), size=(0.15, 0, 0), paint=(1, 1, 1, 0.7), id=1,
        points=[(-0.6, -0.4, 0), (0.6, 0.4, 0), (0.6, -0.4, 0), (-0.6, 0.4, 0), (0, 0.6, 0), (0, -0.6, 0)],
        colors=[(1, 0, 0, 0.7), (1, 0.6, 0, 0.7), (0.8, 1, 0, 0.7), (0, 1, 0.5, 0.7), (0, 0.4, 1, 0.7), (0.7, 0, 1, 0.7)])],
    "marker_line_list_triangles_nan_points": [
        marker(LINE_LIST, at=(0, 0, 0.4), size=(0.06, 0, 0), paint=(0.2, 0.6, 1), id=16, points=[
            (0.5, 0, 0), (0.38242109364224425, 0.3221088436188455, 0.05), (0.08498357145012052, 0.49272486499423007, 0.1),
            (-0.2524230523, 0.43160468332443697, 0.15), (-0.47111117033432903, 0.16749407507795255, 0.2), (0, math.nan, 0),
            (-0.2451304106703501, -0.4357878862067939, 0.3), (0.09325618471128744, -0.4912263063121663, 0.35),
            (0.3877829392551248, -0.3156333189361608, 0.4), (0.49992931819170755, 0.008406950242174856, 0.45)]),
        marker(TRIANGLES, size=0.8, paint=(1, 1, 0), id=17, points=DATA["marker_line_list_triangles_nan_points_1_points"]),
        marker(CUBE, size=0.2, paint=(0, 1, 0), id=18)],
    "marker_line_strip_color_and_alpha_per_point": [
        marker(LINE_STRIP, size=(0.1, 0, 0), paint=(1, 1, 1), id=17, points=spiral(14), colors=[
            (0, 0.33333334, 0, 0.3), (0.5, 0.6666667, 0.25, 0.35), (1, 1, 0.5, 0.4), (0, 0, 0.75, 0.45),
            (0.5, 0.33333334, 1, 0.5), (1, 0.6666667, 0, 0.55), (0, 1, 0.25, 0.6), (0.5, 0, 0.5, 0.65),
            (1, 0.33333334, 0.75, 0.7), (0, 0.6666667, 1, 0.75), (0.5, 1, 0, 0.8), (1, 0, 0.25, 0.85), (0, 0.33333334, 0.5, 0.9),
            (0.5, 0.6666667, 0.75, 0.95)]),
        marker(LINE_LIST, at=(0, 0, 0.5), size=(0.05, 0, 0), paint=(1, 1, 1), id=18, points=spiral(14),
               colors=[(0, 0.33333334, 0, 0.3), (0.5, 0.6666667, 0.25, 0.35), (1, 1, 0.5, 0.4), (0, 0, 0.75, 0.45),
                       (0.5, 0.33333334, 1, 0.5), (1, 0.6666667, 0, 0.55), (0, 1, 0.25, 0.6), (0.5, 0, 0.5, 0.65),
                       (1, 0.33333334, 0.75, 0.7), (0, 0.6666667, 1, 0.75), (0.5, 1, 0, 0.8), (1, 0, 0.25, 0.85),
                       (0, 0.33333334, 0.5, 0.9), (0.5, 0.6666667, 0.75, 0.95)])],
    "marker_line_strip_crossing_colors_differ": [marker(
        LINE_STRIP, at=(0, 0, 0.2), size=(0.15, 0, 0), paint=(1, 1, 1, 0.7),
        points=[(-0.6, -0.4, 0), (0.6, 0.4, 0), (0.6, -0.4, 0), (-0.6, 0.4, 0), (0, 0.6, 0), (0, -0.6, 0)],
        colors=[(1, 0, 0, 0.7), (1, 0.6, 0, 0.7), (0.8, 1, 0, 0.7), (0, 1, 0.5, 0.7), (0, 0.4, 1, 0.7), (0.7, 0, 1, 0.7)])],
    "marker_line_strip_folds_back_translucent": [marker(
        LINE_STRIP, size=(0.12, 0, 0), paint=(0.4, 0.8, 1, 0.6), id=1,
        points=[(-0.6 + 0.1 * i, 0.35 - 0.7 * (i % 2), 0.05 * i) for i in range(12)])],
    "marker_line_strip_over_16384_points": [marker(
        LINE_STRIP, size=(0.05, 0, 0), paint=(1, 0.6, 0.2), id=31, points=DATA["marker_line_strip_over_16384_points_0_points"])],
    "marker_line_strip_past_the_camera": [
        marker(LINE_STRIP, size=(0.2, 0, 0), paint=(0.3, 0.9, 0.9), id=29, points=[
            (-2, -1.5, 0), (0, 0, 0.4), (1.5, 1, 1.2), (3, 2.4, 2.4)]),
        marker(LINE_LIST, size=(0.05, 0, 0), paint=(1, 0.4, 0.1), id=30, points=[
            (-1, 0.5, 0), (3, 2, 1.5), (0, -1, 0), (3, 1, 2)])],
    "marker_line_strip_repeated_ends": [marker(LINE_STRIP, size=(0.1, 0, 0), paint=(0.9, 0.5, 0.2), points=[
        (-0.5, -0.3, 0), (-0.5, -0.3, 0), (0.1, 0.1, 0.2), (0.5, -0.2, 0.3), (0.5, -0.2, 0.3)])],
    "marker_line_strip_sharp_corners": [
        marker(LINE_STRIP, size=(0.12, 0, 0), paint=(0.9, 0.2, 0.2), id=19, points=[
            (-0.6, -0.5, 0), (0.5, -0.4, 0.1), (-0.5, -0.2, 0.2), (-0.5, -0.2, 0.2), (0.6, 0.3, 0.2)]),
        marker(LINE_STRIP, size=(0.004, 0, 0), paint=(1, 1, 0), id=20, points=spiral(14)),
        marker(LINE_LIST, at=(0, 0, 0.1), size=(0.02, 0, 0), paint=(0, 1, 0.4), id=21, points=spiral(6))],
    "marker_lines_translucent_wide": [
        marker(LINE_STRIP, size=(0.08, 0, 0), paint=(1, 0.6, 0.1, 0.5), id=15, points=spiral(14)),
        marker(LINE_LIST, at=(0, 0, 0.3), turned=(0.5, 0, 0), size=(0.06, 0, 0), paint=(0.1, 0.6, 1, 0.6), id=16,
               points=spiral(10))],
    "marker_lines_with_scale_y_and_z": [
        marker(LINE_LIST, size=(0.05, 0.5, 2), paint=(1, 0.5, 0.5), id=22, points=spiral(14)),
        marker(LINE_STRIP, at=(0.2, 0, 0.1), turned=(0.4, 0.3, 0.8), size=(0.03, 1, 1), paint=(0.5, 0.5, 1), id=23,
               points=spiral(14))]})
