"""A short part of `python tests/fuzz/wrong_inputs.py`: what is wrong is refused in a sentence and leaves nothing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from fuzz.wrong_inputs import Answer, inputs, problems

REFUSAL = "pipenav: error: diameter 7 mm is out of range: choose 40 to 300 mm."
WORDS = ["gen-pipe", "--d", "7", "--angle", "75"]


def test_wrong_inputs_are_refused_in_a_sentence() -> None:
    command = [sys.executable, "-P", str(Path(__file__).with_name("wrong_inputs.py")), "--every", "20"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr[-2000:]


def test_a_bad_answer_is_found() -> None:
    assert not list(problems(WORDS, Answer(1, REFUSAL, 1, [])))
    bad = [
        Answer(0, REFUSAL, 1, []),
        Answer(70, REFUSAL, 1, []),
        Answer(1, REFUSAL, 2, []),
        Answer(1, REFUSAL, 1, ["corner"]),
        Answer(1, "pipenav: error: it is out of range: choose 40 to 300 mm.", 1, []),
        Answer(1, "pipenav: error: diameter 7 is bad.", 1, []),
        Answer(1, REFUSAL * 20, 1, []),
    ]
    for answer in bad:
        assert len(list(problems(WORDS, answer))) == 1, answer


def test_every_input_is_listed_once() -> None:
    listed = [tuple(words) for words in inputs()]
    assert len(set(listed)) == len(listed) >= 280
