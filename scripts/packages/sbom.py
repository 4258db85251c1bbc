"""The bill of materials of the programs, as CycloneDX 1.5: the crates that are linked in, as licences.py finds them, with
their checksums in Cargo.lock. It has no serial number, and the moment of the packages: the same sources give the same.
"""

import json
import re
from datetime import datetime, timezone

from licences import linked_crates
from staging import PACKAGE, REPOSITORY

ENTRY = re.compile(r'name = "(.*)"\nversion = "(.*)"\nsource = ".*"\nchecksum = "(.*)"')


def component(crate, checksums):
    """A crate of the registry."""
    name, version = crate['name'], crate['version']
    purl = f'pkg:cargo/{name}@{version}'
    found = {
        'type': 'library', 'bom-ref': purl, 'name': name, 'version': version, 'purl': purl,
        'licenses': [{'expression': crate['license'].replace('/', ' OR ')}],
        'hashes': [{'alg': 'SHA-256', 'content': checksums[name, version]}],
    }
    if crate['repository']:
        found['externalReferences'] = [{'type': 'vcs', 'url': crate['repository']}]
    return found


def cyclonedx(target, version, moment):
    """The whole text for a target."""
    entries = ENTRY.findall((REPOSITORY / 'Cargo.lock').read_text())
    checksums = {(name, version): checksum for name, version, checksum in entries}
    return json.dumps({
        'bomFormat': 'CycloneDX', 'specVersion': '1.5', 'version': 1,
        'metadata': {
            'timestamp': datetime.fromtimestamp(moment, timezone.utc).strftime('%Y-%m-%dT%H:%M:%SZ'),
            'component': {'type': 'application', 'bom-ref': PACKAGE, 'name': PACKAGE, 'version': version,
                          'licenses': [{'license': {'id': 'BSD-3-Clause'}}]},
            'properties': [{'name': 'target', 'value': target}],
        },
        'components': [component(crate, checksums) for crate in linked_crates(target)],
    }, indent=1, sort_keys=True) + '\n'
