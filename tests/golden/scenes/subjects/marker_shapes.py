"""Markers of one shape: cubes, spheres, cylinders; odd scales, colours and poses."""

import math

from ..clouds import SCATTERED, fan, spiral
from ..displays import camera_pub, display
from ..geometry import quaternion
from ..messages import ARROW, CUBE, CUBE_LIST, CYLINDER, LINE_STRIP, MESH, POINTS, SPHERE, TEXT, TRIANGLES, marker, markers
from ..scene import Scene, family


def marker_shapes_close_up_shading(scene):
    scene.camera(eye=(0.9, 0.7, 0.8))
    scene.show_markers(
        marker(CUBE, at=(-0.3, -0.1, 0.2), turned=(0.4, 0.3, 0.8), size=0.4, paint=(1, 1, 1)),
        marker(SPHERE, at=(0.25, -0.25, 0.2), turned=(0.4, 0.3, 0.8), size=0.5, paint=(0.9, 0.3, 0.2), id=1),
        marker(CYLINDER, at=(0.1, 0.4, 0.2), turned=(0.4, 0.3, 0.8), size=(0.35, 0.35, 0.5), paint=(0.3, 0.8, 0.3), id=2))


def marker_shapes_cut_by_near_plane(scene):
    scene.show(display("MarkerArray"), camera_pub({"Near Clip Distance": 0.7}))
    scene.publish("/m", markers(
        marker(SPHERE, at=(1.1, 0.75, 1.05), size=0.5, paint=(0.9, 0.4, 0.3), id=31),
        marker(CUBE, at=(0.6, 0.8, 0.8), turned=(0.4, 0.3, 0.8), size=(0.8, 0.4, 0.4), paint=(0.3, 0.9, 0.4), id=32),
        marker(MESH, at=(1, 0.2, 0.8), turned=(0.4, 0.3, 0.8), size=1, id=33, mesh="crate.obj",
               mesh_use_embedded_materials=True)))


family(Scene.show_markers, {
    "marker_alpha_just_below_1": [
        marker(CUBE, at=(-0.5, 0, 0.2), turned=(0, 0, 0.5), size=(0.4, 0.3, 0.3), paint=(0.2, 1, 0.4, 0.9999), id=87),
        marker(CUBE, at=(-0.15, 0.1, 0.23), turned=(0, 0, 0.6), size=(0.4, 0.3, 0.3), paint=(0.4, 0.8, 0.4, 0.999), id=88),
        marker(CUBE, at=(0.2, 0.2, 0.26), turned=(0, 0, 0.7), size=(0.4, 0.3, 0.3), paint=(0.6, 0.6, 0.4, 0.5), id=89),
        marker(CUBE, at=(0.55, 0.3, 0.29), turned=(0, 0, 0.8), size=(0.4, 0.3, 0.3), paint=(0.8, 0.4, 0.4, 0), id=90)],
    "marker_camera_inside_sphere_and_cylinder": [
        marker(SPHERE, at=(0.8, 0.6, 0.8), size=3, paint=(1, 0, 0), id=96),
        marker(CUBE, at=(0, 0, 0.2), size=0.4, paint=(0, 1, 0), id=97)],
    "marker_color_count_unlike_point_count": [
        marker(LINE_STRIP, size=(0.05, 0, 0), paint=(1, 0.6, 0.2), id=36, points=spiral(6), colors=[
            (0, 0.33333334, 0, 0.3), (0.5, 0.6666667, 0.25, 0.35), (1, 1, 0.5, 0.4)]),
        marker(SPHERE, at=(0.3, 0.3, 0), size=0.2, paint=(1, 1, 1), id=37),
        marker(CUBE_LIST, at=(0, 0, 0.4), size=0.1, paint=(0.2, 0.6, 1), id=38, points=SCATTERED[:6], colors=[
            (0, 0.33333334, 0), (0.5, 0.6666667, 0.25), (1, 1, 0.5), (0, 0, 0.75)]),
        marker(TRIANGLES, at=(0, 0, -0.2), size=0.6, paint=(0.6, 1, 0.2), id=39, points=fan(6, 0.6, 0.5, wave=0.3, step=1.0472),
               colors=[(0, 0.33333334, 0, 0.3), (0.5, 0.6666667, 0.25, 0.35)])],
    "marker_colors_outside_0_to_1": [
        marker(CUBE, at=(-0.4, 0, 0.2), turned=(0.4, 0.3, 0.8), size=0.3, paint=(1.5, -0.5, 0.5, 1.5), id=25),
        marker(LINE_STRIP, at=(0, 0, 0.3), size=(0.06, 0, 0), paint=(1.2, -0.2, 0.5), id=26, points=spiral(14)),
        marker(POINTS, at=(0, 0, 0.1), size=(0.1, 0.1, 0), paint=(1.2, -0.2, 0.5, 1.3), id=27, points=SCATTERED),
        marker(TEXT, at=(0, 0, 0.6), size=(0, 0, 0.2), paint=(1.2, 0.2, -0.2), id=28, text="Loud"),
        marker(TRIANGLES, at=(0.3, 0.3, 0), size=0.5, paint=(1, 1, 1), id=29, points=fan(6, 0.6, 0.5, wave=0.3, step=1.0472),
               colors=[(1.2, -0.2, 0.5) for i in range(6)]),
        marker(CUBE, at=(0.5, -0.3, 0.2), turned=(0.4, 0.3, 0.8), size=0.3, paint=(0.5, 0.5, 1, -0.5), id=30)],
    "marker_cube_many_small": [*(marker(
        CUBE, at=(-0.4 + 0.2 * (i % 5), -0.4 + 0.2 * (i // 5), 0.05 * (i % 3)), turned=(0, 0, 0.2 * i), size=(0.1, 0.12, 0.15),
        paint=(0.25 * (i % 5), 0.25 * (i // 5), 0.5), id=12 + i) for i in range(25))],
    "marker_cylinder_flat_and_long": [
        marker(CYLINDER, at=(0, 0, 0.1), turned=(0.4, 0.3, 0.8), size=(0.7, 0.5, 0.01), paint=(0.9, 0.7, 0.3), id=9),
        marker(CYLINDER, at=(0.3, -0.4, 0.3), turned=(1.2, 0.3, 0), size=(0.03, 0.03, 1.2), paint=(0.3, 0.8, 0.9), id=10),
        marker(SPHERE, at=(-0.3, 0.5, 0.3), turned=(0.4, 0.3, 0.8), size=(0.6, 0.6, 0.02), paint=(0.8, 0.3, 0.8), id=11)],
    "marker_negative_scale_mirrors": [
        marker(CUBE, at=(0, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(-0.4, 0.3, 0.3), paint=(0, 1, 0), id=98),
        marker(SPHERE, at=(0.5, -0.3, 0.2), turned=(0.4, 0.3, 0.8), size=-0.4, paint=(1, 1, 0), id=99),
        marker(CYLINDER, at=(-0.4, 0.4, 0.3), turned=(0.4, 0.3, 0.8), size=(0.3, 0.3, -0.5), paint=(1, 0.3, 1), id=100)],
    "marker_quaternion_not_unit_length": [
        marker(CUBE, at=(-0.4, 0, 0.2), turned=quaternion(0.5, 0.3, 0.2, 2), size=(0.4, 0.3, 0.2), paint=(1, 0.5, 0.5), id=10),
        marker(CUBE, at=(0.4, -0.3, 0.2), turned=quaternion(0, 0, 0, 0), size=(0.4, 0.3, 0.2), paint=(0.5, 1, 0.5), id=11),
        marker(ARROW, at=(0.2, 0.4, 0.2), turned=quaternion(0.1, -0.2, 0.1, 0.3), size=(0.6, 0.1, 0.1), paint=(0.5, 0.5, 1),
               id=12)],
    "marker_small_and_far": [
        marker(CUBE, at=(-8, -6, 0.2), turned=(0.4, 0.3, 0.8), size=0.2, paint=(1, 0.6, 0.2), id=22),
        marker(CUBE, at=(-7, -5.2, 0.2), turned=(0.4, 0.3, 0.8), size=0.2, paint=(1, 0.6, 0.2), id=23),
        marker(CUBE, at=(-6, -4.4, 0.2), turned=(0.4, 0.3, 0.8), size=0.2, paint=(1, 0.6, 0.2), id=24),
        marker(CUBE, at=(-5, -3.6, 0.2), turned=(0.4, 0.3, 0.8), size=0.2, paint=(1, 0.6, 0.2), id=25),
        marker(CUBE, at=(-4, -2.8, 0.2), turned=(0.4, 0.3, 0.8), size=0.2, paint=(1, 0.6, 0.2), id=26),
        marker(CUBE, at=(-3, -2, 0.2), turned=(0.4, 0.3, 0.8), size=0.2, paint=(1, 0.6, 0.2), id=27),
        marker(SPHERE, at=(-20, -14, 0.5), turned=(0.4, 0.3, 0.8), size=0.4, paint=(0.4, 0.6, 1, 0.6), id=28),
        marker(SPHERE, at=(-17, -12, 0.5), turned=(0.4, 0.3, 0.8), size=0.4, paint=(0.4, 0.6, 1, 0.6), id=29),
        marker(SPHERE, at=(-14, -10, 0.5), turned=(0.4, 0.3, 0.8), size=0.4, paint=(0.4, 0.6, 1, 0.6), id=30),
        marker(SPHERE, at=(-11, -8, 0.5), turned=(0.4, 0.3, 0.8), size=0.4, paint=(0.4, 0.6, 1, 0.6), id=31),
        marker(SPHERE, at=(-8, -6, 0.5), turned=(0.4, 0.3, 0.8), size=0.4, paint=(0.4, 0.6, 1, 0.6), id=32),
        marker(LINE_STRIP, size=(0.01, 0, 0), paint=(1, 1, 1), id=33, points=[(-30, -20, 0), (1, 1, 0)])],
    "marker_sphere_cylinder_unequal_scale_normals": [
        marker(SPHERE, at=(-0.3, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(0.8, 0.3, 0.15), paint=(1, 1, 1), id=3),
        marker(SPHERE, at=(0.4, 0.2, 0.3), turned=(0, 1, 0), size=(0.2, 0.2, 0.9), paint=(0.4, 0.7, 1), id=4),
        marker(CYLINDER, at=(0.1, -0.5, 0.2), turned=(1, 0, 0.3), size=(0.6, 0.2, 0.3), paint=(1, 0.7, 0.2), id=5),
        marker(CUBE, at=(0.1, 0.6, 0.2), turned=(0.5, 0.5, 0.5), size=(0.9, 0.05, 0.3), paint=(0.5, 1, 0.5), id=6)],
    "marker_zero_scale_empty_list_nan_position": [
        marker(CUBE, at=(0, 0, 0.2), paint=(1, 1, 1), id=91),
        marker(LINE_STRIP, size=(0.1, 0, 0), paint=(1, 1, 1), id=92),
        marker(POINTS, size=(0.1, 0.1, 0), paint=(1, 1, 1), id=93),
        marker(CUBE, at=(math.nan, 0, 0), size=0.3, paint=(1, 1, 1), id=94),
        marker(SPHERE, at=(0.2, 0.2, 0.2), size=0.4, paint=(0.5, 0.9, 0.2), id=95)],
    "marker_zero_scale_shapes": [
        marker(CUBE, at=(0, 0, 0.3), turned=(0.3, 0.2, 0.1), size=(0.6, 0.5, 0), paint=(1, 0.6, 0.2)),
        marker(CYLINDER, at=(-0.5, 0.4, 0.2), turned=(0.4, 0.3, 0.8), size=(0.4, 0.4, 0), paint=(0.3, 1, 0.4), id=1),
        marker(SPHERE, at=(0.4, -0.5, 0.3), turned=(0, 0.4, 0), size=(0.4, 0.4, 0), paint=(0.4, 0.5, 1), id=2),
        marker(CUBE, at=(0.5, 0.4, 0.1), turned=(0.4, 0.3, 0.8), size=(0, 0.4, 0.4), paint=(1, 1, 1), id=3),
        marker(MESH, at=(-0.5, -0.4, 0.1), turned=(0.4, 0.3, 0.8), size=(1, 1, 0), paint=(0.9, 0.3, 0.3), id=4, mesh="cone.stl"),
        marker(TRIANGLES, at=(0.1, 0.1, -0.1), size=(0.6, 0.6, 0), paint=(0.6, 1, 0.2), id=5, points=fan(
            6, 0.6, 0.5, wave=0.3, step=1.0472))],
    "marker_zero_scale_z_level": [
        marker(CUBE, size=(1, 0.8, 0), paint=(1, 0.6, 0.2), id=6),
        marker(CYLINDER, at=(-0.3, 0.2, 0.3), size=(0.4, 0.4, 0), paint=(0.3, 1, 0.4, 0.5), id=7),
        marker(ARROW, at=(-0.3, -0.3, 0.3), size=(0.6, 0.1, 0), paint=(1, 1, 1), id=8)]})
