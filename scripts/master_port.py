#!/usr/bin/python3
"""Prints a TCP port for a ROS master.

Nobody listens on it, and it lies below those that Linux gives by itself (32768 and up): one of these may be another
node's before the master listens.
"""

import random
import socket

PORTS = range(20000, 32000)


def free_port():
    """One of `PORTS` that nobody listens on, at random."""
    for port in random.sample(PORTS, len(PORTS)):
        with socket.socket() as free:
            try:
                free.bind(('127.0.0.1', port))
                return port
            except OSError:
                pass
    raise OSError('no port from {} to {} is free'.format(PORTS[0], PORTS[-1]))


if __name__ == '__main__':
    print(free_port())
