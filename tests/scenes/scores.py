"""How alike two pictures are, by the measures of the golden tests (`tests/golden/score.rs`).

A content pixel is one that differs by more than 2 levels from the expected picture's most frequent colour, in either picture.
"""

from typing import NamedTuple

import numpy

# Largest difference of a channel, of 255.
STRICT_LEVELS = 2
CLOSE_LEVELS = 16


class Scores(NamedTuple):
    """What a comparison found.

    different: how many pixels are not equal; largest: difference of a channel; strict, close: shares of the content pixels.
    """

    different: int
    largest: int
    strict: float
    close: float


def scores(expected, actual):
    """The Scores of two pictures of the same size: height × width or height × width × channels, 8 or 16 bits."""
    levels = 257 if expected.dtype == numpy.uint16 else 1
    expected, actual = (picture.reshape(*picture.shape[:2], -1).astype(int) for picture in (expected, actual))
    apart = numpy.abs(expected - actual).max(axis=2)
    colors, counts = numpy.unique(expected.reshape(-1, expected.shape[2]), axis=0, return_counts=True)
    background = colors[counts.argmax()]
    content = numpy.zeros(apart.shape, bool)
    for picture in (expected, actual):
        content |= numpy.abs(picture - background).max(axis=2) > STRICT_LEVELS * levels
    matches = _matches_nearby(expected, actual, CLOSE_LEVELS * levels)
    matches &= _matches_nearby(actual, expected, CLOSE_LEVELS * levels)
    strict = apart <= STRICT_LEVELS * levels
    matches |= strict

    def share(hits):
        return float((hits & content).sum() / content.sum()) if content.any() else 1.0

    return Scores(int((apart > 0).sum()), int(apart.max()), share(strict), share(matches))


def _matches_nearby(one, other, levels):
    """Where a pixel of `one` is like one of `other` at most one pixel away."""
    height, width = one.shape[:2]
    padded = numpy.pad(other, ((1, 1), (1, 1), (0, 0)), constant_values=-10 * levels)
    found = numpy.zeros((height, width), bool)
    for down in range(3):
        for right in range(3):
            found |= numpy.abs(one - padded[down:down + height, right:right + width]).max(axis=2) <= levels
    return found
