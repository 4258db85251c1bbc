"""Shows `/projector/patterns` on a wall and sees it with a camera of 160×120 pixels.

Camera pixel (x, y) is lit by projector pixel (0.7 x + 4, 0.6 y + 2); `mirrored` shows the image mirrored. `packed`
publishes compressed images.
"""
from sensor_msgs.msg import CompressedImage

from python_node import *

packed, period = False, 0.05
SIZE, CAMERA = (128, 80), (160, 120)
mirrored, picture = False, bytes(CAMERA[0] * CAMERA[1])


def lit_by(x, y):
    u, v = round(0.7 * x + 4), round(0.6 * y + 2)
    return v * SIZE[0] + (SIZE[0] - 1 - u if mirrored else u)


def shine(message):
    global picture
    assert (message.width, message.height, message.encoding) == SIZE + ('mono8',)
    table = [lit_by(x, y) for y in range(CAMERA[1]) for x in range(CAMERA[0])]
    picture = bytes(30 + message.data[i] * 3 // 5 for i in table)


def image(encoding, step, data):
    message = Image(width=CAMERA[0], height=CAMERA[1], encoding=encoding, step=step, data=data)
    message.header.frame_id, message.header.stamp = 'head_camera_optical', rospy.Time.now()
    return message


def png(bits, data):
    chunk = lambda name, body: struct.pack('>I', len(body)) + name + body + struct.pack('>I', zlib.crc32(name + body))
    row = len(data) // CAMERA[1]
    rows = b''.join(b'\0' + data[i * row:(i + 1) * row] for i in range(CAMERA[1]))
    head = struct.pack('>IIBBBBB', *CAMERA, bits, 0, 0, 0, 0)
    body = chunk(b'IHDR', head) + chunk(b'IDAT', zlib.compress(rows, 1)) + chunk(b'IEND', b'')
    return b'\x89PNG\r\n\x1a\n' + body


def publish_packed():
    message = CompressedImage(format='mono8; png compressed ', data=png(8, picture))
    publisher('/head_camera/rgb/image_raw/compressed', CompressedImage, False).publish(message)
    depth = bytes(12) + png(16, struct.pack('>H', 1200) * len(picture))
    message = CompressedImage(format='16UC1; compressedDepth png', data=depth)
    publisher('/head_camera/depth_registered/image_raw/compressedDepth', CompressedImage, False).publish(message)


def see():
    while not rospy.is_shutdown():
        if packed:
            publish_packed()
        rgb = bytes(level for level in picture for _ in range(3))
        publisher('/head_camera/rgb/image_raw', Image, False).publish(image('rgb8', 3 * CAMERA[0], rgb))
        depth = struct.pack('<H', 1200) * len(picture)
        publisher('/head_camera/depth_registered/image_raw', Image, False).publish(image('16UC1', 2 * CAMERA[0], depth))
        latch('/head_camera/rgb/camera_info', info('head_camera_optical', *CAMERA, f=130.0))
        time.sleep(period)


projector = rospy.Subscriber('/projector/patterns', Image, shine)
threading.Thread(target=see, daemon=True).start()
