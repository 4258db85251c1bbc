"""The camera itself: its lens, its place, its clip planes and its frame."""

import math

from ..clouds import cloud, colored_waves, corner_colors, count_colors, ripples, waves
from ..common import sphere_cube_cylinder
from ..displays import camera_pub, display
from ..messages import frame_at, frames
from ..scene import LARGE, family


def cam_and_cloud_frames_on_tf(scene):
    scene.show(display("Grid"), display("PointCloud2", {"Size (m)": 0.06, "Style": "Squares"}))
    scene.publish("/tf", frames(
        frame_at("arm", "base_link", (0.1, 0.2, 0.3), (0.2, 0.3, 0.4)),
        frame_at("hand", "arm", (0, -0.2, 0.1), (0.5, 0, 1))))
    scene.publish("/cloud", cloud(waves(16, 12), "hand", rgb=count_colors(192)))


def cam_default_light_off(scene):
    scene.default_light = False
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_far_plane_cuts_grid(scene):
    scene.camera(eye=(0, 0, 3), target=(10, 3, 0))
    scene.show(display("Grid", {"Alpha": 1, "Cell Size": 5, "Plane Cell Count": 60}))


def cam_fixed_frame_other(scene):
    scene.fixed_frame = "odom"
    scene.camera(**LARGE)
    scene.frame("base_link", parent="odom", at=(2, -1, 0.1), turned=(0, 0, 0.8))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"))
    scene.publish("/cloud", cloud(ripples(40, 30), rgb=255 * corner_colors(ripples(40, 30)), is_dense=True))


def cam_fixed_frame_rotated_sensor(scene):
    scene.fixed_frame = "sensor"
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_near_clip(scene):
    scene.camera(**LARGE)
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"), camera_pub({"Near Clip Distance": 1.9}))
    scene.publish("/cloud", cloud(ripples(40, 30), rgb=255 * corner_colors(ripples(40, 30)), is_dense=True))


def cam_near_clip_5m(scene):
    scene.camera(eye=(4, 3, 3))
    scene.show(display("Grid", {"Plane Cell Count": 40}),
               display("PointCloud2", {
                   "Color": "90; 220; 120", "Color Transformer": "FlatColor", "Size (m)": 0.5, "Style": "Squares"}),
               camera_pub({"Near Clip Distance": 5}))
    scene.publish("/cloud", cloud(waves(12, 10, half_size=(6, 6))))


def cam_near_clip_cuts_meshes_and_points(scene):
    scene.show(display("Grid"),
               display("Axes"),
               display("PointCloud2", {"Size (m)": 0.05}),
               display("MarkerArray"),
               camera_pub({"Near Clip Distance": 2.1}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def cam_only_p_counts(scene):
    scene.camera(focal=(330, 335), centre=(180, 170), K=[500, 0, 100, 0, 600, 50, 0, 0, 1], D=[0.3, -0.2, 0.01, 0.02, 0])
    scene.show(display("Grid"), display("PointCloud2", {"Size (m)": 0.06, "Style": "Squares"}))
    scene.publish("/cloud", colored_waves())


def cam_upside_down(scene):
    scene.camera(roll=math.pi, focal=(350, 350))
    scene.show(display("Grid"), display("MarkerArray"))
    scene.publish("/m", sphere_cube_cylinder())


def cam_width_1281(scene):
    scene.camera(size=(1281, 203), focal=(400, 400))
    scene.show(display("Grid"),
               display("Axes"),
               display("PointCloud2", {"Size (m)": 0.05}),
               display("MarkerArray"),
               camera_pub({"Background Color": "10; 10; 10"}))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def _waves_and_shapes(scene, **camera):
    """The scene of most cameras. camera: options of `Scene.camera`."""
    scene.camera(**camera)
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/m", sphere_cube_cylinder())


def _ripples(scene, **camera):
    """A denser cloud, without shapes."""
    scene.camera(**camera)
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"))
    scene.publish("/cloud", cloud(ripples(40, 30), rgb=255 * corner_colors(ripples(40, 30)), is_dense=True))


family(_waves_and_shapes, {
    "cam_fx_much_larger_than_fy": {"focal": (520, 230)},
    "cam_fy_much_larger_than_fx": {"focal": (220, 500)},
    "cam_long_focal_length": {"eye": (6, 4, 4), "target": (0, 0, 0.2), "focal": (3000, 3000)},
    "cam_looks_straight_down": {"eye": (0, 0.05, 2), "target": (0, 0.05, 0), "focal": (380, 380)},
    "cam_nonsquare_pixels_off_centre_landscape": {"size": (420, 260), "focal": (240, 410), "centre": (300, 40)},
    "cam_nonsquare_pixels_off_centre_portrait": {"size": (260, 380), "focal": (300, 410), "centre": (70, 260)},
    "cam_principal_point_outside_picture": {"target": (0.82, 1.2, 0.6), "focal": (450, 450), "centre": (-250, 520)},
    "cam_short_focal_length": {"eye": (0.5, 0.4, 0.6), "focal": (60, 60)},
    "cam_stereo_offset_rolled_nonsquare": {"roll": 0.7, "focal": (300, 340), "shift": (-60, 45)},
    "cam_tiny_37x23": {"size": (37, 23), "focal": (30, 30)}})

family(_ripples, {
    "cam_nonsquare_pixels": {"size": (640, 480), "focal": (500, 380)},
    "cam_odd_size": {"size": (333, 257), "focal": (300, 300)},
    "cam_principal_point": {"size": (640, 400), "focal": (950, 950), "centre": (320, 375)},
    "cam_roll": {"eye": (1.2, -1.3, 1.4), "target": (0, 0, 0.1), "roll": 0.7, "size": (640, 480), "focal": (500, 500)},
    "cam_stereo_offset": {"size": (640, 480), "focal": (500, 500), "shift": (-60, 25)}})
