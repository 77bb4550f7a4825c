"""Mutations of files: of their bytes, of their lines, and of the values that they hold."""

from __future__ import annotations

import copy
import json
import math
import random
from typing import Any

NUMBERS = [
    0, 1, -1, 2, 3, 255, 2**31, 2**53, 2**63 - 1, -(2**63), 2**64, 10**400, 0.0, -0.0, 0.5, 1e-9, 5e-324, 1e-308,
    1e-30, 1e9, 1e30, 1e300, 1.7976931348623157e308, math.inf, -math.inf, math.nan,
]  # fmt: skip
WORDS = [
    "", " ", "a", "NaN", "inf", "\0", "a\0b.toml", "../../etc/passwd", "/dev/zero", "/dev/null", "x" * 10_000, "\u202e",
    "\x1b[31m", "é", "\ud7ff", "\U0001f600", "[bold]", "%s%n", "{0}", "baseline:random", "runs-level:9" + "9" * 5000,
    "d=1e400,angle=90", "d=nan,angle=90", "a,b", "a\nb", "world", "wall0", "tip", "base_x", "mujoco", "pybullet",
]  # fmt: skip
PIECES = [
    b"\0", b"\xff", b"\xef\xbb\xbf", b"\r\n", b"\n", b"\r", b"[", b"]", b"{", b"}", b'"', b"'", b"\\", b",", b"=", b":",
    b"1e999", b"nan", b"inf", b"-", b"0x", b"_", b".", b"#", b"\x1b[31m", b"\xe2\x80\xae", b"[" * 300, b"{a=" * 300,
    b'{"a":' * 300, b"a." * 300, b"9" * 5000, b"9" * 400, b'"""', b"'''", b"2000-13-01", b"\n\n",
]  # fmt: skip


MOST_PLACES = 5000
"""Values of a tree from which on it is mutated no further."""


def mutated_bytes(content: bytes, rng: random.Random) -> bytes:
    """The content with some of its bytes, or one of its lines, changed."""
    for _ in range(rng.choice([1, 1, 1, 2, 4, 16])):
        at, size = rng.randrange(len(content) + 1), rng.choice([0, 1, 1, 4, 30, 1000])
        kind = rng.randrange(6)
        if kind == 0:
            content = content[:at] + rng.choice(PIECES) + content[at + size :]
        elif kind == 1:
            content = content[:at] + content[at + size :]
        elif kind == 2:
            content = content[:at]
        elif kind == 3:
            content = content[:at] + content[at : at + size] * rng.choice([2, 3, 200]) + content[at + size :]
        elif kind == 4:
            lines = content.split(b"\n")
            lines.insert(rng.randrange(len(lines) + 1), rng.choice(lines))
            content = b"\n".join(lines)
        else:
            content = content[:at] + bytes(rng.randrange(256) for _ in range(size)) + content[at + size :]
    return content[: 1 << 22]


def mutated_tree(tree: Any, rng: random.Random) -> Any:
    """The values of a file with some of them changed, left out, doubled or nested."""
    tree = copy.deepcopy(tree)
    for _ in range(rng.choice([1, 1, 1, 1, 2, 5])):
        places = _places(tree)
        if not places or len(places) > MOST_PLACES:
            return tree
        holder, key = rng.choice(places)
        kind = rng.randrange(10)
        if kind < 6:
            holder[key] = _changed(holder[key], rng)
        elif kind == 6:
            del holder[key]
        elif kind == 7:
            holder[key] = _nested(holder[key], rng.choice([1, 3, 99, 300]), rng)
        elif isinstance(holder, list):
            holder += holder[key : key + 1] * rng.choice([1, 2, 300])
        else:
            holder[rng.choice([*WORDS, f"{key}x"])] = copy.deepcopy(holder[key])
    return tree


def _places(tree: Any) -> list[tuple[Any, Any]]:
    """Holders and keys of the values in a tree, the first few thousand."""
    places: list[tuple[Any, Any]] = []
    trees = [tree]
    for holder in trees:
        if len(places) > MOST_PLACES:
            break
        keys = list(holder) if isinstance(holder, dict) else range(len(holder)) if isinstance(holder, list) else []
        places += [(holder, key) for key in keys]
        trees += [holder[key] for key in keys]
    return places


def _changed(value: Any, rng: random.Random) -> Any:
    if isinstance(value, bool) or rng.random() < 0.15:
        return rng.choice([None, True, False, [], {}, [[]], *NUMBERS, *WORDS])
    if isinstance(value, int | float):
        value = value if -1e300 < value < 1e300 else 1
        close = [value * rng.choice([-1, 0.1, 0.5, 1.01, 2, 10, 1000, 1e6, 1e-3, 1e-6]), value + rng.choice([-1, 1])]
        return rng.choice([*close, *close, *close, rng.choice(NUMBERS)])
    if isinstance(value, str):
        return rng.choice([*WORDS, value + rng.choice(WORDS), value * 2])
    if isinstance(value, list):
        return rng.choice([value[::-1], value[:-1], value * 2, [], value * 500])
    return rng.choice([{}, [], [value], None, 1])


def _nested(value: Any, depth: int, rng: random.Random) -> Any:
    for _ in range(depth):
        value = [value] if rng.random() < 0.5 else {"a": value}
    return value


def as_json(tree: Any) -> bytes:
    """The values as JSON, whole numbers of any length included."""
    return json.dumps(tree).encode("utf-8", "replace")


def as_toml(tree: Any) -> bytes:
    """The values as TOML, every one behind its key in the first table."""
    if not isinstance(tree, dict):
        return _toml(tree).encode("utf-8", "replace")
    return "".join(f"{_key(key)} = {_toml(value)}\n" for key, value in tree.items()).encode("utf-8", "replace")


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(key)} = {_toml(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, bool) or value is None:
        return str(bool(value)).lower()
    return _key(value) if isinstance(value, str) else str(value)


def _key(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\0", "\\u0000").replace("\x1b", "\\u001b")
