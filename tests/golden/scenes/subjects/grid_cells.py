"""The GridCells display."""

import math

from nav_msgs.msg import GridCells

from ..data import load
from ..displays import display
from ..geometry import points
from ..messages import CUBE, header, marker, markers
from ..scene import LARGE

DATA = load("grid_cells")


def grid_cells(scene):
    scene.camera(**LARGE)
    scene.show(display("GridCells", {"Alpha": 1, "Color": "25; 255; 0"}))
    scene.publish("/g", GridCells(header=header(), cell_width=0.1, cell_height=0.1, cells=points(DATA["grid_cells_cells"])))


def grid_cells_negative_width_zero_height_nan(scene):
    scene.show(display("GridCells", {"Color": "255; 200; 0"}),
               display("GridCells", name="h", topic="/h"),
               display("GridCells", name="i", topic="/i"))
    scene.publish("/g", GridCells(header=header(), cell_width=-0.1, cell_height=0.07, cells=points(
        DATA["grid_cells_negative_width_zero_height_nan_g_cells"])))
    scene.publish("/h", GridCells(header=header(), cell_width=0.1, cells=points(
        DATA["grid_cells_negative_width_zero_height_nan_h_cells"])))
    scene.publish("/i", GridCells(header=header(), cell_width=0.1, cell_height=0.1, cells=points([
        (-0.5, -0.38, 0.6), (-0.5, -0.14, 0.6), (-0.5, 0.1, 0.6), (-0.5, 0.34, 0.6), (-0.38, -0.5, 0.6), (math.nan, 0, 0)])))


def grid_cells_second_message_replaces_first(scene):
    scene.show(display("GridCells", {"Alpha": 0.3}), display("MarkerArray"))
    scene.publish("/g",
                  GridCells(header=header(), cell_width=0.1, cell_height=0.1, cells=points(
                      DATA["grid_cells_negative_width_zero_height_nan_g_cells"])),
                  GridCells(header=header(), cell_width=0.09, cell_height=0.2, cells=points(
                      DATA["grid_cells_second_message_replaces_first_g_1_cells"])))
    scene.publish("/m", markers(marker(CUBE, at=(0, 0, 0.1), size=(0.5, 0.5, 0.3), paint=(1, 0, 0, 0.5), id=1)))


def grid_cells_translucent_oblong_rotated_frame(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("GridCells", {"Alpha": 0.5, "Color": "60; 40; 200"}))
    scene.publish("/g", GridCells(header=header("sensor"), cell_width=0.2, cell_height=0.15, cells=points(
        DATA["grid_cells_negative_width_zero_height_nan_g_cells"])))
