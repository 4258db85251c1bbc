"""The LaserScan display."""

import numpy
from sensor_msgs.msg import LaserScan

from ..data import load
from ..displays import display
from ..laser import ring_ranges
from ..messages import frame_at, frames, header
from ..scene import LARGE

DATA = load("laser_scan")


def laser_scan(scene):
    scene.camera(**LARGE)
    scene.show(display("LaserScan", {
        "Alpha": 1, "Autocompute Intensity Bounds": True, "Channel Name": "intensity", "Color Transformer": "Intensity",
        "Decay Time": 0, "Position Transformer": "XYZ", "Size (m)": 0.03, "Style": "Flat Squares", "Use rainbow": True}))
    scene.publish("/l", LaserScan(
        header=header(), angle_min=-2, angle_max=2, angle_increment=0.011142061, range_min=0.1, range_max=10,
        ranges=list(ring_ranges(360, waves=8, middle=0.8, height=0.2)), intensities=list(numpy.linspace(0, 100, 360))))


def laser_scan_decay_moving_scanner(scene):
    scene.show(display("LaserScan", {"Decay Time": 1000, "Size (Pixels)": 4, "Style": "Points"}))
    scene.publish("/tf", frames(
        frame_at("laser", "base_link", (-1.3, -0.2, -0.1), (-0.3, 0, -0.9), secs=-1),
        frame_at("laser", "base_link", (-0.5, 0, 0.1)),
        frame_at("laser", "base_link", (0.3, 0.2, 0.3), (0.3, 0, 0.9), secs=1),
        frame_at("laser", "base_link", (1.1, 0.4, 0.5), (0.6, 0, 1.8), secs=2)))
    scene.publish("/l",
                  LaserScan(header=header("laser"), angle_min=-2, angle_max=2, angle_increment=0.020100502,
                            time_increment=0.00050251256, range_min=0.1, range_max=10, ranges=list(ring_ranges(200, 0.5)),
                            intensities=[i for i in range(200)]),
                  LaserScan(header=header("laser", secs=0.7000000476837158), angle_min=-2, angle_max=2,
                            angle_increment=0.020100502, time_increment=0.00050251256, range_min=0.1, range_max=10,
                            ranges=list(ring_ranges(200, 0.5)), intensities=[i for i in range(200)]),
                  LaserScan(header=header("laser", secs=1.4000000953674316), angle_min=-2, angle_max=2,
                            angle_increment=0.020100502, time_increment=0.00050251256, range_min=0.1, range_max=10,
                            ranges=list(ring_ranges(200, 0.5)), intensities=[i for i in range(200)]))


def laser_scan_drives_and_turns(scene):
    scene.show(display("LaserScan", {"Size (m)": 0.04, "Style": "Spheres"}))
    scene.publish("/tf", frames(
        frame_at("laser", "base_link", (-1.3, -0.2, -0.1), (-0.3, 0, -0.9), secs=-1),
        frame_at("laser", "base_link", (-0.5, 0, 0.1)),
        frame_at("laser", "base_link", (0.3, 0.2, 0.3), (0.3, 0, 0.9), secs=1),
        frame_at("laser", "base_link", (1.1, 0.4, 0.5), (0.6, 0, 1.8), secs=2)))
    scene.publish("/l", LaserScan(
        header=header("laser"), angle_min=-2, angle_max=2, angle_increment=0.020100502, time_increment=0.0050251256,
        range_min=0.1, range_max=10, ranges=list(ring_ranges(200, 0.6)), intensities=[i for i in range(200)]))


def laser_scan_empty_replaces_first(scene):
    scene.show(display("Grid"), display("LaserScan", {"Size (m)": 0.05, "Style": "Squares"}))
    scene.publish("/l",
                  LaserScan(header=header(), angle_min=-2, angle_max=2, angle_increment=0.020100502, range_min=0.1, range_max=10,
                            ranges=list(ring_ranges(200))),
                  LaserScan(header=header(), angle_min=-2, angle_max=2, angle_increment=4, range_min=0.1, range_max=10))


def laser_scan_invalid_ranges(scene):
    scene.show(display("LaserScan", {"Size (m)": 0.04, "Style": "Flat Squares"}))
    scene.publish("/l", LaserScan(
        header=header(), angle_min=-2, angle_max=2, angle_increment=0.020100502, range_min=0.3, range_max=0.85,
        ranges=DATA["laser_scan_invalid_ranges_ranges"].tolist(), intensities=[i for i in range(200)]))


def laser_scan_squares_rotated_frame(scene):
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("LaserScan", {"Axis": "Z", "Color Transformer": "AxisColor", "Size (m)": 0.05, "Style": "Squares"}))
    scene.publish("/l", LaserScan(
        header=header("sensor"), angle_min=-2, angle_max=2, angle_increment=0.020100502, range_min=0.1, range_max=10,
        ranges=list(ring_ranges(200))))
