"""The Axes display."""

from ..displays import display
from ..scene import LARGE


def axes(scene):
    scene.camera(**LARGE)
    scene.frame("sensor", at=(0.4, -0.5, 0.3), turned=(0.5, 0.4, 0.3))
    scene.show(display("Axes", {"Length": 0.8, "Radius": 0.08}, name="A"),
               display("Axes", {"Length": 0.5, "Radius": 0.02, "Reference Frame": "sensor"}, name="B"))


def axes_camera_inside(scene):
    scene.camera(eye=(0.9, 0.8, 0.7), target=(0, 0, 0))
    scene.show(display("Axes", {"Length": 3, "Radius": 0.3}, name="A"))


def axes_defaults_close_up(scene):
    scene.show(display("Axes", name="A"))


def axes_rotated_frames_rolled_camera(scene):
    scene.camera(roll=0.8)
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.frame("b", parent="sensor", at=(0.2, 0.2, 0.2), turned=(-2.1415926535897936, 1.1415926535897938, -0.141592653589793))
    scene.show(display("Axes", {"Length": 0.5, "Radius": 0.05, "Reference Frame": "sensor"}, name="A"),
               display("Axes", {"Length": 0.3, "Radius": 0.02, "Reference Frame": "b"}, name="B"))


def axes_translucent_thin_and_thick(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("Axes", {"Alpha": 0.5, "Length": 0.9, "Radius": 0.03}, name="A"),
               display("Axes", {"Alpha": 0.3, "Length": 0.4, "Radius": 0.15, "Reference Frame": "sensor"}, name="B"))
