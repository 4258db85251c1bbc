"""Markers over several messages: modified, deleted, replaced; namespaces, frames, topics."""

import genpy
from visualization_msgs.msg import Marker

from ..clouds import fan, spiral
from ..common import four_cubes
from ..displays import display
from ..messages import ARROW, CUBE, CYLINDER, LINE_STRIP, SPHERE, TRIANGLES, header, marker, markers
from ..scene import LARGE, Scene, family


def marker_deleteall_then_two_more(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m", markers(*four_cubes()), markers(
        marker(CUBE, size=1, paint=(1, 1, 1), id=75, action=Marker.DELETEALL),
        marker(SPHERE, at=(0, 0.2, 0.2), size=(0.4, 0.3, 0.3), paint=(0.9, 0.9, 0.2), id=5),
        marker(CUBE, at=(0.4, -0.3, 0.2), size=(0.2, 0.3, 0.3), paint=(0.9, 0.3, 0.9), id=6)))


def marker_deleteall_without_frame(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m",
                  markers(marker(CUBE, at=(-0.4, 0, 0.2), size=0.3, paint=(1, 1, 1), id=1)),
                  markers(marker(CUBE, at=(0.3, 0.3, 0.2), size=0.3, paint=(0, 1, 0), id=2),
                          marker(CUBE, size=1, paint=(1, 1, 1), frame="", id=9, action=Marker.DELETEALL),
                          marker(SPHERE, at=(0.3, -0.3, 0.2), size=0.3, paint=(1, 1, 0), id=3)))


def marker_display_hears_array_topic(scene):
    scene.show(display("Marker"))
    scene.publish("/vm", marker(CUBE, at=(-0.3, 0, 0.2), size=0.3, paint=(1, 0.4, 0.3), id=1))
    scene.publish("/vm_array", markers(
        marker(SPHERE, at=(0.3, 0.3, 0.2), size=0.3, paint=(0.3, 0.4, 1), id=2),
        marker(CUBE, at=(0.3, -0.4, 0.2), size=0.3, paint=(0.3, 1, 0.3), id=3)))


def marker_display_one_topic(scene):
    scene.show(display("Marker"))
    scene.publish("/vm",
                  marker(CUBE, at=(-0.6, 0, 0.2), size=0.25, paint=(1, 0, 0.3), ns="a"),
                  marker(CUBE, at=(-0.2, 0, 0.2), turned=(0, 0, 0.3), size=0.25, paint=(1, 0.2, 0.3), ns="b", id=1),
                  marker(CUBE, at=(0.2, 0, 0.2), turned=(0, 0, 0.6), size=0.25, paint=(1, 0.4, 0.3), ns="a", id=2),
                  marker(CUBE, at=(0.6, 0, 0.2), turned=(0, 0, 0.9), size=0.25, paint=(1, 0.6, 0.3), ns="b", id=3),
                  marker(CUBE, size=1, paint=(1, 1, 1), ns="b", id=1, action=Marker.DELETE))


def marker_modify_delete_add(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m",
                  markers(*four_cubes()),
                  markers(marker(CUBE, size=1, paint=(1, 1, 1), ns="a", action=Marker.DELETE),
                          marker(SPHERE, at=(0, 0.5, 0.2), size=0.3, paint=(0, 1, 1), ns="b", id=1)),
                  markers(marker(CUBE, at=(0.5, -0.4, 0.3), size=(0.2, 0.2, 0.5), paint=(1, 1, 1), ns="a", id=2),
                          marker(CYLINDER, at=(-0.5, -0.4, 0.3), size=(0.2, 0.2, 0.5), paint=(0.4, 0.4, 1), ns="z", id=9)))


def marker_namespace_off(scene):
    scene.show(display("MarkerArray", {"Namespaces": {"a": False, "b": True}}))
    scene.publish("/m", markers(*four_cubes()))


def marker_other_frame_rotated_frame_locked(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show_markers(
        marker(CUBE, at=(0, 0, 0.2), turned=(0.4, 0.3, 0.8), size=(0.3, 0.2, 0.1), paint=(1, 0.5, 0), frame="sensor", id=71),
        marker(ARROW, at=(0.1, 0.3, 0), turned=(0.4, 0.3, 0.8), size=(0.5, 0.1, 0.1), paint=(0, 0.7, 1), header=header("sensor"),
               id=72, frame_locked=True),
        marker(LINE_STRIP, size=(0.04, 0, 0), paint=(1, 1, 1), frame="sensor", id=73, points=spiral(6)),
        marker(TRIANGLES, at=(-0.3, 0, 0), size=0.5, paint=(0.5, 1, 0.5), frame="sensor", id=74, points=fan(
            6, 0.6, 0.5, wave=0.3, step=1.0472)))


def marker_single_topic(scene):
    scene.camera(**LARGE)
    scene.show(display("Marker", name="M"))
    scene.publish("/vm",
                  marker(CUBE, at=(0, 0, 0.2), size=0.3, paint=(1, 0, 0), header=header()),
                  marker(SPHERE, at=(0.5, 0.2, 0.2), size=0.3, paint=(0, 1, 0), header=header(), id=1),
                  marker(CUBE, at=(-0.4, 0.3, 0.2), turned=(0, 0, 0.5), size=(0.5, 0.2, 0.3), paint=(1, 0.8, 0), header=header()))


family(Scene.show_markers, {
    "marker_id_changes_type": [
        marker(CUBE, at=(0, 0, 0.3), size=0.4, paint=(1, 0, 0), id=1),
        marker(ARROW, at=(0, 0, 0.3), size=(0.6, 0.2, 0.2), paint=(0, 1, 0), id=1)],
    "marker_long_lifetime": [
        marker(CUBE, at=(0, 0, 0.2), turned=(0.4, 0.3, 0.8), size=0.3, paint=(0.4, 0.9, 0.6), id=1,
               lifetime=genpy.Duration.from_sec(1000)),
        marker(SPHERE, at=(0.3, -0.4, 0.2), size=0.3, paint=(0.9, 0.5, 0.1, 0.7), id=2, lifetime=genpy.Duration.from_sec(5000))],
    "marker_unknown_type_and_action": [
        marker(12, at=(0, 0, 0.4), size=0.2, paint=(1, 0, 0), id=34),
        marker(CUBE, at=(0, 0.4, 0.4), size=0.2, paint=(1, 1, 0), id=35, action=1),
        marker(CUBE, size=0.2, paint=(0, 1, 0), id=36)]})
