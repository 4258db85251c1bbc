"""The camera's picture: encodings and background colours."""

from ..clouds import cloud, colored_waves, corner_colors, ripples
from ..common import sphere_cube_cylinder
from ..displays import camera_pub, display
from ..scene import LARGE


def cam_background(scene):
    scene.camera(**LARGE)
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"), camera_pub({"Background Color": "40; 90; 160"}))
    scene.publish("/cloud", cloud(ripples(40, 30), rgb=255 * corner_colors(ripples(40, 30)), is_dense=True))


def cam_encoding_bgr8(scene):
    scene.camera(**LARGE)
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"), camera_pub({"Image Encoding": "bgr8"}))
    scene.publish("/cloud", cloud(ripples(40, 30), rgb=255 * corner_colors(ripples(40, 30)), is_dense=True))


def cam_encoding_bgra8(scene):
    scene.show(display("Grid"),
               display("Axes"),
               display("PointCloud2", {"Size (m)": 0.05}),
               display("MarkerArray"),
               camera_pub({"Background Color": "30; 60; 90", "Image Encoding": "bgra8"}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_encoding_mono16(scene):
    scene.show(display("Grid"),
               display("Axes"),
               display("PointCloud2", {"Size (m)": 0.05}),
               display("MarkerArray"),
               camera_pub({"Image Encoding": "mono16"}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_encoding_mono16_background_color(scene):
    scene.show(display("Grid"),
               display("Axes"),
               display("PointCloud2", {"Size (m)": 0.05}),
               display("MarkerArray"),
               camera_pub({"Background Color": "20; 160; 90", "Image Encoding": "mono16"}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_encoding_mono8(scene):
    scene.camera(**LARGE)
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"), camera_pub({"Image Encoding": "mono8"}))
    scene.publish("/cloud", cloud(ripples(40, 30), rgb=255 * corner_colors(ripples(40, 30)), is_dense=True))


def cam_encoding_mono8_background_color(scene):
    scene.show(display("Grid"),
               display("Axes"),
               display("PointCloud2", {"Size (m)": 0.05}),
               display("MarkerArray"),
               camera_pub({"Background Color": "200; 60; 90", "Image Encoding": "mono8"}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_encoding_rgba8(scene):
    scene.camera(**LARGE)
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"), camera_pub({"Image Encoding": "rgba8"}))
    scene.publish("/cloud", cloud(ripples(40, 30), rgb=255 * corner_colors(ripples(40, 30)), is_dense=True))


def cam_portrait_bgr8(scene):
    scene.camera(size=(203, 417), focal=(260, 260))
    scene.show(display("Grid"),
               display("Axes"),
               display("PointCloud2", {"Size (m)": 0.05}),
               display("MarkerArray"),
               camera_pub({"Background Color": "250; 128; 5", "Image Encoding": "bgr8"}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())
