"""The camera itself: its lens, its place, its clip planes and its frame."""

import math

from ..clouds import cloud, corner_colors, count_colors, packed, ripples, waves
from ..common import sphere_cube_cylinder
from ..displays import camera_pub, display
from ..messages import frame_at, frames


def cam_and_cloud_frames_on_tf(scene):
    scene.show(display("Grid"), display("PointCloud2", {"Size (m)": 0.06, "Style": "Squares"}))
    scene.publish("/tf", frames(
        frame_at("arm", "base_link", (0.1, 0.2, 0.3), (0.2, 0.3, 0.4)),
        frame_at("hand", "arm", (0, -0.2, 0.1), (0.5, 0, 1))))
    scene.publish("/cloud", cloud(waves(16, 12), "hand", fields=[("rgb", "rgb", packed(count_colors(192)))]))


def cam_default_light_off(scene):
    scene.default_light = False
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


def cam_far_plane_cuts_grid(scene):
    scene.camera(eye=(0, 0, 3), target=(10, 3, 0))
    scene.show(display("Grid", {"Alpha": 1, "Cell Size": 5, "Plane Cell Count": 60}))


def cam_fixed_frame_other(scene):
    scene.fixed_frame = "odom"
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.frame("base_link", parent="odom", at=(2, -1, 0.1), turned=(0, 0, 0.8))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"))
    scene.publish("/cloud", cloud(
        ripples(40, 30), fields=[("rgb", "rgb", packed(255 * corner_colors(ripples(40, 30))))], is_dense=True))


def cam_fixed_frame_rotated_sensor(scene):
    scene.fixed_frame = "sensor"
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


def cam_fx_much_larger_than_fy(scene):
    scene.camera(focal=(520, 230))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


def cam_fy_much_larger_than_fx(scene):
    scene.camera(focal=(220, 500))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


def cam_long_focal_length(scene):
    scene.camera(eye=(6, 4, 4), target=(0, 0, 0.2), focal=(3000, 3000))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


def cam_looks_straight_down(scene):
    scene.camera(eye=(0, 0.05, 2), target=(0, 0.05, 0), focal=(380, 380))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


def cam_near_clip(scene):
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"), camera_pub({"Near Clip Distance": 1.9}))
    scene.publish("/cloud", cloud(
        ripples(40, 30), fields=[("rgb", "rgb", packed(255 * corner_colors(ripples(40, 30))))], is_dense=True))


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
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


def cam_nonsquare_pixels(scene):
    scene.camera(size=(640, 480), focal=(500, 380))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"))
    scene.publish("/cloud", cloud(
        ripples(40, 30), fields=[("rgb", "rgb", packed(255 * corner_colors(ripples(40, 30))))], is_dense=True))


def cam_nonsquare_pixels_off_centre_landscape(scene):
    scene.camera(size=(420, 260), focal=(240, 410), centre=(300, 40))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


def cam_nonsquare_pixels_off_centre_portrait(scene):
    scene.camera(size=(260, 380), focal=(300, 410), centre=(70, 260))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


def cam_odd_size(scene):
    scene.camera(size=(333, 257), focal=(300, 300))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"))
    scene.publish("/cloud", cloud(
        ripples(40, 30), fields=[("rgb", "rgb", packed(255 * corner_colors(ripples(40, 30))))], is_dense=True))


def cam_only_p_counts(scene):
    scene.camera(focal=(330, 335), centre=(180, 170), K=[500, 0, 100, 0, 600, 50, 0, 0, 1], D=[0.3, -0.2, 0.01, 0.02, 0])
    scene.show(display("Grid"), display("PointCloud2", {"Size (m)": 0.06, "Style": "Squares"}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))


def cam_principal_point(scene):
    scene.camera(size=(640, 400), focal=(950, 950), centre=(320, 375))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"))
    scene.publish("/cloud", cloud(
        ripples(40, 30), fields=[("rgb", "rgb", packed(255 * corner_colors(ripples(40, 30))))], is_dense=True))


def cam_principal_point_outside_picture(scene):
    scene.camera(target=(0.82, 1.2, 0.6), focal=(450, 450), centre=(-250, 520))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


def cam_roll(scene):
    scene.camera(eye=(1.2, -1.3, 1.4), target=(0, 0, 0.1), roll=0.7, size=(640, 480), focal=(500, 500))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"))
    scene.publish("/cloud", cloud(
        ripples(40, 30), fields=[("rgb", "rgb", packed(255 * corner_colors(ripples(40, 30))))], is_dense=True))


def cam_short_focal_length(scene):
    scene.camera(eye=(0.5, 0.4, 0.6), focal=(60, 60))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


def cam_stereo_offset(scene):
    scene.camera(size=(640, 480), focal=(500, 500), shift=(-60, 25))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2"))
    scene.publish("/cloud", cloud(
        ripples(40, 30), fields=[("rgb", "rgb", packed(255 * corner_colors(ripples(40, 30))))], is_dense=True))


def cam_stereo_offset_rolled_nonsquare(scene):
    scene.camera(roll=0.7, focal=(300, 340), shift=(-60, 45))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


def cam_tiny_37x23(scene):
    scene.camera(size=(37, 23), focal=(30, 30))
    scene.show(display("Grid"), display("Axes"), display("PointCloud2", {"Size (m)": 0.05}), display("MarkerArray"))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())


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
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))
    scene.publish("/m", sphere_cube_cylinder())
