"""The DepthCloud display: a depth image with and without an image of colours."""

import math

from sensor_msgs.msg import RegionOfInterest

from ..displays import display
from ..images import hilly_depth, image, millimetres, ramps, size_ramps, wavy_depth, with_alpha
from ..messages import camera_info
from ..scene import LARGE


def depth_cloud(scene):
    scene.camera(**LARGE)
    scene.frame("depth", at=(-0.8, 0, 1.2), turned=(-2.2142974355881813, 0, -math.pi / 2))
    scene.show(display("DepthCloud", {
        "Color Transformer": "RGB8", "Size (m)": 0.01, "Style": "Flat Squares", "Queue Size": None}))
    scene.publish("/depth/camera_info",
                  camera_info("depth", (320, 240), (300, 300)),
                  camera_info("depth", (320, 240), (300, 300)))
    scene.publish("/color/image", image(size_ramps(320, 240), "rgb8", "depth"))
    scene.publish("/depth/image", image(wavy_depth(320, 240, hole=(100, 150, 60, 90)), "32FC1", "depth"))
    scene.publish("/color/image", image(size_ramps(320, 240), "rgb8", "depth"))
    scene.publish("/depth/image", image(wavy_depth(320, 240, hole=(100, 150, 60, 90)), "32FC1", "depth"))
    scene.publish("/color/image", image(size_ramps(320, 240), "rgb8", "depth"))
    scene.publish("/depth/image", image(wavy_depth(320, 240, hole=(100, 150, 60, 90)), "32FC1", "depth"))


def depth_cloud_16uc1_bgr8_squares(scene):
    scene.frame("depth_cam", at=(1.1, -0.5, 0.7), turned=(-2.0316909851, 0, 1.1441688336680207))
    scene.show(display("DepthCloud", {"Style": "Squares"}))
    scene.publish("/depth/camera_info",
                  camera_info("depth_cam", (64, 48), (60, 60)),
                  camera_info("depth_cam", (64, 48), (60, 60)))
    scene.publish("/color/image", *[image(ramps()[:, :, ::-1], "bgr8")] * 3)
    scene.publish("/depth/image", *[image(millimetres(hilly_depth()), "16UC1")] * 3)


def depth_cloud_binning_and_region_of_interest(scene):
    scene.frame("depth_cam", at=(1.1, -0.5, 0.7), turned=(-2.0316909851, 0, 1.1441688336680207))
    scene.show(display("DepthCloud", {"Color Image Topic": "", "Style": "Flat Squares"}))
    scene.publish("/depth/camera_info",
                  camera_info("depth_cam", (400, 300), (120, 110), centre=(80, 70), binning_x=2, binning_y=2,
                              roi=RegionOfInterest(x_offset=20, y_offset=30, height=96, width=128)),
                  camera_info("depth_cam", (400, 300), (120, 110), centre=(80, 70), binning_x=2, binning_y=2,
                              roi=RegionOfInterest(x_offset=20, y_offset=30, height=96, width=128)))
    scene.publish("/depth/image", *[image(hilly_depth(), "32FC1")] * 3)


def depth_cloud_flat_color(scene):
    scene.frame("depth_cam", at=(1.1, -0.5, 0.7), turned=(-2.0316909851, 0, 1.1441688336680207))
    scene.show(display("DepthCloud", {"Color": "90; 255; 40", "Color Transformer": "FlatColor", "Style": "Flat Squares"}))
    scene.publish("/depth/camera_info",
                  camera_info("depth_cam", (64, 48), (60, 60)),
                  camera_info("depth_cam", (64, 48), (60, 60)))
    scene.publish("/color/image", *[image(ramps(), "rgb8")] * 3)
    scene.publish("/depth/image", *[image(hilly_depth(), "32FC1")] * 3)


def depth_cloud_occlusion_compensation(scene):
    scene.frame("depth_cam", at=(1.1, -0.5, 0.7), turned=(-2.0316909851, 0, 1.1441688336680207))
    scene.show(display("DepthCloud", {
        "Occlusion Compensation": {"Occlusion Time-Out": 300, "Value": True}, "Style": "Flat Squares"}))
    scene.publish("/depth/camera_info",
                  camera_info("depth_cam", (64, 48), (60, 60)),
                  camera_info("depth_cam", (64, 48), (60, 60)))
    scene.publish("/color/image", image(ramps(), "rgb8"), image(ramps(), "rgb8"), image(ramps(), "rgb8"),
                  image(ramps(), "rgb8", secs=1))
    scene.publish("/depth/image", image(hilly_depth(), "32FC1"), image(hilly_depth(), "32FC1"), image(hilly_depth(), "32FC1"),
                  image(hilly_depth(near=(22, 39, 17, 32)), "32FC1", secs=1))


def depth_cloud_points_mono8(scene):
    scene.frame("depth_cam", at=(1.1, -0.5, 0.7), turned=(-2.0316909851, 0, 1.1441688336680207))
    scene.show(display("DepthCloud", {"Size (Pixels)": 3, "Style": "Points"}))
    scene.publish("/depth/camera_info",
                  camera_info("depth_cam", (64, 48), (60, 60)),
                  camera_info("depth_cam", (64, 48), (60, 60)))
    scene.publish("/color/image", *[image(ramps()[:, :, 0], "mono8")] * 3)
    scene.publish("/depth/image", *[image(millimetres(hilly_depth()), "16UC1")] * 3)


def depth_cloud_spheres_fixed_size_rgba8(scene):
    scene.frame("depth_cam", at=(1.1, -0.5, 0.7), turned=(-2.0316909851, 0, 1.1441688336680207))
    scene.show(display("DepthCloud", {
        "Alpha": 0.5, "Auto Size": {"Value": False}, "Color Transformer": "RGB8", "Style": "Spheres"}))
    scene.publish("/depth/camera_info",
                  camera_info("depth_cam", (64, 48), (60, 60)),
                  camera_info("depth_cam", (64, 48), (60, 60)))
    scene.publish("/color/image", *[image(with_alpha(ramps()), "rgba8")] * 3)
    scene.publish("/depth/image", *[image(hilly_depth(), "32FC1")] * 3)


def depth_cloud_without_color_boxes_axis(scene):
    scene.frame("depth_cam", at=(1.1, -0.5, 0.7), turned=(-2.0316909851, 0, 1.1441688336680207))
    scene.show(display("DepthCloud", {
        "Auto Size": {"Auto Size Factor": 0.6, "Value": True}, "Color Image Topic": "", "Color Transformer": "AxisColor",
        "Style": "Boxes"}))
    scene.publish("/depth/camera_info",
                  camera_info("depth_cam", (64, 48), (60, 60)),
                  camera_info("depth_cam", (64, 48), (60, 60)))
    scene.publish("/depth/image", *[image(hilly_depth(), "32FC1")] * 3)
