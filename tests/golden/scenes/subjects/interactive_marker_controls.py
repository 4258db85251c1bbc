"""Interactive markers: what their controls look like."""

import math

from std_msgs.msg import Header
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerControl, InteractiveMarkerInit, Marker

from ..common import no_update
from ..displays import display
from ..geometry import points, pose, turn
from ..messages import header, marker


def interactive_marker_default_handles(scene):
    scene.tools = [{"Class": "rviz/Interact", "Hide Inactive Objects": True}, {"Class": "rviz/MoveCamera"}]
    scene.camera(eye=(2.2, 1.4, 1.8))
    scene.show(display("InteractiveMarkers"))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/s", seq_num=1, markers=[
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((-0.7, 0.5, 0)), name="a", description="plane", scale=0.6,
            controls=[InteractiveMarkerControl(
                name="p", orientation=turn(0, -math.pi / 2, 0), interaction_mode=InteractiveMarkerControl.MOVE_PLANE)]),
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((0.2, 0.7, 0)), name="b", scale=0.6,
            controls=[InteractiveMarkerControl(
                name="mr", orientation=turn(0, -math.pi / 2, 0), interaction_mode=InteractiveMarkerControl.MOVE_ROTATE)]),
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((-0.5, -0.6, 0)), name="c", scale=0.6,
            controls=[InteractiveMarkerControl(
                name="r", orientation=turn(0.3, 0.5, 0.4), interaction_mode=InteractiveMarkerControl.ROTATE_AXIS)]),
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((0.6, -0.3, 0.1)), name="d", scale=0.6,
            controls=[InteractiveMarkerControl(
                name="m", orientation=turn(0.1, 0.3, 0.9), interaction_mode=InteractiveMarkerControl.MOVE_AXIS)]),
        InteractiveMarker(header=Header(frame_id="base_link"), pose=pose((0, 0, 0)), name="e", controls=[
            InteractiveMarkerControl(name="n", orientation=turn(0, 0, 0)),
            InteractiveMarkerControl(name="b", orientation=turn(0, 0, 0), interaction_mode=InteractiveMarkerControl.BUTTON),
            InteractiveMarkerControl(name="m3", orientation=turn(0, 0, 0), interaction_mode=InteractiveMarkerControl.MOVE_3D),
            InteractiveMarkerControl(
                name="z", orientation=turn(0, -math.pi / 2, 0), interaction_mode=InteractiveMarkerControl.MOVE_AXIS)])]))
    scene.publish("/im/update", no_update())


def interactive_marker_every_marker_kind(scene):
    scene.tools = [{"Class": "rviz/Interact", "Hide Inactive Objects": True}, {"Class": "rviz/MoveCamera"}]
    scene.camera(eye=(1.4, 0.9, 1.9))
    scene.show(display("InteractiveMarkers", {"Show Descriptions": False}))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/s", seq_num=1, markers=[
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((0, 0, 0), (0, 0, 0.1)), name="a", scale=0.6,
            controls=[InteractiveMarkerControl(
                name="o", orientation=turn(0, 0, 0), interaction_mode=InteractiveMarkerControl.BUTTON,
                markers=[
                    marker(Marker.ARROW, at=(-0.8, 0.5, 0), size=(0.4, 0.08, 0.1), paint=(0.8, 0.5, 0.2, 1), frame="", id=18),
                    marker(Marker.CUBE, at=(-0.4, 0.5, 0), turned=(0.3, 0.2, 0.1), size=(0.2, 0.2, 0.2), paint=(0.8, 0.5, 0.2, 1),
                           frame="", id=19),
                    marker(Marker.SPHERE, at=(0, 0.5, 0), size=(0.3, 0.2, 0.2), paint=(0.2, 0.9, 0.4, 0.6), frame="", id=20),
                    marker(Marker.CYLINDER, at=(0.4, 0.5, 0), size=(0.2, 0.2, 0.2), paint=(0.8, 0.5, 0.2, 1), frame="", id=21),
                    marker(Marker.LINE_STRIP, at=(-0.8, 0.1, 0), size=(0.03, 0, 0), paint=(0.8, 0.5, 0.2, 1), frame="", id=22,
                           points=points([(0, 0, 0), (0.2, 0.1, 0.1), (0.3, -0.1, 0)])),
                    marker(Marker.LINE_LIST, at=(-0.3, 0.1, 0), size=(0.03, 0, 0), paint=(0.8, 0.5, 0.2, 1), frame="", id=23,
                           points=points([(0, 0, 0), (0.2, 0.1, 0.1), (0.3, -0.1, 0), (0.1, -0.2, 0)])),
                    marker(Marker.CUBE_LIST, at=(0.2, 0.1, 0), size=(0.1, 0.1, 0.1), paint=(0.5, 0.5, 1, 1), frame="", id=24,
                           points=points([(0, 0, 0), (0.2, 0, 0), (0.4, 0.1, 0)])),
                    marker(Marker.SPHERE_LIST, at=(-0.8, -0.3, 0), size=(0.1, 0.1, 0.1), paint=(0.9, 0.5, 1, 1), frame="", id=25,
                           points=points([(0, 0, 0), (0.2, 0, 0), (0.3, 0.1, 0)])),
                    marker(Marker.POINTS, at=(-0.3, -0.3, 0), size=(0.06, 0.06, 0), paint=(0.8, 0.5, 0.2, 1), frame="", id=26,
                           points=points([(0, 0, 0), (0.1, 0, 0), (0.2, 0.1, 0)])),
                    marker(Marker.TEXT_VIEW_FACING, at=(0.2, -0.3, 0), size=(0, 0, 0.15), paint=(0.8, 0.5, 0.2, 1), frame="",
                           id=27, text="text"),
                    marker(Marker.MESH_RESOURCE, at=(0.7, -0.2, 0), size=(0.3, 0.3, 0.3), paint=(0.8, 0.5, 0.2, 1), frame="",
                           id=28, mesh_resource="package://conformance_assets/meshes/cone.stl"),
                    marker(Marker.TRIANGLE_LIST, at=(-0.2, -0.7, 0), size=(1, 1, 1), paint=(0.3, 0.9, 0.9, 1), frame="", id=29,
                           points=points([(0, 0, 0), (0.3, 0, 0), (0, 0.2, 0.1)])),
                    marker(Marker.TEXT_VIEW_FACING, size=(0.2, 0.2, 0.2), paint=(0.8, 0.5, 0.2, 1), frame="", id=30, text=" "),
                    marker(Marker.LINE_LIST, size=(0.2, 0.2, 0.2), paint=(0.8, 0.5, 0.2, 1), frame="", id=31,
                           points=points([(0, 0, 0)]))])])]))
    scene.publish("/im/update", no_update())


def interactive_marker_markers_in_own_frames(scene):
    scene.tools = [{"Class": "rviz/Interact", "Hide Inactive Objects": True}, {"Class": "rviz/MoveCamera"}]
    scene.camera(eye=(1.9, 1.2, 1.5))
    scene.frame("tilted", at=(0.1, 0.1, 0.1), turned=(0.6, 0.3, -0.8))
    scene.show(display("InteractiveMarkers"))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/s", seq_num=1, markers=[
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((-0.4, 0.3, 0), (0.3, 0.1, 0.8)), name="a", description="own",
            scale=0.6,
            controls=[
                InteractiveMarkerControl(
                    name="x", orientation=turn(math.pi / 2, 0, 0), interaction_mode=InteractiveMarkerControl.MOVE_AXIS,
                    markers=[marker(Marker.CUBE, at=(0.2, 0, 0), size=(0.2, 0.1, 0.1), paint=(0.9, 0.3, 0.3, 1), frame="tilted",
                                    id=15)]),
                InteractiveMarkerControl(
                    name="f", orientation=turn(0, 0, 0), orientation_mode=InteractiveMarkerControl.FIXED,
                    markers=[marker(Marker.CUBE, at=(0.5, 0, 0), size=(0.2, 0.1, 0.1), paint=(0.3, 0.9, 0.3, 1), frame="tilted",
                                    id=16)]),
                InteractiveMarkerControl(
                    name="i", orientation=turn(0, 0, 0), orientation_mode=InteractiveMarkerControl.VIEW_FACING,
                    markers=[marker(Marker.CUBE, at=(0.8, 0, 0), size=(0.2, 0.1, 0.1), paint=(0.3, 0.3, 0.9, 1), frame="tilted",
                                    id=17)], independent_marker_orientation=True)]),
        InteractiveMarker(
            header=header("tilted"), pose=pose((0.3, -0.4, 0.2), (0.3, 0, 0)), name="b", description="stamped", scale=0.6,
            controls=[InteractiveMarkerControl(
                name="z", orientation=turn(0, -math.pi / 2, 0), interaction_mode=InteractiveMarkerControl.ROTATE_AXIS)])]))
    scene.publish("/im/update", no_update())


def interactive_marker_menu_and_description(scene):
    scene.tools = [{"Class": "rviz/Interact", "Hide Inactive Objects": True}, {"Class": "rviz/MoveCamera"}]
    scene.camera(eye=(1.9, 1.2, 1.5))
    scene.show(display("InteractiveMarkers"))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/s", seq_num=1, markers=[
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((-0.4, 0.4, 0), (0.3, 0.2, 0.5)), name="a",
            description="first line\nand the second", scale=0.6,
            controls=[InteractiveMarkerControl(
                name="m", orientation=turn(0, 0, 0), interaction_mode=InteractiveMarkerControl.MENU, description="Options")]),
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((0.4, -0.2, 0)), name="b", description="  ", scale=0.6,
            controls=[
                InteractiveMarkerControl(name="m", orientation=turn(0, 0, 0), interaction_mode=InteractiveMarkerControl.MENU),
                InteractiveMarkerControl(name="c", orientation=turn(0, 0, 0), markers=[marker(
                    Marker.CUBE, size=(0.2, 0.2, 0.2), paint=(0.8, 0.5, 0.2, 1), frame="", id=32)])])]))
    scene.publish("/im/update", no_update())


def interactive_marker_orientation_fixed_inherit(scene):
    scene.tools = [{"Class": "rviz/Interact", "Hide Inactive Objects": True}, {"Class": "rviz/MoveCamera"}]
    scene.camera(eye=(1.9, 1.2, 1.5))
    scene.frame("tilted", at=(0.1, 0.1, 0.1), turned=(0.6, 0.3, -0.8))
    scene.show(display("InteractiveMarkers", {"Show Axes": True, "Show Descriptions": False}))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/s", seq_num=1, markers=[
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((-0.4, 0.3, 0.1), (0.5, 0.2, 0.9)), name="a", description="not shown",
            scale=0.6,
            controls=[
                InteractiveMarkerControl(
                    name="f", orientation=turn(math.pi / 2, 0, 0), orientation_mode=InteractiveMarkerControl.FIXED,
                    interaction_mode=InteractiveMarkerControl.MOVE_AXIS),
                InteractiveMarkerControl(
                    name="g", orientation=turn(0, -math.pi / 2, 0), orientation_mode=InteractiveMarkerControl.FIXED,
                    interaction_mode=InteractiveMarkerControl.ROTATE_AXIS)]),
        InteractiveMarker(
            header=Header(frame_id="tilted"), pose=pose((0.4, -0.3, 0.1), (0.5, 0.2, 0.9)), name="b", scale=0.6,
            controls=[
                InteractiveMarkerControl(
                    name="i", orientation=turn(math.pi / 2, 0, 0), interaction_mode=InteractiveMarkerControl.MOVE_AXIS),
                InteractiveMarkerControl(
                    name="j", orientation=turn(0, -math.pi / 2, 0), interaction_mode=InteractiveMarkerControl.ROTATE_AXIS),
                InteractiveMarkerControl(name="k", orientation=turn(0, 0, 0), markers=[marker(
                    Marker.CUBE, size=(0.2, 0.2, 0.2), paint=(0.8, 0.5, 0.2, 1), frame="", id=5)])])]))
    scene.publish("/im/update", no_update())


def interactive_marker_view_facing(scene):
    scene.tools = [{"Class": "rviz/Interact", "Hide Inactive Objects": True}, {"Class": "rviz/MoveCamera"}]
    scene.camera(eye=(1.9, 1.2, 1.5), roll=0.4)
    scene.frame("tilted", at=(0.1, 0.1, 0.1), turned=(0.6, 0.3, -0.8))
    scene.show(display("InteractiveMarkers"))
    scene.publish("/im/update_full", InteractiveMarkerInit(server_id="/s", seq_num=1, markers=[
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((-0.5, 0.5, 0.1), (0.5, 0.2, 0.9)), name="a", description="ring",
            scale=0.6,
            controls=[InteractiveMarkerControl(
                name="r", orientation=turn(0, 0, 0), orientation_mode=InteractiveMarkerControl.VIEW_FACING,
                interaction_mode=InteractiveMarkerControl.MOVE_ROTATE)]),
        InteractiveMarker(
            header=Header(frame_id="tilted"), pose=pose((0.4, 0.4, 0), (0.2, -0.4, 0.3)), name="b", scale=0.6,
            controls=[InteractiveMarkerControl(
                name="c", orientation=turn(0, -math.pi / 2, 0), orientation_mode=InteractiveMarkerControl.VIEW_FACING,
                interaction_mode=InteractiveMarkerControl.MOVE_PLANE,
                markers=[
                    marker(Marker.CUBE, at=(0, 0, 0.15), size=(0.2, 0.2, 0.2), paint=(0.8, 0.5, 0.2, 1), frame=""),
                    marker(Marker.CYLINDER, at=(0, 0.2, 0), size=(0.1, 0.1, 0.3), paint=(0.2, 0.7, 0.9, 1), frame="", id=1),
                    marker(Marker.TEXT_VIEW_FACING, at=(0, -0.2, 0.1), size=(0, 0, 0.1), paint=(0.8, 0.5, 0.2, 1), frame="", id=2,
                           text="here"),
                    marker(Marker.LINE_STRIP, size=(0.02, 0, 0), paint=(0.8, 0.5, 0.2, 1), frame="", id=3,
                           points=points([(0, 0, 0), (0, 0.3, 0.3), (0, -0.3, 0.3)]))])]),
        InteractiveMarker(
            header=Header(frame_id="base_link"), pose=pose((0.1, -0.5, 0), (0.3, 0.4, 0.5)), name="c", scale=0.6,
            controls=[InteractiveMarkerControl(
                name="i", orientation=turn(0, 0, 0), orientation_mode=InteractiveMarkerControl.VIEW_FACING,
                interaction_mode=InteractiveMarkerControl.MOVE_PLANE,
                markers=[marker(Marker.CUBE, size=(0.3, 0.15, 0.1), paint=(0.3, 0.9, 0.3, 1), frame="", id=4)],
                independent_marker_orientation=True)])]))
    scene.publish("/im/update", no_update())
