"""rviz's service that loads a config, whose type has no Python module of its own in Debian: `rviz/SendFilePath`."""

import struct

import genpy
import rospy


class _Request(genpy.Message):
    """`std_msgs/String path`"""
    _type, _md5sum, _slot_types, __slots__ = 'rviz/SendFilePathRequest', '*', ['string'], ['path']

    def serialize(self, buff):
        text = self.path.encode()
        buff.write(struct.pack('<I', len(text)) + text)


class _Response(genpy.Message):
    """`bool success`"""
    _type, _md5sum, _slot_types, __slots__ = 'rviz/SendFilePathResponse', '*', ['bool'], ['success']

    def deserialize(self, data):
        self.success = bool(data[0])
        return self


class _SendFilePath:
    _type, _md5sum, _request_class, _response_class = 'rviz/SendFilePath', '*', _Request, _Response


def load_config(rviz, file):
    """Has the rviz of that name load a config and forget the changes of the last one. False: it could not."""
    call = rospy.ServiceProxy(f'{rviz}/load_config_discarding_changes', _SendFilePath)
    return call(str(file)).success
