"""Markers of arrows."""

from visualization_msgs.msg import Marker

from ..displays import display
from ..geometry import points
from ..messages import header, marker, markers


def marker_arrow_changes_form(scene):
    scene.show(display("MarkerArray"))
    scene.publish(
        "/m",
        markers(marker(Marker.ARROW, size=(0.05, 0.12, 0), paint=(1, 0.5, 0, 1), id=1, points=points([
                    (-0.6, -0.4, 0), (0.2, -0.4, 0.3)])),
                marker(Marker.ARROW, at=(-0.3, 0.2, 0.2), turned=(0, 0, 0.4), size=(0.6, 0.2, 0.1), paint=(0, 1, 0, 1), id=2)),
        markers(marker(Marker.ARROW, at=(0.1, 0.1, 0.2), turned=(0, 0, 0.3), size=(0.6, 0.1, 0.1), paint=(1, 0.5, 0, 1), id=1),
                marker(Marker.ARROW, size=(0.1, 0.2, 0.2), paint=(0, 1, 0, 1), id=2, points=points([
                    (-0.2, 0.3, 0.1), (0.5, 0.3, 0.4)]))))


def marker_arrow_cube_sphere_cylinder(scene):
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.ARROW, at=(-0.6, -0.4, 0.2), turned=(0, 0.3, 0.4), size=(0.7, 0.1, 0.15), paint=(1, 0.2, 0.2, 1),
               header=header()),
        marker(Marker.CUBE, at=(0.3, -0.4, 0.2), turned=(0.2, 0.1, 0.5), size=(0.3, 0.4, 0.2), paint=(0.2, 1, 0.2, 1),
               header=header(), id=1),
        marker(Marker.SPHERE, at=(-0.3, 0.4, 0.2), turned=(0, 0, 0.3), size=(0.4, 0.3, 0.5), paint=(0.2, 0.4, 1, 1),
               header=header(), id=2),
        marker(Marker.CYLINDER, at=(0.5, 0.4, 0.3), turned=(0.4, 0, 0), size=(0.3, 0.3, 0.6), paint=(1, 1, 0.2, 1),
               header=header(), id=3)))


def marker_arrow_negative_scale(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.ARROW, at=(-0.3, -0.6, 0.2), size=(-0.5, 0.1, 0.1), paint=(1, 1, 1, 1), id=15),
        marker(Marker.ARROW, size=(0.1, 0.2, -0.1), paint=(1, 0, 0, 1), id=16, points=points([(0.2, 0.2, 0.2), (0.5, 0.2, 0.6)])),
        marker(Marker.ARROW, at=(0.3, -0.6, 0.2), size=(0.5, 0.2, -0.1), paint=(1, 1, 0, 1), id=17)))


def marker_arrow_odd_scales(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.ARROW, at=(-0.5, -0.4, 0.1), turned=(0, 0, 0.3), size=(1, 0.1, 0.1), paint=(1, 0, 0, 1), id=7),
        marker(Marker.ARROW, at=(-0.4, 0.1, 0.1), turned=(0, -0.5, -0.6), size=(0.7, 0.25, 0.05), paint=(0, 1, 0, 1), id=8),
        marker(Marker.ARROW, at=(0.1, 0.3, 0.1), turned=(0.7, -1, 0.2), size=(0.3, 0.3, 0.6), paint=(0.2, 0.4, 1, 1), id=9),
        marker(Marker.ARROW, at=(0.3, -0.5, 0.1), turned=(0, -1.57, 0), size=(0.6, 0.06, 0.12), paint=(1, 1, 0, 0.5), id=10)))


def marker_arrow_points(scene):
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.ARROW, size=(0.04, 0.08, 0.08), paint=(1, 1, 0, 1), header=header(), points=points([
            (-0.5, -0.3, 0.1), (0.1, 0.2, 0.3)])),
        marker(Marker.ARROW, size=(0.04, 0.08, 0), paint=(0, 1, 1, 1), header=header(), id=1, points=points([
            (0.3, -0.3, 0.1), (0.5, 0.4, 0.5)])),
        marker(Marker.ARROW, at=(0.1, 0.5, 0.2), turned=(0, 0, 2), size=(0.4, 0.05, 0.05), paint=(1, 0, 1, 1), header=header(),
               id=2)))


def marker_arrow_points_head_longer_than_arrow(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.ARROW, size=(0.05, 0.12, 0), paint=(1, 0.5, 0, 1), id=11, points=points([
            (-0.6, -0.4, 0), (0.2, -0.4, 0.3)])),
        marker(Marker.ARROW, size=(0.05, 0.2, 2), paint=(0, 0.8, 0.8, 1), id=12, points=points([(-0.4, 0, 0), (0.1, 0.1, 0.5)])),
        marker(Marker.ARROW, at=(0.2, 0.1, 0.2), turned=(0, 0, 1), size=(0.1, 0.15, 0.2), paint=(0.7, 0.2, 1, 0.6), id=13,
               points=points([(0, 0, 0), (0.5, 0, 0)])),
        marker(Marker.ARROW, size=(0.02, 0.05, 0.1), paint=(1, 1, 1, 1), id=14, points=points([(0, 0.6, 0.5), (0, 0.6, -0.1)]))))


def marker_arrow_translucent_over_cubes(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, size=(0.6, 0.6, 0.1), paint=(1, 1, 1, 1), id=2),
        marker(Marker.ARROW, at=(-0.3, -0.3, 0.2), turned=(0, 0.4, 0.8), size=(0.8, 0.15, 0.2), paint=(1, 0.1, 0.1, 0.6), id=3),
        marker(Marker.ARROW, size=(0.1, 0.25, 0.2), paint=(0.1, 0.3, 1, 0.6), id=4, points=points([
            (0.4, -0.5, 0.1), (-0.1, 0.4, 0.5)]))))


def marker_arrow_zero_length_up_and_minus_x(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.ARROW, size=(0.1, 0.2, 0.1), paint=(1, 0, 0, 1), id=9, points=points([(0.2, 0.2, 0.2), (0.2, 0.2, 0.2)])),
        marker(Marker.ARROW, size=(0.05, 0.1, 0.1), paint=(0, 1, 0, 1), id=10, points=points([(-0.2, 0.2, 0), (-0.2, 0.2, 0.6)])),
        marker(Marker.ARROW, size=(0.05, 0.1, 0.1), paint=(0, 0.4, 1, 1), id=11, points=points([
            (0.4, -0.3, 0.2), (-0.4, -0.3, 0.2)])),
        marker(Marker.ARROW, size=(0.05, 0.1, 0.1), paint=(1, 1, 0, 1), id=12, points=points([
            (-0.5, -0.5, 0.3), (-0.5, -0.5, -0.3)]))))
