"""Markers of arrows."""

from ..displays import display
from ..messages import ARROW, CUBE, CYLINDER, SPHERE, header, marker, markers
from ..scene import LARGE, Scene, family


def marker_arrow_changes_form(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m",
                  markers(marker(ARROW, size=(0.05, 0.12, 0), paint=(1, 0.5, 0), id=1, points=[
                              (-0.6, -0.4, 0), (0.2, -0.4, 0.3)]),
                          marker(ARROW, at=(-0.3, 0.2, 0.2), turned=(0, 0, 0.4), size=(0.6, 0.2, 0.1), paint=(0, 1, 0), id=2)),
                  markers(marker(ARROW, at=(0.1, 0.1, 0.2), turned=(0, 0, 0.3), size=(0.6, 0.1, 0.1), paint=(1, 0.5, 0), id=1),
                          marker(ARROW, size=(0.1, 0.2, 0.2), paint=(0, 1, 0), id=2, points=[(-0.2, 0.3, 0.1), (0.5, 0.3, 0.4)])))


def marker_arrow_cube_sphere_cylinder(scene):
    scene.camera(**LARGE)
    scene.show_markers(
        marker(ARROW, at=(-0.6, -0.4, 0.2), turned=(0, 0.3, 0.4), size=(0.7, 0.1, 0.15), paint=(1, 0.2, 0.2), header=header()),
        marker(CUBE, at=(0.3, -0.4, 0.2), turned=(0.2, 0.1, 0.5), size=(0.3, 0.4, 0.2), paint=(0.2, 1, 0.2), header=header(),
               id=1),
        marker(SPHERE, at=(-0.3, 0.4, 0.2), turned=(0, 0, 0.3), size=(0.4, 0.3, 0.5), paint=(0.2, 0.4, 1), header=header(), id=2),
        marker(CYLINDER, at=(0.5, 0.4, 0.3), turned=(0.4, 0, 0), size=(0.3, 0.3, 0.6), paint=(1, 1, 0.2), header=header(), id=3))


def marker_arrow_points(scene):
    scene.camera(**LARGE)
    scene.show_markers(
        marker(ARROW, size=(0.04, 0.08, 0.08), paint=(1, 1, 0), header=header(), points=[(-0.5, -0.3, 0.1), (0.1, 0.2, 0.3)]),
        marker(ARROW, size=(0.04, 0.08, 0), paint=(0, 1, 1), header=header(), id=1, points=[(0.3, -0.3, 0.1), (0.5, 0.4, 0.5)]),
        marker(ARROW, at=(0.1, 0.5, 0.2), turned=(0, 0, 2), size=(0.4, 0.05, 0.05), paint=(1, 0, 1), header=header(), id=2))


family(Scene.show_markers, {
    "marker_arrow_negative_scale": [
        marker(ARROW, at=(-0.3, -0.6, 0.2), size=(-0.5, 0.1, 0.1), paint=(1, 1, 1), id=15),
        marker(ARROW, size=(0.1, 0.2, -0.1), paint=(1, 0, 0), id=16, points=[(0.2, 0.2, 0.2), (0.5, 0.2, 0.6)]),
        marker(ARROW, at=(0.3, -0.6, 0.2), size=(0.5, 0.2, -0.1), paint=(1, 1, 0), id=17)],
    "marker_arrow_odd_scales": [
        marker(ARROW, at=(-0.5, -0.4, 0.1), turned=(0, 0, 0.3), size=(1, 0.1, 0.1), paint=(1, 0, 0), id=7),
        marker(ARROW, at=(-0.4, 0.1, 0.1), turned=(0, -0.5, -0.6), size=(0.7, 0.25, 0.05), paint=(0, 1, 0), id=8),
        marker(ARROW, at=(0.1, 0.3, 0.1), turned=(0.7, -1, 0.2), size=(0.3, 0.3, 0.6), paint=(0.2, 0.4, 1), id=9),
        marker(ARROW, at=(0.3, -0.5, 0.1), turned=(0, -1.57, 0), size=(0.6, 0.06, 0.12), paint=(1, 1, 0, 0.5), id=10)],
    "marker_arrow_points_head_longer_than_arrow": [
        marker(ARROW, size=(0.05, 0.12, 0), paint=(1, 0.5, 0), id=11, points=[(-0.6, -0.4, 0), (0.2, -0.4, 0.3)]),
        marker(ARROW, size=(0.05, 0.2, 2), paint=(0, 0.8, 0.8), id=12, points=[(-0.4, 0, 0), (0.1, 0.1, 0.5)]),
        marker(ARROW, at=(0.2, 0.1, 0.2), turned=(0, 0, 1), size=(0.1, 0.15, 0.2), paint=(0.7, 0.2, 1, 0.6), id=13,
               points=[(0, 0, 0), (0.5, 0, 0)]),
        marker(ARROW, size=(0.02, 0.05, 0.1), paint=(1, 1, 1), id=14, points=[(0, 0.6, 0.5), (0, 0.6, -0.1)])],
    "marker_arrow_translucent_over_cubes": [
        marker(CUBE, size=(0.6, 0.6, 0.1), paint=(1, 1, 1), id=2),
        marker(ARROW, at=(-0.3, -0.3, 0.2), turned=(0, 0.4, 0.8), size=(0.8, 0.15, 0.2), paint=(1, 0.1, 0.1, 0.6), id=3),
        marker(ARROW, size=(0.1, 0.25, 0.2), paint=(0.1, 0.3, 1, 0.6), id=4, points=[(0.4, -0.5, 0.1), (-0.1, 0.4, 0.5)])],
    "marker_arrow_zero_length_up_and_minus_x": [
        marker(ARROW, size=(0.1, 0.2, 0.1), paint=(1, 0, 0), id=9, points=[(0.2, 0.2, 0.2), (0.2, 0.2, 0.2)]),
        marker(ARROW, size=(0.05, 0.1, 0.1), paint=(0, 1, 0), id=10, points=[(-0.2, 0.2, 0), (-0.2, 0.2, 0.6)]),
        marker(ARROW, size=(0.05, 0.1, 0.1), paint=(0, 0.4, 1), id=11, points=[(0.4, -0.3, 0.2), (-0.4, -0.3, 0.2)]),
        marker(ARROW, size=(0.05, 0.1, 0.1), paint=(1, 1, 0), id=12, points=[(-0.5, -0.5, 0.3), (-0.5, -0.5, -0.3)])]})
