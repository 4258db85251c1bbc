"""The package of rviz's plugin for Debian's own rviz, built on this machine, which has to be the Debian it is for."""

import re
import shutil
import subprocess
from pathlib import Path

from distributions import Distribution
from staging import PACKAGE, REPOSITORY, install

# A ROS package of its own, because rviz finds a plugin by what a manifest exports, and the one of the programs is another
# Debian package's. The class keeps its name, by which configs know it.
ROS_PACKAGE = f'{PACKAGE}_plugin'
DISTRIBUTION = Distribution('ros-rviz-camera-stream-plugin', '/usr', '/usr/bin/python3', 'bookworm')
SUMMARY = "rviz's display CameraPub: publishes what a virtual camera sees"
MANIFEST = """<?xml version="1.0"?>
<package format="3">
  <name>{name}</name>
  <version>{version}</version>
  <description>The rviz plugin of rviz_camera_stream.</description>
  <maintainer email="rviz_camera_stream@example.com">The rviz_camera_stream developers</maintainer>
  <license>BSD-3-Clause</license>
  <exec_depend>rviz</exec_depend>
  <exec_depend>image_transport</exec_depend>
  <export>
    <rviz plugin="${{prefix}}/plugin_description.xml"/>
  </export>
</package>
"""


def is_for_this_machine():
    """Whether the headers of Debian's own rviz are here."""
    return Path('/usr/include/rviz/display.h').is_file()


def stage(built, folder, version):
    """Builds the plugin and returns the tree of its package, below `folder`."""
    whole = folder / 'whole'
    install(built, '/usr', DISTRIBUTION.python, whole, plugin=True)
    tree = folder / 'tree'
    library = next((whole / 'usr/lib').rglob(f'lib{PACKAGE}.so'))
    place = tree / library.relative_to(whole)
    place.parent.mkdir(parents=True)
    shutil.copy(library, place)
    subprocess.run(['strip', '--strip-unneeded', str(place)], check=True)
    share = tree / 'usr/share' / ROS_PACKAGE
    share.mkdir(parents=True)
    # By its name alone, as Debian's own plugins: then the dynamic linker finds it in its folder for this architecture.
    description = (REPOSITORY / 'ros_pkg/plugin_description.xml').read_text()
    (share / 'plugin_description.xml').write_text(description.replace(f'path="lib/lib{PACKAGE}"', f'path="lib{PACKAGE}"'))
    shutil.copytree(REPOSITORY / 'ros_pkg/icons', share / 'icons')
    (share / 'package.xml').write_text(MANIFEST.format(name=ROS_PACKAGE, version=version))
    return tree


def relations(tree, folder):
    """The field Depends: the packages of the libraries that the plugin is linked with, as dpkg-shlibdeps finds them."""
    (folder / 'debian').mkdir()
    (folder / 'debian/control').write_text(f'Source: {PACKAGE.replace("_", "-")}\n\nPackage: {DISTRIBUTION.package}\nArchitecture: any\n')
    libraries = [str(path) for path in tree.rglob('*.so')]
    done = subprocess.run(['dpkg-shlibdeps', '-O', '--ignore-missing-info', *libraries], cwd=folder, check=True,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    depends = re.search(r'shlibs:Depends=(.*)', done.stdout).group(1).split(', ')
    return {'Depends': ', '.join(sorted({*depends, 'rviz'}))}
