"""Interactive markers: their messages, frames and the display's settings."""

import math

from std_msgs.msg import Header
from visualization_msgs.msg import InteractiveMarkerPose

from ..displays import display
from ..geometry import pose, quaternion
from ..interaction import (
    INTERACT, MOVE_3D, MOVE_AXIS, MOVE_ROTATE, ROTATE_AXIS, control, interactive, no_update, serve, update, whole_state)
from ..messages import CUBE, CYLINDER, MESH, SPHERE, header, marker
from ..scene import LARGE


def interactive_marker(scene):
    scene.tools = INTERACT
    scene.camera(**LARGE)
    scene.show(display("InteractiveMarkers"))
    serve(scene, interactive(
        "grasp", (0, 0, 0.3), (0, 0, 0.3), description="6-DOF grasp", header=header(),
        controls=[
            control("box", MOVE_AXIS, always_visible=True, markers=[marker(
                CUBE, size=0.25, paint=(0.5, 0.5, 0.5), header=header())]),
            control("rotate_x", ROTATE_AXIS, turned=(math.pi / 2, 0, 0)),
            control("move_x", MOVE_AXIS, turned=(math.pi / 2, 0, 0)),
            control("rotate_y", ROTATE_AXIS, turned=(0, 0, math.pi / 2)),
            control("move_y", MOVE_AXIS, turned=(0, 0, math.pi / 2)),
            control("rotate_z", ROTATE_AXIS, turned=(0, math.pi / 2, 0)),
            control("move_z", MOVE_AXIS, turned=(0, math.pi / 2, 0))]))


def interactive_marker_add_pose_replace_erase(scene):
    scene.tools = INTERACT
    scene.camera(eye=(2.1, 1.4, 1.8))
    scene.show(display("InteractiveMarkers"))
    scene.publish("/im/update_full", whole_state(
        "/s", 1,
        interactive("a", (-0.4, 0.3, 0), description="moves", controls=[
            control("x", MOVE_AXIS, turned=(math.pi / 2, 0, 0)),
            control("o", markers=[marker(CUBE, size=0.2, paint=(0.8, 0.5, 0.2), frame="", id=10)])]),
        interactive("b", (0.5, 0.4, 0), description="gone", controls=[control("o", markers=[marker(
            SPHERE, size=0.2, paint=(0.2, 0.9, 0.3), frame="", id=11)])]),
        interactive("c", (0.4, -0.4, 0), description="old", controls=[control("o", markers=[marker(
            SPHERE, size=0.2, paint=(0.2, 0.4, 0.9), frame="", id=12)])])))
    scene.publish("/im/update", *[no_update()] * 10, update("/s", 2, type=1, markers=[interactive(
        "c", (0.4, -0.4, 0.1), description="new", controls=[control("o", ROTATE_AXIS, turned=(0, -math.pi / 2, 0))])]))
    scene.publish("/im/update_full", whole_state("/t", 7, interactive(
        "t", (-0.3, -0.5, 0), description="other",
        controls=[control("o", markers=[marker(CYLINDER, size=0.2, paint=(0.9, 0.9, 0.3), frame="", id=13)])])))
    scene.publish("/im/update",
                  update("/s", 3, type=1,
                         poses=[InteractiveMarkerPose(
                             header=Header(frame_id="base_link"), pose=pose((-0.1, 0.2, 0.2), (0, 0.5, 0.5)), name="a")],
                         erases=["b"]),
                  update("/t", 7),
                  update("/t", 7),
                  update("/s", 4, type=1, markers=[interactive(
                      "n", (0.9, 0.1, 0), description="added", scale=0.4,
                      controls=[control("o", markers=[marker(CUBE, size=0.2, paint=(0.9, 0.2, 0.6), frame="", id=14)])])]))


def interactive_marker_axes_shown(scene):
    scene.tools = INTERACT
    scene.show(display("InteractiveMarkers", {"Show Axes": True}))
    serve(scene, interactive("a", (0, 0, 0.1), (0, 0.2, 0.3), description="axes", controls=[
        control("o", MOVE_3D, always_visible=True, markers=[marker(
            MESH, size=0.4, paint=(0.8, 0.5, 0.2), frame="", id=33, mesh="gear.dae", mesh_use_embedded_materials=True)]),
        control("mx", MOVE_AXIS, turned=quaternion(1, 0, 0, 1)),
        control("my", MOVE_AXIS, turned=quaternion(0, 0, 1, 1)),
        control("mz", MOVE_AXIS, turned=quaternion(0, 1, 0, 1)),
        control("r", ROTATE_AXIS, turned=quaternion(0, 1, 0, 1))]))


def interactive_marker_other_tool_than_interact(scene):
    scene.tools = [{"Class": "rviz/MoveCamera"}, {"Class": "rviz/Interact", "Hide Inactive Objects": True}]
    scene.show(display("InteractiveMarkers"))
    serve(scene, interactive("a", (0, 0, 0), description="title", controls=[
        control("x", MOVE_AXIS, turned=(math.pi / 2, 0, 0)),
        control("z", ROTATE_AXIS, turned=(0, -math.pi / 2, 0), always_visible=True),
        control("o", markers=[marker(CUBE, size=0.2, paint=(1, 0.4, 0.4), frame="", id=8)]),
        control("p", always_visible=True, markers=[marker(
            CUBE, at=(0.4, 0, 0), size=0.2, paint=(0.8, 0.5, 0.2), frame="", id=9)])]))


def interactive_marker_transparency_off(scene):
    scene.tools = INTERACT
    scene.camera(eye=(1.9, 1.2, 1.5))
    scene.show(display("InteractiveMarkers", {"Enable Transparency": False}))
    serve(scene,
          interactive("a", (-0.4, 0.3, 0), description="opaque", controls=[
              control("x", MOVE_AXIS, turned=(math.pi / 2, 0, 0)),
              control("z", ROTATE_AXIS, turned=(0, -math.pi / 2, 0))]),
          interactive("b", (0.5, 0.3, 0), controls=[control("k", MOVE_ROTATE, turned=(0, -math.pi / 2, 0))]),
          interactive("c", (0.1, -0.4, 0.1), controls=[control("o", markers=[
              marker(SPHERE, size=0.2, paint=(1, 0.4, 0.4, 0.3), frame="", id=6),
              marker(CUBE, at=(0.3, 0, 0), size=0.2, paint=(0.4, 0.4, 1, 0), frame="", id=7)])]))


def interactive_marker_without_controls(scene):
    scene.tools = INTERACT
    scene.show(display("InteractiveMarkers"), display("Grid"))
    serve(scene,
          interactive("a", (0, 0, 0), description="first", controls=[control("x", MOVE_AXIS, turned=(math.pi / 2, 0, 0))]),
          interactive("b", (0.4, 0.4, 0)))
