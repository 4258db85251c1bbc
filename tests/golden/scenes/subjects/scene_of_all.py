"""Displays of many kinds in one scene."""

from ..clouds import ball, cloud, colored_waves, spiral
from ..common import oval_path
from ..displays import display, group
from ..messages import CUBE, LINE_STRIP, MESH, TEXT, marker, markers


def scene_all_kinds_in_groups(scene):
    scene.camera(size=(640, 480), focal=(520, 520))
    scene.show(display("Grid"),
               group("World",
                     display("Axes", {"Length": 0.5, "Radius": 0.03}),
                     display("Path", {"Line Style": "Billboards"}),
                     group("Clouds",
                           display("PointCloud2", {"Size (m)": 0.05, "Style": "Spheres"}),
                           display("PointCloud2", {"Color Transformer": "FlatColor", "Size (Pixels)": 5, "Style": "Points"},
                                   name="d", topic="/cloud2"))), display("MarkerArray"))
    scene.publish("/cloud", colored_waves())
    scene.publish("/cloud2", cloud(ball(100, 0.7)))
    scene.publish("/p", oval_path())
    scene.publish("/m", markers(
        marker(CUBE, at=(0.3, -0.3, 0.4), turned=(0.4, 0.3, 0.8), size=0.3, paint=(0.9, 0.2, 0.2, 0.5)),
        marker(TEXT, at=(0, 0, 0.8), size=(0, 0, 0.15), paint=(1, 1, 1), id=1, text="goal"),
        marker(LINE_STRIP, at=(0, 0, 0.4), size=(0.03, 0, 0), paint=(1, 1, 0), id=2, points=spiral(14)),
        marker(MESH, at=(-0.4, 0.4, 0.4), turned=(0.4, 0.3, 0.8), size=1, id=3, mesh="gear.dae",
               mesh_use_embedded_materials=True)))
