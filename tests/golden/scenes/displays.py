"""The displays of a scene's config, with rviz's own keys.

What a display says in most scenes is in `USUAL`; a scene gives the rest. Whatever is in neither has rviz's default.
"""

import copy

CAMERA_CLASS = "rviz_camera_stream/CameraPub"
CAMERA_INFO_TOPIC = "/proj_view/camera_info"
IMAGE_TOPIC = "/proj_view/image"

USUAL: dict = {
    CAMERA_CLASS: {
        "Name": "CameraPub", "Background Color": "0; 0; 0", "Camera Info Topic": CAMERA_INFO_TOPIC, "Display namespace": "",
        "Frame Rate": -1, "Image Encoding": "rgb8", "Image Topic": IMAGE_TOPIC, "Near Clip Distance": 0.01, "Queue Size": 2},
    "rviz/Axes": {"Name": "Axes"},
    "rviz/DepthCloud": {
        "Name": "d", "Color Image Topic": "/color/image", "Color Transport Hint": "raw", "Depth Map Topic": "/depth/image",
        "Depth Map Transport Hint": "raw", "Topic Filter": False, "Queue Size": 5, "Size (m)": 0.02, "Alpha": 1,
        "Decay Time": 0, "Auto Size": {"Auto Size Factor": 1, "Value": True}, "Occlusion Compensation": {"Value": False}},
    "rviz/Effort": {"Name": "E", "Topic": "/joint_states"},
    "rviz/Grid": {"Name": "Grid"},
    "rviz/GridCells": {"Name": "g", "Topic": "/g"},
    "rviz/InteractiveMarkers": {
        "Name": "I", "Update Topic": "/im/update", "Enable Transparency": True, "Show Axes": False,
        "Show Descriptions": True, "Show Visual Aids": False},
    "rviz/LaserScan": {"Name": "l", "Topic": "/l"},
    "rviz/Map": {"Name": "m", "Topic": "/map", "Color Scheme": "map"},
    "rviz/Marker": {"Name": "K", "Marker Topic": "/vm"},
    "rviz/MarkerArray": {"Name": "M", "Marker Topic": "/m"},
    "rviz/Odometry": {"Name": "o", "Topic": "/o"},
    "rviz/Path": {"Name": "p", "Topic": "/p"},
    "rviz/PointCloud": {"Name": "c", "Topic": "/c"},
    "rviz/PointCloud2": {
        "Name": "c", "Topic": "/cloud", "Alpha": 1, "Color": "255; 255; 255", "Color Transformer": "RGB8", "Decay Time": 0,
        "Position Transformer": "XYZ", "Queue Size": 10, "Size (Pixels)": 3, "Size (m)": 0.03, "Style": "Flat Squares",
        "Use Fixed Frame": True, "Use rainbow": True},
    "rviz/Pose": {"Name": "p", "Topic": "/p"},
    "rviz/PoseWithCovariance": {
        "Name": "p", "Topic": "/p", "Head Length": 0.15, "Head Radius": 0.1, "Shaft Length": 0.4, "Shaft Radius": 0.04},
    "rviz/RobotModel": {"Name": "R"},
    "rviz/TF": {"Name": "TF"},
}


def display(kind, properties=None, **more):
    """A display of the config.

    kind: rviz's class, without `rviz/` if it is one of rviz's own.
    properties: rviz's keys and values beside those of `USUAL`; None as a value leaves out a usual one.
    more: `name`, `topic`, for short.
    """
    kind = kind if "/" in kind else f"rviz/{kind}"
    found = {"Class": kind, "Enabled": True, "Value": True, **copy.deepcopy(USUAL.get(kind, {})),
             **{key.capitalize(): value for key, value in more.items()}, **(properties or {})}
    found["Value"] = found["Enabled"]
    return {key: value for key, value in found.items() if value is not None}


def camera_pub(properties=None, **more):
    """The CameraPub display, which publishes the picture."""
    return display(CAMERA_CLASS, properties, **more)


def group(name, *displays, enabled=True):
    """A group of displays."""
    return {"Class": "rviz/Group", "Name": name, "Enabled": enabled, "Value": enabled, "Displays": list(displays)}


def all_visible(displays):
    """The Visibility of a CameraPub that draws every display."""
    visible = {"Value": True}
    for each in displays:
        if each["Class"] == "rviz/Group":
            visible[each["Name"]] = all_visible(each["Displays"])
        elif each["Class"] != CAMERA_CLASS:
            visible[each["Name"]] = True
    return visible


def cameras(displays):
    """All CameraPub displays, those in groups included."""
    found = []
    for each in displays:
        if each["Class"] == CAMERA_CLASS:
            found.append(each)
        found += cameras(each.get("Displays", []))
    return found
