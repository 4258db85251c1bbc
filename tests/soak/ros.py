"""ROS with plain sockets and a deadline for everything, so that `./soak` itself never waits for what it has broken."""

import http.client
import io
import socket
import struct
import xmlrpc.client

import rosgraph.network

NAME = '/soak'
TIMEOUT_S = 20.0


class Transport(xmlrpc.client.Transport):
    """HTTP with a deadline."""

    def make_connection(self, host):
        return http.client.HTTPConnection(host, timeout=TIMEOUT_S)


def proxy(uri):
    return xmlrpc.client.ServerProxy(uri, transport=Transport(), allow_none=True)


def master_call(uri, method, *arguments):
    """The master's answer; OSError if it refuses."""
    code, message, value = getattr(proxy(uri), method)(NAME, *arguments)
    if code != 1:
        raise OSError(message)
    return value


def topic_address(node_uri, topic):
    """Host and port where a node sends a topic."""
    _, message, protocol = proxy(node_uri).requestTopic(NAME, topic, [['TCPROS']])
    if not protocol:
        raise OSError('{}: {}'.format(topic, message))
    return protocol[1], protocol[2]


def subscribe(node_uri, topic, kind, name=NAME):
    """A connection to a topic on which messages will come."""
    connection = socket.create_connection(topic_address(node_uri, topic), TIMEOUT_S)
    try:
        fields = {'callerid': name, 'topic': topic, 'type': kind._type, 'md5sum': kind._md5sum, 'tcp_nodelay': '1'}
        rosgraph.network.write_ros_handshake_header(connection, fields)
        answer = rosgraph.network.decode_ros_handshake_header(framed(read_message(connection)))
        if 'error' in answer:
            raise OSError(answer['error'])
    except BaseException:
        connection.close()
        raise
    return connection


def framed(data):
    return struct.pack('<I', len(data)) + bytes(data)


def read_exactly(connection, into):
    """Fills a buffer from a connection."""
    view = memoryview(into)
    while view:
        received = connection.recv_into(view)
        if received == 0:
            raise OSError('closed by the peer')
        view = view[received:]


def read_message(connection):
    """The next message on a connection."""
    length = bytearray(4)
    read_exactly(connection, length)
    data = bytearray(struct.unpack('<I', length)[0])
    read_exactly(connection, data)
    return data


def call_service(service_uri, service, kind, request):
    """The response of a service; OSError if it answers with an error."""
    host, port = rosgraph.network.parse_http_host_and_port(service_uri.replace('rosrpc://', 'http://'))
    with socket.create_connection((host, port), TIMEOUT_S) as connection:
        fields = {'callerid': NAME, 'service': service, 'md5sum': kind._md5sum, 'type': kind._type}
        rosgraph.network.write_ros_handshake_header(connection, fields)
        answer = rosgraph.network.decode_ros_handshake_header(framed(read_message(connection)))
        if 'error' in answer:
            raise OSError(answer['error'])
        data = io.BytesIO()
        request.serialize(data)
        connection.sendall(framed(data.getvalue()))
        is_ok = bytearray(1)
        read_exactly(connection, is_ok)
        body = read_message(connection)
        if is_ok != b'\1':
            raise OSError('{}: {}'.format(service, bytes(body).decode('utf-8', 'replace')))
        response = kind._response_class()
        response.deserialize(bytes(body))
        return response
