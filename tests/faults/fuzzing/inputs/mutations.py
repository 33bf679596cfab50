"""Mutations: what is done to sound bytes and to sound JSON so that little of it is sound any more."""

from __future__ import annotations

import contextlib
import copy
import gzip
import io
import json
import struct
import zipfile
import zlib
from collections.abc import Callable, Sequence
from random import Random
from typing import Any

WORDS = (
    b"II*\0", b"MM\0*", b"II+\0\x08\0\0\0", b"\x89PNG\r\n\x1a\n", b"IHDR", b"IDAT", b"PLTE", b"tRNS", b"pHYs", b"eXIf",
    b"acTL", b"fdAT", b"\xff\xd8\xff\xe0", b"\xff\xda", b"\xff\xc4", b"\xff\xe1\x00\x10Exif\0\0", b"BM", b"GIF89a",
    b"\x21\xf9\x04", b"RIFF", b"WEBPVP8L", b"WEBPVP8X", b"\0\0\0\x0cjP  ", b"ihdr", b"jp2c", b"P1\n", b"P3\n", b"P5\n",
    b"P6 1 1 65535\n", b"\x93NUMPY\x01\0", b"'descr': '<f8'", b"'descr': '|O'", b"'descr': '<c16'", b"'<M8[s]'",
    b"'shape': (9, 12, 4)", b"'shape': (-1, 9)", b"'shape': (99999999999, 9)", b"'fortran_order': True",
    b"n+1\0", b"DICM", b"NRRD0004\n", b"\x1f\x8b\x08\0", b"PK\x03\x04", b"ImageJ=1.11a\nimages=999999999\n",
    b"<?xml version='1.0'?><OME><Pixels PhysicalSizeX='nan'/></OME>", b"nan", b"inf", b"-1e308", b"1e-320", b"0x10",
    b"1_000", b"\xef\xbb\xbf", b"\xed\xa0\x80", b"\x00", b"\r", b"\"", b",,,,", b"=1+1", b"\x1b[31m",
)  # fmt: skip
"""Signatures, names and values that decoders look for."""

_NUMBERS = (0, 1, 2, 3, 7, 8, 16, 127, 128, 255, 256, 32767, 32768, 65535, 65536, 2**31 - 1, 2**31, 2**32 - 1, 2**62)
_PNG, _GZIP, _ZIP = b"\x89PNG\r\n\x1a\n", b"\x1f\x8b\x08", b"PK\x03\x04"

VALUES: tuple[Any, ...] = (
    None, True, False, 0, 1, -1, 2, 0.5, -0.0, 1e-320, 1e6, 1e9, -1e6, 1e300, -1e308, 10**30, 2**31, 2**63,
    float("nan"), float("inf"), "", "auto", "nan", "1", "\0", "\x1b[31m", "a\nb", "é\ud800", "x" * 10**6, "../" * 50,
    [], [[]], {}, [0.0, 0.0], [1e9, -1e9], [[0, 0]] * 3, {"shape": "circle"}, [None] * 1000, [[[[]]]],
)  # fmt: skip
"""Values that stand in place of others."""


_MOST, _SMALL = 20_000, 200
"""Size of JSON from which on it is left as it is, and below which it is copied many times: copies of copies would fill
memory."""


def mutated(content: bytes, random: Random, others: Sequence[bytes] = ()) -> bytes:
    """Bytes with a few changes; those of a PNG and of a packed file are often such that their check sums are right."""
    if content.startswith((_GZIP, _ZIP)) and random.random() < 0.7:
        with contextlib.suppress(OSError, EOFError, zlib.error, zipfile.BadZipFile):
            return _changed_within(content, random)
    changed = bytearray(content)
    for _ in range(random.choice((1, 1, 1, 2, 3, 6))):
        random.choice(_CHANGES)(changed, random)
    if others and random.random() < 0.05:
        other = random.choice(others)
        cut = random.randrange(len(other) + 1)
        changed = changed[: random.randrange(len(changed) + 1)] + other[cut:]
    if changed.startswith(_PNG) and random.random() < 0.7:
        return _with_sums(bytes(changed))
    return bytes(changed)


def _flip(content: bytearray, random: Random) -> None:
    if content:
        content[_place(content, random)] ^= 1 << random.randrange(8)


def _set(content: bytearray, random: Random) -> None:
    if content:
        content[_place(content, random)] = random.choice((0, 1, 0x7F, 0x80, 0xFF, random.randrange(256)))


def _number(content: bytearray, random: Random) -> None:
    """Put a number of two, four or eight bytes."""
    kind = random.choice("HIQ")
    size = struct.calcsize(kind)
    at, value = _place(content, random), random.choice(_NUMBERS) % 256**size
    content[at : at + size] = struct.pack(random.choice("<>") + kind, value)


def _word(content: bytearray, random: Random) -> None:
    word, at = random.choice(WORDS), _place(content, random)
    content[at : at + random.choice((0, len(word)))] = word


def _remove(content: bytearray, random: Random) -> None:
    at = _place(content, random)
    del content[at : at + random.choice((1, 2, 4, 16, 100))]


def _repeat(content: bytearray, random: Random) -> None:
    at = _place(content, random)
    content[at:at] = content[at : at + random.choice((1, 4, 30))] * random.choice((1, 2, 50))


def _cut(content: bytearray, random: Random) -> None:
    del content[_place(content, random) :]


def _digit(content: bytearray, random: Random) -> None:
    """Change a digit of a number that is written as text."""
    digits = [at for at, byte in enumerate(content[:4000]) if 48 <= byte <= 57]
    if digits:
        at = random.choice(digits)
        content[at : at + 1] = random.choice((b"0", b"9", b"-", b"", b".", b"e5", b"99999999", b"nan"))


_CHANGES: tuple[Callable[[bytearray, Random], None], ...] = (
    *(_flip, _flip, _set, _set, _number, _number, _number),
    *(_word, _remove, _repeat, _cut, _digit),
)


def _place(content: bytearray, random: Random) -> int:
    """A place in a file, more often near its beginning, where the header is."""
    size = len(content) if random.random() < 0.5 else min(len(content), 120)
    return random.randrange(size) if size else 0


def _with_sums(content: bytes) -> bytes:
    """A PNG with right check sums of its chunks, so that what is in them is looked at."""
    parts, at = [_PNG], len(_PNG)
    while at + 12 <= len(content):
        (length,) = struct.unpack(">I", content[at : at + 4])
        body = content[at + 4 : at + 8 + length]
        parts.append(content[at : at + 4] + body + struct.pack(">I", zlib.crc32(body)))
        at += 12 + length
    return b"".join(parts) + content[at:]


def _changed_within(content: bytes, random: Random) -> bytes:
    """A packed file with changes of what is packed in it."""
    if content.startswith(_GZIP):
        return gzip.compress(mutated(gzip.decompress(content), random), 1, mtime=0)
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as before, zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as after:
        chosen = random.choice(before.namelist())
        for name in before.namelist():
            content = before.read(name)
            after.writestr(zipfile.ZipInfo(name), mutated(content, random) if name == chosen else content)
    return stream.getvalue()


def mutated_json(plain: Any, random: Random) -> Any:
    """Plain JSON with a few changes of its values, names and nesting."""
    plain = json.loads(json.dumps(plain))
    for _ in range(random.choice((1, 1, 2, 3, 8))):
        place = random.choice(_places(plain)) if _size(plain) <= _MOST else None
        if place is None:
            break
        inside, key = place
        change = random.random()
        if change < 0.55:
            inside[key] = _other(inside[key], random)
        elif change < 0.7:
            del inside[key]
        elif change < 0.8:
            inside[key] = _nested(inside[key], random)
        elif isinstance(inside, dict):
            inside[random.choice(("", "shape", "data", "kind", str(key) + " ", "\0"))] = inside.pop(key)
        else:
            several = (1, 2, 60) if _size(inside[key]) < _SMALL else (1, 2)
            inside[key:key] = [copy.deepcopy(inside[key]) for _ in range(random.choice(several))]
    return plain


def _other(value: Any, random: Random) -> Any:
    """Another value: often one of the same type."""
    if random.random() < 0.5:
        return copy.deepcopy(random.choice(VALUES))  # what is put into it later must not stay for the next input
    if isinstance(value, bool):
        return not value
    if isinstance(value, int | float):
        return random.choice((-value, value + 1, value * 1e3, value / 1e3, value + 0.5, abs(value), str(value)))
    if isinstance(value, str):
        return random.choice((value[1:], value + value, value.upper(), value[: len(value) // 2], [value], "a" * 5000))
    if isinstance(value, list):
        return random.choice(
            (value[::-1], value[1:], value + copy.deepcopy(value), value[:1], dict.fromkeys(map(str, value)), [value])
        )
    if isinstance(value, dict):
        return random.choice((list(value.values()), list(value), dict(list(value.items())[1:]), [value]))
    return copy.deepcopy(random.choice(VALUES))


def _nested(value: Any, random: Random) -> Any:
    for _ in range(random.choice((1, 10, 70, 100))):
        value = [value] if random.random() < 0.5 else {"a": value}
    return value


def _places(plain: Any) -> list[tuple[Any, Any] | None]:
    """Places of all values, the object or list that holds each and its key in it."""
    found: list[tuple[Any, Any] | None] = [None]
    layer = [plain]
    while layer:
        inner = []
        for holder in layer:
            items = holder.items() if isinstance(holder, dict) else enumerate(holder)
            for key, value in items:
                found.append((holder, key))
                if isinstance(value, dict | list):
                    inner.append(value)
        layer = inner
    return found[1:] or found


def _size(plain: Any) -> int:
    """Size of JSON: its values and the hundreds of characters in its texts, counted to a little above `_MOST`."""
    size, waiting = 0, [plain]
    while waiting and size <= _MOST:
        value = waiting.pop()
        size += 1
        if isinstance(value, str):
            size += len(value) // 100
        elif isinstance(value, dict):
            size += sum(len(key) // 100 for key in value)
            waiting += value.values()
        elif isinstance(value, list):
            waiting += value
    return size
