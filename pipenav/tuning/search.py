"""The driver of a search: asks the study for settings, has them trained at a place, and tells the study what came.

It may be killed at any moment. The journal then has the trials that ran, the store the results that had come in, and
the training folders what was saved: the next driver takes all of it up.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from pipenav.errors import PipenavError
from pipenav.jobs import Done, Event, Job, JobStore, Kept, Place, Progressed, Stopped, run_jobs
from pipenav.learning.config import TrainConfig
from pipenav.storage.atomic_files import prepare_folder
from pipenav.tuning.objective import Outcome
from pipenav.tuning.plan import TunePlan
from pipenav.tuning.study import TrialRecord, TuningStudy, best_record
from pipenav.tuning.trial import TrialOrder, run_trial, trial_folder

PRESET = "preset"
"""Key of the job that trains with the preset's own settings."""

RESULTS = "results"
"""Folder in that of a search, with what its jobs returned."""

MOST_CORES = 1 << 10
"""More cores than any machine has: a training takes all that its place has for it."""

MOST_REFUSED = 100
"""Suggestions in a row that fit no training, after which a search ends."""

ShouldStop = Callable[[], bool]


class SearchNews(NamedTuple):
    """News of a search.

    Attributes:
        share: share of the work that is done.
        ended: words about a trial that has ended; empty where none has.
    """

    share: float
    ended: str


class Search:
    """A search in its folder, which must have one writer.

    Args:
        plan: what is searched.

    Raises:
        PipenavError: the folder holds another search, or files of it are damaged.
    """

    def __init__(self, plan: TunePlan) -> None:
        prepare_folder(plan.out)
        self.plan = plan
        self.store = JobStore(plan.out / RESULTS, plan.request)
        self.study = TuningStudy(
            plan.out, plan.space, plan.objective, plan.config.seed, check_every=plan.config.check.every
        )
        self._shares_disk = True
        self._told: Callable[[SearchNews], None] = lambda _news: None
        self._latest: dict[str, Outcome] = {}
        self._pruned: set[str] = set()

    def run(self, place: Place, told: Callable[[SearchNews], None], should_stop: ShouldStop) -> bool:
        """Try settings, then train the best and the preset again; False where it was asked to stop before the end.

        Raises:
            JobsLost: trials whose process or machine ended under them every time; all others are done.
            PipenavError: the settings fit no training, again and again, or the place cannot be reached.
        """
        self._told, self._shares_disk = told, place.shares_disk
        return run_jobs(place, self._trials(), self._hear, should_stop, self.store) and run_jobs(
            place, self._repetitions(), self._hear, should_stop, self.store
        )

    def preset(self) -> Outcome | None:
        """The outcome of the preset's own settings, if it is known."""
        return self._result(PRESET)

    def best(self) -> TrialRecord | None:
        """The best trial that is done."""
        return best_record(self.study.records(), self.plan.objective)

    def repeated(self, name: str) -> list[Outcome]:
        """Outcomes of the preset, or of a trial by its name, with other seeds."""
        found = [self._result(_repetition(name, seed)) for seed in self.other_seeds]
        return [outcome for outcome in found if outcome is not None]

    @property
    def other_seeds(self) -> range:
        """Seeds of the trainings at the end."""
        return range(self.plan.config.seed + 1, self.plan.config.seed + 1 + self.plan.again)

    def _result(self, key: str) -> Outcome | None:
        content = self.store.read(key)
        return None if content is None else Outcome.model_validate_json(content)

    def _trials(self) -> Iterator[Job]:
        """The preset's job, those of trials that ran when a driver was killed, then new ones."""
        yield self._job(PRESET, self.plan.config)
        for record in self.study.records():
            if record.state == "running":
                job = self._trial_job(record)
                if job is not None:
                    yield job
        refused = 0
        while self._tried() < self.plan.trials:
            record = self.study.ask()
            job = self._trial_job(record)
            refused = refused + 1 if job is None else 0
            if refused == MOST_REFUSED:
                problem = self.study.record(record.number).problem.rstrip(".")
                raise PipenavError(f"the last {refused} settings fit no training, {problem}: narrow the space.")
            if job is not None:
                yield job

    def _tried(self) -> int:
        """Number of trials that are done or run."""
        return sum(not record.preset and record.state != "refused" for record in self.study.records())

    def _trial_job(self, record: TrialRecord) -> Job | None:
        """The job of a trial; None where its settings fit no training."""
        try:
            config = self.plan.trial_config(record.settings)
        except PipenavError as problem:
            self.study.refuse(record.number, str(problem))
            return None
        return self._job(trial_name(record.number), config)

    def _repetitions(self) -> Iterator[Job]:
        """Jobs of the best trial and the preset with other seeds."""
        best = self.best()
        if best is None or best.outcome is None or not self.plan.objective.reached(best.outcome):
            return
        for seed in self.other_seeds:
            for name, settings in ((PRESET, {}), (trial_name(best.number), best.settings)):
                yield self._job(_repetition(name, seed), self.plan.trial_config(settings, seed))

    def _job(self, key: str, config: TrainConfig) -> Job:
        folder = trial_folder(self.plan.out.resolve(), key) if self._shares_disk else None
        cores = MOST_CORES if self._shares_disk else 1
        order = TrialOrder(config, self.plan.objective, key, folder)
        return Job(key, key.replace("-", " "), run_trial, order, cores)

    def _hear(self, event: Event) -> bool | None:
        key, number = event.job.key, _number(event.job.key)
        if isinstance(event, Progressed):
            before = self._latest.get(key)
            self._latest[key] = event.progress
            news = event.progress.checks and (before is None or before.checks != event.progress.checks)
            if news and number is not None and key not in self._pruned and self.study.hear(number, event.progress):
                self._pruned.add(key)
                return True
        elif isinstance(event, Done | Kept):
            outcome = self._result(key)
            assert outcome is not None
            self._take(key, number, outcome)
        elif isinstance(event, Stopped) and number is not None and key in self._pruned:
            self.study.tell_pruned(number, self._latest[key])
            self._end(key, f"ended early, success {self._latest[key].success:.1%}")
        self._told(SearchNews(self._share(), ""))
        return None

    def _take(self, key: str, number: int | None, outcome: Outcome) -> None:
        """Tell the study the outcome of a job that is done."""
        if key == PRESET and (settings := self.plan.preset_settings()) is not None:
            self.study.add_preset(settings, outcome)
        if number is not None:
            if self.study.record(number).state != "running":
                return
            self.study.tell(number, outcome)
        self._end(key, self.plan.objective.words(self.plan.objective.value(outcome)))

    def _end(self, key: str, words: str) -> None:
        self._latest.pop(key, None)
        self._told(SearchNews(self._share(), f"{key.replace('-', ' ')}: {words}"))

    def _share(self) -> float:
        """Share of the trials that are done, those that run counted by their steps."""
        records = self.study.records()
        ended = sum(record.state in ("done", "pruned") and not record.preset for record in records)
        running = sum(
            outcome.steps / self.plan.config.steps for key, outcome in self._latest.items() if _number(key) is not None
        )
        return min(1.0, (ended + running) / self.plan.trials)


def trial_name(number: int) -> str:
    """Name of a trial, of its job and of its training folder."""
    return f"trial-{number:04d}"


def _number(key: str) -> int | None:
    """Number of the trial whose job has this key; None of another job."""
    parts = key.split("-")
    return int(parts[1]) if parts[0] == "trial" and len(parts) == 2 else None


def _repetition(name: str, seed: int) -> str:
    """Key of the job that trains the preset or a trial with another seed."""
    return f"{name}-seed-{seed}"
