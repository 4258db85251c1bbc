"""Measures what open operator's pages cost the other outputs: none, one, and twenty of which one never reads.

A page here is a WebSocket that takes each image as a browser does; what a browser does with it is not measured.
"""

import contextlib
import json
import os
import re
import socket
import struct
import threading
import time

COUNTS = [0, 1, 20]
CAMERA = 'camera0'
TIMEOUT_S = 30


def address(log):
    """Host and port of the page that was served last, and its token."""
    with open(log, errors='replace') as text:
        found = re.findall(r"the operator's page: http://([^/]+)/#token=(\w+)", text.read())
    host, port = found[-1][0].rsplit(':', 1)
    return (host, int(port)), found[-1][1]


class Page:
    """A page that watches the camera. One that is stalled never reads what it is sent."""

    def __init__(self, place, token, is_stalled):
        self.images = 0
        self.socket = socket.create_connection(place, TIMEOUT_S)
        self.socket.settimeout(None)
        self.socket.sendall((
            'GET /api/stream HTTP/1.1\r\nHost: {}:{}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n'
            'Sec-WebSocket-Key: {}\r\nSec-WebSocket-Protocol: rcs, token.{}\r\n\r\n'.format(
                *place, 'dGhlIHNhbXBsZSBub25jZQ==', token)).encode())
        self.stream = self.socket.makefile('rb')
        status = self.stream.readline()
        if b' 101 ' not in status:
            raise ConnectionError('the page is not served: {!r}'.format(status))
        while self.stream.readline().strip():
            pass
        self.send({'type': 'watch', 'cameras': [CAMERA]})
        self.send({'type': 'ready'})
        if not is_stalled:
            threading.Thread(target=self.read, daemon=True).start()

    def send(self, message):
        """Sends a short text, masked with zeros as a client has to."""
        text = json.dumps(message).encode()
        self.socket.sendall(bytes([0x81, 0x80 | len(text)]) + bytes(4) + text)

    def read(self):
        """Takes messages and asks for the next image, until the connection ends."""
        with contextlib.suppress(OSError, struct.error, ValueError):
            while True:
                kind, length = struct.unpack('!BB', self.stream.read(2))
                if length == 126:
                    length, = struct.unpack('!H', self.stream.read(2))
                elif length == 127:
                    length, = struct.unpack('!Q', self.stream.read(8))
                payload = self.stream.read(length)
                if kind & 15 == 9:
                    self.socket.sendall(bytes([0x8a, 0x80 | length]) + bytes(4) + payload)
                elif kind & 15 == 2 and b'"type":"image"' in payload[:400]:
                    self.images += 1
                    self.send({'type': 'ready'})

    def close(self):
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()


def section(bench, text):
    """The rows of the section. The clouds and the image's size are those that the probe uses."""
    rows = []
    os.environ['ROS_HOME'] = bench.folder
    for camera in bench.cameras:
        camera = camera._replace(command=camera.command + ['--web', '0'])
        with bench.running(camera, text) as (usage, _):
            place, token = address(bench.log)
            for count in COUNTS:
                pages = [Page(place, token, is_stalled=number == 19) for number in range(count)]
                seen, begun = sum(page.images for page in pages), time.monotonic()
                figures = bench.measure(bench.given.hz, usage, bench.given.seconds)
                shown = sum(page.images for page in pages) - seen
                reading = min(count, 19)
                figures['page_hz'] = shown / reading / (time.monotonic() - begun) if reading else float('nan')
                rows.append(bench.row(camera, figures, pages=count))
                for page in pages:
                    page.close()
    return {'rows': rows}
