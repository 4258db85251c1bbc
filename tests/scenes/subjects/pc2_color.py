"""Point clouds: the colour transformers."""

import math

import numpy

from ..clouds import cloud, columns, corner_colors, count_colors, packed, raw_cloud, ripples, waves, with_values
from ..data import load
from ..displays import display
from ..scene import case

DATA = load("pc2_color")


@case
def pc2_axis_x_fixed(scene):
    """AxisColor along X, fixed bounds, in the cloud's own frame"""
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.frame("sensor", at=(0.1, 0, 0.1), turned=(0.2, -0.1, 0.5))
    scene.show(
        display(
            "PointCloud2",
            {
                "Autocompute Value Bounds": {"Max Value": 0.5, "Min Value": -0.7, "Value": False},
                "Axis": "X",
                "Color Transformer": "AxisColor",
                "Use Fixed Frame": False,
            },
        )
    )
    scene.publish("/cloud", cloud(ripples(40, 30), "sensor", is_dense=True))


@case
def pc2_axis_x_fixed_frame_rotated_cloud(scene):
    """AxisColor X in the fixed frame, cloud rotated, automatic bounds"""
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Axis": "X", "Color Transformer": "AxisColor", "Size (m)": 0.05}))
    scene.publish("/cloud", cloud(waves(16, 12), "sensor"))


@case
def pc2_axis_x_nan_points(scene):
    """AxisColor X, automatic bounds, NaN points"""
    scene.show(
        display("PointCloud2", {"Axis": "X", "Color Transformer": "AxisColor", "Size (m)": 0.06, "Style": "Squares"})
    )
    scene.publish("/cloud", cloud(with_values(waves(16, 12), range(0, 192, 6), (math.nan, math.nan, math.nan))))


@case
def pc2_axis_y_boxes(scene):
    """AxisColor Y with Boxes"""
    scene.show(
        display("PointCloud2", {"Axis": "Y", "Color Transformer": "AxisColor", "Size (m)": 0.07, "Style": "Boxes"})
    )
    scene.publish("/cloud", cloud(waves(16, 12)))


@case
def pc2_axis_y_cloud_frame_rotated_cloud(scene):
    """AxisColor Y in the cloud's own frame, cloud rotated, automatic bounds"""
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(
        display(
            "PointCloud2", {"Axis": "Y", "Color Transformer": "AxisColor", "Size (m)": 0.05, "Use Fixed Frame": False}
        )
    )
    scene.publish("/cloud", cloud(waves(16, 12), "sensor"))


@case
def pc2_axis_y_fixed_frame_rotated_cloud(scene):
    """AxisColor Y in the fixed frame, cloud rotated, automatic bounds"""
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Axis": "Y", "Color Transformer": "AxisColor", "Size (m)": 0.05}))
    scene.publish("/cloud", cloud(waves(16, 12), "sensor"))


@case
def pc2_axis_z(scene):
    """AxisColor along Z, automatic bounds"""
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(
        display(
            "PointCloud2",
            {
                "Autocompute Value Bounds": {"Max Value": 10, "Min Value": -10, "Value": True},
                "Axis": "Z",
                "Color Transformer": "AxisColor",
            },
        )
    )
    scene.publish("/cloud", cloud(ripples(40, 30), is_dense=True))


@case
def pc2_axis_z_fixed_frame_rotated_cloud(scene):
    """AxisColor Z in the fixed frame, cloud rotated, automatic bounds"""
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Axis": "Z", "Color Transformer": "AxisColor", "Size (m)": 0.05}))
    scene.publish("/cloud", cloud(waves(16, 12), "sensor"))


@case
def pc2_axis_z_infinite_points(scene):
    """AxisColor Z, automatic bounds, infinite points"""
    scene.show(
        display("PointCloud2", {"Axis": "Z", "Color Transformer": "AxisColor", "Size (m)": 0.06, "Style": "Squares"})
    )
    scene.publish(
        "/cloud",
        cloud(
            with_values(
                with_values(waves(16, 12), range(5, 192, 187), (math.inf, math.inf, math.inf)),
                range(17, 192, 175),
                (None, None, -math.inf),
            )
        ),
    )


@case
def pc2_axis_z_values_beyond_bounds(scene):
    """AxisColor Z, fixed bounds, values beyond both"""
    scene.show(
        display(
            "PointCloud2",
            {
                "Autocompute Value Bounds": {"Max Value": 0.25, "Min Value": 0.15, "Value": False},
                "Axis": "Z",
                "Color Transformer": "AxisColor",
                "Size (m)": 0.05,
            },
        )
    )
    scene.publish("/cloud", cloud(waves(16, 12)))


@case
def pc2_both_rgb_and_rgba(scene):
    """a cloud with both rgb and rgba"""
    scene.show(display("PointCloud2", {"Size (m)": 0.06, "Style": "Squares"}))
    scene.publish(
        "/cloud",
        cloud(
            waves(16, 12),
            fields=[
                ("rgb", "rgb", packed(count_colors(192))),
                ("rgba", "uint32", packed(count_colors(192)[:, [2, 0, 1]], 120)),
            ],
        ),
    )


@case
def pc2_intensity_all_equal(scene):
    """Intensity, automatic bounds, all values equal"""
    scene.show(display("PointCloud2", {"Color Transformer": "Intensity", "Size (m)": 0.05}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("intensity", "float32", numpy.full(192, 7.5))]))


@case
def pc2_intensity_channel_missing(scene):
    """Intensity named, cloud has rgb only"""
    scene.show(display("PointCloud2", {"Color Transformer": "Intensity", "Size (m)": 0.06, "Style": "Squares"}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))


@case
def pc2_intensity_colors(scene):
    """Intensity between two colours, fixed bounds"""
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(
        display(
            "PointCloud2",
            {
                "Autocompute Intensity Bounds": False,
                "Channel Name": "intensity",
                "Color Transformer": "Intensity",
                "Max Color": "250; 220; 0",
                "Max Intensity": 200,
                "Min Color": "10; 40; 200",
                "Min Intensity": 50,
                "Use rainbow": False,
            },
        )
    )
    scene.publish(
        "/cloud", cloud(ripples(40, 30), fields=[("intensity", "float32", numpy.linspace(0, 250, 1200))], is_dense=True)
    )


@case
def pc2_intensity_float64_rainbow(scene):
    """Intensity of a float64 channel, automatic bounds, rainbow"""
    scene.show(display("PointCloud2", {"Channel Name": "range", "Color Transformer": "Intensity", "Size (m)": 0.05}))
    scene.publish(
        "/cloud",
        cloud(waves(16, 12), fields=[("range", "float64", numpy.linalg.norm(numpy.float32(waves(16, 12)), axis=1))]),
    )


@case
def pc2_intensity_int16_fixed_bounds(scene):
    """Intensity of an int16 channel, fixed bounds inside the values"""
    scene.show(
        display(
            "PointCloud2",
            {
                "Autocompute Intensity Bounds": False,
                "Channel Name": "i",
                "Color Transformer": "Intensity",
                "Max Intensity": 60,
                "Min Intensity": -50,
                "Size (m)": 0.06,
                "Style": "Boxes",
            },
        )
    )
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("i", "int16", -96 + 1 * numpy.arange(192))]))


@case
def pc2_intensity_int32_negative(scene):
    """Intensity of an int32 channel with negative values, Points"""
    scene.show(
        display(
            "PointCloud2",
            {"Channel Name": "v", "Color Transformer": "Intensity", "Size (Pixels)": 5, "Style": "Points"},
        )
    )
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("v", "int32", -70000 + 1000 * numpy.arange(192))]))


@case
def pc2_intensity_int8_channel_intensities(scene):
    """Intensity of an int8 channel called intensities"""
    scene.show(
        display(
            "PointCloud2",
            {"Channel Name": "intensity", "Color Transformer": "Intensity", "Size (m)": 0.05, "Style": "Squares"},
        )
    )
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("intensities", "int8", numpy.arange(192).astype("int8"))]))


@case
def pc2_intensity_max_below_min(scene):
    """Intensity, fixed bounds with Max below Min"""
    scene.show(
        display(
            "PointCloud2",
            {
                "Autocompute Intensity Bounds": False,
                "Color Transformer": "Intensity",
                "Max Intensity": 10,
                "Min Intensity": 40,
                "Size (m)": 0.05,
            },
        )
    )
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("intensity", "float32", 1 * numpy.arange(192) % 50)]))


@case
def pc2_intensity_nan(scene):
    """Intensity with NaN values"""
    scene.show(display("PointCloud2", {"Color Transformer": "Intensity", "Size (m)": 0.05}))
    scene.publish(
        "/cloud", cloud(waves(16, 12), fields=[("intensity", "float32", DATA["pc2_intensity_nan_intensity"])])
    )


@case
def pc2_intensity_nan_two_colors(scene):
    """Intensity with NaN values, two colours, fixed bounds"""
    scene.show(
        display(
            "PointCloud2",
            {
                "Autocompute Intensity Bounds": False,
                "Color Transformer": "Intensity",
                "Max Color": "0; 255; 90",
                "Max Intensity": 40,
                "Min Color": "255; 0; 60",
                "Min Intensity": 5,
                "Size (m)": 0.05,
                "Use rainbow": False,
            },
        )
    )
    scene.publish(
        "/cloud", cloud(waves(16, 12), fields=[("intensity", "float32", DATA["pc2_intensity_nan_intensity"])])
    )


@case
def pc2_intensity_of_z_channel(scene):
    """Intensity of the channel z"""
    scene.show(
        display(
            "PointCloud2", {"Channel Name": "z", "Color Transformer": "Intensity", "Size (m)": 0.05, "Style": "Spheres"}
        )
    )
    scene.publish("/cloud", cloud(waves(16, 12)))


@case
def pc2_intensity_rainbow(scene):
    """Intensity, rainbow, automatic bounds"""
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(
        display(
            "PointCloud2",
            {"Autocompute Intensity Bounds": True, "Channel Name": "intensity", "Color Transformer": "Intensity"},
        )
    )
    scene.publish(
        "/cloud", cloud(ripples(40, 30), fields=[("intensity", "float32", numpy.linspace(0, 250, 1200))], is_dense=True)
    )


@case
def pc2_intensity_uint16_inverted_rainbow(scene):
    """Intensity of a uint16 channel "ring", inverted rainbow, fixed bounds exceeded"""
    scene.show(
        display(
            "PointCloud2",
            {
                "Autocompute Intensity Bounds": False,
                "Channel Name": "ring",
                "Color Transformer": "Intensity",
                "Invert Rainbow": True,
                "Max Intensity": 140,
                "Min Intensity": 20,
                "Style": "Squares",
            },
        )
    )
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("ring", "uint16", numpy.arange(192))], point_step=17))


@case
def pc2_intensity_uint8_two_colors(scene):
    """Intensity of a uint8 channel between two colours, automatic bounds, Spheres"""
    scene.show(
        display(
            "PointCloud2",
            {
                "Channel Name": "label",
                "Color Transformer": "Intensity",
                "Max Color": "255; 240; 30",
                "Min Color": "20; 60; 250",
                "Size (m)": 0.06,
                "Style": "Spheres",
                "Use rainbow": False,
            },
        )
    )
    scene.publish("/cloud", raw_cloud([("label", "uint8", 7 * numpy.arange(192) % 256), *columns(waves(16, 12))]))


@case
def pc2_mono8_of_rgb(scene):
    """MONO8 of an rgb channel"""
    scene.show(display("PointCloud2", {"Color Transformer": "MONO8", "Size (m)": 0.06}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))


@case
def pc2_mono8_of_rgba(scene):
    """MONO8 of an rgba cloud"""
    scene.show(display("PointCloud2", {"Color Transformer": "MONO8", "Size (m)": 0.09, "Style": "Spheres"}))
    scene.publish(
        "/cloud",
        cloud(waves(16, 12), fields=[("rgba", "uint32", packed(count_colors(192), 40 + 1 * numpy.arange(192) % 192))]),
    )


@case
def pc2_rgb8_of_uint32(scene):
    """RGB8 of an rgb field that is uint32"""
    scene.show(display("PointCloud2", {"Size (m)": 0.06, "Style": "Squares"}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "uint32", packed(count_colors(192), 77))]))


@case
def pc2_rgbf32(scene):
    """RGBF32 from r, g and b channels"""
    scene.camera(size=(640, 480), focal=(500, 500))
    scene.show(display("PointCloud2", {"Color Transformer": "RGBF32"}))
    scene.publish(
        "/cloud",
        cloud(
            ripples(40, 30),
            fields=[
                ("r", "float32", corner_colors(ripples(40, 30))[:, 0]),
                ("g", "float32", corner_colors(ripples(40, 30))[:, 1]),
                ("b", "float32", corner_colors(ripples(40, 30))[:, 2]),
            ],
            is_dense=True,
        ),
    )


@case
def pc2_rgbf32_out_of_range_rotated_frame(scene):
    """RGBF32 out of 0..1, in a rotated frame, Squares"""
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show(display("PointCloud2", {"Color Transformer": "RGBF32", "Size (m)": 0.06, "Style": "Squares"}))
    scene.publish(
        "/cloud",
        cloud(
            waves(16, 12),
            "sensor",
            fields=[
                ("r", "float32", count_colors(192)[:, 0] / 200),
                ("g", "float32", count_colors(192)[:, 1] / 255),
                ("b", "float32", count_colors(192)[:, 2] / 255 - 0.2),
            ],
        ),
    )


@case
def pc2_transformer_rgb8_without_rgb(scene):
    """Color Transformer RGB8 named, cloud has only xyz and intensity"""
    scene.show(display("PointCloud2", {"Size (m)": 0.05}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("intensity", "float32", numpy.arange(192))]))


@case
def pc2_transformer_unset_cloud_with_rgb(scene):
    """no Color Transformer named, cloud has rgb"""
    scene.show(display("PointCloud2", {"Size (m)": 0.05, "Color Transformer": None, "Position Transformer": None}))
    scene.publish("/cloud", cloud(waves(16, 12), fields=[("rgb", "rgb", packed(count_colors(192)))]))


@case
def pc2_transformer_unset_cloud_with_xyz(scene):
    """no transformer named, cloud has only xyz"""
    scene.show(display("PointCloud2", {"Size (m)": 0.05, "Color Transformer": None, "Position Transformer": None}))
    scene.publish("/cloud", cloud(waves(16, 12)))
