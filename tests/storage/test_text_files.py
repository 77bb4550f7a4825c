"""Text files are sized up before a parser sees them: hostile ones are refused in a sentence, harmless ones are read."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.errors import ConfigError, FileProblem, PipenavError
from pipenav.storage.text_files import (
    MAX_DEPTH,
    MAX_SETTINGS,
    parse_json,
    parse_toml,
    read_bytes,
    read_json,
    read_text,
    read_toml,
)

READERS: list[Callable[[Path], Any]] = [read_text, read_toml, read_json]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "a.toml"


def test_byte_order_mark_windows_lines_and_empty_last_lines_are_read(file: Path) -> None:
    file.write_bytes(b"\xef\xbb\xbfa = 1\r\nb = 'x'\r\n\r\n")
    assert read_toml(file) == {"a": 1, "b": "x"}
    file.write_bytes(b'\xef\xbb\xbf{"a": 1}\r\n\r\n')
    assert read_json(file) == {"a": 1}


@pytest.mark.parametrize("read", READERS)
def test_only_plain_files_are_read(read: Callable[[Path], Any], tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path, Path("/dev/zero"), Path("/dev/null")):
        with pytest.raises(PipenavError, match=r"not a plain file|Is a directory"):
            read(path)


@pytest.mark.parametrize("read", READERS)
def test_names_that_no_file_can_have(read: Callable[[Path], Any], tmp_path: Path) -> None:
    for name in ("a\0b", "a" * 5000, "missing"):
        with pytest.raises(PipenavError) as refused:
            read(tmp_path / name)
        assert len(str(refused.value)) < 600
        assert "\0" not in str(refused.value)


def test_a_file_may_be_as_large_as_its_format_needs(file: Path) -> None:
    file.write_bytes(b"#" * MAX_SETTINGS)
    assert read_toml(file) == {}
    file.write_bytes(b"#" * (MAX_SETTINGS + 1))
    with pytest.raises(ConfigError, match="larger than 256 KiB"):
        read_toml(file)
    with pytest.raises(ConfigError, match="larger than 1 KiB"):
        read_bytes(file, 1024)


def test_what_is_no_text(file: Path) -> None:
    file.write_bytes(b"a = '\xff'")
    with pytest.raises(ConfigError, match="not text in UTF-8: byte 6"):
        read_toml(file)


def test_a_missing_file_is_named(file: Path) -> None:
    with pytest.raises(FileProblem, match=r"cannot read .*a\.toml: No such file"):
        read_toml(file)


NESTED = MAX_DEPTH + 1
HOSTILE_TOML = {
    "lists": "a = " + "[" * 50_000,
    "closed lists": f"a = {'[' * NESTED}{']' * NESTED}",
    "tables": "a = " + "{a = " * 50_000,
    "dotted key": ".".join("a" * 100_000) + " = 1",
    "dotted header": f"[{' . '.join('a' * 100_000)}]",
    "quoted dotted key": ".".join(["'a'"] * 50_000) + " = 1",
    "dotted keys in tables": f"a = {{ {'.'.join('a' * 90)} = {{ {'.'.join('a' * 90)} = 1 }} }}",
    "digits": "a = " + "1" * 5000,
    "digits apart": "a = " + "1_" * 3000 + "1",
    "hexadecimal digits": "a = 0x" + "f" * 5000,
    "a number beyond 64 bits": "a = 18446744073709551616",
    "after a string": 'a = "["\nb = ' + "[" * 5000,
    "after an open string": "a = '\nb = " + "[" * 5000,
    "a month that is none": "a = 2000-13-01",
    "a null byte": "a = 1\0",
}
HOSTILE_JSON = {
    "lists": "[" * 50_000,
    "closed lists": "[" * NESTED + "]" * NESTED,
    "tables": '{"a":' * 50_000,
    "digits": "1" * 5000,
    "a number beyond 64 bits": "1" + "0" * 400,
    "after a string": '["\\"[", ' + "[" * 5000,
}


@pytest.mark.parametrize("text", HOSTILE_TOML.values(), ids=HOSTILE_TOML)
def test_hostile_toml_is_refused_in_a_sentence(text: str) -> None:
    with pytest.raises(ConfigError) as refused:
        parse_toml(text, "x.toml")
    assert len(str(refused.value)) < 300


@pytest.mark.parametrize("text", HOSTILE_JSON.values(), ids=HOSTILE_JSON)
def test_hostile_json_is_refused_in_a_sentence(text: str) -> None:
    with pytest.raises(ConfigError) as refused:
        parse_json(text, "x.json")
    assert len(str(refused.value)) < 300


@given(st.text(max_size=300))
def test_any_text_in_a_string_does_no_harm(text: str) -> None:
    """Brackets, digits and dots in strings and comments are no nesting, numbers or keys."""
    import json

    harmless = (text + "[{" * 200 + "1" * 2000 + "a." * 200)[:MAX_SETTINGS]
    assert parse_json(json.dumps(harmless), "x.json") == harmless
    quoted = json.dumps(harmless).replace("\x7f", "\\u007f")
    comment = "".join(letter for letter in harmless if letter.isprintable())
    if not any(0xD800 <= ord(letter) <= 0xDFFF for letter in harmless) and "\\ud8" not in quoted.lower():
        assert parse_toml(f"# {comment}\na = '[' # {comment}\nb = 1", "x.toml") == {"a": "[", "b": 1}


@given(st.text(alphabet="ab.=[]{}\"'\\\n#0123456789_-\0 \ufeff", max_size=200))
def test_any_text_is_read_or_refused(text: str) -> None:
    for parse in (parse_toml, parse_json):
        with contextlib.suppress(ConfigError):
            parse(text, "x")
