"""Accelerations, twists and wrenches: AccelStamped, TwistStamped, WrenchStamped."""

import math

from ..displays import display
from ..messages import accel_stamped, twist_stamped, wrench_stamped
from ..scene import LARGE


def accel(scene):
    scene.camera(**LARGE)
    scene.frame("sensor", at=(-0.3, 0, 0.2), turned=(0.1, 0.2, 0.3))
    scene.show(display("AccelStamped",
                       {"Alpha": 1, "Angular Arrow Scale": 0.6, "Arrow Width": 0.15, "History Length": 1,
                        "Linear Arrow Scale": 0.6}, name="t", topic="/t"))
    scene.publish("/t", accel_stamped((0.5, 0.6, 0.1), (0, 0.7, 0.3), frame="sensor"))


def accel_lengths_shown_and_hidden(scene):
    scene.frame("sensor", at=(0.3, -0.2, 0.25), turned=(0.4, -0.5, 1.1))
    scene.show(display("AccelStamped", {"Angular Arrow Scale": 0.5, "Arrow Width": 0.2, "Linear Arrow Scale": 0.5}, name="a",
                       topic="/a"),
               display("AccelStamped", {"Angular Arrow Scale": 0.5, "Arrow Width": 0.2, "Linear Arrow Scale": 0.5}, name="b",
                       topic="/b"),
               display("AccelStamped", {"Angular Arrow Scale": 1, "Arrow Width": 0.5, "Linear Arrow Scale": 1}, name="c",
                       topic="/c"))
    scene.publish("/a", accel_stamped((0.3, 0, 0), (0, 1.2, 0)))
    scene.publish("/b", accel_stamped((1, 0.5, 0.5), (0.1, 0, 0.3), frame="sensor"))
    scene.publish("/c", accel_stamped((0, -0.5, 0), (-0.52, 0, 0)))


def twist_defaults(scene):
    scene.camera(eye=(2.2, 1.5, 1.6))
    scene.show(display("TwistStamped", name="t", topic="/t"))
    scene.publish("/t", twist_stamped((0.3, 0.2, 0.1), (-0.2, 0.35, 0.2)))


def twist_history_length_3_translucent(scene):
    scene.frame("sensor", at=(0.3, -0.2, 0.25), turned=(0.4, -0.5, 1.1))
    scene.show(display("TwistStamped",
                       {"Alpha": 0.5, "Angular Arrow Scale": 0.4, "Arrow Width": 0.15, "History Length": 3,
                        "Linear Arrow Scale": 0.4}, name="t", topic="/t"))
    scene.publish("/t",
                  twist_stamped((0, 0, 1.5), (1, 1, 0)),
                  twist_stamped((1.3, 0, 0.2), (0, 0, 1.4)),
                  twist_stamped((0, -1.3, 0.2), (1.4, 0, 0.1), frame="sensor"),
                  twist_stamped((-1, 0.4, 0.2), (0, 1, 1)))


def twist_nan_and_unknown_frame_ignored(scene):
    scene.show(display(
        "TwistStamped", {"Angular Arrow Scale": 0.5, "Arrow Width": 0.2, "Linear Arrow Scale": 0.5}, name="t", topic="/t"))
    scene.publish("/t",
                  twist_stamped((1, 0.5, 0.5), (0.1, 1, 0.3)),
                  twist_stamped((math.nan, 0.5, 0.5), (0.1, 1, 0.3)),
                  twist_stamped((0, 0, 1), (0.1, math.inf, 0.3)),
                  twist_stamped((0, 1, 1), (1, 0, 0), frame="nowhere"))


def wrench(scene):
    scene.camera(**LARGE)
    scene.frame("sensor", at=(-0.3, 0, 0.2), turned=(0.1, 0.2, 0.3))
    scene.show(display("WrenchStamped",
                       {"Alpha": 1, "Arrow Width": 0.15, "Force Arrow Scale": 0.6, "Force Color": "204; 51; 51",
                        "History Length": 1, "Torque Arrow Scale": 0.6, "Torque Color": "204; 204; 51"}, name="w", topic="/w"))
    scene.publish("/w", wrench_stamped((1, 0.5, 0.3), (0.2, -0.4, 0.8), frame="sensor"))


def wrench_along_and_against_z(scene):
    scene.frame("up", at=(-0.3, 0.3, 0.5), turned=(0, 0, 1))
    scene.frame("sensor", at=(0.3, -0.3, 0))
    scene.show(display("WrenchStamped", {"Arrow Width": 0.15, "Force Arrow Scale": 0.4, "Torque Arrow Scale": 0.4}, name="w",
                       topic="/w"),
               display("WrenchStamped",
                       {"Arrow Width": 0.1, "Force Arrow Scale": 0.4, "Force Color": "0; 255; 0", "Torque Arrow Scale": 0.4},
                       name="v", topic="/v"))
    scene.publish("/w", wrench_stamped((0, 0, -1.4), (1.3, 0, 0), frame="up"))
    scene.publish("/v", wrench_stamped((0, -1.2, 0), (0, 0, -1.6), frame="sensor"))


def wrench_along_z(scene):
    scene.frame("sensor", at=(0.3, -0.3, 0))
    scene.show(display("WrenchStamped", {"Arrow Width": 0.15, "Force Arrow Scale": 0.4, "Torque Arrow Scale": 0.4}, name="w",
                       topic="/w"),
               display("WrenchStamped", {"Arrow Width": 0.15, "Force Arrow Scale": 0.4, "Torque Arrow Scale": 0.4}, name="v",
                       topic="/v"))
    scene.publish("/w", wrench_stamped((0, 0, 1.4), (0, 1.3, 0)))
    scene.publish("/v", wrench_stamped((0, -1.2, 0), (0, 0, 1.6), frame="sensor"))


def wrench_negative_scale_and_width(scene):
    scene.frame("sensor", at=(0.3, -0.2, 0.25), turned=(0.4, -0.5, 1.1))
    scene.show(display("WrenchStamped", {"Arrow Width": -0.1, "Force Arrow Scale": -0.5, "Torque Arrow Scale": 0.5}, name="w",
                       topic="/w"),
               display("WrenchStamped", {"Arrow Width": -0.4, "Force Arrow Scale": 0.5, "Torque Arrow Scale": -0.5}, name="v",
                       topic="/v"))
    scene.publish("/w", wrench_stamped((0.1, 0.1, 0), (0.4, 0.8, 0.4)))
    scene.publish("/v", wrench_stamped((0, 0.8, 0), (0.3, 0.3, 0.5), frame="sensor"))


def wrench_turned_frames_other_colors(scene):
    scene.frame("sensor", at=(0.3, -0.2, 0.25), turned=(0.4, -0.5, 1.1))
    scene.show(display("WrenchStamped",
                       {"Arrow Width": 0.12, "Force Arrow Scale": 0.5, "Force Color": "20; 200; 255", "Torque Arrow Scale": 0.4,
                        "Torque Color": "255; 120; 0"}, name="w", topic="/w"),
               display("WrenchStamped", {"Arrow Width": 0.2, "Force Arrow Scale": 0.3, "Torque Arrow Scale": 0.5}, name="v",
                       topic="/v"))
    scene.publish("/w", wrench_stamped((1, 0.4, 0.3), (0.2, 0.9, 0.4), frame="sensor"))
    scene.publish("/v", wrench_stamped((-1.2, 0.3, 0.8), (-0.3, -0.8, 0.9)))
