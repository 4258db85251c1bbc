"""Interactive markers of the scenes, and their server's messages."""

from std_msgs.msg import Header
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerControl, InteractiveMarkerInit, InteractiveMarkerUpdate

from .geometry import pose

# A scene's tools, of which the first is the current one.
INTERACT = [{"Class": "rviz/Interact", "Hide Inactive Objects": True}, {"Class": "rviz/MoveCamera"}]

# What a control does, and how it is turned.
NONE, MENU, BUTTON, MOVE_AXIS, MOVE_PLANE, ROTATE_AXIS, MOVE_ROTATE, MOVE_3D, ROTATE_3D, MOVE_ROTATE_3D = range(10)
INHERIT, FIXED, VIEW_FACING = range(3)


def control(name, mode=NONE, turned=(0.0, 0.0, 0.0), **fields):
    """An InteractiveMarkerControl. fields: those of the message."""
    return InteractiveMarkerControl(name=name, interaction_mode=mode, orientation=pose(turned=turned).orientation, **fields)


def interactive(name, at, turned=(0.0, 0.0, 0.0), description="", scale=0.6, frame="base_link", **fields):
    """An InteractiveMarker whose stamp is 0. fields: those of the message, such as `controls`."""
    fields = {"header": Header(frame_id=frame), **fields}
    return InteractiveMarker(name=name, pose=pose(at, turned), description=description, scale=scale, **fields)


def whole_state(server, number, *markers):
    """The InteractiveMarkerInit of a server: all its markers."""
    return InteractiveMarkerInit(server_id=server, seq_num=number, markers=list(markers))


def update(server, number, **fields):
    """An InteractiveMarkerUpdate, which keeps a connection alive if its `type` is not 1."""
    return InteractiveMarkerUpdate(server_id=server, seq_num=number, **fields)


def no_update():
    """The first update of the server `/s`, which keeps its connection alive."""
    return update("/s", 1)


def serve(scene, *markers):
    """Publishes the markers of the server `/s`."""
    scene.publish("/im/update_full", whole_state("/s", 1, *markers))
    scene.publish("/im/update", no_update())
