"""Pipe folders are written whole or not at all, and read back as they were."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.errors import ConfigError, FileProblem, OutOfRange, PipenavError
from pipenav.export import corner_folder
from pipenav.export.corner_folder import FILES, read_pipe, write_pipe_folder
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.json_keys import CORNER_KEYS

diameters = st.floats(40, 300)
angles = st.one_of(st.floats(30, 180), st.sampled_from([30.0, 90.0, 179.999, 180.0]))
bends = st.one_of(st.floats(0, 500), st.sampled_from([0.0, 0.01, 1.0, 20.0]))
turns = st.sampled_from(["left", "right"])
walls = st.sampled_from([0.5, 3.0, 50.0])
pipes = st.builds(lambda d, a, t, r, w: PipeCorner.of(d, a, t, r, wall_mm=w), diameters, angles, turns, bends, walls)


@settings(max_examples=50, deadline=None)
@given(pipes)
def test_json_round_trip_is_exact(pipe: PipeCorner) -> None:
    record = json.loads(json.dumps(corner_folder.pipe_record(pipe)))
    assert PipeCorner.model_validate({f: record[key] for f, key in CORNER_KEYS.items()}) == pipe


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"schema": 2}, ConfigError, "schema 2: this version of pipenav reads schema 1"),
        ({"diameter_m": "wide"}, ConfigError, "diameter: input should be a valid number, given 'wide'"),
        ({"turn": "up"}, ConfigError, "turn: input should be 'left' or 'right'"),
        ({"diameter_m": 0.4}, OutOfRange, "diameter 400 mm is out of range: choose 40 to 300 mm"),
        ({"diameter_mm": 90}, ConfigError, "diameter_mm 90 contradicts"),
        ({"leg_m": None}, ConfigError, "leg: input should be a valid number"),
    ],
)
def test_bad_pipe_files_are_refused_in_one_sentence(
    tmp_path: Path, change: dict[str, object], error: type[PipenavError], message: str
) -> None:
    file = tmp_path / "pipe.json"
    file.write_text(json.dumps({**corner_folder.pipe_record(PipeCorner.of(100, 75)), **change}))
    with pytest.raises(error, match=message) as caught:
        read_pipe(file)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"{", "is not valid JSON"),
        (b"\xff\xfe", "is not text"),
        (b"[1]", "has no 'schema'"),
        (b'{"schema": 1, "turn": "left"}', "lacks diameter_m, angle_rad"),
    ],
)
def test_files_that_are_not_pipes_are_refused(tmp_path: Path, content: bytes, message: str) -> None:
    file = tmp_path / "pipe.json"
    file.write_bytes(content)
    with pytest.raises(ConfigError, match=message):
        read_pipe(file)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match=r"cannot read .*nowhere"):
        read_pipe(tmp_path / "nowhere")


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Writing without the slow part, the drawing."""
    monkeypatch.setattr("pipenav.drawing.corner.draw_pipe", lambda _, path: path.write_bytes(b"png"))


@pytest.mark.usefixtures("quick")
def test_writing_again_replaces_the_folder_and_keeps_what_others_put_there(tmp_path: Path) -> None:
    folder = write_pipe_folder(PipeCorner.of(100, 75), tmp_path)
    (folder / "notes.txt").write_text("mine")
    assert write_pipe_folder(PipeCorner.of(100, 75, wall_mm=5), tmp_path) == folder
    assert read_pipe(folder).wall == 0.005
    assert {path.name for path in folder.iterdir()} == {*FILES, "notes.txt"}
    assert list(tmp_path.iterdir()) == [folder]


@pytest.mark.parametrize("kind", ["folder", "file", "link"])
def test_what_is_not_a_pipe_folder_stays(tmp_path: Path, kind: str) -> None:
    target = tmp_path / PipeCorner.of(100, 75).name
    if kind == "folder":
        target.mkdir()
        (target / "thesis.tex").write_text("years of work")
    elif kind == "file":
        target.write_text("years of work")
    else:
        target.symlink_to("nowhere")
    with pytest.raises(PipenavError, match="is not a pipe folder: move it away"):
        write_pipe_folder(PipeCorner.of(100, 75), tmp_path)
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.usefixtures("quick")
def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "occupied").write_text("a file where a folder should be")
    with pytest.raises(FileProblem, match=r"cannot write .*corner-d100-a75-left"):
        write_pipe_folder(PipeCorner.of(100, 75), tmp_path / "occupied")


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_write_that_fails_leaves_the_old_folder_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    with monkeypatch.context() as quick:
        quick.setattr("pipenav.drawing.corner.draw_pipe", lambda _, path: path.write_bytes(b"png"))
        folder = write_pipe_folder(PipeCorner.of(100, 75), tmp_path)

    def fail(_: PipeCorner, path: Path) -> None:
        path.write_bytes(b"half")
        raise error

    monkeypatch.setattr("pipenav.drawing.corner.draw_pipe", fail)
    with pytest.raises(FileProblem if isinstance(error, OSError) else KeyboardInterrupt):
        write_pipe_folder(PipeCorner.of(100, 75, wall_mm=5), tmp_path)
    assert read_pipe(folder).wall == 0.003 and (folder / "pipe.png").read_bytes() == b"png"
    assert list(tmp_path.iterdir()) == [folder]


@pytest.mark.usefixtures("quick")
def test_a_failed_swap_puts_the_old_folder_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = write_pipe_folder(PipeCorner.of(100, 75), tmp_path)
    rename = Path.rename
    monkeypatch.setattr("pipenav.storage.atomic_folder.exchange", lambda *_: False)

    def refuse_new(self: Path, target: Path) -> Path:
        if target == folder and "-old-" not in self.name:
            raise PermissionError(13, "Permission denied")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", refuse_new)
    with pytest.raises(FileProblem, match="Permission denied"):
        write_pipe_folder(PipeCorner.of(100, 75, wall_mm=5), tmp_path)
    assert read_pipe(folder).wall == 0.003
    assert list(tmp_path.iterdir()) == [folder]
