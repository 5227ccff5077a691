"""Write the table of MAVLink messages from the definitions of a dialect.

Usage: ``python3 mavlink_messages.py DEFINITIONS/ardupilotmega.xml > mavlink_messages.tsv``, where ``DEFINITIONS`` is the folder
``message_definitions/v1.0`` of https://github.com/mavlink/mavlink. Definitions that the dialect includes are read from the
same folder. Each line of the table holds the number, the name, the checksum's extra byte, the fields in the order in which
they are sent, and the extension fields of MAVLink 2. A field is ``type:name``, of an array ``type[length]:name``.
"""

import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

SHORT = {
    "uint64_t": "u64",
    "int64_t": "i64",
    "double": "f64",
    "uint32_t": "u32",
    "int32_t": "i32",
    "float": "f32",
    "uint16_t": "u16",
    "int16_t": "i16",
    "uint8_t": "u8",
    "uint8_t_mavlink_version": "u8",
    "int8_t": "i8",
    "char": "char",
}
SIZE = {"u64": 8, "i64": 8, "f64": 8, "u32": 4, "i32": 4, "f32": 4, "u16": 2, "i16": 2, "u8": 1, "i8": 1, "char": 1}


def read_messages(path: Path, seen: set[Path]) -> list[ElementTree.Element]:
    """Return the elements of all messages of a dialect and of what it includes, each file once."""
    if path in seen:
        return []
    seen.add(path)
    root = ElementTree.parse(path).getroot()
    found = [one for include in root.iter("include") for one in read_messages(path.parent / str(include.text), seen)]
    return found + list(root.iter("message"))


def accumulate(crc: int, data: bytes) -> int:
    """Return the checksum of MAVLink (CRC-16/MCRF4XX) after further bytes."""
    for byte in data:
        mixed = (byte ^ crc) & 0xFF
        mixed = (mixed ^ (mixed << 4)) & 0xFF
        crc = ((crc >> 8) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4)) & 0xFFFF
    return crc


def line(message: ElementTree.Element) -> str:
    """Return the line of the table for a message."""
    base: list[tuple[str, str, int | None]] = []
    extensions: list[tuple[str, str, int | None]] = []
    into = base
    for child in message:
        if child.tag == "extensions":
            into = extensions
        if child.tag != "field":
            continue
        kind, length = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", child.attrib["type"]).groups()  # type: ignore[union-attr]
        into.append((kind, child.attrib["name"], int(length) if length else None))
    base.sort(key=lambda field: -SIZE[SHORT[field[0]]])
    crc = accumulate(0xFFFF, f"{message.attrib['name']} ".encode())
    for kind, name, length in base:
        crc = accumulate(crc, f"{kind.removesuffix('_mavlink_version')} {name} ".encode())
        if length:
            crc = accumulate(crc, bytes([length]))

    def written(fields: list[tuple[str, str, int | None]]) -> str:
        return " ".join(f"{SHORT[kind]}{f'[{length}]' if length else ''}:{name}" for kind, name, length in fields)

    extra = (crc & 0xFF) ^ (crc >> 8)
    return "\t".join([message.attrib["id"], message.attrib["name"], str(extra), written(base), written(extensions)])


if __name__ == "__main__":
    messages = read_messages(Path(sys.argv[1]), set())
    for each in sorted(messages, key=lambda message: int(message.attrib["id"])):
        print(line(each))
