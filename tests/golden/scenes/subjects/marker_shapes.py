"""Markers of one shape: cubes, spheres, cylinders; odd scales, colours and poses."""

import math

from visualization_msgs.msg import Marker

from ..clouds import fan
from ..displays import camera_pub, display
from ..geometry import colors, points, quaternion
from ..messages import marker, markers


def marker_alpha_just_below_1(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(-0.5, 0, 0.2), turned=(0, 0, 0.5), size=(0.4, 0.3, 0.3), paint=(0.2, 1, 0.4, 0.9999), id=87),
        marker(Marker.CUBE, at=(-0.15, 0.1, 0.23), turned=(0, 0, 0.6), size=(0.4, 0.3, 0.3), paint=(0.4, 0.8, 0.4, 0.999), id=88),
        marker(Marker.CUBE, at=(0.2, 0.2, 0.26), turned=(0, 0, 0.7), size=(0.4, 0.3, 0.3), paint=(0.6, 0.6, 0.4, 0.5), id=89),
        marker(Marker.CUBE, at=(0.55, 0.3, 0.29), turned=(0, 0, 0.8), size=(0.4, 0.3, 0.3), paint=(0.8, 0.4, 0.4, 0), id=90)))


def marker_camera_inside_sphere_and_cylinder(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.SPHERE, at=(0.8, 0.6, 0.8), size=(3, 3, 3), paint=(1, 0, 0, 1), id=96),
        marker(Marker.CUBE, at=(0, 0, 0.2), size=(0.4, 0.4, 0.4), paint=(0, 1, 0, 1), id=97)))


def marker_color_count_unlike_point_count(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.LINE_STRIP, size=(0.05, 0, 0), paint=(1, 0.6, 0.2, 1), id=36,
               points=points([(0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(6)]),
               colors=colors([(0, 0.33333334, 0, 0.3), (0.5, 0.6666667, 0.25, 0.35), (1, 1, 0.5, 0.4)])),
        marker(Marker.SPHERE, at=(0.3, 0.3, 0), size=(0.2, 0.2, 0.2), paint=(1, 1, 1, 1), id=37),
        marker(Marker.CUBE_LIST, at=(0, 0, 0.4), size=(0.1, 0.1, 0.1), paint=(0.2, 0.6, 1, 1), id=38,
               points=points([(0.10201343894004822, -0.07649841159582138, 0.5620033741),
                              (-0.035613980144262314, 0.015484984964132309, 0.22356292605400085),
                              (-0.4412810206413269, -0.2871411442756653, 0.0910501480102539),
                              (-0.08555378764867783, -0.30935078859329224, -0.05313597619533539),
                              (-0.044158484786748886, 0.07426488399505615, -0.2048734873533249),
                              (-0.10405879467725754, 0.17111675441265106, 0.2760317325592041)]),
               colors=colors([(0, 0.33333334, 0), (0.5, 0.6666667, 0.25), (1, 1, 0.5), (0, 0, 0.75)])),
        marker(Marker.TRIANGLE_LIST, at=(0, 0, -0.2), size=(0.6, 0.6, 0.6), paint=(0.6, 1, 0.2, 1), id=39,
               points=points(fan(6, 0.6, 0.5, wave=0.3, step=1.0472)),
               colors=colors([(0, 0.33333334, 0, 0.3), (0.5, 0.6666667, 0.25, 0.35)]))))


def marker_colors_outside_0_to_1(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(-0.4, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(0.3, 0.3, 0.3), paint=(1.5, -0.5, 0.5, 1.5), id=25),
        marker(Marker.LINE_STRIP, at=(0, 0, 0.3), size=(0.06, 0, 0), paint=(1.2, -0.2, 0.5, 1), id=26,
               points=points([(0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(14)])),
        marker(Marker.POINTS, at=(0, 0, 0.1), size=(0.1, 0.1, 0), paint=(1.2, -0.2, 0.5, 1.3), id=27,
               points=points([(0.10201343894004822, -0.07649841159582138, 0.5620033741),
                              (-0.035613980144262314, 0.015484984964132309, 0.22356292605400085),
                              (-0.4412810206413269, -0.2871411442756653, 0.0910501480102539),
                              (-0.08555378764867783, -0.30935078859329224, -0.05313597619533539),
                              (-0.044158484786748886, 0.07426488399505615, -0.2048734873533249),
                              (-0.10405879467725754, 0.17111675441265106, 0.2760317325592041),
                              (-0.31145262718200684, 0.13290244340896606, -0.20210231840610504),
                              (-0.386665940284729, -0.3934466242790222, -0.19066210091114044)])),
        marker(Marker.TEXT_VIEW_FACING, at=(0, 0, 0.6), size=(0, 0, 0.2), paint=(1.2, 0.2, -0.2, 1), id=28, text="Loud"),
        marker(Marker.TRIANGLE_LIST, at=(0.3, 0.3, 0), size=(0.5, 0.5, 0.5), paint=(1, 1, 1, 1), id=29,
               points=points(fan(6, 0.6, 0.5, wave=0.3, step=1.0472)), colors=colors([(1.2, -0.2, 0.5) for i in range(6)])),
        marker(Marker.CUBE, at=(0.5, -0.3, 0.2), turned=(0.4, 0.3, 0.8), size=(0.3, 0.3, 0.3), paint=(0.5, 0.5, 1, -0.5), id=30)))


def marker_cube_many_small(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(*(marker(
        Marker.CUBE, at=(-0.4 + 0.2 * (i % 5), -0.4 + 0.2 * (i // 5), 0.05 * (i % 3)), turned=(0, 0, 0.2 * i),
        size=(0.1, 0.12, 0.15), paint=(0.25 * (i % 5), 0.25 * (i // 5), 0.5, 1), id=12 + i) for i in range(25))))


def marker_cylinder_flat_and_long(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CYLINDER, at=(0, 0, 0.1), turned=(0.4, 0.3, 0.8), size=(0.7, 0.5, 0.01), paint=(0.9, 0.7, 0.3, 1), id=9),
        marker(Marker.CYLINDER, at=(0.3, -0.4, 0.3), turned=(1.2, 0.3, 0), size=(0.03, 0.03, 1.2), paint=(0.3, 0.8, 0.9, 1),
               id=10),
        marker(Marker.SPHERE, at=(-0.3, 0.5, 0.3), turned=(0.4, 0.3, 0.8), size=(0.6, 0.6, 0.02), paint=(0.8, 0.3, 0.8, 1),
               id=11)))


def marker_negative_scale_mirrors(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(0, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(-0.4, 0.3, 0.3), paint=(0, 1, 0, 1), id=98),
        marker(Marker.SPHERE, at=(0.5, -0.3, 0.2), turned=(0.4, 0.3, 0.8), size=(-0.4, -0.4, -0.4), paint=(1, 1, 0, 1), id=99),
        marker(Marker.CYLINDER, at=(-0.4, 0.4, 0.3), turned=(0.4, 0.3, 0.8), size=(0.3, 0.3, -0.5), paint=(1, 0.3, 1, 1),
               id=100)))


def marker_quaternion_not_unit_length(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(-0.4, 0, 0.2), turned=quaternion(0.5, 0.3, 0.2, 2), size=(0.4, 0.3, 0.2), paint=(1, 0.5, 0.5, 1),
               id=10),
        marker(Marker.CUBE, at=(0.4, -0.3, 0.2), turned=quaternion(0, 0, 0, 0), size=(0.4, 0.3, 0.2), paint=(0.5, 1, 0.5, 1),
               id=11),
        marker(Marker.ARROW, at=(0.2, 0.4, 0.2), turned=quaternion(0.1, -0.2, 0.1, 0.3), size=(0.6, 0.1, 0.1),
               paint=(0.5, 0.5, 1, 1), id=12)))


def marker_shapes_close_up_shading(scene):
    scene.camera(eye=(0.9, 0.7, 0.8))
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(-0.3, -0.1, 0.2), turned=(0.4, 0.3, 0.8), size=(0.4, 0.4, 0.4), paint=(1, 1, 1, 1)),
        marker(Marker.SPHERE, at=(0.25, -0.25, 0.2), turned=(0.4, 0.3, 0.8), size=(0.5, 0.5, 0.5), paint=(0.9, 0.3, 0.2, 1),
               id=1),
        marker(Marker.CYLINDER, at=(0.1, 0.4, 0.2), turned=(0.4, 0.3, 0.8), size=(0.35, 0.35, 0.5), paint=(0.3, 0.8, 0.3, 1),
               id=2)))


def marker_shapes_cut_by_near_plane(scene):
    scene.show(display("MarkerArray"), camera_pub({"Near Clip Distance": 0.7}))
    scene.publish("/m", markers(
        marker(Marker.SPHERE, at=(1.1, 0.75, 1.05), size=(0.5, 0.5, 0.5), paint=(0.9, 0.4, 0.3, 1), id=31),
        marker(Marker.CUBE, at=(0.6, 0.8, 0.8), turned=(0.4, 0.3, 0.8), size=(0.8, 0.4, 0.4), paint=(0.3, 0.9, 0.4, 1), id=32),
        marker(Marker.MESH_RESOURCE, at=(1, 0.2, 0.8), turned=(0.4, 0.3, 0.8), size=(1, 1, 1), id=33,
               mesh_resource="package://conformance_assets/meshes/crate.obj", mesh_use_embedded_materials=True)))


def marker_small_and_far(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(-8, -6, 0.2), turned=(0.4, 0.3, 0.8), size=(0.2, 0.2, 0.2), paint=(1, 0.6, 0.2, 1), id=22),
        marker(Marker.CUBE, at=(-7, -5.2, 0.2), turned=(0.4, 0.3, 0.8), size=(0.2, 0.2, 0.2), paint=(1, 0.6, 0.2, 1), id=23),
        marker(Marker.CUBE, at=(-6, -4.4, 0.2), turned=(0.4, 0.3, 0.8), size=(0.2, 0.2, 0.2), paint=(1, 0.6, 0.2, 1), id=24),
        marker(Marker.CUBE, at=(-5, -3.6, 0.2), turned=(0.4, 0.3, 0.8), size=(0.2, 0.2, 0.2), paint=(1, 0.6, 0.2, 1), id=25),
        marker(Marker.CUBE, at=(-4, -2.8, 0.2), turned=(0.4, 0.3, 0.8), size=(0.2, 0.2, 0.2), paint=(1, 0.6, 0.2, 1), id=26),
        marker(Marker.CUBE, at=(-3, -2, 0.2), turned=(0.4, 0.3, 0.8), size=(0.2, 0.2, 0.2), paint=(1, 0.6, 0.2, 1), id=27),
        marker(Marker.SPHERE, at=(-20, -14, 0.5), turned=(0.4, 0.3, 0.8), size=(0.4, 0.4, 0.4), paint=(0.4, 0.6, 1, 0.6), id=28),
        marker(Marker.SPHERE, at=(-17, -12, 0.5), turned=(0.4, 0.3, 0.8), size=(0.4, 0.4, 0.4), paint=(0.4, 0.6, 1, 0.6), id=29),
        marker(Marker.SPHERE, at=(-14, -10, 0.5), turned=(0.4, 0.3, 0.8), size=(0.4, 0.4, 0.4), paint=(0.4, 0.6, 1, 0.6), id=30),
        marker(Marker.SPHERE, at=(-11, -8, 0.5), turned=(0.4, 0.3, 0.8), size=(0.4, 0.4, 0.4), paint=(0.4, 0.6, 1, 0.6), id=31),
        marker(Marker.SPHERE, at=(-8, -6, 0.5), turned=(0.4, 0.3, 0.8), size=(0.4, 0.4, 0.4), paint=(0.4, 0.6, 1, 0.6), id=32),
        marker(Marker.LINE_STRIP, size=(0.01, 0, 0), paint=(1, 1, 1, 1), id=33, points=points([(-30, -20, 0), (1, 1, 0)]))))


def marker_sphere_cylinder_unequal_scale_normals(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.SPHERE, at=(-0.3, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(0.8, 0.3, 0.15), paint=(1, 1, 1, 1), id=3),
        marker(Marker.SPHERE, at=(0.4, 0.2, 0.3), turned=(0, 1, 0), size=(0.2, 0.2, 0.9), paint=(0.4, 0.7, 1, 1), id=4),
        marker(Marker.CYLINDER, at=(0.1, -0.5, 0.2), turned=(1, 0, 0.3), size=(0.6, 0.2, 0.3), paint=(1, 0.7, 0.2, 1), id=5),
        marker(Marker.CUBE, at=(0.1, 0.6, 0.2), turned=(0.5, 0.5, 0.5), size=(0.9, 0.05, 0.3), paint=(0.5, 1, 0.5, 1), id=6)))


def marker_zero_scale_empty_list_nan_position(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(0, 0, 0.2), paint=(1, 1, 1, 1), id=91),
        marker(Marker.LINE_STRIP, size=(0.1, 0, 0), paint=(1, 1, 1, 1), id=92),
        marker(Marker.POINTS, size=(0.1, 0.1, 0), paint=(1, 1, 1, 1), id=93),
        marker(Marker.CUBE, at=(math.nan, 0, 0), size=(0.3, 0.3, 0.3), paint=(1, 1, 1, 1), id=94),
        marker(Marker.SPHERE, at=(0.2, 0.2, 0.2), size=(0.4, 0.4, 0.4), paint=(0.5, 0.9, 0.2, 1), id=95)))


def marker_zero_scale_shapes(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, at=(0, 0, 0.3), turned=(0.3, 0.2, 0.1), size=(0.6, 0.5, 0), paint=(1, 0.6, 0.2, 1)),
        marker(Marker.CYLINDER, at=(-0.5, 0.4, 0.2), turned=(0.4, 0.3, 0.8), size=(0.4, 0.4, 0), paint=(0.3, 1, 0.4, 1), id=1),
        marker(Marker.SPHERE, at=(0.4, -0.5, 0.3), turned=(0, 0.4, 0), size=(0.4, 0.4, 0), paint=(0.4, 0.5, 1, 1), id=2),
        marker(Marker.CUBE, at=(0.5, 0.4, 0.1), turned=(0.4, 0.3, 0.8), size=(0, 0.4, 0.4), paint=(1, 1, 1, 1), id=3),
        marker(Marker.MESH_RESOURCE, at=(-0.5, -0.4, 0.1), turned=(0.4, 0.3, 0.8), size=(1, 1, 0), paint=(0.9, 0.3, 0.3, 1), id=4,
               mesh_resource="package://conformance_assets/meshes/cone.stl"),
        marker(Marker.TRIANGLE_LIST, at=(0.1, 0.1, -0.1), size=(0.6, 0.6, 0), paint=(0.6, 1, 0.2, 1), id=5,
               points=points(fan(6, 0.6, 0.5, wave=0.3, step=1.0472)))))


def marker_zero_scale_z_level(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(
        marker(Marker.CUBE, size=(1, 0.8, 0), paint=(1, 0.6, 0.2, 1), id=6),
        marker(Marker.CYLINDER, at=(-0.3, 0.2, 0.3), size=(0.4, 0.4, 0), paint=(0.3, 1, 0.4, 0.5), id=7),
        marker(Marker.ARROW, at=(-0.3, -0.3, 0.3), size=(0.6, 0.1, 0), paint=(1, 1, 1, 1), id=8)))
