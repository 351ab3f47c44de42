"""Reads the PNG pictures that Chromium writes; the standard library alone."""

import struct
import zlib
from collections import namedtuple

Picture = namedtuple("Picture", "width height pixels")


def decode(data):
    """Width, height and RGB bytes, of 8-bit RGB or RGBA without interlacing."""
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError("no PNG")
    at, packed, header = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    width, height, depth, colour, _, _, interlace = header
    if (depth, interlace) != (8, 0) or colour not in (2, 6):
        raise ValueError(f"expected 8-bit RGB or RGBA, found depth {depth}, colour type {colour}, interlacing {interlace}")
    channels = 3 if colour == 2 else 4
    raw, stride = zlib.decompress(packed), width * channels
    pixels, above = bytearray(), bytearray(stride)
    for row in range(height):
        start = row * (stride + 1)
        line = bytearray(raw[start + 1 : start + 1 + stride])
        unfilter(raw[start], line, above, channels)
        pixels += line if channels == 3 else bytes(value for k, value in enumerate(line) if k % 4 != 3)
        above = line
    return Picture(width, height, bytes(pixels))


def unfilter(kind, line, above, channels):
    """Undoes a row's filter in place (PNG specification, section 9)."""
    for k in range(len(line)):
        left = line[k - channels] if k >= channels else 0
        up = above[k]
        corner = above[k - channels] if k >= channels else 0
        if kind == 1:
            guess = left
        elif kind == 2:
            guess = up
        elif kind == 3:
            guess = (left + up) // 2
        elif kind == 4:
            estimate = left + up - corner
            guess = min((left, up, corner), key=lambda value: abs(estimate - value))
        else:
            return
        line[k] = (line[k] + guess) & 0xFF
