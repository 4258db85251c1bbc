"""Faults of the plugin that this one replaces: each would come back here."""

import math
import os
import pathlib
import unittest

from golden.scenes.processes import wait_until

from .camera_topics import CameraFrame, Infos, Pictures, camera_info, pixels, trigger
from .stage import PREFIX_VARIABLE, stage
from .window import ANSWER_TIMEOUT_SECS, CAMERA_PUB, ERROR, OK, WARNING, Rviz, camera, grid


class Faults(unittest.TestCase):
    frame: CameraFrame

    @classmethod
    def setUpClass(cls):
        stage()
        cls.frame = CameraFrame()

    @classmethod
    def tearDownClass(cls):
        cls.frame.close()

    def topic(self, kind, *arguments):
        """A publisher or subscriber that ends with the test."""
        opened = kind(*arguments)
        self.addCleanup(opened.close)
        return opened

    def open(self, *displays, **settings):
        """rviz with these displays; the test fails if it does not close cleanly."""
        rviz = Rviz(displays, **settings)
        self.addCleanup(lambda: self.assertEqual(rviz.close(), 0, rviz.program.last_lines(40)))
        return rviz

    def test_a_camera_info_that_changes_size_again_and_again_keeps_one_texture(self):
        infos = self.topic(Infos, "/camera/info", camera_info())
        pictures = self.topic(Pictures, "/camera/image")
        rviz = self.open(grid(), camera())
        pictures.next(rviz)
        before = rviz.resources()
        for width, height in [(128, 96), (640, 480), (37, 23), (1280, 800), (64, 48)] * 4:
            infos.send(camera_info(width, height))
            pictures.forget()
            picture = pictures.wait_for(lambda each: each.width == width, f"of {width}x{height}", rviz)
            self.assertEqual((picture.height, picture.step, len(picture.data)), (height, 3 * width, 3 * width * height))
        self.assertEqual(rviz.resources(), before)

    def test_a_display_can_be_added_by_the_topic_of_an_image(self):
        self.topic(Infos, "/added/camera_info", camera_info())
        pictures = self.topic(Pictures, "/added/image")
        rviz = self.open(grid())
        rviz.command("create", "Added", "rviz_camera_stream/CameraPub")
        rviz.command("topic", "Added", "/added/image", "sensor_msgs/Image")
        rviz.command("topic", "Added", "/added/camera_info", "sensor_msgs/CameraInfo")
        self.assertEqual(pictures.next(rviz).width, 64)
        rviz.command("topic", "Added", "/other/image/compressed", "sensor_msgs/CompressedImage")
        self.assertEqual(rviz.command("get", "Added", "Image Topic"), "/other/image")

    def test_the_background_colour_is_that_of_the_same_frame(self):
        self.topic(Infos, "/camera/info", camera_info())
        pictures = self.topic(Pictures, "/camera/image")
        rviz = self.open(camera(**{"Frame Rate": 0, "Background Color": "10; 20; 30"}))
        rviz.wait_for_status("Camera", "Camera Info", OK)
        pictures.connect(rviz)
        for colour in [(10, 20, 30), (200, 0, 0), (0, 200, 0)]:
            rviz.command("set", "Camera", "Background Color", "; ".join(str(each) for each in colour))
            pictures.forget()
            self.assertTrue(trigger("/camera/camera_trigger").success)
            picture = pictures.wait_for(lambda _: True, "after a trigger", rviz)
            self.assertEqual(set(map(tuple, pixels(picture).reshape(-1, 3))), {colour})

    def test_the_near_clip_distance_counts_from_the_first_frame(self):
        self.topic(Infos, "/camera/info", camera_info())
        pictures = self.topic(Pictures, "/camera/image")
        # The grid is 3 m away.
        rviz = self.open(grid(), camera(**{"Frame Rate": 0, "Near Clip Distance": 20}))
        rviz.wait_for_status("Camera", "Camera Info", OK)
        pictures.connect(rviz)
        trigger("/camera/camera_trigger")
        self.assertEqual(pixels(pictures.wait_for(lambda _: True, "the first", rviz)).max(), 0)
        rviz.command("set", "Camera", "Near Clip Distance", "0.01")
        pictures.forget()
        trigger("/camera/camera_trigger")
        self.assertEqual(pixels(pictures.wait_for(lambda _: True, "the second", rviz)).max(), 255)

    def test_nothing_is_published_without_a_valid_camera_info_and_its_frame(self):
        infos = self.topic(Infos, "/camera/info", camera_info())
        pictures = self.topic(Pictures, "/camera/image")
        rviz = self.open(grid(), camera())
        pictures.next(rviz)
        wrong = [(camera_info(P=[math.nan] * 12), "Camera Info", "P[0] is NaN"),
                 (camera_info(width=0), "Camera Info", "width is 0"),
                 (camera_info(frame="nowhere"), "getTransform", "nowhere")]
        for info, status, text in wrong:
            infos.send(info)
            rviz.wait_for_status("Camera", status, ERROR, text)
            self.assertEqual(pictures.quiet_for(0.5), [], text)
            infos.send(camera_info())
            pictures.next(rviz)
            self.assertNotEqual(rviz.statuses("Camera").get(status, (OK, ""))[0], ERROR)
        # Without one at all: what was received before is forgotten when the topic changes.
        rviz.command("set", "Camera", "Camera Info Topic", "/nobody/info")
        rviz.wait_for_status("Camera", "Camera Info", WARNING, "/nobody/info")
        self.assertEqual(pictures.quiet_for(0.5), [])

    def test_displays_of_one_namespace_share_the_trigger_service(self):
        self.topic(Infos, "/camera/info", camera_info())
        first, second = self.topic(Pictures, "/a/image"), self.topic(Pictures, "/b/image")
        shared = {"Frame Rate": 0, "Camera Info Topic": "/camera/info", "Display namespace": "both"}
        rviz = self.open(grid(), camera("A", **shared), camera("B", **shared))
        for name, pictures in (("A", first), ("B", second)):
            rviz.wait_for_status(name, "Camera Info", OK)
            pictures.connect(rviz)
        answer = trigger("/both/camera_trigger")
        self.assertTrue(answer.success)
        self.assertIn("/a/image", answer.message)
        self.assertIn("/b/image", answer.message)
        for pictures in (first, second):
            pictures.wait_for(lambda _: True, "after the trigger of both", rviz)
        rviz.command("remove", "A")
        second.forget()
        self.assertIn("/b/image", trigger("/both/camera_trigger").message)
        second.wait_for(lambda _: True, "after the other one was removed", rviz)
        rviz.command("set", "B", "Display namespace", "alone")
        second.forget()
        self.assertTrue(trigger("/alone/camera_trigger").success)
        wait_until(lambda: not stage().has_service("/both/camera_trigger"), ANSWER_TIMEOUT_SECS, "the old service is still there")

    def test_its_own_camera_info_is_not_taken_for_the_cameras(self):
        # Published beside the image: where the camera's own CameraInfo comes from, too.
        infos = self.topic(Infos, "/loop/camera_info", camera_info(64, 48))
        pictures, published = self.topic(Pictures, "/loop/image"), []
        rviz = self.open(grid(), camera("Loop", **{"Camera Info Topic": "/loop/camera_info"}))
        pictures.next(rviz)
        # It comes back now, between the camera's; the size changes once, and not back.
        infos.send(camera_info(100, 80))
        pictures.wait_for(lambda each: each.width == 100, "of the new size", rviz)
        published = [each.width for each in pictures.all()]
        self.assertEqual(published, sorted(published))
        infos.close()
        rviz.wait_for_status("Loop", "Camera Info", WARNING, "No publishers on [/loop/camera_info]")

    def test_a_topic_or_namespace_that_is_no_name_is_a_status(self):
        rviz = self.open(grid(), camera())
        rviz.command("set", "Camera", "Image Topic", "/no name")
        rviz.wait_for_status("Camera", "Output Topic", ERROR)
        rviz.command("set", "Camera", "Image Topic", "")
        rviz.wait_for_status("Camera", "Output Topic", ERROR, "No topic set")
        rviz.command("set", "Camera", "Camera Info Topic", "")
        rviz.wait_for_status("Camera", "Camera Info", ERROR, "No topic set")
        rviz.command("set", "Camera", "Display namespace", "no name")
        rviz.wait_for_status("Camera", "Display namespace", ERROR, "Invalid namespace")
        rviz.command("set", "Camera", "Display namespace", "name")
        rviz.wait_for_status("Camera", "Display namespace", OK)
        rviz.command("set", "Camera", "Depth Topic", "no name")
        rviz.command("set", "Camera", "Image Topic", "/camera/image")
        rviz.wait_for_status("Camera", "Output Topic", ERROR)

    def test_a_trigger_before_the_first_camera_info_is_served_when_it_comes(self):
        pictures = self.topic(Pictures, "/camera/image")
        rviz = self.open(grid(), camera(**{"Frame Rate": 0}))
        pictures.connect(rviz)
        self.assertTrue(trigger("/camera/camera_trigger").success)
        self.assertEqual(pictures.quiet_for(0.3), [])
        self.topic(Infos, "/camera/info", camera_info())
        pictures.wait_for(lambda _: True, "for the trigger", rviz)
        rviz.command("enable", "Camera", 0)
        answer = trigger("/camera/camera_trigger")
        self.assertFalse(answer.success)
        self.assertEqual(answer.message, "Image publisher not configured")

    def preload(self, **variables):
        """The environment in which rviz meets faults of the driver or the system (driver/faults.cpp)."""
        library = pathlib.Path(os.environ[PREFIX_VARIABLE], "lib", "librviz_test_faults.so").resolve()
        return {"LD_PRELOAD": str(library), **{f"RVIZ_FAULTS_{name}": str(value) for name, value in variables.items()}}

    def test_a_driver_that_fails_with_pixel_buffers_is_not_asked_again(self):
        self.topic(Infos, "/camera/info", camera_info())
        pictures = self.topic(Pictures, "/camera/image")
        fences = stage().folder / "fences.txt"
        rviz = self.open(grid(), camera(), environment=self.preload(FENCES=fences))
        for _ in range(5):
            self.assertEqual(pixels(pictures.next(rviz)).max(), 255)
        self.assertEqual(fences.read_text(), "a fence\n")

    def test_an_image_too_large_for_the_memory_is_a_status_and_rviz_goes_on(self):
        infos = self.topic(Infos, "/camera/info", camera_info())
        pictures = self.topic(Pictures, "/camera/image")
        # Four bytes a pixel are read and published; what is sent has the header as well.
        limit = 4 * 4096 * 2048
        rviz = self.open(grid(), camera(**{"Image Encoding": "rgba8"}), environment=self.preload(LARGEST_BYTES=limit))
        for height, reason in ((2048, "Cannot publish the image"), (2049, "Cannot read the image of 4096x2049 pixels")):
            pictures.next(rviz)
            infos.send(camera_info(4096, height))
            rviz.wait_for_status("Camera", "Picture", ERROR, reason)
            infos.send(camera_info())
        pictures.next(rviz)
        wait_until(lambda: "Picture" not in rviz.statuses("Camera"), ANSWER_TIMEOUT_SECS, "the status stays")

    def test_a_camera_that_cannot_start_is_a_status_and_rviz_goes_on(self):
        infos = self.topic(Infos, "/added/info", camera_info())
        self.topic(Pictures, "/added/image")
        no_threads = stage().folder / "no_threads"
        rviz = self.open(grid(), environment=self.preload(NO_THREADS=no_threads))
        no_threads.touch()
        try:
            rviz.command("create", "Added", CAMERA_PUB)
        finally:
            no_threads.unlink()
        rviz.wait_for_status("Added", "Picture", ERROR, "Cannot start the camera")
        rviz.command("topic", "Added", "/added/image", "sensor_msgs/Image")
        infos.send(camera_info(100, 80))
        rviz.frames(3)
        rviz.command("remove", "Added")
        rviz.frames(1)


if __name__ == "__main__":
    unittest.main()
