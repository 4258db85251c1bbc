"""What ROS's own Python makes of images and bags: peer.py pair | write_bag FILE COMPRESSION | read_bag FILE"""
import sys

import message_filters
import rosbag
import rospy
from geometry_msgs.msg import PointStamped
from sensor_msgs.msg import CameraInfo, Image


def pair():
    """Prints images whose CameraInfo has the same stamp."""
    rospy.init_node("viewer")

    def both(image, info):
        size = (image.width, image.height, image.encoding, image.step, len(image.data), info.width)
        print("pair", image.header == info.header, image.header.frame_id, *size, flush=True)

    topics = [("/view/image", Image), ("/view/camera_info", CameraInfo)]
    subscribers = [message_filters.Subscriber(topic, kind) for topic, kind in topics]
    message_filters.TimeSynchronizer(subscribers, 20).registerCallback(both)
    rospy.spin()


def write_bag(path, compression):
    """Writes a hundred points whose times are not in order."""
    with rosbag.Bag(path, "w", compression=compression, chunk_threshold=2000) as bag:
        for i in range(100):
            message = PointStamped()
            message.header.frame_id = "map"
            message.point.x = i
            bag.write("/point", message, rospy.Time(1000 + (i * 37) % 100))


def read_bag(path):
    for topic, message, time in rosbag.Bag(path).read_messages():
        print(topic, message._type, message.header.frame_id, message.point.y, time.secs)


if sys.argv[1] == "pair":
    pair()
elif sys.argv[1] == "write_bag":
    write_bag(*sys.argv[2:])
else:
    read_bag(sys.argv[2])
