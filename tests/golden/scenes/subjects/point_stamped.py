"""The PointStamped display."""

from geometry_msgs.msg import PointStamped

from ..displays import display
from ..geometry import point
from ..messages import header
from ..scene import LARGE


def point_stamped(scene):
    scene.camera(**LARGE)
    scene.show(display("PointStamped", {"Alpha": 1, "Color": "204; 41; 204", "Radius": 0.15}, name="p", topic="/p"))
    scene.publish("/p", PointStamped(header=header(), point=point(0.1, 0.2, 0.3)))


def point_stamped_history(scene):
    scene.frame("sensor", at=(0.2, -0.1, 0.2), turned=(0.3, -0.2, 0.7))
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PointStamped", {"Alpha": 0.5, "Color": "255; 220; 0", "History Length": 3, "Radius": 0.12}, name="p",
                       topic="/pt"))
    scene.publish("/pt", *(PointStamped(header=header("sensor"), point=point(-0.6 + 0.3 * i, -0.3 + 0.2 * i, 0.1 + 0.05 * i))
                           for i in range(5)))
