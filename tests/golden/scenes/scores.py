"""How alike two pictures are, by the measures of the golden tests (`tests/golden/score.rs`).

A content pixel is one that differs by more than 2 levels from the expected picture's most frequent colour, in either picture.
"""

from typing import NamedTuple

import numpy

# Largest difference of a channel, of 255.
STRICT_LEVELS = 2
CLOSE_LEVELS = 16


class Scores(NamedTuple):
    """The result of a comparison.

    different: how many pixels are not equal; largest: difference of a channel; strict, close: shares of the content pixels;
    content: how many content pixels there are.
    """

    different: int
    largest: int
    strict: float
    close: float
    content: int


def scores(expected, actual):
    """The Scores of two pictures of the same size: height × width or height × width × channels, 8 or 16 bits."""
    expected, actual, levels = _comparable(expected, actual)
    apart = numpy.abs(expected - actual).max(axis=2)
    background = _most_frequent_color(expected)
    content = numpy.zeros(apart.shape, bool)
    for picture in (expected, actual):
        content |= numpy.abs(picture - background).max(axis=2) > STRICT_LEVELS * levels
    strict = apart <= STRICT_LEVELS * levels

    def share(hits):
        return float((hits & content).sum() / content.sum()) if content.any() else 1.0

    close = _are_close(expected, actual, levels)
    return Scores(int((apart > 0).sum()), int(apart.max()), share(strict), share(close), int(content.sum()))


def comparison(expected, actual):
    """Expected | difference | actual, as RGB of 8 bits; what is not close is magenta in the middle."""
    close = _are_close(*_comparable(expected, actual))
    expected, actual = (_rgb(picture) for picture in (expected, actual))
    middle = numpy.where(close[:, :, None], actual // 3, numpy.array((255, 0, 255), numpy.uint8))
    return numpy.concatenate((expected, middle, actual), axis=1)


def _comparable(expected, actual):
    """Both pictures as height × width × channels of integers, and how many of their levels are one of 255."""
    levels = 257 if expected.dtype == numpy.uint16 else 1
    return *(picture.reshape(*picture.shape[:2], -1).astype(numpy.int32) for picture in (expected, actual)), levels


def _rgb(picture):
    if picture.dtype == numpy.uint16:
        picture = (picture // 257).astype(numpy.uint8)
    return numpy.repeat(picture[:, :, None], 3, axis=2) if picture.ndim == 2 else picture


def _most_frequent_color(picture):
    """The smallest of them, if several are as frequent."""
    # One number for each pixel.
    packed = picture.astype(numpy.int64) @ (1 << 16 * numpy.arange(picture.shape[2])[::-1])
    numbers, first, counts = numpy.unique(packed, return_index=True, return_counts=True)
    return picture.reshape(-1, picture.shape[2])[first[counts.argmax()]]


def _are_close(expected, actual, levels):
    """Where pixels match, each in the other picture, at most one pixel away."""
    close = numpy.abs(expected - actual).max(axis=2) <= STRICT_LEVELS * levels
    # Most pixels match where they are.
    places = numpy.nonzero(~close)
    close[places] = (_match_nearby(expected, actual, places, CLOSE_LEVELS * levels)
                     & _match_nearby(actual, expected, places, CLOSE_LEVELS * levels))
    return close


def _match_nearby(one, other, places, levels):
    """Which of the pixels of `one` at `places` are like one of `other` at most one pixel away."""
    rows, columns = places
    padded = numpy.pad(other, ((1, 1), (1, 1), (0, 0)), constant_values=-10 * levels)
    found = numpy.zeros(rows.shape, bool)
    for down in range(3):
        for right in range(3):
            found |= numpy.abs(one[places] - padded[rows + down, columns + right]).max(axis=1) <= levels
    return found
