"""A viewer of `./soak`: receives pictures from the node and prints a line about each.

    python3 -m soak.viewer NODE_URI TOPIC...

It asks the node itself for its topics, so that it depends on no master, and connects again when its connection is lost. Lines on
standard output, fields separated by tabs; times are those of the monotonic clock, which all processes of a machine share:

    picture  TOPIC  ARRIVAL  STAMP  WIDTH  HEIGHT  CRC  LATENCY_MS or -
    lost     TOPIC  ARRIVAL  REASON
    saved    TOPIC  WIDTH  HEIGHT

A line `TOPIC FILE` on standard input saves the last picture. It ends with its standard input.
"""

import os
import struct
import sys
import threading
import time
import zlib

from sensor_msgs.msg import Image

from . import ros


class Viewer(threading.Thread):
    """Receives one topic."""

    def __init__(self, node_uri, topic, write):
        super().__init__(daemon=True)
        self.node_uri, self.topic, self.write, self.last, self.colour = node_uri, topic, write, None, None
        self.start()

    def run(self):
        while True:
            connection = None
            try:
                connection = ros.subscribe(self.node_uri, self.topic, Image, '/soak_viewer_{}'.format(os.getpid()))
                connection.settimeout(None)
                while True:
                    self.see(ros.read_message(connection))
            except OSError as error:
                self.write('lost', self.topic, time.monotonic(), error)
                time.sleep(0.2)
            finally:
                if connection:
                    connection.close()

    def see(self, message):
        now = time.monotonic()
        _, secs, nsecs, length = struct.unpack_from('<4I', message)
        place = 16 + length
        height, width, length = struct.unpack_from('<3I', message, place)
        place += 12 + length
        _, step, length = struct.unpack_from('<BII', message, place)
        pixels = memoryview(message)[place + 9:place + 9 + length]
        self.last = (width, height, pixels)
        latency = '-'
        if step == 3 * width:
            middle = height // 2 * step + width // 2 * 3
            colour = pixels[middle] << 16 | pixels[middle + 1] << 8 | pixels[middle + 2]
            if colour != self.colour:
                self.colour = colour
                # The colour is the time at which the cloud was published, in ms.
                latency_ms = (int(now * 1000) - colour) & 0xffffff
                latency = latency_ms if latency_ms < 10000 else '-'
        self.write('picture', self.topic, now, '{}.{:09}'.format(secs, nsecs), width, height, zlib.crc32(pixels), latency)

    def save(self, file):
        width, height, pixels = self.last or (0, 0, b'')
        with open(file, 'wb') as out:
            out.write(pixels)
        self.write('saved', self.topic, width, height)


def main():
    lock = threading.Lock()

    def write(*fields):
        with lock:
            print(*fields, sep='\t', flush=True)

    viewers = {topic: Viewer(sys.argv[1], topic, write) for topic in sys.argv[2:]}
    for line in sys.stdin:
        topic, file = line.split(None, 1)
        viewers[topic].save(file.strip())


if __name__ == '__main__':
    main()
