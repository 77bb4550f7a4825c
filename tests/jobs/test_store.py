"""A store refuses what it was not made for, and takes a damaged result for none."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.errors import PipenavError
from pipenav.jobs import JobStore

CONTENT = b"first\nsecond"


@pytest.fixture
def store(tmp_path: Path) -> JobStore:
    store = JobStore(tmp_path / "store", {"seed": 1, "pipes": ["thesis"]})
    store.write("job", CONTENT)
    return store


def test_the_same_request_opens_it_again(store: JobStore) -> None:
    again = JobStore(store.folder, {"seed": 1, "pipes": ["thesis"]})
    assert again.read("job") == CONTENT


@pytest.mark.parametrize("request_", [{"seed": 2, "pipes": ["thesis"]}, {"seed": 1}, {}])
def test_another_request_is_refused(store: JobStore, request_: dict[str, int]) -> None:
    with pytest.raises(PipenavError, match=r"holds finished parts of something else \((seed|pipes) .*--out"):
        JobStore(store.folder, request_)
    assert store.read("job") == CONTENT


def test_a_damaged_request_is_refused(store: JobStore) -> None:
    (store.folder / "request.json").write_text("[")
    with pytest.raises(PipenavError, match="damaged: remove"):
        JobStore(store.folder, {})


@given(st.data())
def test_a_damaged_result_is_none(data: st.DataObject) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as path:
        store = JobStore(Path(path) / "store", {})
        store.write("job", CONTENT)
        file = store.folder / "job"
        whole = bytearray(file.read_bytes())
        place = data.draw(st.integers(0, len(whole) - 1))
        if data.draw(st.booleans()):
            del whole[place:]
        else:
            whole[place] ^= 1 << data.draw(st.integers(0, 7))
        file.write_bytes(bytes(whole))
        assert not store.has("job")
        store.write("job", CONTENT)
        assert store.read("job") == CONTENT


def test_a_removed_store_is_gone(store: JobStore) -> None:
    store.remove()
    assert not store.folder.exists()
