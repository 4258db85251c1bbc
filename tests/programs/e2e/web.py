"""A page of the operator: a WebSocket of raw bytes, and POSTs."""
import base64, json, socket, struct, urllib.error, urllib.request

from python_node import *

class Page:
    def __init__(self, url, cameras=('CameraPub',)):
        self.url, self.token = url.split('#token=')
        self.address = self.url.split('/')[2]
        self.state, self.images, self.masks, self.lines = {}, [], [], []
        self.socket = socket.create_connection(self.address.split(':'))
        self.socket.sendall((f'GET /api/stream HTTP/1.1\r\nHost: {self.address}\r\nConnection: Upgrade\r\n'
            f'Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n'
            f'Sec-WebSocket-Protocol: rcs, token.{self.token}\r\n\r\n').encode())
        self.stream = self.socket.makefile('rb')
        assert b' 101 ' in self.stream.readline()
        while self.stream.readline().strip(): pass
        self.send({'type': 'watch', 'cameras': list(cameras)})
        self.send({'type': 'ready'})
        threading.Thread(target=self.read, daemon=True).start()

    def send(self, message):
        text = json.dumps(message).encode()
        self.socket.sendall(bytes([0x81, 0x80 | len(text)]) + bytes(4) + text)

    def read(self):
        while True:
            head = self.stream.read(2)
            if len(head) < 2: return
            length = head[1]
            if length > 125:
                kind, count = ('>H', 2) if length == 126 else ('>Q', 8)
                length = struct.unpack(kind, self.stream.read(count))[0]
            body = self.stream.read(length)
            if head[0] & 15 == 1:
                message = json.loads(body)
                if message['type'] == 'state': self.state = dict(message, came=time.monotonic())
                else: self.lines += message['lines']
            elif head[0] & 15 == 2:
                length = struct.unpack('<I', body[:4])[0]
                message = json.loads(body[4:4 + length])
                message['file'] = body[4 + length:]
                (self.images if message['type'] == 'image' else self.masks).append(message)
                if message['type'] == 'image': self.send({'type': 'ready'})

    def close(self):
        self.socket.shutdown(socket.SHUT_RDWR)

    def post(self, name, body, token=None):
        headers = {'Authorization': f'Bearer {token or self.token}', 'Content-Type': 'application/json'}
        request = urllib.request.Request(f'{self.url}api/{name}', json.dumps(body).encode(), headers)
        try:
            with urllib.request.urlopen(request, timeout=30) as response:
                return response.status, json.load(response)['message']
        except urllib.error.HTTPError as error:
            return error.code, json.load(error)['message']

    def answer(self, name, body, number=None, late_ms=0):
        """Posts what answers the newest state, or the one of this number."""
        state = self.state
        sent_ms = state['clock_ms'] + 1e3 * (time.monotonic() - state['came']) - late_ms
        number = state['number'] if number is None else number
        return self.post(name, dict(body, number=number, sent_ms=sent_ms))
