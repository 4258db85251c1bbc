"""What laser scanners of the scenes measure."""

import numpy


def ring_ranges(count, scale=1.0, waves=5, middle=0.7, height=0.25):
    """`count` distances from -2 to 2 rad, in waves about `middle`, all of it times `scale`."""
    return scale * (middle + height * numpy.sin(waves * numpy.linspace(-2.0, 2.0, count)))
