"""Markers that are translucent, and the order in which they are drawn."""

import math

from visualization_msgs.msg import Marker

from ..clouds import fan
from ..displays import display
from ..geometry import colors, points
from ..messages import marker, markers


def marker_sorting_translucent_along_the_view(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(0.5, 0.4, 0.5), turned=(0, 0, 0.6), size=(0.3, 0.3, 0.3), paint=(1, 0, 0, 0.5), id=76),
        marker(Marker.SPHERE, at=(-0.5, -0.4, 0.02), turned=(0, 0, 0.6), size=(0.3, 0.3, 0.3), paint=(0, 1, 0, 0.5), id=77),
        marker(Marker.CUBE, at=(0.25, 0.2, 0.38), turned=(0, 0, 0.6), size=(0.3, 0.3, 0.3), paint=(0, 0, 1, 0.5), id=78),
        marker(Marker.SPHERE, at=(-0.25, -0.2, 0.14), turned=(0, 0, 0.6), size=(0.3, 0.3, 0.3), paint=(1, 1, 0, 0.5), id=79),
        marker(Marker.CUBE, at=(0, 0, 0.26), turned=(0, 0, 0.6), size=(0.3, 0.3, 0.3), paint=(0, 1, 1, 0.5), id=80)))


def marker_sorting_translucent_kinds(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(0, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(0.5, 0.5, 0.3), paint=(1, 0, 0, 0.5), id=81),
        marker(Marker.SPHERE_LIST, size=(0.3, 0.3, 0.3), paint=(0, 0.8, 0, 0.6), id=82, points=points([
            (0.10201343894004822, -0.07649841159582138, 0.5620033741),
            (-0.035613980144262314, 0.015484984964132309, 0.22356292605400085),
            (-0.4412810206413269, -0.2871411442756653, 0.0910501480102539),
            (-0.08555378764867783, -0.30935078859329224, -0.05313597619533539),
            (-0.044158484786748886, 0.07426488399505615, -0.2048734873533249),
            (-0.10405879467725754, 0.17111675441265106, 0.2760317325592041)])),
        marker(Marker.LINE_STRIP, size=(0.1, 0, 0), paint=(0, 0.5, 1, 0.6), id=83, points=points([(
            0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(14)])),
        marker(Marker.TRIANGLE_LIST, at=(0, 0, 0.1), size=(0.8, 0.8, 0.8), paint=(1, 1, 0, 0.5), id=84,
               points=points(fan(6, 0.6, 0.5, wave=0.3, step=1.0472))),
        marker(Marker.TEXT_VIEW_FACING, at=(0.2, 0.2, 0.5), size=(0, 0, 0.25), paint=(1, 1, 1, 0.7), id=85, text="MIX"),
        marker(Marker.POINTS, size=(0.1, 0.1, 0), paint=(1, 0, 1, 0.5), id=86, points=points([
            (-0.31145262718200684, 0.13290244340896606, -0.20210231840610504),
            (-0.386665940284729, -0.3934466242790222, -0.19066210091114044),
            (0.27303701639175415, 0.19521236419677734, 0.01620626449584961),
            (-0.177785262465477, 0.0016093869926407933, -0.05183679610490799),
            (0.4232485890388489, -0.3370666205883026, -0.003306191647425294),
            (-0.0836169645190239, -0.04327646270394325, 0.2061869502067566),
            (0.05567915365099907, 0.37601539492607117, -0.024472113698720932),
            (0.5047212839126587, -0.09885836392641068, -0.15441320836544037)]))))


def marker_sorting_translucent_kinds_other_frame(scene):
    scene.frame("sensor", at=(0.3, -0.4, 0.2), turned=(0.2, 0.3, 1.1))
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(0, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(0.5, 0.5, 0.3), paint=(1, 0, 0, 0.5), frame="sensor",
               id=4),
        marker(Marker.SPHERE_LIST, at=(0.1, 0.1, 0), turned=(0.4, 0.3, 0.8), size=(0.3, 0.3, 0.3), paint=(0, 0.8, 0, 0.6),
               frame="sensor", id=5,
               points=points([(0.10201343894004822, -0.07649841159582138, 0.5620033741),
                              (-0.035613980144262314, 0.015484984964132309, 0.22356292605400085),
                              (-0.4412810206413269, -0.2871411442756653, 0.0910501480102539),
                              (-0.08555378764867783, -0.30935078859329224, -0.05313597619533539),
                              (-0.044158484786748886, 0.07426488399505615, -0.2048734873533249),
                              (-0.10405879467725754, 0.17111675441265106, 0.2760317325592041)])),
        marker(Marker.LINE_STRIP, at=(0.2, 0.1, 0.1), size=(0.1, 0, 0), paint=(0, 0.5, 1, 0.6), frame="sensor", id=6,
               points=points([(0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(14)])),
        marker(Marker.TRIANGLE_LIST, at=(0, 0, 0.1), size=(0.8, 0.8, 0.8), paint=(1, 1, 0, 0.5), frame="sensor", id=7,
               points=points(fan(6, 0.6, 0.5, wave=0.3, step=1.0472))),
        marker(Marker.POINTS, size=(0.1, 0.1, 0), paint=(1, 0, 1, 0.5), id=8, points=points([
            (-0.31145262718200684, 0.13290244340896606, -0.20210231840610504),
            (-0.386665940284729, -0.3934466242790222, -0.19066210091114044),
            (0.27303701639175415, 0.19521236419677734, 0.01620626449584961),
            (-0.177785262465477, 0.0016093869926407933, -0.05183679610490799),
            (0.4232485890388489, -0.3370666205883026, -0.003306191647425294),
            (-0.0836169645190239, -0.04327646270394325, 0.2061869502067566),
            (0.05567915365099907, 0.37601539492607117, -0.024472113698720932),
            (0.5047212839126587, -0.09885836392641068, -0.15441320836544037)])),
        marker(Marker.CUBE_LIST, at=(0, 0.1, 0.3), size=(0.1, 0.2, 0.1), paint=(1, 0, 1, 0.5), id=9,
               points=points([(0.08726540952920914, 0.30790194869041443, 0.23355430364608765),
                              (0.2649879455566406, 0.23368476331233978, 0.10141211748123169),
                              (-0.11921411007642746, -0.03566266968846321, 0.5009777545928955),
                              (0.02785974182188511, -0.16504912078380585, -0.08682825416326523),
                              (-0.1877734214067459, 0.374629408121109, -0.03484344109892845),
                              (0.3382982313632965, 0.09828438609838486, 0.01868138648569584)]),
               colors=colors([(1, 1, 1, 0.72), (0, 0, 0, 0.75), (0.5, 0.33333334, 0.25, 0.78), (1, 0.6666667, 0.5, 0.81),
                              (0, 1, 0.75, 0.84), (0.5, 0, 1, 0.87)]))))


def marker_translucent_cubes_and_spheres(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(0.35, 0, 0), size=(0.5, 0.35, 0.4), paint=(0, 0.5, 0, 0.5)),
        marker(Marker.SPHERE, at=(0.1891058070538489, 0.29451484468276373, 0.1), turned=(0.3, 0.2, 1), size=(0.5, 0.35, 0.4),
               paint=(0.5, 1, 1, 0.5), id=1),
        marker(Marker.CYLINDER, at=(-0.14565139279149983, 0.3182540993889886, 0.2), turned=(0.6, 0.4, 2), size=(0.5, 0.35, 0.4),
               paint=(1, 0, 0.5, 0.5), id=2),
        marker(Marker.CUBE, at=(-0.3464973738101559, 0.049392002820953525, 0.3), turned=(0.9, 0.6, 3), size=(0.5, 0.35, 0.4),
               paint=(0, 0.5, 0, 0.5), id=3),
        marker(Marker.SPHERE, at=(-0.22877526730226416, -0.2648808733577748, 0.4), turned=(1.2, 0.8, 4), size=(0.5, 0.35, 0.4),
               paint=(0.5, 1, 1, 0.5), id=4),
        marker(Marker.CYLINDER, at=(0.09928176491212919, -0.33562349613209846, 0.5), turned=(1.5, 1, 5), size=(0.5, 0.35, 0.4),
               paint=(1, 0, 0.5, 0.5), id=5)))


def marker_translucent_parts_of_one_arrow_overlap(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.ARROW, at=(-0.5, 0, 0.2), turned=(0, -0.2, 0.5), size=(1, 0.3, 0.3), paint=(1, 0.5, 0.2, 0.5), id=39),
        marker(Marker.CYLINDER, at=(0.2, 0.3, 0.2), turned=(0.3, 0, 0), size=(0.4, 0.4, 0.5), paint=(0.2, 0.6, 1, 0.5), id=40),
        marker(Marker.ARROW, size=(0.2, 0.4, 0.3), paint=(0.3, 1, 0.3, 0.6), id=41, points=points([
            (0.4, -0.6, 0), (-0.2, -0.2, 0.6)]))))
