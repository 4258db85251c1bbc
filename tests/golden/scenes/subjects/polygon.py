"""The Polygon display."""

from geometry_msgs.msg import Polygon, PolygonStamped

from ..displays import display
from ..geometry import points32
from ..messages import header
from ..scene import LARGE


def polygon(scene):
    scene.camera(**LARGE)
    scene.show(display("Polygon", {"Alpha": 1, "Color": "25; 255; 0"}, name="p", topic="/p"))
    scene.publish("/p", PolygonStamped(header=header(), polygon=Polygon(points=points32([
        (-0.6, -0.5, 0.1), (0.6, -0.4, 0.2), (0.5, 0.6, 0.1), (-0.2, 0.3, 0.4)]))))


def polygon_rotated_frame_replaced(scene):
    scene.frame("sensor", at=(0.2, -0.1, 0.2), turned=(0.3, -0.2, 0.7))
    scene.show(display("Polygon", {"Alpha": 0.3, "Color": "255; 90; 200"}, name="p", topic="/poly"),
               display("Polygon", name="q", topic="/one"))
    scene.publish("/poly",
                  PolygonStamped(header=header(), polygon=Polygon(points=points32([(0, 0, 0), (1, 0, 0), (0, 1, 1)]))),
                  PolygonStamped(header=header("sensor"), polygon=Polygon(points=points32([
                      (-0.6, -0.4, 0), (0.6, -0.5, 0.2), (0.7, 0.5, 0), (0, 0.1, 0.4), (-0.5, 0.6, 0.1)]))))
    scene.publish("/one", PolygonStamped(header=header(), polygon=Polygon(points=points32([(0.3, 0.3, 0.1)]))))
