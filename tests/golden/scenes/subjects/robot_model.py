"""The RobotModel display."""

from ..common import arm_frames, lamp_frames
from ..displays import display


def robot_model(scene):
    scene.camera(eye=(1.7, 1.2, 1.2), target=(0, 0, 0.4), size=(640, 480), focal=(500, 500))
    lamp_frames(scene)
    scene.show(display("RobotModel", {
        "Alpha": 1, "Collision Enabled": False, "Robot Description": "robot_description", "Visual Enabled": True}))


def robot_model_all_links_off_one_on(scene):
    scene.camera(focal=(330, 330))
    arm_frames(scene)
    scene.show(display("RobotModel", {"Links": {
        "All Links Enabled": False, "Link Tree Style": "Links in Alphabetic Order",
        "lower": {"Alpha": 1, "Show Axes": True, "Value": True}, "shoulder": {"Alpha": 0.3, "Show Axes": True}}}))


def robot_model_alpha(scene):
    scene.camera(eye=(1.7, 1.2, 1.2), target=(0, 0, 0.4), size=(640, 480), focal=(500, 500))
    lamp_frames(scene)
    scene.show(display("Grid"), display("RobotModel", {
        "Alpha": 0.4, "Robot Description": "robot_description", "Visual Enabled": True}))


def robot_model_collision_only(scene):
    scene.camera(focal=(330, 330))
    arm_frames(scene)
    scene.show(display("RobotModel", {"Collision Enabled": True, "Visual Enabled": False}))


def robot_model_link_frames_missing(scene):
    scene.camera(focal=(330, 330))
    scene.frame("shoulder", at=(0, -0.3, 0.1), turned=(0, 0, 0.5))
    scene.frame("upper", parent="shoulder", at=(0, 0, 0.15), turned=(0, -0.7, 0))
    scene.frame("lower", parent="upper", at=(0.5, 0, 0), turned=(0.3, 1.1, 0))
    scene.show(display("RobotModel", {"Alpha": 0.5}))


def robot_model_link_options(scene):
    scene.camera(focal=(330, 330))
    arm_frames(scene)
    scene.show(display("RobotModel", {"Links": {
        "All Links Enabled": True, "Expand Joint Details": False, "Expand Link Details": False, "Expand Tree": False,
        "Link Tree Style": "Links in Alphabetic Order",
        "hand": {"Alpha": 1, "Show Axes": False, "Show Trail": True, "Value": True},
        "root": {"Alpha": 1, "Show Axes": True, "Show Trail": False},
        "shoulder": {"Alpha": 0.4, "Show Axes": True, "Show Trail": False, "Value": True},
        "upper": {"Alpha": 1, "Show Axes": True, "Show Trail": False, "Value": False}}}))


def robot_model_materials(scene):
    scene.camera(focal=(330, 330))
    for name in ("base", "a", "b", "c", "d", "e", "f"):
        scene.frame(name, turned=(0, 0, 0.2))
    scene.show(display("RobotModel"))


def robot_model_materials_alpha(scene):
    scene.camera(focal=(330, 330))
    for name in ("base", "a", "b", "c", "d", "e", "f"):
        scene.frame(name, turned=(0, 0, 0.2))
    scene.show(display("Grid", {"Alpha": 1}), display("RobotModel", {"Alpha": 0.6}))


def robot_model_missing_mesh_negative_scale(scene):
    scene.camera(focal=(330, 330))
    arm_frames(scene)
    scene.show(display("RobotModel"))


def robot_model_tf_prefix(scene):
    scene.camera(focal=(330, 330))
    scene.frame("r1/shoulder", at=(0, -0.3, 0.1), turned=(0, 0, 0.5))
    scene.frame("r1/upper", parent="r1/shoulder", at=(0, 0, 0.15), turned=(0, -0.7, 0))
    scene.frame("r1/lower", parent="r1/upper", at=(0.5, 0, 0), turned=(0.3, 1.1, 0))
    scene.frame("r1/hand", parent="r1/lower", at=(0.4, 0, 0), turned=(0.5, 0.2, 0.1))
    scene.frame("r1/root")
    scene.show(display("RobotModel", {"TF Prefix": "r1"}))


def robot_model_visual_collision_alpha(scene):
    scene.camera(focal=(330, 330))
    arm_frames(scene)
    scene.show(display("RobotModel", {"Alpha": 0.5, "Collision Enabled": True}))
