# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads OpenEXR files as Blender writes them without compression, without Blender's own reader."""

import struct

import numpy as np

_TYPES = {0: np.uint32, 1: np.float16, 2: np.float32}


def _text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _header(data, at):
    """The attributes of one part, and where the next begins."""
    attributes = {}
    while data[at]:
        name, at = _text(data, at)
        _, at = _text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _channels(attribute):
    channels, at = [], 0
    while attribute[at]:
        name, at = _text(attribute, at)
        (kind,) = struct.unpack_from("<i", attribute, at)
        channels.append((name, np.dtype(_TYPES[kind])))
        at += 16
    return channels


def header(path):
    """The attributes of the file's first part by name, as bytes."""
    return _header(path.read_bytes(), 8)[0]


def read(path):
    """Channels by name: arrays (height, width), the top row first. In files with parts, names begin with the part's."""
    data = path.read_bytes()
    magic, version = struct.unpack_from("<II", data)
    if magic != 20000630:
        raise ValueError(f"{path} is no OpenEXR file")
    parts, at = [], 8
    multipart = bool(version & 0x1000)
    while data[at]:
        attributes, at = _header(data, at)
        parts.append(attributes)
        if not multipart:
            break
    at += multipart
    chunks = [struct.unpack("<4i", part["dataWindow"]) for part in parts]
    heights = [top_to_bottom[3] - top_to_bottom[1] + 1 for top_to_bottom in chunks]
    at += 8 * sum(heights)
    images = [
        {name: np.zeros((height, window[2] - window[0] + 1), kind) for name, kind in _channels(part["channels"])}
        for part, window, height in zip(parts, chunks, heights, strict=True)
    ]
    for part in parts:
        if part["compression"] != b"\0":
            raise ValueError(f"{path} is compressed")
    for _ in range(sum(heights)):
        number = 0
        if multipart:
            (number,) = struct.unpack_from("<i", data, at)
            at += 4
        row, size = struct.unpack_from("<ii", data, at)
        at += 8
        offset = at
        for channel in images[number].values():
            line = np.frombuffer(data, channel.dtype.newbyteorder("<"), channel.shape[1], offset)
            channel[row - chunks[number][1]] = line
            offset += line.nbytes
        at += size
    result = {}
    for part, image in zip(parts, images, strict=True):
        prefix = part["name"].decode() + "." if multipart else ""
        for name, values in image.items():
            result[name if not multipart or name.startswith(prefix) else prefix + name] = values
    return result
