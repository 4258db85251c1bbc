"""Markers of text."""

import math

from ..displays import camera_pub, display
from ..geometry import quaternion
from ..messages import CUBE, TEXT, header, marker, markers
from ..scene import LARGE, Scene, family


def marker_text(scene):
    scene.camera(**LARGE)
    scene.show_markers(
        marker(TEXT, at=(0, 0, 0.5), size=(0, 0, 0.2), paint=(1, 1, 1), header=header(), text="grasp: gear"),
        marker(TEXT, at=(-0.3, 0.3, 0.1), size=(0, 0, 0.12), paint=(0, 1, 0), header=header(), id=1, text="0.87\nlarge screw"),
        marker(TEXT, at=(0.3, -0.4, 0.1), size=(0, 0, 0.3), paint=(1, 0.3, 0.3, 0.7), header=header(), id=2, text="Fetch"))


def marker_text_behind_and_before_a_cube(scene):
    scene.camera(roll=0.4)
    scene.frame("sensor", at=(0.1, -0.2, 0.3), turned=(0.5, -0.3, 0.9))
    scene.show_markers(
        marker(CUBE, at=(0, 0, 0.2), size=0.4, paint=(0.2, 0.4, 0.8), id=39),
        marker(TEXT, at=(0.4, 0.3, 0.3), size=(0, 0, 0.2), paint=(1, 1, 1), id=40, text="front"),
        marker(TEXT, at=(-0.5, -0.4, 0.3), size=(0, 0, 0.3), paint=(1, 0.5, 0), id=41, text="behind"),
        marker(TEXT, at=(0.1, 0.2, 0.5), turned=(0.4, 0.3, 0.8), size=(0, 0, 0.15), paint=(0, 1, 0), frame="sensor", id=42,
               text="frame"))


def marker_text_close_up(scene):
    scene.camera(eye=(0.8, 0.5, 0.5), target=(0, 0, 0.2))
    scene.show_markers(marker(TEXT, at=(0, 0, 0.2), size=(0, 0, 0.4), paint=(1, 0.8, 0.2), id=5, text="Ag&"))


def marker_text_over_background_grid_and_cube(scene):
    scene.show(display("Grid"), display("MarkerArray"), camera_pub({"Background Color": "180; 190; 220"}))
    scene.publish("/m", markers(
        marker(CUBE, at=(0.3, 0.2, 0.2), size=0.4, paint=(0.9, 0.2, 0.2, 0.5), id=26),
        marker(TEXT, at=(0, 0, 0.4), size=(0, 0, 0.3), paint=(0.1, 0.1, 0.1), id=27, text="dark"),
        marker(TEXT, at=(0.5, 0.4, 0.15), size=(0, 0, 0.2), paint=(1, 1, 1, 0.6), id=28, text="half")))


def marker_text_printable_ascii(scene):
    scene.camera(eye=(2, 0, 0.4), target=(-2, 0, 0), size=(480, 320), focal=(420, 420))
    scene.show_markers(
        marker(TEXT, at=(0.1, 0, 0.55), size=(0, 0, 0.11), paint=(1, 1, 1), id=34, text=" !\"#$%&'()*+,-./012"),
        marker(TEXT, at=(0.1, 0, 0.38), size=(0, 0, 0.11), paint=(1, 1, 1), id=35, text="3456789:;<=>?@ABCDE"),
        marker(TEXT, at=(0.1, 0, 0.21), size=(0, 0, 0.11), paint=(1, 1, 1), id=36, text="FGHIJKLMNOPQRSTUVWX"),
        marker(TEXT, at=(0.1, 0, 0.04), size=(0, 0, 0.11), paint=(1, 1, 1), id=37, text="YZ[\\]^_`abcdefghijk"),
        marker(TEXT, at=(0.1, 0, -0.13), size=(0, 0, 0.11), paint=(1, 1, 1), id=38, text="lmnopqrstuvwxyz{|}~"))


family(Scene.show_markers, {
    "marker_text_beyond_ascii": [
        marker(TEXT, at=(0, 0, 0.4), size=(0, 0, 0.2), paint=(1, 1, 1), id=43, text="Größe 20°"),
        marker(TEXT, size=(0, 0, 0.2), paint=(0, 1, 1), id=44, text="aΩb 中 c")],
    "marker_text_few_pixels": [
        marker(TEXT, at=(0.4, -0.4, 0.7), size=(0, 0, 0.02), paint=(1, 1, 1), id=13, text="Small text 0"),
        marker(TEXT, at=(-0.1, 0.1, 0.7), size=(0, 0, 0.026), paint=(1, 1, 1), id=14, text="Small text 1"),
        marker(TEXT, at=(0.4, -0.4, 0.57), size=(0, 0, 0.032), paint=(1, 1, 1), id=15, text="Small text 2"),
        marker(TEXT, at=(-0.1, 0.1, 0.57), size=(0, 0, 0.038), paint=(1, 1, 1), id=16, text="Small text 3"),
        marker(TEXT, at=(0.4, -0.4, 0.44), size=(0, 0, 0.044), paint=(1, 1, 1), id=17, text="Small text 4"),
        marker(TEXT, at=(-0.1, 0.1, 0.44), size=(0, 0, 0.05), paint=(1, 1, 1), id=18, text="Small text 5"),
        marker(TEXT, at=(0.4, -0.4, 0.31), size=(0, 0, 0.056), paint=(1, 1, 1), id=19, text="Small text 6"),
        marker(TEXT, at=(-0.1, 0.1, 0.31), size=(0, 0, 0.062), paint=(1, 1, 1), id=20, text="Small text 7"),
        marker(TEXT, at=(0.4, -0.4, 0.18), size=(0, 0, 0.068), paint=(1, 1, 1), id=21, text="Small text 8"),
        marker(TEXT, at=(-0.1, 0.1, 0.18), size=(0, 0, 0.074), paint=(1, 1, 1), id=22, text="Small text 9"),
        marker(TEXT, at=(0.4, -0.4, 0.05), size=(0, 0, 0.08), paint=(1, 1, 1), id=23, text="Small text 10"),
        marker(TEXT, at=(-0.1, 0.1, 0.05), size=(0, 0, 0.086), paint=(1, 1, 1), id=24, text="Small text 11")],
    "marker_text_larger_than_picture": [marker(
        TEXT, at=(0.3, 0.2, 0.3), size=(0, 0, 0.9), paint=(0.9, 0.9, 0.2, 0.8), id=25, text="Big\ngo")],
    "marker_text_long_line_cut_by_picture": [marker(
        TEXT, at=(0, 0, 0.2), size=(0, 0, 0.12), paint=(0.6, 1, 0.6), id=6,
        text="The quick brown fox jumps over the lazy dog 0123456789")],
    "marker_text_nan_orientation": [
        marker(TEXT, at=(0, 0, 0.5), turned=quaternion(math.nan, 0, 0, 1), size=(0, 0, 0.2), paint=(1, 1, 1), id=37, text="here"),
        marker(CUBE, size=0.2, paint=(0, 1, 0), id=38)],
    "marker_text_position_outside_picture": [
        marker(TEXT, at=(0.6, 1.4, 0.2), size=(0, 0, 0.3), paint=(1, 1, 1), id=7, text="outside the left"),
        marker(TEXT, at=(0, 0, 0.5), size=(0, 0, 0.1), paint=(1, 1, 1), id=8, text="in")],
    "marker_text_sizes_colors_alpha_lines": [
        marker(TEXT, at=(0, 0, 0.6), size=(0, 0, 0.3), paint=(1, 1, 0), id=31, text="Pick 42 %"),
        marker(TEXT, at=(-0.2, 0.2, 0.2), size=(0, 0, 0.08), paint=(0.3, 0.8, 1), id=32,
               text="first line\nsecond, longer line\n3rd"),
        marker(TEXT, at=(0.3, -0.5, 0.1), size=(0, 0, 0.18), paint=(1, 0.3, 0.8, 0.4), id=33, text="gy|jq_{}")],
    "marker_text_spaces_tab_empty_lines": [
        marker(TEXT, at=(0, 0, 0.5), size=(0, 0, 0.15), paint=(1, 1, 1), id=45, text="  two  spaces  "),
        marker(TEXT, at=(0, 0, 0.1), size=(0, 0, 0.15), paint=(1, 1, 0), id=46, text="tab\there\n\nend\n")]})
