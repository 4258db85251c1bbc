"""Markers of triangle lists."""

from ..clouds import fan
from ..data import load
from ..displays import display
from ..messages import TRIANGLES, header, marker, markers
from ..scene import LARGE, Scene, family

DATA = load("marker_triangles")


def marker_triangles(scene):
    scene.camera(**LARGE)
    scene.show_markers(
        marker(TRIANGLES, at=(-0.4, 0, 0.1), size=1, paint=(0.9, 0.6, 0.1), header=header(), points=fan(8, 0.5, 0.5)),
        marker(TRIANGLES, at=(0.5, 0.1, 0.1), size=(0.8, 0.8, 1.2), paint=(1, 0.5, 0), header=header(), id=1,
               points=fan(8, 0.5, 0.5), colors=DATA["marker_triangles_1_colors"]))


def marker_triangles_coincident_later_wins(scene):
    scene.show(display("MarkerArray"))
    corners = [(0.5, 0, 0.1), (-0.3, 0.4, 0.1), (-0.3, -0.4, 0.5)]
    scene.publish("/m", markers(marker(
        TRIANGLES, size=1, paint=(1, 1, 1), points=corners * 3,
        colors=[(1, 0, 0)] * 3 + [(0, 0.3, 1)] * 3 + [(1, 0.6, 0), (0.2, 1, 0), (0, 0.6, 1)])))


def marker_triangles_degenerate_among_others(scene):
    scene.show(display("MarkerArray"))
    good = [(0.5, 0, 0.1), (-0.3, 0.4, 0.1), (-0.3, -0.4, 0.5)]
    two_equal = [(0, 0, 0.6), (0, 0, 0.6), (0.2, 0, 0.6)]
    all_equal = [(0, 0, 0.6)] * 3
    on_a_line = [(0, 0, 0.6), (0.1, 0, 0.6), (0.2, 0, 0.6)]
    lists = [two_equal + good, good + all_equal, good + on_a_line + two_equal]
    scene.publish("/m", markers(
        *(marker(TRIANGLES, at=(0, 0.5 * i - 0.5, 0), size=0.6, paint=(1, 0.5, 0.2, 1 if i < 2 else 0.5), id=i, points=each)
          for i, each in enumerate(lists)),
        marker(TRIANGLES, at=(0.6, 0, 0), size=0.4, paint=(1, 1, 1), id=3, points=good + two_equal,
               colors=[(0, 1, 0.5)] * 3 + [(1, 0, 0)] * 3)))


def marker_triangles_gain_and_lose_colors(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m",
                  markers(marker(TRIANGLES, at=(-0.3, -0.3, 0), size=0.6, paint=(0.6, 1, 0.2), id=1,
                                 points=fan(6, 0.6, 0.5, wave=0.3, step=1.0472)),
                          marker(TRIANGLES, at=(0.3, 0.3, 0), size=0.6, paint=(0.6, 1, 0.2), id=2,
                                 points=fan(6, 0.6, 0.5, wave=0.3, step=1.0472),
                                 colors=[(0, 0, 1), (0.5, 1, 0.8333333), (1, 0, 0.6666667), (0, 1, 0.5), (0.5, 0, 0.33333334),
                                         (1, 1, 0.16666667)])),
                  markers(marker(TRIANGLES, at=(-0.3, -0.3, 0), size=0.6, paint=(0.6, 1, 0.2), id=1,
                                 points=fan(6, 0.6, 0.5, wave=0.3, step=1.0472),
                                 colors=[(0, 0, 1), (0.5, 1, 0.8333333), (1, 0, 0.6666667), (0, 1, 0.5), (0.5, 0, 0.33333334),
                                         (1, 1, 0.16666667)]),
                          marker(TRIANGLES, at=(0.3, 0.3, 0), size=0.6, paint=(0.6, 1, 0.2), id=2, points=fan(
                              6, 0.6, 0.5, wave=0.3, step=1.0472))))


family(Scene.show_markers, {
    "marker_triangles_color_and_alpha_per_vertex": [marker(
        TRIANGLES, at=(0, 0, 0.1), turned=(0.4, 0.3, 0.8), size=(1, 1, 0.6), paint=(1, 1, 1, 0.8), id=49,
        points=fan(6, 0.6, 0.5, wave=0.3, step=1.0472), colors=DATA["marker_triangles_color_and_alpha_per_vertex_0_colors"])],
    "marker_triangles_color_per_face_opaque": [marker(
        TRIANGLES, size=1, paint=(1, 1, 1), id=48, points=fan(6, 0.6, 0.5, wave=0.3, step=1.0472),
        colors=[(0, 0, 1), (0.5, 1, 0.8333333), (1, 0, 0.6666667), (0, 1, 0.5), (0.5, 0, 0.33333334), (1, 1, 0.16666667)])],
    "marker_triangles_color_per_face_translucent": [marker(
        TRIANGLES, size=1, paint=(1, 1, 1), id=47, points=fan(6, 0.6, 0.5, wave=0.3, step=1.0472),
        colors=[(0, 0, 1, 0.4), (0.5, 1, 0.8333333, 0.5), (1, 0, 0.6666667, 0.6), (0, 1, 0.5, 0.7), (0.5, 0, 0.33333334, 0.8),
                (1, 1, 0.16666667, 0.9)])],
    "marker_triangles_one_color_lit_both_sides": [
        marker(TRIANGLES, at=(-0.4, 0, 0), size=(0.7, 0.7, 1.2), paint=(0.9, 0.6, 0.2), id=50, points=fan(
            6, 0.6, 0.5, wave=0.3, step=1.0472)),
        marker(TRIANGLES, at=(0.5, 0.2, 0.4), turned=(3, 0, 0), size=0.6, paint=(0.3, 0.6, 0.9), id=51,
               points=fan(6, 0.6, 0.5, wave=0.3, step=1.0472)),
        marker(TRIANGLES, at=(0.2, -0.6, 0.2), size=0.5, paint=(0.3, 0.9, 0.4, 0.5), id=52, points=fan(
            6, 0.6, 0.5, wave=0.3, step=1.0472))]})
