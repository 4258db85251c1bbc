"""Scalars: FluidPressure, Illuminance, RelativeHumidity, Temperature."""

import math

from sensor_msgs.msg import FluidPressure, Illuminance, RelativeHumidity, Temperature

from ..displays import display
from ..messages import header
from ..scene import LARGE


def scalar_all_four_defaults(scene):
    scene.frame("s0", at=(-0.55, -0.3, 0.2))
    scene.frame("s1", at=(0, -0.3, 0.2), turned=(0.3, 0, 0.5))
    scene.frame("s2", at=(0.55, -0.3, 0.2), turned=(0.6, 0, 1))
    scene.frame("s3", at=(-0.55, 0.25, 0.2), turned=(0.9, 0, 1.5))
    scene.frame("s4", at=(0, 0.25, 0.2), turned=(1.2, 0, 2))
    scene.frame("s5", at=(0.55, 0.25, 0.2), turned=(1.5, 0, 2.5))
    scene.show(display("FluidPressure", {"Size (m)": 0.4, "Style": "Spheres"}, name="p", topic="/p"),
               display("Illuminance", {"Size (m)": 0.4, "Style": "Spheres"}, name="i", topic="/i"),
               display("RelativeHumidity", {"Size (m)": 0.4, "Style": "Spheres"}, name="h", topic="/h"),
               display("Temperature", {"Size (m)": 0.4, "Style": "Spheres"}, name="t", topic="/t"))
    scene.publish("/p", FluidPressure(header=header("s0"), fluid_pressure=100000))
    scene.publish("/i", Illuminance(header=header("s1"), illuminance=300))
    scene.publish("/h", RelativeHumidity(header=header("s2"), relative_humidity=0.7))
    scene.publish("/t", Temperature(header=header("s3"), temperature=30))


def scalar_colors_bounds_transformers(scene):
    scene.frame("s0", at=(-0.55, -0.3, 0.2))
    scene.frame("s1", at=(0, -0.3, 0.2), turned=(0.3, 0, 0.5))
    scene.frame("s2", at=(0.55, -0.3, 0.2), turned=(0.6, 0, 1))
    scene.frame("s3", at=(-0.55, 0.25, 0.2), turned=(0.9, 0, 1.5))
    scene.frame("s4", at=(0, 0.25, 0.2), turned=(1.2, 0, 2))
    scene.frame("s5", at=(0.55, 0.25, 0.2), turned=(1.5, 0, 2.5))
    scene.show(display("FluidPressure",
                       {"Max Color": "255; 255; 0", "Max Intensity": 101000, "Min Color": "0; 0; 255", "Min Intensity": 99000,
                        "Size (m)": 0.4, "Style": "Boxes", "Use rainbow": False}, name="p", topic="/p"),
               display("Illuminance", {"Autocompute Intensity Bounds": True, "Size (m)": 0.4, "Style": "Squares"}, name="i",
                       topic="/i"),
               display("RelativeHumidity",
                       {"Alpha": 0.5, "Color": "255; 0; 255", "Color Transformer": "FlatColor", "Size (m)": 0.4,
                        "Style": "Spheres"}, name="h", topic="/h"),
               display("Temperature", {"Invert Rainbow": False, "Size (m)": 0.4, "Style": "Flat Squares"}, name="t", topic="/t"),
               display("Illuminance", {"Size (m)": 0.4, "Style": "Spheres"}, name="j", topic="/j"),
               display("Temperature", {"Size (m)": 0.4, "Style": "Spheres"}, name="n", topic="/n"))
    scene.publish("/p", FluidPressure(header=header("s0"), fluid_pressure=100500))
    scene.publish("/i", Illuminance(header=header("s1"), illuminance=300))
    scene.publish("/h", RelativeHumidity(header=header("s2"), relative_humidity=0.7))
    scene.publish("/t", Temperature(header=header("s3"), temperature=30))
    scene.publish("/j", Illuminance(header=header("s4"), illuminance=3000))
    scene.publish("/n", Temperature(header=header("s5"), temperature=math.nan))


def scalar_fluidpressure(scene):
    scene.camera(**LARGE)
    scene.frame("sensor", at=(0.1, 0, 0.2))
    scene.show(display("FluidPressure", {"Alpha": 1, "Decay Time": 0, "Size (m)": 0.4, "Style": "Spheres"}, name="s", topic="/s"))
    scene.publish("/s", FluidPressure(header=header("sensor"), fluid_pressure=99500))


def scalar_temperature(scene):
    scene.camera(**LARGE)
    scene.frame("sensor", at=(0.1, 0, 0.2))
    scene.show(display("Temperature", {"Alpha": 1, "Decay Time": 0, "Size (m)": 0.4, "Style": "Spheres"}, name="s", topic="/s"))
    scene.publish("/s", Temperature(header=header("sensor"), temperature=24))
