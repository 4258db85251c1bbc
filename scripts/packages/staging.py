"""The tree of files of a package, installed by the catkin package's own rules, with the programs that were built before."""

import gzip
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
PACKAGE = 'rviz_camera_stream'
# What the README links to at the root of the sources, beside docs.
PAGES = ['README.md', 'CHANGELOG.md', 'CONTRIBUTING.md', 'LICENSE', 'SECURITY.md', 'THIRD_PARTY.md']


def install(built, prefix, python, tree, plugin=False):
    """Installs programs, scripts, launch files, configs and CMake files below `tree` for the given prefix; with rviz's plugin
    if that is wanted, built for the rviz of this machine."""
    with tempfile.TemporaryDirectory() as build:
        # A sourced workspace must not reach the files.
        environment = {'PATH': '/usr/bin:/bin', 'LC_ALL': 'C.UTF-8', 'DESTDIR': str(tree)}
        quietly(['cmake', str(REPOSITORY / 'ros_pkg'), f'-DCMAKE_INSTALL_PREFIX={prefix}', '-DCATKIN_BUILD_BINARY_PACKAGE=ON',
                 f'-DRVIZ_CAMERA_STREAM_PREBUILT={built}', f'-DRVIZ_CAMERA_STREAM_PYTHON={python}',
                 '-DCATKIN_ENABLE_TESTING=OFF', f'-DRVIZ_CAMERA_STREAM_PLUGIN={"ON" if plugin else "OFF"}', '-DCMAKE_BUILD_TYPE=Release',
                 # No path of this machine in the library.
                 f'-DCMAKE_CXX_FLAGS=-ffile-prefix-map={REPOSITORY}=/rviz_camera_stream -ffile-prefix-map={build}=/build'],
                build, environment)
        quietly(['make', 'install'], build, environment)
    # So that a build from source finds the programs, and the plugin's its core.
    place = tree / prefix.lstrip('/')
    core = Path(built) / 'lib' / PACKAGE / 'librcs_capi.tar.xz'
    shutil.copy(core, place / 'lib' / PACKAGE / core.name)
    shutil.copy(Path(built) / 'share' / PACKAGE / 'prebuilt', place / 'share' / PACKAGE / 'prebuilt')
    # Debian's own ROS has no setup file that would source what lies there.
    shutil.rmtree(tree / 'usr/etc', ignore_errors=True)
    # rviz reads the description of each plugin that a manifest exports, and this package has none.
    manifest = place / 'share' / PACKAGE / 'package.xml'
    manifest.write_text(re.sub(r'\n\s*<export>\s*<rviz plugin="[^"]*"/>\s*</export>', '', manifest.read_text()))


def install_help(built, share, zsh):
    """Copies completions and man pages, packed, below `share`; `zsh` is the folder of zsh's."""
    source = Path(built) / 'share'
    for folder, place in [('bash-completion', 'bash-completion'), ('fish', 'fish'), ('zsh/site-functions', zsh)]:
        shutil.copytree(source / folder, share / place)
    pages = share / 'man/man1'
    pages.mkdir(parents=True)
    for page in (source / 'man/man1').iterdir():
        compressed(pages / f'{page.name}.gz', page.read_text())


def compressed(path, text):
    """Writes text as gzip without a name and a moment in it."""
    path.write_bytes(gzip.compress(text.encode(), 9, mtime=0))


def quietly(command, folder, environment):
    """Runs a command and shows what it printed only if it fails."""
    done = subprocess.run(command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        raise RuntimeError(f'{" ".join(command)} failed:\n{done.stdout}')


def copy_pages(folder):
    """Copies the pages with the pictures that they show, so that their links to each other work."""
    folder.mkdir(parents=True)
    for page in PAGES:
        shutil.copy(REPOSITORY / page, folder / page)
    shutil.copytree(REPOSITORY / 'docs', folder / 'docs')


def normalise(tree, moment):
    """Gives all files the same moment, and modes that do not depend on whoever built them."""
    for path in sorted(tree.rglob('*')) + [tree]:
        if not path.is_symlink():
            is_executable = path.is_dir() or path.stat().st_mode & 0o100
            path.chmod(0o755 if is_executable else 0o644)
        os.utime(path, (moment, moment), follow_symlinks=False)


def size_bytes(tree):
    """The size of the tree's files, each rounded up to a kilobyte as `Installed-Size` counts them."""
    return sum(1024 if path.is_dir() or path.is_symlink() else -(-path.stat().st_size // 1024) * 1024
               for path in tree.rglob('*'))
