"""The properties of the display in rviz, and the effect of each."""

import pathlib
import unittest

import numpy
import yaml

from golden.scenes.processes import wait_until

from .camera_topics import CameraFrame, Infos, Pictures, camera_info, pixels, trigger
from .stage import stage
from .window import ANSWER_TIMEOUT_SECS, CAMERA_PUB, OK, WARNING, Rviz, camera, grid

# Of the plugin that this one replaces: names in their order, values of a new display, and help.
INHERITED = [
    ("Visibility", "true", "Changes the visibility of other Displays in the camera view."),
    ("Image Topic", "", "sensor_msgs::Image topic to publish to."),
    ("Display namespace", "", "Namespace for this display."),
    ("Camera Info Topic", "", "sensor_msgs::CameraInfo topic to subscribe to."),
    ("Queue Size", "2", "Advanced: set the size of the incoming message queue.  Increasing this is useful if your incoming TF "
     "data is delayed significantly from your image data, but it can greatly increase memory usage if the messages are big."),
    ("Frame Rate", "-1", "Sets target frame rate. Set to < 0 for maximum speed, set to 0 to stop, you can trigger single images "
     "with the /rviz_camera_trigger service."),
    ("Background Color", "0; 0; 0", "Sets background color, values from 0.0 to 1.0."),
    ("Image Encoding", "rgb8", "Sets the image encoding"),
    ("Near Clip Distance", "0.01", "Set the near clip distance"),
]
ADDED = ["Projection", "Undistort", "Depth Topic", "Headless Twin"]

# What that plugin saves for such a display.
SAVED = """\
Background Color: 1; 2; 3
Camera Info Topic: /camera/info
Class: rviz_camera_stream/CameraPub
Display namespace: camera
Enabled: true
Frame Rate: 12.5
Image Encoding: bgra8
Image Topic: /camera/image
Name: Camera
Near Clip Distance: 0.5
Queue Size: 7
Value: true
Visibility:
  Driver: true
  Grid: false
  Value: true
"""


class Properties(unittest.TestCase):
    frame: CameraFrame

    @classmethod
    def setUpClass(cls):
        stage()
        cls.frame = CameraFrame()

    @classmethod
    def tearDownClass(cls):
        cls.frame.close()

    def topic(self, kind, *arguments):
        opened = kind(*arguments)
        self.addCleanup(opened.close)
        return opened

    def open(self, *displays, **settings):
        rviz = Rviz(displays, **settings)
        self.addCleanup(lambda: self.assertEqual(rviz.close(), 0, rviz.program.last_lines(40)))
        return rviz

    def test_names_defaults_order_and_help_are_those_of_before(self):
        rviz = self.open(grid())
        rviz.command("create", "New", CAMERA_PUB)
        lines = [line.split("\t") for line in rviz.command("properties", "New").splitlines()]
        shown = [(name, value, text) for name, value, text in lines if not name.startswith("Status")]
        # The value of a real number is shown as the nearest 32-bit one.
        shown = [(name, "0.01" if name == "Near Clip Distance" and abs(float(value) - 0.01) < 1e-9 else value, text)
                 for name, value, text in shown]
        self.assertEqual(shown[:len(INHERITED)], INHERITED)
        self.assertEqual([name for name, _, _ in shown[len(INHERITED):]], ADDED)
        self.assertTrue(all(text for _, _, text in shown))

    def test_a_config_is_loaded_and_saved_as_before(self):
        rviz = self.open(grid(), yaml.safe_load(SAVED))
        self.assertEqual(rviz.command("settings", "Camera").strip(), SAVED.strip())
        rviz.command("set", "Camera", "Undistort", "true")
        rviz.command("set", "Camera", "Projection", "exact")
        rviz.command("set", "Camera", "Depth Topic", "/depth")
        added = {"Undistort": True, "Projection": "exact", "Depth Topic": "/depth"}
        saved = yaml.safe_load(rviz.command("settings", "Camera"))
        self.assertEqual({name: saved.pop(name) for name in added}, added)
        self.assertEqual(saved, yaml.safe_load(SAVED))
        rviz.command("duplicate", "Camera", "Copy")
        self.assertEqual(rviz.command("get", "Copy", "Projection"), "exact")

    def test_every_encoding_has_its_bytes(self):
        self.topic(Infos, "/camera/info", camera_info())
        pictures = self.topic(Pictures, "/camera/image")
        rviz = self.open(camera(**{"Background Color": "10; 20; 30"}))
        expected = {"rgb8": [10, 20, 30], "rgba8": [10, 20, 30, 255], "bgr8": [30, 20, 10], "bgra8": [30, 20, 10, 255],
                    "mono8": [10], "mono16": [10, 10]}
        for encoding, pixel in expected.items():
            rviz.command("set", "Camera", "Image Encoding", encoding)
            picture = pictures.wait_for(lambda each: each.encoding == encoding, encoding, rviz)
            self.assertEqual(picture.data, bytes(pixel) * (64 * 48))
            self.assertEqual(picture.step, 64 * len(pixel))

    def test_picture_and_camera_info_have_one_stamp_and_frame(self):
        import rospy
        from sensor_msgs.msg import CameraInfo
        received = {}
        sent = camera_info(D=[0.1, 0.0, 0.0, 0.0, 0.0])
        self.topic(Infos, "/camera/info", sent)
        pictures = self.topic(Pictures, "/camera/image")
        subscriber = rospy.Subscriber("/camera/camera_info", CameraInfo, lambda each: received.update({each.header.stamp: each}))
        self.addCleanup(subscriber.unregister)
        rviz = self.open(camera())
        picture = pictures.wait_for(lambda each: each.header.stamp in received, "with a CameraInfo", rviz)
        info = received[picture.header.stamp]
        self.assertEqual((picture.header.frame_id, info.header.frame_id), ("camera", "camera"))
        self.assertEqual((info.P, info.D, info.width), (tuple(sent.P), tuple(sent.D), 64))

    def test_frame_rates(self):
        self.topic(Infos, "/camera/info", camera_info())
        pictures = self.topic(Pictures, "/camera/image")
        rviz = self.open(grid(), camera(**{"Frame Rate": 5}))
        pictures.next(rviz)
        first = pictures.next(rviz).header.stamp
        wait_until(lambda: len(pictures.all()) > 10, ANSWER_TIMEOUT_SECS, "ten pictures", [rviz.program])
        took = (pictures.all()[10].header.stamp - first).to_sec()
        # On a loaded machine rviz itself may be slower, never faster.
        self.assertGreater(took, 1.7)
        rviz.command("set", "Camera", "Frame Rate", 0)
        rviz.frames(5)
        self.assertEqual(pictures.quiet_for(0.5), [])
        trigger("/camera/camera_trigger")
        pictures.wait_for(lambda _: True, "for a trigger", rviz)
        self.assertEqual(pictures.quiet_for(0.3), [])
        rviz.command("set", "Camera", "Frame Rate", -1)
        pictures.next(rviz)
        rviz.wait_for_status("Camera", "Timing", OK, "pictures/s")

    def test_nothing_is_drawn_while_nobody_subscribes(self):
        self.topic(Infos, "/camera/info", camera_info())
        rviz = self.open(grid(), camera())
        rviz.wait_for_status("Camera", "Camera Info", OK)
        rviz.frames(10)
        self.assertNotIn("Timing", rviz.statuses("Camera"))
        pictures = self.topic(Pictures, "/camera/image")
        pictures.next(rviz)

    def test_visibility_hides_a_display(self):
        self.topic(Infos, "/camera/info", camera_info())
        pictures = self.topic(Pictures, "/camera/image")
        rviz = self.open(grid(), camera(Visibility={"Value": True, "Grid": False}))
        pictures.next(rviz)
        self.assertEqual(pixels(pictures.next(rviz)).max(), 0)
        rviz.command("remove", "Camera")
        rviz.command("create", "Camera", CAMERA_PUB)
        rviz.command("set", "Camera", "Camera Info Topic", "/camera/info")
        rviz.command("set", "Camera", "Image Topic", "/camera/image")
        pictures.wait_for(lambda each: pixels(each).max() == 255, "with the grid", rviz)

    def test_depths_are_metres_along_the_optical_axis(self):
        import rospy
        from visualization_msgs.msg import Marker
        wall = Marker(type=Marker.CUBE, action=Marker.ADD, ns="wall")
        wall.header.frame_id = "camera"
        wall.pose.position.x, wall.pose.position.z, wall.pose.orientation.w = 1.0, 2.5, 1.0
        wall.scale.x, wall.scale.y, wall.scale.z = 2.0, 4.0, 1.0
        wall.color.r = wall.color.a = 1.0
        publisher = rospy.Publisher("/wall", Marker, latch=True, queue_size=1)
        publisher.publish(wall)
        self.addCleanup(publisher.unregister)
        self.topic(Infos, "/camera/info", camera_info(64, 48, focal=50.0))
        depths = self.topic(Pictures, "/camera/depth")
        marker = {"Class": "rviz/Marker", "Name": "Wall", "Enabled": True, "Value": True, "Marker Topic": "/wall"}
        rviz = self.open(marker, camera(**{"Depth Topic": "/camera/depth"}))
        picture = depths.wait_for(lambda each: numpy.isfinite(pixels(each)).any(), "with the wall", rviz)
        self.assertEqual((picture.encoding, picture.step, picture.header.frame_id), ("32FC1", 4 * 64, "camera"))
        values = pixels(picture)
        # The wall's front is 2 m away and fills the right half.
        self.assertTrue(numpy.isnan(values[:, :31]).all())
        numpy.testing.assert_allclose(values[:, 34:], 2.0, atol=1e-3)

    def test_undistort_bends_the_picture_and_keeps_its_size(self):
        bent = camera_info(200, 100, focal=90, D=[-0.3, 0.0, 0.0, 0.0, 0.0])
        self.topic(Infos, "/camera/info", bent)
        pictures = self.topic(Pictures, "/camera/image")
        rviz = self.open(grid(), camera())
        straight = pixels(pictures.wait_for(lambda each: pixels(each).max() == 255, "with the grid", rviz))
        rviz.wait_for_status("Camera", "Camera Info", WARNING, "D")
        rviz.command("set", "Camera", "Undistort", "true")
        wait_until(lambda: rviz.statuses("Camera")["Camera Info"][0] == OK, ANSWER_TIMEOUT_SECS, "the warning is still there")
        picture = pixels(pictures.next(rviz))
        self.assertEqual(picture.shape, straight.shape)
        self.assertGreater(int((picture != straight).sum()), 100)
        # A barrel lens pulls what is far from the middle towards it; undone, that lies farther out.
        def outermost(each):
            return numpy.flatnonzero((each[:, :, 0] > 100).sum(axis=1) > 60)
        self.assertGreater(len(outermost(straight)), len(outermost(picture)))

    def test_the_headless_twin_follows_rviz(self):
        folder = pathlib.Path(stage().folder)
        path = folder / "twin.rviz"
        unknown = {"Class": "somebody_rviz/Thing", "Name": "Thing", "Enabled": True, "Value": True}
        rviz = self.open(grid(), unknown, camera(**{"Headless Twin": str(path)}))
        line = rviz.wait_for_status("Camera", "Headless Twin", OK, "roslaunch rviz_camera_stream")
        self.assertIn(str(path), line)
        rviz.wait_for_status("Camera", "Headless Twin: not drawn", WARNING, "Thing")
        twin = yaml.safe_load(path.read_text())["Visualization Manager"]
        self.assertEqual({each["Name"] for each in twin["Displays"]}, {"Grid", "Thing", "Camera", "Driver"})
        self.assertEqual(twin["Global Options"]["Fixed Frame"], "map")
        rviz.command("set", "Grid", "Cell Size", "2.5")
        wait_until(lambda: "Cell Size: 2.5" in path.read_text(), ANSWER_TIMEOUT_SECS, "the twin does not follow", [rviz.program])
        rviz.command("set", "Camera", "Headless Twin", "/nowhere/at/all.rviz")
        rviz.wait_for_status("Camera", "Headless Twin", 2, "/nowhere/at/all.rviz")
        rviz.command("set", "Camera", "Headless Twin", "")
        wait_until(lambda: "Headless Twin" not in rviz.statuses("Camera"), ANSWER_TIMEOUT_SECS, "the status is still there")


if __name__ == "__main__":
    unittest.main()
