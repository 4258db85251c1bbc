"""The licences of everything that is linked into the programs, as one text: which crates, and each licence's text once.

From `cargo metadata` and the files in the crates themselves. A crate that comes without the text of its licence gets the
standard text, as another crate has it, with its authors in place of the copyright line.
"""

import json
import subprocess
from pathlib import Path

from staging import REPOSITORY

# The packages of this workspace that are shipped.
ROOTS = ['rcs_app', 'rcs_capi']
# Of several licences to choose from, the first of these.
PREFERENCE = ['MIT', 'BSD-3-Clause', 'BSD-2-Clause', 'ISC', 'Zlib', 'Apache-2.0', 'BSL-1.0', 'Unicode-3.0', 'MPL-2.0']
# How the files are named that hold the text of a licence; without a name of its own, it is that of the crate's only licence.
FILE_WORDS = {'MIT': ['mit'], 'Apache-2.0': ['apache'], 'Zlib': ['zlib'], 'BSL-1.0': ['boost', 'bsl'], 'ISC': ['isc'],
              'BSD-3-Clause': ['bsd'], 'BSD-2-Clause': ['bsd'], 'Unicode-3.0': ['unicode'], 'MPL-2.0': ['mpl']}
# What the standard text of a licence contains, so that it can be found among the files of all crates.
PHRASES = {'MIT': 'Permission is hereby granted, free of charge', 'Apache-2.0': 'Apache License\n', 'ISC': 'Permission to use, copy',
           'BSD-3-Clause': 'Redistribution and use in source', 'MPL-2.0': 'Mozilla Public License', 'Zlib': "'as-is'"}
NOT_CRATES = '''\
Rust's standard library                 MIT OR Apache-2.0
    Copyright (c) The Rust Project Contributors; https://github.com/rust-lang/rust
LLVM's libunwind and compiler-rt        Apache-2.0 WITH LLVM-exception
    Copyright (c) the LLVM Project; https://llvm.org, as Zig distributes them
Message types of ROS                    BSD-3-Clause
    generated from std_msgs, common_msgs, geometry2 and others; Copyright (c) Willow Garage, Inc., and Open Source Robotics
    Foundation, Inc.; https://github.com/ros
'''


class MissingLicence(Exception):
    """A crate whose licence, or its text, cannot be found."""


def linked_crates(target):
    """The crates of the registry that are linked in for a target, from `cargo metadata`."""
    command = ['cargo', 'metadata', '--format-version', '1', '--locked', '--filter-platform', target]
    metadata = json.loads(subprocess.run(command, cwd=REPOSITORY, stdout=subprocess.PIPE, check=True).stdout)
    packages = {package['id']: package for package in metadata['packages']}
    nodes = {node['id']: node for node in metadata['resolve']['nodes']}
    waiting = [key for key, package in packages.items() if package['name'] in ROOTS and package['source'] is None]
    if len(waiting) != len(ROOTS):
        raise MissingLicence(f'not all of {ROOTS} are in the workspace')
    seen = set(waiting)
    while waiting:
        for dependency in nodes[waiting.pop()]['deps']:
            key = dependency['pkg']
            is_linked = any(kind['kind'] is None for kind in dependency['dep_kinds'])
            is_macro = any('proc-macro' in kind for target in packages[key]['targets'] for kind in [target['kind']])
            if is_linked and not is_macro and key not in seen:
                seen.add(key)
                waiting.append(key)
    found = [packages[key] for key in seen if packages[key]['source'] is not None]
    return sorted(found, key=lambda package: (package['name'], package['version']))


def chosen(expression):
    """The licences of an SPDX expression that are taken: all parts of `AND`, one of each `OR`."""
    taken = []
    for part in expression.replace('/', ' OR ').replace('(', '').replace(')', '').split(' AND '):
        names = [name.strip().split(' WITH ')[0] for name in part.split(' OR ')]
        known = [name for name in PREFERENCE if name in names]
        if not known:
            raise MissingLicence(f'no licence of "{expression}" is known to scripts/packages/licences.py')
        taken.append(known[0])
    return taken


def licence_files(crate):
    """The files of a crate that hold licences or notices, as {path: text}."""
    folder = Path(crate['manifest_path']).parent
    names = ('licen', 'copying', 'notice', 'unlicense')
    paths = [path for path in sorted(folder.iterdir()) if path.is_file() and path.name.lower().startswith(names)]
    if crate['license_file'] and (folder / crate['license_file']).is_file():
        paths.append(folder / crate['license_file'])
    return {path: path.read_text(errors='replace').replace('\r\n', '\n').strip() for path in paths}


def text_of(licence, files):
    """The text of a licence among a crate's files, or nothing."""
    by_name = [text for path, text in files.items() if any(word in path.name.lower() for word in FILE_WORDS[licence])]
    phrase = PHRASES.get(licence)
    by_phrase = [text for text in files.values() if phrase and phrase in text + '\n']
    return next(iter(by_name or by_phrase), None)


def standard_text(licence, crate, texts):
    """The text that most crates have for the licence, without the lines that name their holders."""
    bodies = ['\n'.join(line for line in text.splitlines() if not line.strip().lower().startswith('copyright')).strip()
              for text in texts.get(licence, [])]
    if not bodies:
        raise MissingLicence(f'{crate["name"]} {crate["version"]} has no text of {licence}, and neither has any other crate')
    authors = ', '.join(crate['authors']) or f'the authors of {crate["name"]}'
    return f'Copyright (c) {authors}\n\n{max(sorted(set(bodies)), key=bodies.count)}'


def third_party(target):
    """The whole text."""
    crates = linked_crates(target)
    files = {crate['id']: licence_files(crate) for crate in crates}
    texts = {}
    for crate in crates:
        for licence in chosen(crate['license'] or ''):
            text = text_of(licence, files[crate['id']])
            if text:
                texts.setdefault(licence, []).append(text)
    users = {}
    rows = []
    for crate in crates:
        name = f'{crate["name"]} {crate["version"]}'
        rows.append(f'{name:40}{crate["license"]}\n    {crate["repository"] or "https://crates.io/crates/" + crate["name"]}')
        for licence in chosen(crate['license'] or ''):
            text = text_of(licence, files[crate['id']]) or standard_text(licence, crate, texts)
            users.setdefault(text, []).append(name)
        for path, text in files[crate['id']].items():
            if path.name.lower().startswith('notice'):
                users.setdefault(text, []).append(name)
    font = REPOSITORY / 'rust_core/scene/assets/LiberationSans-LICENSE.txt'
    users.setdefault(font.read_text().strip(), []).append('Liberation Sans, the font')
    line = '=' * 100
    parts = [f'Linked into the programs of rviz_camera_stream: {len(crates)} crates, and the parts below them.\n',
             *rows, '', NOT_CRATES]
    parts += [f'{line}\n{", ".join(names)}\n{line}\n\n{text}\n' for text, names in users.items()]
    return '\n'.join(parts)
