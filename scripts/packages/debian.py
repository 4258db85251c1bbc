"""Debian packages from a tree of files, by dpkg-deb: the same tree gives the same bytes."""

import hashlib
import os
import re
import subprocess
import textwrap
import xml.etree.ElementTree as ElementTree
from email.utils import formatdate
from pathlib import Path

from staging import REPOSITORY, compressed, normalise, size_bytes

SUMMARY = 'what virtual cameras see of an rviz scene, as image topics'
REVISION = '1'
# What lintian reports and why it is as it is.
EXCEPTIONS = [
    ('embedded-library *', 'Its translation to Rust, which no Debian package has.'),
    ('initial-upload-closes-no-bugs *', 'Not uploaded to Debian.'),
    ('extra-license-file *', 'The README links to it.'),
]
PLUGIN_EXCEPTIONS = [
    ('initial-upload-closes-no-bugs *', 'Not uploaded to Debian.'),
    ('shared-library-lacks-version *', 'A plugin, which rviz loads by its name.'),
    ('package-name-doesnt-match-sonames *', 'A plugin, which rviz loads by its name.'),
]
OPT_EXCEPTIONS = [
    ('dir-or-file-in-opt *', "ROS's distributions lie below /opt/ros."),
    ('python2-script-but-no-python2-dep *', 'Ubuntu 18.04 has python2 in the package python.'),
]


class Manifest:
    """What package.xml says about the package."""

    def __init__(self, path):
        root = ElementTree.parse(path).getroot()
        self.version = root.findtext('version').strip()
        maintainer = root.find('maintainer')
        self.maintainer = f'{maintainer.text.strip()} <{maintainer.get("email")}>'
        self.description = ' '.join(root.findtext('description').split())


def copyright_text(manifest, licences):
    """The copyright file in Debian's machine-readable format. `licences`: the file with those of what is linked in."""
    own = (REPOSITORY / 'LICENSE').read_text()
    holder = re.search(r'^Copyright (.*)$', own, re.M).group(1).removeprefix('(c) ')
    body = '\n'.join(' ' + (line.strip() or '.') for line in own.split('\n\n', 2)[2].strip().splitlines())
    return (f'Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n'
            f'Upstream-Name: rviz_camera_stream\nUpstream-Contact: {manifest.maintainer}\n\n'
            f'Files: *\nCopyright: {holder}\nLicense: BSD-3-Clause\nComment:\n'
            f' The programs have libraries of others linked in; their licences and copyright\n lines are in\n {licences}.\n\n'
            f'License: BSD-3-Clause\n{body}\n')


def write_documents(tree, distribution, manifest, licences, moment):
    """The copyright file, changelogs, licences and lintian's exceptions below /usr/share."""
    folder = tree / 'usr/share/doc' / distribution.package
    folder.mkdir(parents=True, exist_ok=True)
    name = 'third_party_licences.txt.gz'
    (folder / 'copyright').write_text(copyright_text(manifest, f'/usr/share/doc/{distribution.package}/{name}'))
    compressed(folder / name, licences)
    compressed(folder / 'changelog.gz', (REPOSITORY / 'CHANGELOG.md').read_text())
    compressed(folder / 'changelog.Debian.gz',
               f'{distribution.package} ({manifest.version}-{REVISION}) {distribution.suite}; urgency=medium\n\n'
               f'  * Version {manifest.version}; see changelog.gz.\n\n -- {manifest.maintainer}  {formatdate(moment)}\n')
    overrides = tree / 'usr/share/lintian/overrides' / distribution.package
    overrides.parent.mkdir(parents=True, exist_ok=True)
    tags = EXCEPTIONS + (OPT_EXCEPTIONS if distribution.name_prefix else [])
    if distribution.package.endswith('-plugin'):
        tags = PLUGIN_EXCEPTIONS
    overrides.write_text(''.join(f'# {reason}\n{distribution.package}: {tag}\n' for tag, reason in tags))


def build(tree, distribution, manifest, architecture, relations, moment, folder, summary=SUMMARY):
    """Writes the package into `folder` and returns its path."""
    control = tree / 'DEBIAN'
    control.mkdir()
    if any(tree.glob('usr/lib/*/lib*.so')):
        (control / 'triggers').write_text('activate-noawait ldconfig\n')
    normalise(tree, moment)
    files = sorted(path for path in tree.rglob('*')
                   if path.is_file() and not path.is_symlink() and control not in path.parents)
    sums = ''.join(f'{hashlib.md5(path.read_bytes()).hexdigest()}  {path.relative_to(tree)}\n' for path in files)
    (control / 'md5sums').write_text(sums)
    long_description = '\n'.join(' ' + line for line in textwrap.wrap(manifest.description, 78))
    fields = {
        'Package': distribution.package, 'Version': f'{manifest.version}-{REVISION}', 'Architecture': architecture,
        'Maintainer': manifest.maintainer, 'Installed-Size': str(size_bytes(tree) // 1024), **relations,
        'Section': 'misc', 'Priority': 'optional', 'Description': f'{summary}\n{long_description}',
    }
    (control / 'control').write_text(''.join(f'{name}: {value}\n' for name, value in fields.items() if value))
    normalise(tree, moment)
    path = Path(folder) / f'{distribution.package}_{manifest.version}-{REVISION}_{architecture}.deb'
    # xz: Ubuntu 18.04's dpkg reads no zstd. One thread: with several, the bytes depend on their number.
    subprocess.run(['dpkg-deb', '--root-owner-group', '-Zxz', '--threads-max=1', '--build', str(tree), str(path)], check=True,
                   stdout=subprocess.DEVNULL, env={**os.environ, 'SOURCE_DATE_EPOCH': str(moment)})
    return path
