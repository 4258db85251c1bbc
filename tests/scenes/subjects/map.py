"""The Map display."""

from map_msgs.msg import OccupancyGridUpdate
from nav_msgs.msg import MapMetaData, OccupancyGrid
from visualization_msgs.msg import Marker

from ..clouds import cloud, waves
from ..common import map_of_every_value, raised_map_of_every_value, two_cubes
from ..data import load
from ..displays import display
from ..geometry import pose
from ..messages import header, marker, markers, time_at
from ..scene import case

DATA = load("map")


@case
def map(scene):
    """Map, map scheme, default alpha"""
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(
        display("Map", {"Alpha": 0.7, "Draw Behind": False}), display("Axes", {"Length": 0.4, "Radius": 0.03}, name="A")
    )
    scene.publish(
        "/map",
        OccupancyGrid(
            header=header(),
            info=MapMetaData(
                map_load_time=time_at(), resolution=0.04, width=60, height=40, origin=pose((-1.2, -0.8, 0))
            ),
            data=DATA["map_data"].tolist(),
        ),
    )


@case
def map_37x23_odd_cell_size_grazing(scene):
    """a map of 37 x 23 cells of an odd size, close by and grazing"""
    scene.camera(eye=(1.1, 0.5, 0.35), target=(-0.2, 0, 0))
    scene.show(display("Map", {"Alpha": 0.9}))
    scene.publish(
        "/map",
        OccupancyGrid(
            header=header(),
            info=MapMetaData(resolution=0.0713, width=37, height=23, origin=pose((-1.4, -0.6, 0))),
            data=[41 * i % 101 for i in range(851)],
        ),
    )


@case
def map_camera_stands_on_it(scene):
    """a map that the camera stands on"""
    scene.camera(eye=(0.1, 0.15, 0.25), target=(-2, -1, 0.1))
    scene.show(display("Map", {"Alpha": 0.9}))
    scene.publish(
        "/map",
        OccupancyGrid(
            header=header(),
            info=MapMetaData(resolution=0.1, width=60, height=60, origin=pose((-3, -3, 0))),
            data=[41 * i % 101 for i in range(3600)],
        ),
    )


@case
def map_costmap(scene):
    """Map, costmap scheme, rotated origin"""
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(display("Map", {"Alpha": 0.7, "Color Scheme": "costmap", "Draw Behind": False}))
    scene.publish(
        "/map",
        OccupancyGrid(
            header=header(),
            info=MapMetaData(
                map_load_time=time_at(),
                resolution=0.04,
                width=60,
                height=40,
                origin=pose((-0.8, -1, 0.05), (0, 0, 0.5)),
            ),
            data=[(i % 128) for i in range(2400)],
        ),
    )


@case
def map_data_shorter_than_size(scene):
    """a map with less data than its size says"""
    scene.show(display("Map", {"Alpha": 0.9}))
    scene.publish(
        "/map",
        OccupancyGrid(
            header=header(),
            info=MapMetaData(resolution=0.1, width=16, height=16, origin=pose((-0.8, -0.8, 0))),
            data=[i for i in range(100)],
        ),
    )


@case
def map_draw_behind(scene):
    """Draw Behind: opaque map above other things, and a translucent one"""
    scene.show(
        display("Map", {"Alpha": 1, "Draw Behind": True}),
        display("Map", {"Alpha": 0.5, "Color Scheme": "costmap", "Draw Behind": True}, name="n", topic="/map2"),
        display("MarkerArray"),
        display("Grid"),
    )
    scene.publish(
        "/map",
        OccupancyGrid(
            header=header(),
            info=MapMetaData(resolution=0.1, width=16, height=16, origin=pose((-0.8, -0.8, 0.3))),
            data=[(i + 128) % 256 - 128 for i in range(256)],
        ),
    )
    scene.publish(
        "/map2",
        OccupancyGrid(
            header=header(),
            info=MapMetaData(resolution=0.1, width=16, height=16, origin=pose((-0.5, -1, 0.5))),
            data=[(i + 128) % 256 - 128 for i in range(256)],
        ),
    )
    scene.publish("/m", two_cubes())


@case
def map_every_value_scheme_costmap(scene):
    """every byte value in the scheme costmap, alpha 1, over a second map behind"""
    scene.show(
        display("Map", {"Alpha": 1, "Color Scheme": "costmap"}),
        display("Map", {"Alpha": 0.4, "Color Scheme": "raw"}, name="n", topic="/map2"),
    )
    scene.publish("/map", map_of_every_value())
    scene.publish(
        "/map2",
        OccupancyGrid(
            header=header(),
            info=MapMetaData(resolution=0.08, width=16, height=16, origin=pose((-0.8, -0.8, 0.3))),
            data=[(16 * i + i // 16 + 128) % 256 - 128 for i in range(256)],
        ),
    )


@case
def map_every_value_scheme_map(scene):
    """every byte value in the scheme map, alpha 1, over a grid and axes"""
    scene.show(
        display("Map", {"Alpha": 1}),
        display("Grid", {"Alpha": 1, "Cell Size": 0.2}),
        display("Axes", {"Length": 0.5, "Radius": 0.03}, name="A"),
    )
    scene.publish("/map", map_of_every_value())


@case
def map_every_value_scheme_raw(scene):
    """every byte value in the scheme raw, alpha 0.6, rolled camera"""
    scene.camera(roll=0.5)
    scene.show(display("Map", {"Alpha": 0.6, "Color Scheme": "raw"}))
    scene.publish("/map", map_of_every_value())


@case
def map_opaque_cuts_markers(scene):
    """opaque map that cuts through markers, and a translucent marker over it"""
    scene.show(
        display("Map", {"Alpha": 1}),
        display("MarkerArray"),
        display("PointCloud2", {"Color Transformer": "AxisColor", "Size (m)": 0.05}),
    )
    scene.publish("/map", raised_map_of_every_value())
    scene.publish("/m", two_cubes())
    scene.publish("/cloud", cloud(waves(16, 12)))


@case
def map_partial_updates_past_edge(scene):
    """partial updates, one of them past the edge"""
    scene.show(display("Map", {"Alpha": 0.9, "Color Scheme": "costmap"}))
    scene.publish(
        "/map",
        OccupancyGrid(
            header=header(),
            info=MapMetaData(resolution=0.1, width=16, height=16, origin=pose((-0.8, -0.8, 0))),
            data=[20] * 256,
        ),
    )
    scene.publish("/map_updates", OccupancyGridUpdate(header=header(), x=3, y=2, width=7, height=4, data=[99] * 28))


@case
def map_rotated_origin_and_frame_from_below(scene):
    """a map with a rotated, offset origin in a rotated frame, alpha 0.8, seen partly from below"""
    scene.frame("sensor", at=(0.2, 0.1, 0.3), turned=(0.3, -0.2, 0.5))
    scene.show(
        display("Map", {"Alpha": 0.8}),
        display("Axes", {"Length": 0.5, "Radius": 0.03, "Reference Frame": "sensor"}, name="A"),
    )
    scene.publish(
        "/map",
        OccupancyGrid(
            header=header("sensor"),
            info=MapMetaData(resolution=0.1, width=16, height=16, origin=pose((-0.4, -0.7, 0.1), (0.2, 0.4, 0.9))),
            data=[(i + 128) % 256 - 128 for i in range(256)],
        ),
    )


@case
def map_translucent_among_markers(scene):
    """translucent map among translucent markers"""
    scene.show(display("Map", {"Alpha": 0.6}), display("MarkerArray"))
    scene.publish("/map", raised_map_of_every_value())
    scene.publish(
        "/m",
        markers(
            marker(Marker.CUBE, at=(-0.4, 0.3, 0.3), size=(0.3, 0.3, 0.3), paint=(0.1, 0.5, 1, 0.5), id=1),
            marker(Marker.CUBE, at=(0.3, -0.3, 0.3), size=(0.3, 0.3, 0.3), paint=(0.9, 0.9, 0.1, 0.5), id=2),
            marker(Marker.SPHERE, at=(-0.9, -0.9, 0.1), size=(0.5, 0.5, 0.5), paint=(0.1, 0.9, 0.1, 0.5), id=3),
        ),
    )


@case
def map_unknown_and_missing_frame(scene):
    """a map in an unknown frame, another without a frame name"""
    scene.frame("map", at=(0, 0.3, 0.4))
    scene.show(display("Map", {"Alpha": 0.9}), display("Map", name="n", topic="/map2"))
    scene.publish(
        "/map",
        OccupancyGrid(
            header=header("nowhere"),
            info=MapMetaData(resolution=0.1, width=16, height=16, origin=pose((-0.8, -0.8, 0))),
            data=[(i + 128) % 256 - 128 for i in range(256)],
        ),
    )
    scene.publish(
        "/map2",
        OccupancyGrid(
            header=header(""),
            info=MapMetaData(resolution=0.05, width=16, height=16, origin=pose((-0.8, -0.8, 0))),
            data=[(i + 128) % 256 - 128 for i in range(256)],
        ),
    )
