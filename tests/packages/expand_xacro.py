"""Compares a xacro file with the description that it was expanded to, where xacro itself is not installed.

    expand_xacro.py FILE.urdf.xacro FILE.urdf

Knows what the package's files use: include, property, macro with defaults and blocks, insert_block, unless, and ${...}.
Prints the first difference and exits with 1.
"""
import copy
import math
import os
import re
import sys
import xml.etree.ElementTree as ElementTree

XACRO = '{http://www.ros.org/wiki/xacro}'


def text_of(text, values):
    def evaluate(match):
        return str(eval(match.group(1), {'__builtins__': {}, 'pi': math.pi}, numbers(values)))
    return re.sub(r'\$\{([^}]*)\}', evaluate, text)


def numbers(values):
    def number(text):
        for kind in (int, float):
            try:
                return kind(text)
            except ValueError:
                pass
        return text
    return {name: number(text) for name, text in values.items()}


def expand(parent, element, folder, macros, values, blocks):
    """Appends what an element stands for."""
    name = element.tag.replace(XACRO, '') if element.tag.startswith(XACRO) else None
    attributes = {key: text_of(text, values) for key, text in element.attrib.items() if name != 'macro'}
    if name is None:
        added = ElementTree.SubElement(parent, element.tag, attributes)
        for child in element:
            expand(added, child, folder, macros, values, blocks)
    elif name == 'include':
        for child in ElementTree.parse(os.path.join(folder, attributes['filename'])).getroot():
            expand(parent, child, folder, macros, values, blocks)
    elif name == 'property':
        values[attributes['name']] = attributes['value']
    elif name == 'macro':
        macros[element.attrib['name']] = element
    elif name == 'unless':
        if attributes['value'].lower() in ('false', '0'):
            for child in element:
                expand(parent, child, folder, macros, values, blocks)
    elif name == 'insert_block':
        parent.append(copy.deepcopy(blocks[attributes['name']]))
    else:
        call(parent, element, attributes, macros[name], folder, macros, values, blocks)


def call(parent, element, attributes, macro, folder, macros, values, blocks):
    inner, given = dict(values), {}
    holder = ElementTree.Element('holder')
    for child in element:
        expand(holder, child, folder, macros, values, blocks)
    children = iter(holder)
    for parameter in macro.attrib['params'].split():
        if parameter.startswith('*'):
            given[parameter[1:]] = next(children)
        else:
            name, _, default = parameter.partition(':=')
            inner[name] = attributes.get(name, default.strip("'"))
    for child in macro:
        expand(parent, child, folder, macros, inner, given)


def plain(element):
    """The element with its numbers in one form."""
    def value(text):
        try:
            return tuple(round(float(word), 9) for word in text.split())
        except ValueError:
            return text
    attributes = {key: value(text) for key, text in element.attrib.items()}
    return element.tag, sorted(attributes.items(), key=str), [plain(child) for child in element]


def difference(a, b, path=''):
    if a[:2] != b[:2] or len(a[2]) != len(b[2]):
        return '{}: {} with {} children, not {} with {}'.format(path, a[:2], len(a[2]), b[:2], len(b[2]))
    found = (difference(x, y, path + '/' + x[0]) for x, y in zip(a[2], b[2]))
    return next((text for text in found if text), None)


def main():
    source, expanded = sys.argv[1:]
    root = ElementTree.parse(source).getroot()
    robot = ElementTree.Element('robot', {'name': root.attrib['name']})
    macros, values = {}, {}
    for child in root:
        expand(robot, child, os.path.dirname(source), macros, values, {})
    found = difference(plain(robot), plain(ElementTree.parse(expanded).getroot()))
    if found:
        sys.exit('{} is not what {} expands to: {}'.format(expanded, source, found))


main()
