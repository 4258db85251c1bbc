"""Interactive markers: what their controls look like."""

import math

from ..displays import display
from ..interaction import (
    BUTTON, FIXED, INTERACT, MENU, MOVE_3D, MOVE_AXIS, MOVE_PLANE, MOVE_ROTATE, ROTATE_AXIS, VIEW_FACING, control, interactive,
    serve)
from ..messages import (
    ARROW, CUBE, CUBE_LIST, CYLINDER, LINE_LIST, LINE_STRIP, MESH, POINTS, SPHERE, SPHERE_LIST, TEXT, TRIANGLES, header, marker)


def interactive_marker_default_handles(scene):
    scene.tools = INTERACT
    scene.camera(eye=(2.2, 1.4, 1.8))
    scene.show(display("InteractiveMarkers"))
    serve(scene,
          interactive("a", (-0.7, 0.5, 0), description="plane", controls=[control("p", MOVE_PLANE, turned=(0, -math.pi / 2, 0))]),
          interactive("b", (0.2, 0.7, 0), controls=[control("mr", MOVE_ROTATE, turned=(0, -math.pi / 2, 0))]),
          interactive("c", (-0.5, -0.6, 0), controls=[control("r", ROTATE_AXIS, turned=(0.3, 0.5, 0.4))]),
          interactive("d", (0.6, -0.3, 0.1), controls=[control("m", MOVE_AXIS, turned=(0.1, 0.3, 0.9))]),
          interactive("e", (0, 0, 0), scale=0, controls=[
              control("n"), control("b", BUTTON), control("m3", MOVE_3D), control("z", MOVE_AXIS, turned=(0, -math.pi / 2, 0))]))


def interactive_marker_every_marker_kind(scene):
    scene.tools = INTERACT
    scene.camera(eye=(1.4, 0.9, 1.9))
    scene.show(display("InteractiveMarkers", {"Show Descriptions": False}))
    serve(scene, interactive("a", (0, 0, 0), (0, 0, 0.1), controls=[control("o", BUTTON, markers=[
        marker(ARROW, at=(-0.8, 0.5, 0), size=(0.4, 0.08, 0.1), paint=(0.8, 0.5, 0.2), frame="", id=18),
        marker(CUBE, at=(-0.4, 0.5, 0), turned=(0.3, 0.2, 0.1), size=0.2, paint=(0.8, 0.5, 0.2), frame="", id=19),
        marker(SPHERE, at=(0, 0.5, 0), size=(0.3, 0.2, 0.2), paint=(0.2, 0.9, 0.4, 0.6), frame="", id=20),
        marker(CYLINDER, at=(0.4, 0.5, 0), size=0.2, paint=(0.8, 0.5, 0.2), frame="", id=21),
        marker(LINE_STRIP, at=(-0.8, 0.1, 0), size=(0.03, 0, 0), paint=(0.8, 0.5, 0.2), frame="", id=22,
               points=[(0, 0, 0), (0.2, 0.1, 0.1), (0.3, -0.1, 0)]),
        marker(LINE_LIST, at=(-0.3, 0.1, 0), size=(0.03, 0, 0), paint=(0.8, 0.5, 0.2), frame="", id=23,
               points=[(0, 0, 0), (0.2, 0.1, 0.1), (0.3, -0.1, 0), (0.1, -0.2, 0)]),
        marker(CUBE_LIST, at=(0.2, 0.1, 0), size=0.1, paint=(0.5, 0.5, 1), frame="", id=24, points=[
            (0, 0, 0), (0.2, 0, 0), (0.4, 0.1, 0)]),
        marker(SPHERE_LIST, at=(-0.8, -0.3, 0), size=0.1, paint=(0.9, 0.5, 1), frame="", id=25, points=[
            (0, 0, 0), (0.2, 0, 0), (0.3, 0.1, 0)]),
        marker(POINTS, at=(-0.3, -0.3, 0), size=(0.06, 0.06, 0), paint=(0.8, 0.5, 0.2), frame="", id=26,
               points=[(0, 0, 0), (0.1, 0, 0), (0.2, 0.1, 0)]),
        marker(TEXT, at=(0.2, -0.3, 0), size=(0, 0, 0.15), paint=(0.8, 0.5, 0.2), frame="", id=27, text="text"),
        marker(MESH, at=(0.7, -0.2, 0), size=0.3, paint=(0.8, 0.5, 0.2), frame="", id=28, mesh="cone.stl"),
        marker(TRIANGLES, at=(-0.2, -0.7, 0), size=1, paint=(0.3, 0.9, 0.9), frame="", id=29, points=[
            (0, 0, 0), (0.3, 0, 0), (0, 0.2, 0.1)]),
        marker(TEXT, size=0.2, paint=(0.8, 0.5, 0.2), frame="", id=30, text=" "),
        marker(LINE_LIST, size=0.2, paint=(0.8, 0.5, 0.2), frame="", id=31, points=[(0, 0, 0)])])]))


def interactive_marker_markers_in_own_frames(scene):
    scene.tools = INTERACT
    scene.camera(eye=(1.9, 1.2, 1.5))
    scene.frame("tilted", at=(0.1, 0.1, 0.1), turned=(0.6, 0.3, -0.8))
    scene.show(display("InteractiveMarkers"))
    serve(scene,
          interactive("a", (-0.4, 0.3, 0), (0.3, 0.1, 0.8), description="own", controls=[
              control("x", MOVE_AXIS, turned=(math.pi / 2, 0, 0), markers=[marker(
                  CUBE, at=(0.2, 0, 0), size=(0.2, 0.1, 0.1), paint=(0.9, 0.3, 0.3), frame="tilted", id=15)]),
              control("f", orientation_mode=FIXED, markers=[marker(
                  CUBE, at=(0.5, 0, 0), size=(0.2, 0.1, 0.1), paint=(0.3, 0.9, 0.3), frame="tilted", id=16)]),
              control("i", orientation_mode=VIEW_FACING,
                      markers=[marker(CUBE, at=(0.8, 0, 0), size=(0.2, 0.1, 0.1), paint=(0.3, 0.3, 0.9), frame="tilted", id=17)],
                      independent_marker_orientation=True)]),
          interactive("b", (0.3, -0.4, 0.2), (0.3, 0, 0), description="stamped", header=header("tilted"),
                      controls=[control("z", ROTATE_AXIS, turned=(0, -math.pi / 2, 0))]))


def interactive_marker_menu_and_description(scene):
    scene.tools = INTERACT
    scene.camera(eye=(1.9, 1.2, 1.5))
    scene.show(display("InteractiveMarkers"))
    serve(scene,
          interactive("a", (-0.4, 0.4, 0), (0.3, 0.2, 0.5), description="first line\nand the second",
                      controls=[control("m", MENU, description="Options")]),
          interactive("b", (0.4, -0.2, 0), description="  ", controls=[control("m", MENU), control(
              "c", markers=[marker(CUBE, size=0.2, paint=(0.8, 0.5, 0.2), frame="", id=32)])]))


def interactive_marker_orientation_fixed_inherit(scene):
    scene.tools = INTERACT
    scene.camera(eye=(1.9, 1.2, 1.5))
    scene.frame("tilted", at=(0.1, 0.1, 0.1), turned=(0.6, 0.3, -0.8))
    scene.show(display("InteractiveMarkers", {"Show Axes": True, "Show Descriptions": False}))
    serve(scene,
          interactive("a", (-0.4, 0.3, 0.1), (0.5, 0.2, 0.9), description="not shown", controls=[
              control("f", MOVE_AXIS, turned=(math.pi / 2, 0, 0), orientation_mode=FIXED),
              control("g", ROTATE_AXIS, turned=(0, -math.pi / 2, 0), orientation_mode=FIXED)]),
          interactive("b", (0.4, -0.3, 0.1), (0.5, 0.2, 0.9), frame="tilted", controls=[
              control("i", MOVE_AXIS, turned=(math.pi / 2, 0, 0)),
              control("j", ROTATE_AXIS, turned=(0, -math.pi / 2, 0)),
              control("k", markers=[marker(CUBE, size=0.2, paint=(0.8, 0.5, 0.2), frame="", id=5)])]))


def interactive_marker_view_facing(scene):
    scene.tools = INTERACT
    scene.camera(eye=(1.9, 1.2, 1.5), roll=0.4)
    scene.frame("tilted", at=(0.1, 0.1, 0.1), turned=(0.6, 0.3, -0.8))
    scene.show(display("InteractiveMarkers"))
    serve(scene,
          interactive("a", (-0.5, 0.5, 0.1), (0.5, 0.2, 0.9), description="ring", controls=[control(
              "r", MOVE_ROTATE, orientation_mode=VIEW_FACING)]),
          interactive("b", (0.4, 0.4, 0), (0.2, -0.4, 0.3), frame="tilted", controls=[
              control("c", MOVE_PLANE, turned=(0, -math.pi / 2, 0), orientation_mode=VIEW_FACING, markers=[
                  marker(CUBE, at=(0, 0, 0.15), size=0.2, paint=(0.8, 0.5, 0.2), frame=""),
                  marker(CYLINDER, at=(0, 0.2, 0), size=(0.1, 0.1, 0.3), paint=(0.2, 0.7, 0.9), frame="", id=1),
                  marker(TEXT, at=(0, -0.2, 0.1), size=(0, 0, 0.1), paint=(0.8, 0.5, 0.2), frame="", id=2, text="here"),
                  marker(LINE_STRIP, size=(0.02, 0, 0), paint=(0.8, 0.5, 0.2), frame="", id=3, points=[
                      (0, 0, 0), (0, 0.3, 0.3), (0, -0.3, 0.3)])])]),
          interactive("c", (0.1, -0.5, 0), (0.3, 0.4, 0.5), controls=[control(
              "i", MOVE_PLANE, orientation_mode=VIEW_FACING,
              markers=[marker(CUBE, size=(0.3, 0.15, 0.1), paint=(0.3, 0.9, 0.3), frame="", id=4)],
              independent_marker_orientation=True)]))
