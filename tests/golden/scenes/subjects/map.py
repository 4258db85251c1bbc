"""The Map display."""

from map_msgs.msg import OccupancyGridUpdate

from ..clouds import cloud, waves
from ..common import EVERY_VALUE, map_of_every_value, two_cubes
from ..data import load
from ..displays import display
from ..messages import CUBE, SPHERE, header, marker, markers, occupancy_grid, time_at
from ..scene import LARGE, family, one_display

DATA = load("map")


def map(scene):
    scene.camera(**LARGE)
    scene.show(display("Map", {"Alpha": 0.7, "Draw Behind": False}), display("Axes", {"Length": 0.4, "Radius": 0.03}, name="A"))
    scene.publish("/map", occupancy_grid(
        0.04, (60, 40), (-1.2, -0.8, 0), data=DATA["map_data"].tolist(), map_load_time=time_at()))


def map_draw_behind(scene):
    scene.show(display("Map", {"Alpha": 1, "Draw Behind": True}),
               display("Map", {"Alpha": 0.5, "Color Scheme": "costmap", "Draw Behind": True}, name="n", topic="/map2"),
               display("MarkerArray"),
               display("Grid"))
    scene.publish("/map", occupancy_grid(0.1, (16, 16), (-0.8, -0.8, 0.3), data=EVERY_VALUE))
    scene.publish("/map2", occupancy_grid(0.1, (16, 16), (-0.5, -1, 0.5), data=EVERY_VALUE))
    scene.publish("/m", two_cubes())


def map_every_value_scheme_costmap(scene):
    scene.show(display("Map", {"Alpha": 1, "Color Scheme": "costmap"}),
               display("Map", {"Alpha": 0.4, "Color Scheme": "raw"}, name="n", topic="/map2"))
    scene.publish("/map", map_of_every_value())
    scene.publish("/map2", occupancy_grid(0.08, (16, 16), (-0.8, -0.8, 0.3), data=[(16 * i + i // 16 + 128) % 256 - 128
                                                                                   for i in range(256)]))


def map_every_value_scheme_map(scene):
    scene.show(display("Map", {"Alpha": 1}),
               display("Grid", {"Alpha": 1, "Cell Size": 0.2}),
               display("Axes", {"Length": 0.5, "Radius": 0.03}, name="A"))
    scene.publish("/map", map_of_every_value())


def map_opaque_cuts_markers(scene):
    scene.show(display("Map", {"Alpha": 1}), display("MarkerArray"), display("PointCloud2", {
        "Color Transformer": "AxisColor", "Size (m)": 0.05}))
    scene.publish("/map", map_of_every_value(0.1))
    scene.publish("/m", two_cubes())
    scene.publish("/cloud", cloud(waves(16, 12)))


def map_partial_updates_past_edge(scene):
    scene.show(display("Map", {"Alpha": 0.9, "Color Scheme": "costmap"}))
    scene.publish("/map", occupancy_grid(0.1, (16, 16), (-0.8, -0.8, 0), data=[20] * 256))
    scene.publish("/map_updates", OccupancyGridUpdate(header=header(), x=3, y=2, width=7, height=4, data=[99] * 28))


def map_rotated_origin_and_frame_from_below(scene):
    scene.frame("sensor", at=(0.2, 0.1, 0.3), turned=(0.3, -0.2, 0.5))
    scene.show(display("Map", {"Alpha": 0.8}), display(
        "Axes", {"Length": 0.5, "Radius": 0.03, "Reference Frame": "sensor"}, name="A"))
    scene.publish("/map", occupancy_grid(0.1, (16, 16), (-0.4, -0.7, 0.1), (0.2, 0.4, 0.9), data=EVERY_VALUE, frame="sensor"))


def map_translucent_among_markers(scene):
    scene.show(display("Map", {"Alpha": 0.6}), display("MarkerArray"))
    scene.publish("/map", map_of_every_value(0.1))
    scene.publish("/m", markers(
        marker(CUBE, at=(-0.4, 0.3, 0.3), size=0.3, paint=(0.1, 0.5, 1, 0.5), id=1),
        marker(CUBE, at=(0.3, -0.3, 0.3), size=0.3, paint=(0.9, 0.9, 0.1, 0.5), id=2),
        marker(SPHERE, at=(-0.9, -0.9, 0.1), size=0.5, paint=(0.1, 0.9, 0.1, 0.5), id=3)))


def map_unknown_and_missing_frame(scene):
    scene.frame("map", at=(0, 0.3, 0.4))
    scene.show(display("Map", {"Alpha": 0.9}), display("Map", name="n", topic="/map2"))
    scene.publish("/map", occupancy_grid(0.1, (16, 16), (-0.8, -0.8, 0), data=EVERY_VALUE, frame="nowhere"))
    scene.publish("/map2", occupancy_grid(0.05, (16, 16), (-0.8, -0.8, 0), data=EVERY_VALUE, frame=""))


family(one_display("Map", "/map"), {
    "map_37x23_odd_cell_size_grazing": (
        {"Alpha": 0.9},
        occupancy_grid(0.0713, (37, 23), (-1.4, -0.6, 0), data=[41 * i % 101 for i in range(851)]),
        dict(eye=(1.1, 0.5, 0.35), target=(-0.2, 0, 0))),
    "map_camera_stands_on_it": (
        {"Alpha": 0.9},
        occupancy_grid(0.1, (60, 60), (-3, -3, 0), data=[41 * i % 101 for i in range(3600)]),
        dict(eye=(0.1, 0.15, 0.25), target=(-2, -1, 0.1))),
    "map_costmap": (
        {"Alpha": 0.7, "Color Scheme": "costmap", "Draw Behind": False},
        occupancy_grid(0.04, (60, 40), (-0.8, -1, 0.05), (0, 0, 0.5), data=[i % 128 for i in range(2400)],
                       map_load_time=time_at()), LARGE),
    "map_data_shorter_than_size": ({"Alpha": 0.9}, occupancy_grid(0.1, (16, 16), (-0.8, -0.8, 0), data=[i for i in range(100)])),
    "map_every_value_scheme_raw": ({"Alpha": 0.6, "Color Scheme": "raw"}, map_of_every_value(), dict(roll=0.5))})
