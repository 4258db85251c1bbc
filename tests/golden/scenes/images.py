"""Images of a depth camera for the scenes: depths in metres as arrays of height × width, colours of height × width × 3."""

import numpy
from sensor_msgs.msg import Image

from .messages import header

_BYTES = {"32FC1": 4, "16UC1": 2, "rgb8": 3, "bgr8": 3, "rgba8": 4, "mono8": 1}
_TYPES = {"32FC1": numpy.float32, "16UC1": numpy.uint16}


def image(pixels, encoding, frame="depth_cam", secs=0.0):
    """A sensor_msgs/Image of the array."""
    pixels = numpy.asarray(pixels).astype(_TYPES.get(encoding, numpy.uint8))
    height, width = pixels.shape[:2]
    return Image(header=header(frame, secs), height=height, width=width, encoding=encoding, step=_BYTES[encoding] * width,
                 data=pixels.tobytes())


def _indices(width, height):
    return numpy.meshgrid(numpy.arange(width), numpy.arange(height))


def hilly_depth(near=None):
    """64 × 48 pixels of hills about 1.2 m away, with NaN along each 23rd diagonal.

    near: columns from, to and rows from, to, where something is 0.7 m away.
    """
    column, row = _indices(64, 48)
    depth = 1.2 + 0.25 * numpy.sin(0.15 * column) + 0.2 * numpy.cos(0.2 * row)
    if near:
        left, right, top, bottom = near
        depth[top:bottom, left:right] = 0.7
    depth[(column + row) % 23 == 0] = numpy.nan
    return depth


def wavy_depth(width, height, hole=(0, 0, 0, 0)):
    """Waves about 1.2 m away. hole: columns from, to and rows from, to, where there is NaN."""
    column, row = _indices(width, height)
    depth = 1.2 + 0.2 * numpy.sin(column / 25) * numpy.cos(row / 20)
    left, right, top, bottom = hole
    depth[top:bottom, left:right] = numpy.nan
    return depth


def millimetres(depth):
    """Depths as whole millimetres, 0 where there are none."""
    return numpy.where(numpy.isnan(depth), 0, 1000 * depth)


def ramps():
    """Colours for 64 × 48 pixels: red grows to the right, green downwards, blue shrinks with both."""
    column, row = _indices(64, 48)
    return numpy.stack((4 * column, 5 * row, 255 - 2 * (column + row)), axis=-1)


def size_ramps(width, height):
    """Colours for any size: red from left to right, green from top to bottom, blue along both, again and again."""
    column, row = _indices(width, height)
    return numpy.stack((column * 255 // width, row * 255 // height, (column + row) % 256), axis=-1)


def with_alpha(colors):
    """The colours with an alpha of 255."""
    return numpy.dstack((colors, numpy.full(colors.shape[:2], 255)))
