"""The tarball that runs from any folder: the same files as in the packages, and a setup file for a shell."""

import lzma
import shutil
import tarfile
from pathlib import Path

from staging import PACKAGE, copy_pages, install, install_help, normalise

SETUP = '''\
# To be sourced, by bash, zsh or sh in this folder: rosrun and roslaunch then find rviz_camera_stream here, and its programs
# are on PATH. A ROS that is sourced before stays.
if [ -n "${BASH_SOURCE:-}" ]; then
  rviz_camera_stream_folder=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
elif [ -n "${ZSH_VERSION:-}" ]; then
  rviz_camera_stream_folder=$(cd "$(dirname "$0")" && pwd)
else
  rviz_camera_stream_folder=$PWD
fi
# Debian's own ROS is found without these variables, and has to be named beside others.
export ROS_PACKAGE_PATH="$rviz_camera_stream_folder/share:${ROS_PACKAGE_PATH:-/usr/share}"
export CMAKE_PREFIX_PATH="$rviz_camera_stream_folder:${CMAKE_PREFIX_PATH:-/usr}"
export PATH="$rviz_camera_stream_folder/lib/rviz_camera_stream:$PATH"
export MANPATH="$rviz_camera_stream_folder/share/man:${MANPATH:-}"
export XDG_DATA_DIRS="$rviz_camera_stream_folder/share:${XDG_DATA_DIRS:-/usr/local/share:/usr/share}"
if [ -n "${BASH_VERSION:-}" ]; then
  CATKIN_ENV_HOOK_WORKSPACE=$rviz_camera_stream_folder
  . "$rviz_camera_stream_folder/etc/catkin/profile.d/50.rviz_camera_stream.bash"
  unset CATKIN_ENV_HOOK_WORKSPACE
fi
[ -z "${ZSH_VERSION:-}" ] || FPATH="$rviz_camera_stream_folder/share/zsh/site-functions:$FPATH"
unset rviz_camera_stream_folder
'''


def stage(built, folder, name, licences, materials):
    """Installs everything below `folder`/`name` and returns that."""
    install(built, f'/{name}', '/usr/bin/python3', folder)
    tree = Path(folder) / name
    # Their paths are those of an installed package.
    shutil.rmtree(tree / 'lib/pkgconfig')
    shutil.rmtree(tree / 'share' / PACKAGE / 'cmake')
    (tree / '.catkin').write_text('')
    (tree / 'setup.bash').write_text(SETUP)
    for setup in ('setup.sh', 'setup.zsh'):
        (tree / setup).symlink_to('setup.bash')
    install_help(built, tree / 'share', 'zsh/site-functions')
    copy_pages(tree / 'share/doc' / PACKAGE)
    (tree / 'share/doc' / PACKAGE / 'third_party_licences.txt').write_text(licences)
    (tree / 'share/doc' / PACKAGE / 'sbom.cdx.json').write_text(materials)
    return tree


def write(tree, path, moment):
    """Packs the tree: sorted, owned by root, without the moments and owners of this machine."""
    normalise(tree, moment)

    def as_root(entry):
        entry.uid = entry.gid = 0
        entry.uname = entry.gname = 'root'
        return entry

    with lzma.open(path, 'wb', preset=9) as packed, \
            tarfile.open(fileobj=packed, mode='w', format=tarfile.PAX_FORMAT) as archive:
        for entry in [tree, *sorted(tree.rglob('*'))]:
            archive.add(entry, entry.relative_to(tree.parent), recursive=False, filter=as_root)
