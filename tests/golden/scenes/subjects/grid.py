"""The Grid display."""

from ..displays import camera_pub, display
from ..scene import LARGE


def grid_billboards_other_frame(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("Grid", {
        "Alpha": 1, "Cell Size": 0.2, "Line Style": {"Line Width": 0.015, "Value": "Billboards"}, "Plane Cell Count": 6,
        "Reference Frame": "sensor"}))


def grid_billboards_translucent_crossing(scene):
    scene.show(display("Grid", {
        "Alpha": 0.4, "Cell Size": 0.4, "Color": "255; 120; 40", "Line Style": {"Line Width": 0.08, "Value": "Billboards"},
        "Plane Cell Count": 4}))


def grid_billboards_xz(scene):
    scene.camera(**LARGE)
    scene.show(display("Grid", {
        "Alpha": 0.8, "Cell Size": 0.4, "Color": "200; 120; 60", "Line Style": {"Line Width": 0.03, "Value": "Billboards"},
        "Normal Cell Count": 0, "Offset": {"X": 0.2, "Y": -0.3, "Z": 0.1}, "Plane": "XZ", "Plane Cell Count": 6}))


def grid_dark_over_bright_background(scene):
    scene.show(display("Grid", {"Alpha": 0.7, "Cell Size": 0.4, "Color": "20; 30; 60", "Plane Cell Count": 8}),
               camera_pub({"Background Color": "255; 250; 230"}))


def grid_default(scene):
    scene.camera(**LARGE)
    scene.show(display("Grid"))


def grid_grazing_rolled_camera(scene):
    scene.camera(eye=(3, 2, 0.2), target=(-3, -2, 0), roll=0.3)
    scene.show(display("Grid", {"Alpha": 1, "Cell Size": 0.5, "Plane Cell Count": 20}))


def grid_lines_through_camera_plane(scene):
    scene.camera(eye=(0.1, 0.15, 0.4), target=(-2, -1, 0.3))
    scene.show(display("Grid", {"Alpha": 1, "Cell Size": 0.4, "Plane Cell Count": 30}))


def grid_one_cell_and_odd_count(scene):
    scene.show(display("Grid", {"Alpha": 1, "Plane Cell Count": 1}),
               display("Grid", {"Alpha": 1, "Cell Size": 0.5, "Color": "0; 255; 255", "Plane Cell Count": 3}, name="H"))


def grid_small_cells(scene):
    scene.show(display("Grid", {"Alpha": 0.5, "Cell Size": 0.04, "Plane Cell Count": 40}))


def grid_three_two_translucent(scene):
    scene.show(display("Grid"),
               display("Grid", {"Alpha": 0.3, "Cell Size": 0.33, "Color": "255; 0; 0", "Offset": {"X": 0, "Y": 0, "Z": 0.2}},
                       name="G2"),
               display("Grid",
                       {"Alpha": 0.8, "Color": "0; 255; 0", "Offset": {"X": 0, "Y": 0, "Z": -0.3}, "Plane": "YZ",
                        "Plane Cell Count": 3}, name="G3"))


def grid_xy_billboards_normal_count_2(scene):
    scene.show(display("Grid", {
        "Alpha": 0.6, "Cell Size": 0.35, "Color": "90; 200; 255", "Line Style": {"Line Width": 0.04, "Value": "Billboards"},
        "Normal Cell Count": 2, "Plane Cell Count": 4}))


def grid_xy_opaque_7_cells(scene):
    scene.show(display("Grid", {"Alpha": 1, "Cell Size": 0.25, "Color": "255; 200; 40", "Plane Cell Count": 7}))


def grid_xz_normal_count_3(scene):
    scene.show(display("Grid", {"Alpha": 0.7, "Cell Size": 0.3, "Normal Cell Count": 3, "Plane": "XZ", "Plane Cell Count": 4}))


def grid_xz_offset_rotated_frame(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("Grid", {
        "Alpha": 1, "Cell Size": 0.3, "Offset": {"X": 0.2, "Y": 0.3, "Z": -0.1}, "Plane": "XZ", "Plane Cell Count": 4,
        "Reference Frame": "sensor"}))


def grid_yz_billboards_normal_count(scene):
    scene.show(display("Grid", {
        "Alpha": 1, "Cell Size": 0.3, "Color": "200; 80; 255", "Line Style": {"Line Width": 0.02, "Value": "Billboards"},
        "Normal Cell Count": 1, "Plane": "YZ", "Plane Cell Count": 3}))


def grid_yz_offset(scene):
    scene.show(display("Grid", {
        "Alpha": 0.9, "Cell Size": 0.3, "Offset": {"X": -0.4, "Y": 0.2, "Z": 0.3}, "Plane": "YZ", "Plane Cell Count": 5}))
