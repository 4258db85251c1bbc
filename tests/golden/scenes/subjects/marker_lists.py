"""Markers of cube, sphere and point lists."""

import math

import numpy

from ..clouds import SCATTERED, ball, fan, random_rows, spiral
from ..data import load
from ..messages import CUBE, CUBE_LIST, LINE_LIST, LINE_STRIP, POINTS, SPHERE_LIST, TRIANGLES, header, marker
from ..scene import LARGE, Scene, family

DATA = load("marker_lists")


def marker_lists(scene):
    scene.camera(**LARGE)
    scene.show_markers(
        marker(CUBE_LIST, size=(0.06, 0.08, 0.1), paint=(1, 0.5, 0), header=header(),
               points=[(0.5 * math.cos(6 * i / 29), 0.5 * math.sin(6 * i / 29), 0.1 + 0.3 * i / 29) for i in range(30)],
               colors=random_rows(30, 2)),
        marker(SPHERE_LIST, at=(0, 0, 0.4), size=0.08, paint=(1, 0.5, 0), header=header(), id=1,
               points=[(0.5 * math.cos(6 * i / 29), 0.5 * math.sin(6 * i / 29), 0.1 + 0.3 * i / 29) for i in range(30)],
               colors=random_rows(30, 2)),
        marker(POINTS, at=(0.3, -0.3, 0.1), size=(0.04, 0.02, 0), paint=(1, 0.5, 0), header=header(), id=2,
               points=[(0.5 * math.cos(6 * i / 29), 0.5 * math.sin(6 * i / 29), 0.1 + 0.3 * i / 29) for i in range(30)],
               colors=random_rows(30, 2)))


family(Scene.show_markers, {
    "marker_cube_list_color_per_cube": [marker(
        CUBE_LIST, at=(0, 0, 0.2), turned=(0.4, 0.3, 0.8), size=0.15, paint=(1, 1, 1), id=25,
        points=numpy.float32(ball(20, 0.6, seed=5)), colors=DATA["marker_cube_list_color_per_cube_0_colors"])],
    "marker_cube_list_larger_than_one_buffer": [marker(
        CUBE_LIST, at=(0, 0, 0.2), turned=(0, 0, 0.3), size=0.012, paint=(0.9, 0.6, 0.2, 0.5), id=32,
        points=[(-0.33 + 0.03 * (i % 22), -0.33 + 0.03 * (i // 22 % 22), -0.2 + 0.03 * (i // 484)) for i in range(11000)])],
    "marker_cube_list_larger_than_one_buffer_colors": [marker(
        CUBE_LIST, at=(0, 0, 0.2), turned=(0, 0, 0.3), size=0.025, paint=(1, 1, 1), id=33,
        points=[(-0.33 + 0.03 * (i % 22), -0.33 + 0.03 * (i // 22 % 22), -0.2 + 0.03 * (i // 484)) for i in range(11000)][::-1],
        colors=[(0.1 + 0.04 * (i // 484), 0.9 - 0.03 * (i // 484), 0.2, 0.3) for i in range(11000)])],
    "marker_cube_list_translucent_posed": [marker(
        CUBE_LIST, at=(0, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(0.2, 0.1, 0.3), paint=(0.3, 0.8, 0.4, 0.5), id=24,
        points=numpy.float32(ball(20, 0.6, seed=5)))],
    "marker_lists_alpha_of_marker_and_of_colors": [
        marker(LINE_LIST, at=(0, 0, 0.3), size=(0.06, 0, 0), paint=(1, 1, 1, 0.5), id=19, points=spiral(14),
               colors=[(1, 0.5, 0.2) for i in range(14)]),
        marker(CUBE_LIST, at=(0, 0, 0.1), size=0.1, paint=(1, 1, 1, 0.3), id=20, points=SCATTERED, colors=[(1, 0.5, 0.2)
                                                                                                           for i in range(8)]),
        marker(TRIANGLES, size=0.8, paint=(1, 1, 1, 0.5), id=21, points=fan(6, 0.6, 0.5, wave=0.3, step=1.0472),
               colors=[(0.2, 0.5, 1) for i in range(18)])],
    "marker_lists_negative_scale": [
        marker(POINTS, at=(0, 0, 0.2), size=(-0.2, 0.1, 0), paint=(0.3, 0.7, 1), id=11, points=SCATTERED),
        marker(SPHERE_LIST, at=(0, 0.2, 0.3), size=(-0.2, 0.2, 0.2), paint=(0.7, 1, 0.3), id=12, points=[
            (0.27303701639175415, 0.19521236419677734, 0.01620626449584961),
            (-0.177785262465477, 0.0016093869926407933, -0.05183679610490799),
            (0.4232485890388489, -0.3370666205883026, -0.003306191647425294),
            (-0.0836169645190239, -0.04327646270394325, 0.2061869502067566)]),
        marker(SPHERE_LIST, at=(0, 0.2, 0.1), size=(-0.2, -0.2, 0.2), paint=(0.7, 1, 1), id=13, points=[
            (-0.10405879467725754, 0.17111675441265106, 0.2760317325592041),
            (-0.31145262718200684, 0.13290244340896606, -0.20210231840610504),
            (-0.386665940284729, -0.3934466242790222, -0.19066210091114044),
            (0.27303701639175415, 0.19521236419677734, 0.01620626449584961)]),
        marker(CUBE_LIST, at=(0, 0.2, 0.3), size=(-0.1, 0.1, 0.1), paint=(1, 0.2, 0.6), id=14, points=[
            (0.05567915365099907, 0.37601539492607117, -0.024472113698720932),
            (0.5047212839126587, -0.09885836392641068, -0.15441320836544037),
            (0.08726540952920914, 0.30790194869041443, 0.23355430364608765),
            (0.2649879455566406, 0.23368476331233978, 0.10141211748123169),
            (-0.11921411007642746, -0.03566266968846321, 0.5009777545928955),
            (0.02785974182188511, -0.16504912078380585, -0.08682825416326523),
            (-0.1877734214067459, 0.374629408121109, -0.03484344109892845),
            (0.3382982313632965, 0.09828438609838486, 0.01868138648569584)])],
    "marker_lists_translucent_over_opaque_cube": [
        marker(CUBE, at=(0, 0, 0.1), size=(1, 1, 0.1), paint=(0.2, 0.3, 0.9), id=3),
        marker(CUBE_LIST, at=(0, 0, 0.4), size=0.15, paint=(1, 0.8, 0.2, 0.35), id=4, points=SCATTERED),
        marker(SPHERE_LIST, at=(0.1, 0.1, 0.4), size=0.2, paint=(1, 1, 1), id=5,
               points=[(0.27303701639175415, 0.19521236419677734, 0.01620626449584961),
                       (-0.177785262465477, 0.0016093869926407933, -0.05183679610490799),
                       (0.4232485890388489, -0.3370666205883026, -0.003306191647425294),
                       (-0.0836169645190239, -0.04327646270394325, 0.2061869502067566),
                       (0.05567915365099907, 0.37601539492607117, -0.024472113698720932),
                       (0.5047212839126587, -0.09885836392641068, -0.15441320836544037)],
               colors=[(1, 0.33333334, 0.75, 0.54), (0, 0.6666667, 1, 0.57), (0.5, 1, 0, 0.6), (1, 0, 0.25, 0.63),
                       (0, 0.33333334, 0.5, 0.66), (0.5, 0.6666667, 0.75, 0.69)]),
        marker(POINTS, at=(0, -0.1, 0.4), size=(0.12, 0.12, 0), paint=(0.2, 0.9, 0.3, 0.6), id=6, points=[
            (0.08726540952920914, 0.30790194869041443, 0.23355430364608765),
            (0.2649879455566406, 0.23368476331233978, 0.10141211748123169),
            (-0.11921411007642746, -0.03566266968846321, 0.5009777545928955),
            (0.02785974182188511, -0.16504912078380585, -0.08682825416326523),
            (-0.1877734214067459, 0.374629408121109, -0.03484344109892845),
            (0.3382982313632965, 0.09828438609838486, 0.01868138648569584)])],
    "marker_points_dark_lighter_edge": [marker(
        POINTS, at=(0, 0, 0.2), size=(0.2, 0.2, 0), paint=(0.1, 0.05, 0.2), id=7, points=numpy.float32(ball(20, 0.6, seed=5)))],
    "marker_points_line_strip_nan_points": [
        marker(POINTS, at=(0, 0, 0.2), size=(0.2, 0.2, 0), paint=(1, 0.6, 0.2), id=13, points=[
            (0.10201343894004822, -0.07649841159582138, 0.5620033741),
            (-0.035613980144262314, 0.015484984964132309, 0.22356292605400085),
            (-0.4412810206413269, -0.2871411442756653, 0.0910501480102539),
            (-0.08555378764867783, -0.30935078859329224, -0.05313597619533539), (math.nan, 0, 0),
            (-0.044158484786748886, 0.07426488399505615, -0.2048734873533249),
            (-0.10405879467725754, 0.17111675441265106, 0.2760317325592041),
            (-0.31145262718200684, 0.13290244340896606, -0.20210231840610504),
            (-0.386665940284729, -0.3934466242790222, -0.19066210091114044)]),
        marker(LINE_STRIP, at=(0, 0, 0.4), size=(0.06, 0, 0), paint=(0.2, 0.6, 1), id=14, points=[
            (0.5, 0, 0), (0.38242109364224425, 0.3221088436188455, 0.05), (0.08498357145012052, 0.49272486499423007, 0.1),
            (-0.2524230523, 0.43160468332443697, 0.15), (-0.47111117033432903, 0.16749407507795255, 0.2), (0, math.nan, 0),
            (-0.46822834364539817, -0.17539161384480992, 0.25), (-0.2451304106703501, -0.4357878862067939, 0.3),
            (0.09325618471128744, -0.4912263063121663, 0.35), (0.3877829392551248, -0.3156333189361608, 0.4),
            (0.49992931819170755, 0.008406950242174856, 0.45)]),
        marker(CUBE, size=0.2, paint=(0, 1, 0), id=15)],
    "marker_points_translucent_alpha_counts_twice": [
        marker(POINTS, at=(0, 0, 0.2), size=(0.2, 0.2, 0), paint=(1, 0.7, 0.3, 0.5), id=29,
               points=numpy.float32(ball(20, 0.6, seed=5))),
        marker(SPHERE_LIST, at=(0.3, 0.3, 0.2), size=0.3, paint=(0.2, 0.7, 1, 0.5), id=30, points=SCATTERED[:5])],
    "marker_points_unequal_scale": [marker(
        POINTS, at=(0, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(0.2, 0.06, 0), paint=(0.3, 0.7, 1), id=28,
        points=numpy.float32(ball(20, 0.6, seed=5)))],
    "marker_sphere_list_alpha_per_sphere": [marker(
        SPHERE_LIST, at=(0, 0, 0.2), size=0.25, paint=(1, 1, 1), id=26, points=numpy.float32(ball(20, 0.6, seed=5)),
        colors=DATA["marker_sphere_list_alpha_per_sphere_0_colors"])],
    "marker_sphere_list_unequal_scale": [marker(
        SPHERE_LIST, at=(0, 0, 0.2), size=(0.3, 0.12, 0.2), paint=(0.9, 0.5, 0.2), id=27,
        points=numpy.float32(ball(20, 0.6, seed=5)))]})
