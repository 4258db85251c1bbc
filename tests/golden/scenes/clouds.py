"""Point clouds for the scenes: a few shapes, a few ways to colour them, and the PointCloud2 of any fields.

Shapes are arrays of n × 3 numbers in metres, channels are arrays of n. All are the same each time.
"""

import math

import numpy
from sensor_msgs.msg import PointCloud2, PointField

from .messages import header

_TYPES = {"int8": 1, "uint8": 2, "int16": 3, "uint16": 4, "int32": 5, "uint32": 6, "float32": 7, "float64": 8}


# Points that lie in no order, and no nearer to each other than markers need.
SCATTERED = [
    (0.10201343894004822, -0.07649841159582138, 0.5620033741), (-0.035613980144262314, 0.015484984964132309, 0.22356292605400085),
    (-0.4412810206413269, -0.2871411442756653, 0.0910501480102539),
    (-0.08555378764867783, -0.30935078859329224, -0.05313597619533539),
    (-0.044158484786748886, 0.07426488399505615, -0.2048734873533249),
    (-0.10405879467725754, 0.17111675441265106, 0.2760317325592041),
    (-0.31145262718200684, 0.13290244340896606, -0.20210231840610504),
    (-0.386665940284729, -0.3934466242790222, -0.19066210091114044)]


def spiral(count):
    """Points that go up around the z axis."""
    return [(0.5 * math.cos(0.7 * i), 0.5 * math.sin(0.7 * i), 0.05 * i) for i in range(count)]


def waves(columns, rows, height=lambda x, y: 0.2 + 0.15 * numpy.sin(3 * x) * numpy.cos(2 * y) + 0.1 * y,
          half_size=(0.8, 0.6)):
    """A grid of points over x and y around the origin, row by row, whose z is `height(x, y)`."""
    x, y = numpy.meshgrid(numpy.linspace(-half_size[0], half_size[0], columns),
                          numpy.linspace(-half_size[1], half_size[1], rows))
    z = numpy.broadcast_to(height(x, y), x.shape)
    return numpy.stack((x, y, z), axis=-1).reshape(-1, 3)


def ripples(columns, rows):
    """Waves with hills in both directions."""
    return waves(columns, rows, lambda x, y: 0.2 + 0.12 * numpy.sin(4 * x) * numpy.cos(5 * y))


def count_colors(count):
    """Colours that differ from point to point, n × 3 of 0 to 255, the first of them blue."""
    index = numpy.arange(count)
    return numpy.stack((40 + 53 * index % 216, 29 * index % 256, 255 - 17 * index % 256), axis=-1)


def corner_colors(xyz):
    """Red along x, green along y, blue along z, n × 3 from 0 to just below 1."""
    xyz = numpy.asarray(xyz, float)
    offset = xyz - xyz.min(axis=0)
    # A sine's last digit depends on the processor, so that of two least ones one may be a little above the other.
    offset[offset < 1e-12] = 0
    return offset / (numpy.ptp(xyz, axis=0) + 1e-12)


def packed(rgb, alpha=0):
    """Colours n × 3 of 0 to 255 as one integer each, as in the field `rgba` and, read as a float, `rgb`."""
    red, green, blue = numpy.asarray(rgb).astype(numpy.uint32).T
    return numpy.asarray(alpha).astype(numpy.uint32) << 24 | red << 16 | green << 8 | blue


def cloud(xyz, frame="base_link", fields=(), rgb=None, **options):
    """A PointCloud2 with the float32 fields x, y, z and the further `fields`.

    rgb: colours n × 3 of 0 to 255, for a field `rgb` instead.
    fields: (name, type, values), where the type is numpy's name of it, or `rgb` for packed colours in a float.
    options: those of `raw_cloud`.
    """
    xyz = numpy.asarray(xyz, float)
    position = [(name, "float32", xyz[:, axis]) for axis, name in enumerate("xyz")]
    if rgb is not None:
        fields = [("rgb", "rgb", packed(rgb))]
    return raw_cloud([*position, *fields], frame, **options)


def colored_waves():
    """A PointCloud2 of 16 × 12 points in waves, each of another colour."""
    return cloud(waves(16, 12), rgb=count_colors(192))


def raw_cloud(fields, frame="base_link", rows=1, point_step=None, offsets=None, is_dense=False):
    """A PointCloud2 of nothing but `fields`: (name, type, values), in their order without gaps.

    point_step: bytes of a point, if there are more than the fields need. offsets: of the fields, if not one after the other.
    """
    types = ["float32" if kind == "rgb" else kind for _, kind, _ in fields]
    sizes = [numpy.dtype(kind).itemsize for kind in types]
    offsets = offsets or [sum(sizes[:index]) for index in range(len(sizes))]
    point_step = point_step or sum(sizes)
    count = len(fields[0][2])
    layout = numpy.dtype({"names": [name for name, _, _ in fields], "formats": types, "offsets": offsets,
                          "itemsize": point_step})
    data = numpy.zeros(count, layout)
    for name, kind, values in fields:
        data[name] = numpy.asarray(values, numpy.uint32).view(numpy.float32) if kind == "rgb" else values
    # Without this, the bytes of a packed colour that are no number as a float could change.
    return PointCloud2(
        header=header(frame), height=rows, width=count // rows, point_step=point_step,
        row_step=point_step * (count // rows), is_dense=is_dense, data=data.tobytes(),
        fields=[PointField(name, offset, _TYPES[kind], 1) for (name, _, _), offset, kind in zip(fields, offsets, types)])


def ball(count, radius, seed=1):
    """Points that lie around the origin in any direction, 0.3 to 1 times `radius` away."""
    random = numpy.random.RandomState(seed)
    directions = random.randn(count, 3)
    directions /= numpy.linalg.norm(directions, axis=1)[:, None]
    return directions * (radius * (0.3 + 0.7 * random.rand(count)))[:, None]


def any_colors(count, seed):
    """Colours at random, none of them dark, n × 3 of 0 to 255."""
    return numpy.random.RandomState(seed).randint(40, 256, (count, 3))


def with_values(xyz, which, values):
    """The points with `values` for x, y and z at the indices `which`; None leaves a coordinate as it is."""
    changed = numpy.array(xyz, float)
    for axis, value in enumerate(values):
        if value is not None:
            changed[list(which), axis] = value
    return changed


def columns(xyz, kind="float32"):
    """The fields x, y and z of a `raw_cloud`."""
    return [(name, kind, numpy.asarray(xyz, float)[:, axis]) for axis, name in enumerate("xyz")]


def cut(message, count):
    """The cloud with no more than the first `count` bytes of its data."""
    message.data = message.data[:count]
    return message


def random_rows(count, seed):
    """Three numbers from 0 to 1 at random for each point."""
    return numpy.random.RandomState(seed).rand(count, 3)


def fan(count, radius, height, wave=0.0, step=None):
    """The corners of `count` triangles around a peak at `height`. Every other outer corner is at `wave` instead of 0.

    step: the angle of a triangle in radians, usually such that they close.
    """
    step = step or 2 * numpy.pi / count
    index = numpy.arange(count)
    rim = numpy.stack((radius * numpy.cos(step * index), radius * numpy.sin(step * index), wave * (index % 2)), axis=-1)
    return numpy.concatenate([[(0.0, 0.0, height), rim[each], rim[(each + 1) % count]] for each in index])
