"""Optuna's study of a search, asked and told by one driver, which alone writes its journal.

Each trial's suggestion has a seed of its own, from the search's and the trial's number: a search that is killed and
goes on suggests what it would have suggested, and no values again.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pipenav.errors import FileProblem, PipenavError
from pipenav.storage.atomic_files import atomic_write
from pipenav.tuning.objective import Objective, Outcome
from pipenav.tuning.space import SearchSpace, ValueRange, value_text

if TYPE_CHECKING:
    from optuna import Study
    from optuna.distributions import BaseDistribution
    from optuna.trial import FrozenTrial, Trial

JOURNAL_FILE = "study.journal"

STUDY = "pipenav"
"""Name of the study in the journal."""

BEFORE_PRUNING = 5
"""Trials that are trained to their end before any is ended early."""

_OUTCOME, _REFUSED, _PRESET = "outcome", "refused", "preset"
"""Attributes of a trial in the journal: its outcome as JSON, why it was not trained, whether it is the preset's."""


class TrialRecord(NamedTuple):
    """A trial as the journal has it.

    Attributes:
        number: its number in the study, from 0.
        state: `done`, `pruned` (ended early, for others were better), `running`, or `refused` (settings that fit no
            training).
        settings: its settings, by dotted keys.
        outcome: what came of it; None of one that runs or was refused.
        problem: why it was refused; else empty.
        preset: whether its settings are the preset's own.
    """

    number: int
    state: str
    settings: dict[str, Any]
    outcome: Outcome | None
    problem: str
    preset: bool


def require_optuna() -> None:
    """Make sure that Optuna is installed.

    Raises:
        PipenavError: it is not.
    """
    if importlib.util.find_spec("optuna") is None:
        raise PipenavError("pipenav tune needs Optuna, which is not installed: pip install 'pipenav[tune]'.")


class TuningStudy:
    """The study in a folder, new or going on. Its journal must have one writer.

    Args:
        folder: folder of the search.
        space: what may be suggested.
        objective: the number that is made small.
        seed: seed of the suggestions.
        check_every: control steps between two checks of every trial.

    Raises:
        PipenavError: the journal is damaged.
        FileProblem: it cannot be read or written.
    """

    def __init__(self, folder: Path, space: SearchSpace, objective: Objective, seed: int, check_every: int) -> None:
        self._space, self._objective, self._seed, self._every = space.space, objective, seed, check_every
        self._study = _opened(folder / JOURNAL_FILE)

    def records(self) -> list[TrialRecord]:
        """All trials, in the order in which they began."""
        return [self._record(trial) for trial in self._study.get_trials(deepcopy=False)]

    def record(self, number: int) -> TrialRecord:
        """A single trial."""
        return self._record(self._study.get_trials(deepcopy=False)[number])

    def ask(self) -> TrialRecord:
        """A new trial, which runs from now on."""
        from optuna.samplers import TPESampler

        number = len(self._study.get_trials(deepcopy=False))
        seed = int(np.random.SeedSequence([self._seed, number]).generate_state(1)[0])
        self._study.sampler = TPESampler(seed=seed, multivariate=True, constant_liar=True)
        trial = self._study.ask({key: _distribution(values) for key, values in self._space.items()})
        return self.record(trial.number)

    def refuse(self, number: int, problem: str) -> None:
        """End a trial whose settings fit no training; it counts as one of the worst, so that none like it follows."""
        self._trial(number).set_user_attr(_REFUSED, problem)
        self._tell_pruned(number)

    def hear(self, number: int, so_far: Outcome) -> bool:
        """Take the checks that a trial has had; returns whether it shall end, for the median trial was better."""
        trial = self._trial(number)
        self._report(trial, so_far)
        return trial.should_prune()

    def tell(self, number: int, outcome: Outcome) -> None:
        """End a trial that is done. A success counts at all later checks too, which it did not need."""
        trial = self._trial(number)
        self._report(trial, outcome)
        if self._objective.ends_early and (found := self._objective.first_success(outcome)) is not None:
            known = self._study.get_trials(deepcopy=False)
            later = max((step for one in known for step in one.intermediate_values), default=0)
            for step in range(found.steps // self._every + 1, later + 1):
                self._report_value(trial, step, 1.0 - found.success)
        trial.set_user_attr(_OUTCOME, outcome.model_dump_json())
        self._study.tell(number, self._objective.value(outcome))

    def tell_pruned(self, number: int, so_far: Outcome) -> None:
        """End a trial that was stopped because others were better."""
        self._trial(number).set_user_attr(_OUTCOME, so_far.model_dump_json())
        self._tell_pruned(number)

    def add_preset(self, settings: Mapping[str, Any], outcome: Outcome) -> None:
        """Let the study know what came of the preset's own settings, once."""
        from optuna.trial import create_trial

        if any(record.preset for record in self.records()):
            return
        values = {check.steps // self._every: 1.0 - check.success for check in outcome.checks}
        self._study.add_trial(
            create_trial(
                params={key: _as_parameter(self._space[key], value) for key, value in settings.items()},
                distributions={key: _distribution(values) for key, values in self._space.items()},
                value=self._objective.value(outcome),
                user_attrs={_PRESET: True, _OUTCOME: outcome.model_dump_json()},
                intermediate_values=values,
            )
        )

    def importance(self) -> dict[str, float]:
        """Share of each setting in how good trials differ from others, the largest first; empty with too few trials.

        Source: PED-ANOVA, Watanabe et al., IJCAI 2023 (arXiv:2304.10255).
        """
        from optuna.importance import get_param_importances

        done = [record for record in self.records() if record.state == "done"]
        if len(done) < BEFORE_PRUNING:
            return {}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return dict(get_param_importances(self._study))

    def _record(self, trial: FrozenTrial) -> TrialRecord:
        from optuna.trial import TrialState

        attributes = trial.user_attrs
        outcome = Outcome.model_validate_json(attributes[_OUTCOME]) if _OUTCOME in attributes else None
        state = {TrialState.RUNNING: "running", TrialState.COMPLETE: "done"}.get(trial.state, "pruned")
        if _REFUSED in attributes:
            state = "refused"
        settings = {key: _as_setting(self._space[key], trial.params[key]) for key in self._space if key in trial.params}
        problem, preset = attributes.get(_REFUSED, ""), bool(attributes.get(_PRESET))
        return TrialRecord(trial.number, state, settings, None if state == "running" else outcome, problem, preset)

    def _trial(self, number: int) -> Trial:
        """A trial that runs, to be reported on; after a kill the study has only its record."""
        from optuna.trial import Trial

        return Trial(self._study, self._study.get_trials(deepcopy=False)[number]._trial_id)

    def _report(self, trial: Trial, so_far: Outcome) -> None:
        for check in so_far.checks:
            self._report_value(trial, check.steps // self._every, 1.0 - check.success)

    def _report_value(self, trial: Trial, step: int, failures: float) -> None:
        if step not in self._study.get_trials(deepcopy=False)[trial.number].intermediate_values:
            trial.report(failures, step)

    def _tell_pruned(self, number: int) -> None:
        from optuna.trial import TrialState

        self._study.tell(number, state=TrialState.PRUNED)


def _opened(journal: Path) -> Study:
    """The study in a journal, made where there is none."""
    import optuna
    from optuna.pruners import MedianPruner
    from optuna.storages import JournalStorage
    from optuna.storages.journal import JournalFileBackend

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    _mend(journal)
    try:
        storage = JournalStorage(JournalFileBackend(str(journal)))
        return optuna.create_study(
            storage=storage,
            study_name=STUDY,
            direction="minimize",
            load_if_exists=True,
            pruner=MedianPruner(n_startup_trials=BEFORE_PRUNING),
        )
    except OSError as error:
        raise FileProblem(journal, "use", error) from error
    except (ValueError, LookupError, TypeError) as error:
        raise PipenavError(f"{journal} is damaged: choose another --out, or remove the folder.") from error


def _mend(journal: Path) -> None:
    """Undo what a killed driver left: half a line at the journal's end, and the lock by which it wrote.

    Nobody else writes it, which the folder's own lock makes sure of.
    """
    with contextlib.suppress(OSError):
        Path(f"{journal}.lock").unlink(missing_ok=True)
    try:
        content = journal.read_bytes()
    except FileNotFoundError:
        return
    except OSError as error:
        raise FileProblem(journal, "read", error) from error
    if not content.endswith(b"\n"):
        atomic_write(journal, content[: content.rfind(b"\n") + 1])


def _distribution(values: ValueRange) -> BaseDistribution:
    """A setting's values, as Optuna has them."""
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    if values.choices is not None:
        return CategoricalDistribution([value_text(value) for value in values.choices])
    assert values.low is not None and values.high is not None
    if values.whole:
        return IntDistribution(int(values.low), int(values.high), log=values.log)
    return FloatDistribution(float(values.low), float(values.high), log=values.log)


def _as_parameter(values: ValueRange, setting: Any) -> Any:
    """A setting's value as Optuna has it: choices as text, since they may be lists."""
    if values.choices is not None:
        return value_text(setting)
    return int(setting) if values.whole else float(setting)


def _as_setting(values: ValueRange, parameter: Any) -> Any:
    if values.choices is not None:
        return json.loads(parameter)
    return parameter if values.whole else _rounded(parameter)


def _rounded(value: float) -> float:
    """A number of five digits: further ones change nothing, and make it hard to read."""
    return float(f"{value:.5g}")


def best_record(records: Sequence[TrialRecord], objective: Objective) -> TrialRecord | None:
    """The best trial that is done, apart from the preset's own."""
    done = [record for record in records if record.state == "done" and not record.preset and record.outcome]
    return min(done, key=lambda record: objective.value(_outcome(record)), default=None)


def _outcome(record: TrialRecord) -> Outcome:
    assert record.outcome is not None
    return record.outcome
