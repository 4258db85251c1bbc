"""Interactive markers: their messages, frames and the display's settings."""

import math

from std_msgs.msg import Header
from visualization_msgs.msg import (
    InteractiveMarker, InteractiveMarkerControl, InteractiveMarkerInit, InteractiveMarkerPose, InteractiveMarkerUpdate, Marker)

from ..common import no_update
from ..displays import display
from ..geometry import pose, quaternion, turn
from ..messages import header, marker


def interactive_marker(scene):
    scene.tools = [{"Class": "rviz/Interact", "Hide Inactive Objects": True}, {"Class": "rviz/MoveCamera"}]
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(display("InteractiveMarkers"))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/s", seq_num=1, markers=[
        InteractiveMarker(
            header=header(), pose=pose((0, 0, 0.3), (0, 0, 0.3)), name="grasp", description="6-DOF grasp", scale=0.6,
            controls=[
                InteractiveMarkerControl(
                    name="box", orientation=turn(0, 0, 0), interaction_mode=InteractiveMarkerControl.MOVE_AXIS,
                    always_visible=True,
                    markers=[marker(Marker.CUBE, size=(0.25, 0.25, 0.25), paint=(0.5, 0.5, 0.5, 1), header=header())]),
                InteractiveMarkerControl(
                    name="rotate_x", orientation=turn(math.pi / 2, 0, 0), interaction_mode=InteractiveMarkerControl.ROTATE_AXIS),
                InteractiveMarkerControl(
                    name="move_x", orientation=turn(math.pi / 2, 0, 0), interaction_mode=InteractiveMarkerControl.MOVE_AXIS),
                InteractiveMarkerControl(
                    name="rotate_y", orientation=turn(0, 0, math.pi / 2), interaction_mode=InteractiveMarkerControl.ROTATE_AXIS),
                InteractiveMarkerControl(
                    name="move_y", orientation=turn(0, 0, math.pi / 2), interaction_mode=InteractiveMarkerControl.MOVE_AXIS),
                InteractiveMarkerControl(
                    name="rotate_z", orientation=turn(0, math.pi / 2, 0), interaction_mode=InteractiveMarkerControl.ROTATE_AXIS),
                InteractiveMarkerControl(
                    name="move_z", orientation=turn(0, math.pi / 2, 0), interaction_mode=InteractiveMarkerControl.MOVE_AXIS)])]))
    scene.publish("/im/update", no_update())


def interactive_marker_add_pose_replace_erase(scene):
    scene.tools = [{"Class": "rviz/Interact", "Hide Inactive Objects": True}, {"Class": "rviz/MoveCamera"}]
    scene.camera(eye=(2.1, 1.4, 1.8))
    scene.show(display("InteractiveMarkers"))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/s", seq_num=1, markers=[
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((-0.4, 0.3, 0)), name="a", description="moves", scale=0.6,
            controls=[
                InteractiveMarkerControl(
                    name="x", orientation=turn(math.pi / 2, 0, 0), interaction_mode=InteractiveMarkerControl.MOVE_AXIS),
                InteractiveMarkerControl(name="o", orientation=turn(0, 0, 0), markers=[marker(
                    Marker.CUBE, size=(0.2, 0.2, 0.2), paint=(0.8, 0.5, 0.2, 1), frame="", id=10)])]),
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((0.5, 0.4, 0)), name="b", description="gone", scale=0.6,
            controls=[InteractiveMarkerControl(name="o", orientation=turn(0, 0, 0), markers=[marker(
                Marker.SPHERE, size=(0.2, 0.2, 0.2), paint=(0.2, 0.9, 0.3, 1), frame="", id=11)])]),
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((0.4, -0.4, 0)), name="c", description="old", scale=0.6,
            controls=[InteractiveMarkerControl(name="o", orientation=turn(0, 0, 0), markers=[marker(
                Marker.SPHERE, size=(0.2, 0.2, 0.2), paint=(0.2, 0.4, 0.9, 1), frame="", id=12)])])]))
    scene.publish("/im/update", no_update(), no_update(), no_update(), no_update(), no_update(), no_update(), no_update(),
                  no_update(), no_update(), no_update(),
                  InteractiveMarkerUpdate(server_id="/s", seq_num=2, type=1, markers=[InteractiveMarker(
                      header=Header(frame_id="base_link"), pose=pose((0.4, -0.4, 0.1)), name="c", description="new", scale=0.6,
                      controls=[InteractiveMarkerControl(
                          name="o", orientation=turn(0, -math.pi / 2, 0),
                          interaction_mode=InteractiveMarkerControl.ROTATE_AXIS)])]))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/t", seq_num=7, markers=[
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((-0.3, -0.5, 0)), name="t", description="other", scale=0.6,
            controls=[InteractiveMarkerControl(name="o", orientation=turn(0, 0, 0), markers=[marker(
                Marker.CYLINDER, size=(0.2, 0.2, 0.2), paint=(0.9, 0.9, 0.3, 1), frame="", id=13)])])]))
    scene.publish("/im/update",
                  InteractiveMarkerUpdate(
                      server_id="/s", seq_num=3, type=1,
                      poses=[InteractiveMarkerPose(
                          header=Header(frame_id="base_link"), pose=pose((-0.1, 0.2, 0.2), (0, 0.5, 0.5)), name="a")],
                      erases=["b"]),
                  InteractiveMarkerUpdate(server_id="/t", seq_num=7),
                  InteractiveMarkerUpdate(server_id="/t", seq_num=7),
                  InteractiveMarkerUpdate(server_id="/s", seq_num=4, type=1, markers=[InteractiveMarker(
                      header=Header(frame_id="base_link"), pose=pose((0.9, 0.1, 0)), name="n", description="added", scale=0.4,
                      controls=[InteractiveMarkerControl(name="o", orientation=turn(0, 0, 0), markers=[marker(
                          Marker.CUBE, size=(0.2, 0.2, 0.2), paint=(0.9, 0.2, 0.6, 1), frame="", id=14)])])]))


def interactive_marker_axes_shown(scene):
    scene.tools = [{"Class": "rviz/Interact", "Hide Inactive Objects": True}, {"Class": "rviz/MoveCamera"}]
    scene.show(display("InteractiveMarkers", {"Show Axes": True}))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/s", seq_num=1, markers=[
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((0, 0, 0.1), (0, 0.2, 0.3)), name="a", description="axes", scale=0.6,
            controls=[
                InteractiveMarkerControl(
                    name="o", orientation=turn(0, 0, 0), interaction_mode=InteractiveMarkerControl.MOVE_3D, always_visible=True,
                    markers=[marker(Marker.MESH_RESOURCE, size=(0.4, 0.4, 0.4), paint=(0.8, 0.5, 0.2, 1), frame="", id=33,
                                    mesh_resource="package://conformance_assets/meshes/gear.dae",
                                    mesh_use_embedded_materials=True)]),
                InteractiveMarkerControl(
                    name="mx", orientation=quaternion(1, 0, 0, 1), interaction_mode=InteractiveMarkerControl.MOVE_AXIS),
                InteractiveMarkerControl(
                    name="my", orientation=quaternion(0, 0, 1, 1), interaction_mode=InteractiveMarkerControl.MOVE_AXIS),
                InteractiveMarkerControl(
                    name="mz", orientation=quaternion(0, 1, 0, 1), interaction_mode=InteractiveMarkerControl.MOVE_AXIS),
                InteractiveMarkerControl(
                    name="r", orientation=quaternion(0, 1, 0, 1), interaction_mode=InteractiveMarkerControl.ROTATE_AXIS)])]))
    scene.publish("/im/update", no_update())


def interactive_marker_other_tool_than_interact(scene):
    scene.tools = [{"Class": "rviz/MoveCamera"}, {"Class": "rviz/Interact", "Hide Inactive Objects": True}]
    scene.show(display("InteractiveMarkers"))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/s", seq_num=1, markers=[
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((0, 0, 0)), name="a", description="title", scale=0.6,
            controls=[
                InteractiveMarkerControl(
                    name="x", orientation=turn(math.pi / 2, 0, 0), interaction_mode=InteractiveMarkerControl.MOVE_AXIS),
                InteractiveMarkerControl(
                    name="z", orientation=turn(0, -math.pi / 2, 0), interaction_mode=InteractiveMarkerControl.ROTATE_AXIS,
                    always_visible=True),
                InteractiveMarkerControl(name="o", orientation=turn(0, 0, 0), markers=[marker(
                    Marker.CUBE, size=(0.2, 0.2, 0.2), paint=(1, 0.4, 0.4, 1), frame="", id=8)]),
                InteractiveMarkerControl(name="p", orientation=turn(0, 0, 0), always_visible=True, markers=[
                    marker(Marker.CUBE, at=(0.4, 0, 0), size=(0.2, 0.2, 0.2), paint=(0.8, 0.5, 0.2, 1), frame="", id=9)])])]))
    scene.publish("/im/update", no_update())


def interactive_marker_transparency_off(scene):
    scene.tools = [{"Class": "rviz/Interact", "Hide Inactive Objects": True}, {"Class": "rviz/MoveCamera"}]
    scene.camera(eye=(1.9, 1.2, 1.5))
    scene.show(display("InteractiveMarkers", {"Enable Transparency": False}))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/s", seq_num=1, markers=[
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((-0.4, 0.3, 0)), name="a", description="opaque", scale=0.6,
            controls=[
                InteractiveMarkerControl(
                    name="x", orientation=turn(math.pi / 2, 0, 0), interaction_mode=InteractiveMarkerControl.MOVE_AXIS),
                InteractiveMarkerControl(
                    name="z", orientation=turn(0, -math.pi / 2, 0), interaction_mode=InteractiveMarkerControl.ROTATE_AXIS)]),
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((0.5, 0.3, 0)), name="b", scale=0.6,
            controls=[InteractiveMarkerControl(
                name="k", orientation=turn(0, -math.pi / 2, 0), interaction_mode=InteractiveMarkerControl.MOVE_ROTATE)]),
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((0.1, -0.4, 0.1)), name="c", scale=0.6,
            controls=[InteractiveMarkerControl(name="o", orientation=turn(0, 0, 0), markers=[
                marker(Marker.SPHERE, size=(0.2, 0.2, 0.2), paint=(1, 0.4, 0.4, 0.3), frame="", id=6),
                marker(Marker.CUBE, at=(0.3, 0, 0), size=(0.2, 0.2, 0.2), paint=(0.4, 0.4, 1, 0), frame="", id=7)])])]))
    scene.publish("/im/update", no_update())


def interactive_marker_without_controls(scene):
    scene.tools = [{"Class": "rviz/Interact", "Hide Inactive Objects": True}, {"Class": "rviz/MoveCamera"}]
    scene.show(display("InteractiveMarkers"), display("Grid"))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/s", seq_num=1, markers=[
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((0, 0, 0)), name="a", description="first", scale=0.6,
            controls=[InteractiveMarkerControl(
                name="x", orientation=turn(math.pi / 2, 0, 0), interaction_mode=InteractiveMarkerControl.MOVE_AXIS)]),
        InteractiveMarker(header=Header(frame_id="base_link"), pose=pose((0.4, 0.4, 0)), name="b", scale=0.6)]))
    scene.publish("/im/update", no_update())
