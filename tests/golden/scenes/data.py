"""Numbers of scenes that follow no rule, kept beside this file: one `.npz` for each module of `subjects`."""

import pathlib

import numpy


def load(name):
    """The arrays of a module, by name."""
    with numpy.load(pathlib.Path(__file__).parent / "data" / f"{name}.npz") as arrays:
        return {key: arrays[key] for key in arrays.files}
