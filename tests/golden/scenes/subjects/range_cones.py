"""The Range display."""

import math

from sensor_msgs.msg import Range

from ..displays import display
from ..messages import header


def range(scene):
    scene.camera(eye=(1.6, 1.4, 1), target=(0.5, 0, 0), size=(640, 480), focal=(500, 500))
    scene.show(display("Range", {"Alpha": 0.5, "Color": "255; 255; 255"}, name="r", topic="/r"))
    scene.publish("/r", Range(header=header(), field_of_view=0.5, min_range=0.1, max_range=3, range=1.2))


def range_last_three_of_four(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.frame("other", at=(-0.5, 0.4, 0.2), turned=(0, 0.2, -0.7))
    scene.show(display("Range", {"Alpha": 0.4, "Buffer Length": 3, "Color": "255; 160; 0"}, name="r", topic="/r"))
    scene.publish("/r",
                  Range(header=header(), field_of_view=0.5, min_range=0.1, max_range=3, range=1.5),
                  Range(header=header("sensor"), field_of_view=0.3, min_range=0.1, max_range=3, range=0.8),
                  Range(header=header("other"), field_of_view=1.2, min_range=0.1, max_range=3, range=0.9),
                  Range(header=header(), field_of_view=0.2, min_range=0.1, max_range=3, range=0.6))


def range_out_of_limits_and_infinite(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.frame("other", at=(-0.5, 0.4, 0.2), turned=(0, 0.2, -0.7))
    scene.show(display("Range", {"Alpha": 1, "Color": "255; 0; 0"}, name="r0", topic="/r0"),
               display("Range", {"Alpha": 1, "Color": "0; 255; 0"}, name="r1", topic="/r1"),
               display("Range", {"Alpha": 1, "Color": "0; 0; 255"}, name="r2", topic="/r2"),
               display("Range", {"Alpha": 1, "Color": "255; 255; 255"}, name="r3", topic="/r3"))
    scene.publish("/r0", Range(header=header(), field_of_view=0.5, min_range=0.1, max_range=3, range=3.5))
    scene.publish("/r1", Range(header=header("sensor"), field_of_view=0.4, min_range=0.7, max_range=0.7, range=-math.inf))
    scene.publish("/r2", Range(header=header(), field_of_view=0.4, min_range=0.9, max_range=0.9, range=math.inf))
    scene.publish("/r3", Range(header=header("other"), field_of_view=0.5, min_range=0.1, max_range=3, range=0.1))
