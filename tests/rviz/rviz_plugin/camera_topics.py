"""The topics of a camera: its frame, its CameraInfo, its images."""

import threading
import time

import numpy

from golden.scenes.processes import wait_until

PICTURE_TIMEOUT_SECS = 300.0


def camera_info(width=64, height=48, focal=50.0, frame="camera", **fields):
    """A CameraInfo with the principal point in the middle of the picture."""
    from sensor_msgs.msg import CameraInfo
    info = CameraInfo(width=width, height=height, distortion_model="plumb_bob", D=[0.0] * 5)
    info.header.frame_id = frame
    info.K = [focal, 0, width / 2, 0, focal, height / 2, 0, 0, 1]
    info.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    info.P = [focal, 0, width / 2, 0, 0, focal, height / 2, 0, 0, 0, 1, 0]
    for name, value in fields.items():
        setattr(info, name, value)
    return info


class CameraFrame:
    """The frame `camera`, 3 m behind the origin of `map` and looking at it, sent for as long as it is open."""

    def __init__(self, child="camera", parent="map"):
        import rospy
        from geometry_msgs.msg import TransformStamped
        from tf2_msgs.msg import TFMessage
        transform = TransformStamped()
        transform.header.frame_id, transform.child_frame_id = parent, child
        transform.transform.translation.z = -3.0
        transform.transform.rotation.w = 1.0
        self._publisher = rospy.Publisher("/tf_static", TFMessage, latch=True, queue_size=1)
        self._publisher.publish(TFMessage([transform]))

    def close(self):
        self._publisher.unregister()


class Infos:
    """Publishes the CameraInfo of a camera."""

    def __init__(self, topic, info=None):
        import rospy
        from sensor_msgs.msg import CameraInfo
        self._publisher = rospy.Publisher(topic, CameraInfo, latch=True, queue_size=10)
        if info is not None:
            self.send(info)

    def send(self, info):
        self._publisher.publish(info)

    def close(self):
        self._publisher.unregister()


class Pictures:
    """The pictures on a topic since it was opened, or since `forget`."""

    def __init__(self, topic):
        import rospy
        from sensor_msgs.msg import Image
        self.topic = topic
        self._lock, self._all = threading.Lock(), []
        self._subscriber = rospy.Subscriber(topic, Image, self._receive, queue_size=50, buff_size=1 << 24)

    def _receive(self, message):
        with self._lock:
            self._all.append(message)

    def all(self):
        with self._lock:
            return list(self._all)

    def forget(self):
        with self._lock:
            self._all.clear()

    def wait_for(self, condition, what, rviz):
        """Waits for a picture that fulfils the condition and returns it."""
        try:
            return wait_until(lambda: next((each for each in self.all() if condition(each)), None), PICTURE_TIMEOUT_SECS,
                              f"no picture on {self.topic}: {what}", [rviz.program])
        except TimeoutError as error:
            found = f"{len(self.all())} others came over {self._subscriber.get_num_connections()} connections"
            raise TimeoutError(f"{error}; {found}; {rviz.report()}") from error

    def next(self, rviz):
        """The next picture that comes."""
        self.forget()
        return self.wait_for(lambda _: True, "none at all", rviz)

    def connect(self, rviz):
        """Waits until rviz publishes here."""
        wait_until(self._subscriber.get_num_connections, PICTURE_TIMEOUT_SECS, f"{self.topic} is not published", [rviz.program])

    def quiet_for(self, secs):
        """The pictures that come within this time."""
        self.forget()
        time.sleep(secs)
        return self.all()

    def close(self):
        self._subscriber.unregister()


def pixels(message):
    """The picture of a rgb8 or 32FC1 message as an array of height × width (× 3)."""
    if message.encoding == "32FC1":
        return numpy.frombuffer(message.data, "<f4").reshape(message.height, message.width)
    return numpy.frombuffer(message.data, numpy.uint8).reshape(message.height, message.width, -1)


def trigger(service):
    """Calls a trigger service and returns its answer."""
    import rospy
    from std_srvs.srv import Trigger
    rospy.wait_for_service(service, PICTURE_TIMEOUT_SECS)
    return rospy.ServiceProxy(service, Trigger)()
