"""A depth camera beside the projector that looks at a wall, and a hand that may be in front of it."""
import numpy as np

from python_node import *

TOPIC = '/cam/depth/image_raw'
wall, hand = [2.0], [False]


def depths():
    z = np.full((60, 80), wall[0], np.float32)
    x, y = (np.arange(80) - 40) / 60.0, (np.arange(60) - 30) / 60.0
    # The sensor is 0.1 m to the right of the projector.
    in_hand = (np.abs(x[None, :] * 1.2 + 0.1) < 0.12) & (np.abs(y[:, None] * 1.2) < 0.12)
    if hand[0]: z[in_hand] = 1.2
    return z, x, y


def depth_image():
    message = Image(width=80, height=60, step=160, encoding='16UC1')
    message.header.stamp, message.header.frame_id = rospy.Time.now(), 'sensor'
    message.data = (depths()[0] * 1000).astype('<u2').tobytes()
    return message


def depth_cloud(rows=60):
    z, x, y = depths()
    points = np.stack([x[None, :] * z, y[:, None] * z, z], axis=2).astype('<f4')
    message = PointCloud2(height=rows, width=4800 // rows, point_step=12, row_step=12 * 4800 // rows)
    message.header.stamp, message.header.frame_id = rospy.Time.now(), 'sensor'
    message.fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate('xyz')]
    message.data = points.tobytes()
    return message


def stream(): return PublishRepeatedly(20, lambda i: depth_image(), TOPIC)


latch('/cam/depth/camera_info', info('sensor', 80, 60, 60.0))
latch('/tf_static', TFMessage(tf('map', 'eye').transforms + tf('map', 'sensor', (0.1, 0, 0)).transforms))
latch('/eye/camera_info', info())
latch('/cloud', cloud(0xff0000))
latch('/labels', cloud(0x00ff00, points=((-2, 0, 4),)))
viewer = Viewer('/view/image')
