"""The distributions that packages are made for: where their ROS lies and what they call its packages."""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass

# Debian's Debian packages, where their names do not follow from ROS's: programs and Python modules of ROS's tools.
DEBIAN_NAMES = {
    'rosbash': 'rosbash',
    'roslaunch': 'python3-roslaunch',
    'rostopic': 'python3-rostopic',
    'rospy': 'python3-rospy',
    'genpy': 'python3-genpy',
    'image_view': 'ros-image-view',
}
LIBC = 'libc6 (>= 2.27)'
# Videos, and drawing on a GPU; and the package of what only viewer:=image_view needs.
SUGGESTED = ['ffmpeg', 'libvulkan1', 'mesa-vulkan-drivers']
SUGGESTED_OF_ROS = 'image_view'


@dataclass(frozen=True)
class Distribution:
    """One of ROS's distributions on one of Linux's."""
    package: str
    prefix: str
    python: str
    # The name in the changelog: the oldest that it is for.
    suite: str
    # For /opt/ros/DISTRO: what the packages' names begin with. Debian's own have none in common.
    name_prefix: str = ''

    def package_of(self, ros_package):
        """The Debian package of a ROS package."""
        dashed = ros_package.replace('_', '-')
        if self.name_prefix:
            return self.name_prefix + dashed
        # Debian has the Python modules of messages in packages of their own: rostopic needs them, the programs nothing.
        return DEBIAN_NAMES.get(ros_package) or 'python3-' + dashed

    def relations(self, package_xml):
        """The fields Depends and Suggests for what a package.xml says that the programs run with. What has a condition is
        the rviz plugin's, which is a package of its own."""
        root = ElementTree.parse(package_xml).getroot()
        tags = [tag for kind in ('exec_depend', 'depend') for tag in root.findall(kind) if 'condition' not in tag.attrib]
        depends = [LIBC] + [self.package_of(name) for name in sorted({tag.text.strip() for tag in tags})]
        depends.append('python3' if self.python == '/usr/bin/python3' else 'python')
        return {
            'Depends': ', '.join(sorted(depends)),
            'Suggests': ', '.join(sorted([*SUGGESTED, self.package_of(SUGGESTED_OF_ROS)])),
        }


DISTRIBUTIONS = [
    Distribution('ros-melodic-rviz-camera-stream', '/opt/ros/melodic', '/usr/bin/python2', 'bionic', 'ros-melodic-'),
    Distribution('ros-noetic-rviz-camera-stream', '/opt/ros/noetic', '/usr/bin/python3', 'focal', 'ros-noetic-'),
    # ROS-O, for Ubuntu 22.04 and newer.
    Distribution('ros-one-rviz-camera-stream', '/opt/ros/one', '/usr/bin/python3', 'jammy', 'ros-one-'),
    Distribution('ros-rviz-camera-stream', '/usr', '/usr/bin/python3', 'bookworm'),
]
