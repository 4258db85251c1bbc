"""The TF display."""

from rosgraph_msgs.msg import Clock

from ..common import arm_frame, cart_frame
from ..displays import display
from ..messages import frame_at, frames, time_at
from ..scene import LARGE


def tf_arrows_far_near_and_below_1mm(scene):
    scene.camera(eye=(0.5, 0.9, 0.7), target=(0.2, 0.5, 0.4))
    scene.frame("sensor", at=(0.3, -0.2, 0.25), turned=(0.4, -0.5, 1.1))
    scene.frame("lens", parent="sensor", at=(0.25, 0, 0.1), turned=(0, 0.8, 0.2))
    scene.frame("same as lens", parent="lens")
    scene.frame("near", at=(-0.3, 0.4, 0.05), turned=(0, 0, 2))
    scene.frame("nearer", parent="near", at=(0.03, 0.04, 0))
    scene.frame("touching", parent="nearer", at=(0, 0, 0.0005))
    scene.frame("base_link", parent="map", at=(-0.5, -0.4, 0.2), turned=(0.2, 0, 0.3))
    scene.show(display("TF", {"Frame Timeout": 1000, "Marker Scale": 1.3, "Show Axes": False, "Show Names": False}))


def tf_axes_marker_alpha_and_scale(scene):
    scene.frame("sensor", at=(0.3, -0.2, 0.25), turned=(0.4, -0.5, 1.1))
    scene.frame("lens", parent="sensor", at=(0.25, 0, 0.1), turned=(0, 0.8, 0.2))
    scene.frame("same as lens", parent="lens")
    scene.frame("near", at=(-0.3, 0.4, 0.05), turned=(0, 0, 2))
    scene.frame("nearer", parent="near", at=(0.03, 0.04, 0))
    scene.frame("touching", parent="nearer", at=(0, 0, 0.0005))
    scene.frame("base_link", parent="map", at=(-0.5, -0.4, 0.2), turned=(0.2, 0, 0.3))
    scene.show(display("TF", {
        "Frame Timeout": 1000, "Marker Alpha": 0.4, "Marker Scale": 1.5, "Show Arrows": False, "Show Names": False}))


def tf_default(scene):
    scene.camera(**LARGE)
    scene.frame("torso", at=(0, 0, 0.4), turned=(0, 0, 0.4))
    scene.frame("head", parent="torso", at=(0.2, 0, 0.5), turned=(0, 0.5, 0))
    scene.frame("arm", parent="torso", at=(0.3, -0.4, 0), turned=(1, 0, 0.2))
    scene.show(display("TF", {
        "Frame Timeout": 1000, "Marker Scale": 1, "Show Arrows": True, "Show Axes": True, "Show Names": True}))


def tf_frames_as_plain_values(scene):
    scene.frame("sensor", at=(0.3, -0.2, 0.25), turned=(0.4, -0.5, 1.1))
    scene.frame("lens", parent="sensor", at=(0.25, 0, 0.1), turned=(0, 0.8, 0.2))
    scene.frame("near", at=(-0.3, 0.4, 0.05), turned=(0, 0, 2))
    scene.frame("base_link", parent="map", at=(-0.5, -0.4, 0.2), turned=(0.2, 0, 0.3))
    scene.show(display("TF", {"Frame Timeout": 1000, "Frames": {"All Enabled": True, "lens": {}, "near": True, "sensor": False}}))


def tf_frames_fading(scene):
    scene.frame("post", at=(-0.4, -0.2, 0.1))
    scene.frame("hand", parent="arm", at=(0.1, 0.1, 0.1))
    scene.show(display("TF", {"Frame Timeout": 9, "Marker Alpha": 0.8}))
    scene.publish("/clock", Clock(clock=time_at()))
    scene.publish("/tf", cart_frame(), arm_frame())
    scene.publish("/clock", Clock(clock=time_at(7.5)), secs=7.5)


def tf_frames_off(scene):
    scene.frame("sensor", at=(0.3, -0.2, 0.25), turned=(0.4, -0.5, 1.1))
    scene.frame("lens", parent="sensor", at=(0.25, 0, 0.1), turned=(0, 0.8, 0.2))
    scene.frame("same as lens", parent="lens")
    scene.frame("near", at=(-0.3, 0.4, 0.05), turned=(0, 0, 2))
    scene.frame("nearer", parent="near", at=(0.03, 0.04, 0))
    scene.frame("base_link", parent="map", at=(-0.5, -0.4, 0.2), turned=(0.2, 0, 0.3))
    scene.show(display("TF", {"Frame Timeout": 1000, "Frames": {
        "All Enabled": False, "base_link": {"Value": False}, "near": {"Value": True}, "sensor": {"Value": False}}}))


def tf_frames_on_their_way_to_grey(scene):
    scene.frame("post", at=(-0.4, -0.2, 0.1))
    scene.frame("hand", parent="arm", at=(0.1, 0.1, 0.1))
    scene.show(display("TF", {"Frame Timeout": 9, "Marker Alpha": 0.8}))
    scene.publish("/clock", Clock(clock=time_at()))
    scene.publish("/tf", cart_frame(), arm_frame())
    scene.publish("/clock", Clock(clock=time_at(4.5)), secs=4.5)


def tf_frames_past_timeout(scene):
    scene.frame("post", at=(-0.4, -0.2, 0.1))
    scene.frame("hand", parent="arm", at=(0.1, 0.1, 0.1))
    scene.show(display("TF", {"Frame Timeout": 9}))
    scene.publish("/clock", Clock(clock=time_at()))
    scene.publish("/tf", cart_frame(), arm_frame())
    scene.publish("/clock", Clock(clock=time_at(9.5)), secs=9.5)


def tf_moving_frames_update_interval(scene):
    scene.frame("post", at=(-0.4, -0.2, 0.1))
    scene.show(display("TF", {"Frame Timeout": 1000, "Update Interval": 0.3}))
    scene.publish("/tf",
                  frames(frame_at("cart", "base_link", (0.9, 0.1, 0.2), (0, 0, 1), secs=-2)),
                  frames(frame_at("cart", "base_link", (0.5, 0.3, 0.2), (0, 0, 2), secs=-1)),
                  frames(frame_at("arm", "cart", (0.2, 0, 0.3), (0, 1, 0), secs=-2)),
                  frames(frame_at("arm", "cart", (0.3, -0.2, 0.2), (0, 0.5, 0), secs=-1.5)))


def tf_names_only(scene):
    scene.camera(roll=0.3)
    scene.frame("a frame", at=(0.3, -0.5, 0.3))
    scene.frame("größe/2", at=(-0.6, 0.1, 0.6), turned=(1, 1, 1))
    scene.show(display("TF", {"Frame Timeout": 1000, "Marker Scale": 2, "Show Arrows": False, "Show Axes": False}))


def tf_negative_marker_scale(scene):
    scene.frame("sensor", at=(0.3, -0.2, 0.25), turned=(0.4, -0.5, 1.1))
    scene.frame("lens", parent="sensor", at=(0.25, 0, 0.1), turned=(0, 0.8, 0.2))
    scene.show(display("TF", {"Frame Timeout": 1000, "Marker Scale": -1}))


def tf_two_trees(scene):
    scene.frame("sensor", at=(0.3, -0.2, 0.25), turned=(0.4, -0.5, 1.1))
    scene.frame("lens", parent="sensor", at=(0.25, 0, 0.1), turned=(0, 0.8, 0.2))
    scene.frame("same as lens", parent="lens")
    scene.frame("near", at=(-0.3, 0.4, 0.05), turned=(0, 0, 2))
    scene.frame("nearer", parent="near", at=(0.03, 0.04, 0))
    scene.frame("touching", parent="nearer", at=(0, 0, 0.0005))
    scene.frame("base_link", parent="map", at=(-0.5, -0.4, 0.2), turned=(0.2, 0, 0.3))
    scene.frame("moon", parent="other", at=(0.4, 0.4, 0.4))
    scene.show(display("TF", {"Frame Timeout": 1000, "Marker Scale": 1.2, "Show Names": False}))
