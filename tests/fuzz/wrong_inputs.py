"""Wrong inputs through whole commands: `python tests/fuzz/wrong_inputs.py`, the commands are those of wrong_inputs.txt.

Each must be refused in one sentence that names what was given and says what is allowed or what to do, with exit code 1,
or 2 for wrong usage, and must leave its folder as it was. `--show` prints all sentences, for people to judge them.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import re
import shlex
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
TESTS = HERE.parent

LONGEST = 20
"""Seconds that a refusal may take, on a machine that may be busy."""

HEAVY = (
    "matplotlib.pyplot",
    "mujoco",
    "pipenav_hardware.backend",
    "pipenav_pybullet.backend",
    "pipenav.learning.train",
)
"""Modules that commands import where they need them."""

LONG = 20
"""Letters of a part of an input from which on a message may leave out its middle."""

MOST_LETTERS = 600
"""Most characters of a message: lists of known names are the longest."""

ADVICE = re.compile(
    r"\b(choose|give|write|leave out|try|make|train|name|did you mean|must|should|at most|at least|needs?|copy|move|"
    r"record it|one of|between|missing|see|remove|use|say|write|written|leave|make|correct|check|it needs|plug|"
    r"set it|replay it|shows)\b",
    re.IGNORECASE,
)
"""Words by which a sentence says what is allowed or what to do."""


ODD = {"<byte>": "\udcff", "<line>": "\n", "<escape>": "\x1b[31m", "<long>": "x" * 5000}
"""Letters that cannot be seen in a list: a byte that is no UTF-8, as Python decodes it, and the like."""

UNNAMED = (
    "''",
    "issing",
    "no pipe is named",
    "see above",
    "name the device",
    "one route",
    "the passage",
    "fault 1",
    "there is no",
    "leaves the plane",
    "measures a policy",
)
"""Words of messages about what is not in the input: an empty text, an option that is missing, a part of a file."""


class Answer(NamedTuple):
    """A command's answer to an input.

    Attributes:
        code: exit code; minus the number of the signal that ended it.
        message: the error, on one line.
        lines: number of lines on stderr; 1 for wrong usage, whose frame does not count.
        changes: what became different in the folder.
    """

    code: int
    message: str
    lines: int
    changes: list[str]


def inputs() -> list[list[str]]:
    """The wrong inputs: words after `pipenav`."""
    lines = (HERE / "wrong_inputs.txt").read_text().splitlines()
    return [list(map(_unfolded, shlex.split(line))) for line in lines if line.strip() and not line.startswith("#")]


def _unfolded(word: str) -> str:
    """A word with the letters that <...> stands for."""
    for sign, letters in ODD.items():
        word = word.replace(sign, letters)
    return word


class Bench:
    """A folder with the files in which commands are run; what one of them changes is put back."""

    def __init__(self, folder: Path) -> None:
        from fuzz.wrong_files import prepare

        self._whole, self._folder, self._said = folder / "whole", folder / "work", folder / "said"
        self._whole.mkdir()
        prepare(self._whole)
        self._before = _listing(self._whole)
        shutil.copytree(self._whole, self._folder)

    def answer(self, words: Sequence[str]) -> Answer:
        """Run a command, words after `pipenav`, in a process of its own."""
        pid = os.fork()
        if not pid:
            _become(words, self._folder, self._said)
        code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        after = _listing(self._folder)
        changes = [name for name in sorted({*self._before, *after}) if self._before.get(name) != after.get(name)]
        if changes:
            shutil.rmtree(self._folder)
            shutil.copytree(self._whole, self._folder)
        text = self._said.read_text(errors="replace")
        frame = re.search(r"╭─ Error ─+╮\n(.*?)╰", text, re.DOTALL)
        if frame:
            return Answer(code, " ".join(frame[1].replace("│", " ").split()), 1, changes)
        lines = [line for line in text.strip().splitlines() if line.strip()]
        return Answer(code, "\n".join(lines), len(lines), changes)


def _become(words: Sequence[str], folder: Path, said: Path) -> None:
    """Run a command in this process, which ends with it."""
    from pipenav.cli import main

    os.setpgid(0, 0)
    signal.alarm(LONGEST)
    os.chdir(folder)
    tempfile.tempdir = str(folder.parent)
    output = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    nothing = os.open(os.devnull, os.O_RDWR)
    for descriptor, stream in ((nothing, 0), (nothing, 1), (output, 2)):
        os.dup2(descriptor, stream)
    os.environ |= {"COLUMNS": "2000", "TERM": "dumb"}
    code = 1
    try:
        main(list(words))
    except SystemExit as left:
        code = int(left.code or 0)
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _listing(folder: Path) -> dict[str, str]:
    """Every path in a folder, with a number made from its content."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
        for path in folder.rglob("*")
    }


def problems(words: Sequence[str], answer: Answer) -> Iterator[str]:
    """Everything that is wrong with an answer."""
    if "Traceback" in answer.message or answer.code not in (1, 2):
        yield f"exit code {answer.code}"
    if answer.changes:
        yield f"changed {', '.join(answer.changes)}"
    message = answer.message
    if answer.lines != 1:
        yield f"{answer.lines} lines on stderr"
    if len(message) > MOST_LETTERS:
        yield f"{len(message)} characters"
    if not ADVICE.search(message):
        yield "no advice"
    if not any(sign in message for sign in UNNAMED) and not any(_named(part, message) for part in _given(words)):
        yield "does not name what was given"


def _named(part: str, message: str) -> bool:
    """Whether a message names a part of an input, as a word of its own, or the beginning of a long one."""
    if len(part) > LONG:
        return part[:LONG] in message
    return re.search(rf"(?<!\w){re.escape(part)}(?!\w)", message) is not None


def _given(words: Sequence[str]) -> Iterator[str]:
    """Parts of an input that a message can name: options, values, and numbers without their zeros."""
    for word in words:
        for part in filter(None, (word, word.removeprefix("--"), *re.split("[=,]", word))):
            yield part
            yield repr(part)[1:-1]
            yield part.replace("-", " ")
            yield "".join(letter if letter.isprintable() else "?" for letter in part.replace("\n", " "))
            try:
                yield f"{float(part):g}"
            except ValueError:
                continue


def warm_up() -> None:
    """Import what the commands import, so that each child has it at once."""
    from pipenav.cli import COMMANDS

    for name in (*HEAVY, *(target.partition(":")[0] for target, _ in COMMANDS.values())):
        import_module(name)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--show", action="store_true", help="print every message")
    parser.add_argument("--only", default="", help="only inputs in which this text is found")
    parser.add_argument("--every", type=int, default=1, help="only every Nth input")
    given = parser.parse_args()
    warm_up()
    chosen = [words for words in inputs()[:: given.every] if given.only in shlex.join(words)]
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder))
        for words in chosen:
            answer = bench.answer(words)
            wrong = list(problems(words, answer))
            failed += bool(wrong)
            if wrong or given.show:
                print(f"{shlex.join(['pipenav', *words])}\n  {answer.code}: {answer.message}", flush=True)
            for line in wrong:
                print(f"  WRONG: {line}", flush=True)
    print(f"{len(chosen)} wrong inputs: {failed} answered badly")
    return int(failed > 0)


if __name__ == "__main__":
    sys.path[:0] = [str(TESTS), str(TESTS.parent), str(TESTS.parent / "plugins")]
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main())
