"""Jobs on a Ray cluster of two nodes end as at every other place, though a worker or a whole node dies."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers.jobs import Heard, faulty, killed, killed_at_first, numbers, one, patient, refused
from helpers.waiting import wait_until

from pipenav.errors import OutOfRange, PipenavError
from pipenav.evaluation import part_plan
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.jobs import Done, Job, JobsLost, Lost, MemoryStore, Progressed, Stopped, run_jobs

pytest.importorskip("ray")
pytestmark = pytest.mark.slow
TESTS = Path(__file__).resolve().parents[2]
EVALUATION = EvaluationConfig(policy="arm", pipes=("d=100,angle=90", "d=70,angle=55"), episodes=200, seed=3)


@pytest.fixture(scope="module", autouse=True)
def path_of_workers() -> Iterator[None]:
    """Workers of Ray find the functions that only tests have."""
    with pytest.MonkeyPatch.context() as patch:
        path = [str(TESTS), str(TESTS.parent), str(TESTS.parent / "plugins"), os.environ.get("PYTHONPATH", "")]
        patch.setenv("PYTHONPATH", os.pathsep.join(filter(None, path)))
        yield


@pytest.fixture(scope="module")
def cluster(path_of_workers: None) -> Iterator[Any]:  # noqa: ARG001  # the cluster's processes inherit it
    """A head without cores and two nodes of one core each, all on this machine."""
    import pipenav_ray  # noqa: F401  # sets what Ray reads when it is imported
    from pipenav_ray.cluster import QUICK_HEALTH, STORE_BYTES
    from ray.cluster_utils import Cluster

    head = {"num_cpus": 0, "_system_config": QUICK_HEALTH, "object_store_memory": STORE_BYTES}
    made = Cluster(initialize_head=True, head_node_args=head)
    for _ in range(2):
        made.add_node(num_cpus=1, object_store_memory=STORE_BYTES)
    yield made
    made.shutdown()


@pytest.fixture
def place(cluster: Any) -> Any:
    from pipenav_ray import RayPlace

    return RayPlace(cluster.address)


def test_every_job_is_done_once(place: Any) -> None:
    heard = Heard()
    assert run_jobs(place, numbers(7), heard)
    assert sorted((event.job.data, event.content) for event in heard.of(Done)) == [
        (i, str(2 * i).encode()) for i in range(7)
    ]


def test_a_users_error_comes_as_it_was_and_is_not_tried_again(place: Any) -> None:
    heard = Heard()
    with pytest.raises(OutOfRange) as found:
        run_jobs(place, one(refused, 5), heard)
    assert str(found.value) == str(OutOfRange("angle", 5.0, 10, 20, "deg"))
    assert not heard.of(Lost)


def test_a_fault_comes_with_its_place(place: Any) -> None:
    with pytest.raises(RuntimeError, match=r"in faulty(.|\n)*by nothing"):
        run_jobs(place, one(faulty))


def test_a_job_that_ends_its_process_costs_only_itself(place: Any, tmp_path: Path) -> None:
    heard = Heard()
    poison = Job("poison", "the poison", killed, int(signal.SIGSEGV))
    sick = Job("sick", "the sick", killed_at_first, str(tmp_path))
    with pytest.raises(JobsLost, match="a job was lost 3 times: the poison"):
        run_jobs(place, [poison, sick, *numbers(3)], heard)
    assert len([event for event in heard.of(Lost) if event.job.key == "poison"]) == 3
    assert {event.job.key for event in heard.of(Done)} == {"sick", "number-0", "number-1", "number-2"}


def test_a_job_that_asks_saves_before_it_stops(place: Any, tmp_path: Path) -> None:
    file, heard = tmp_path / "saved", Heard()
    assert not run_jobs(place, one(patient, str(file)), heard, lambda: file.with_suffix(".runs").exists())
    assert file.exists()


def test_one_job_can_be_stopped_while_the_others_go_on(place: Any, tmp_path: Path) -> None:
    heard = Heard()

    def hear(event: object) -> bool:
        heard(event)  # type: ignore[arg-type]
        return isinstance(event, Progressed) and event.progress == "waiting"

    assert run_jobs(place, [*one(patient, str(tmp_path / "saved")), *numbers(3)], hear)
    assert len(heard.of(Stopped)) == 1 and len(heard.of(Done)) == 3


def test_nothing_is_imported_from_the_current_folder(place: Any, tmp_path: Path, monkeypatch: Any) -> None:
    for name in ("numpy", "helpers", "colorsys"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('a stranger runs')\n")
    monkeypatch.chdir(tmp_path)
    assert run_jobs(place, numbers(2))


class FromTheSecondPartOn(MemoryStore):
    """A store that acts when a part after the first comes in, until it has once found somebody to act on."""

    def __init__(self, act: Callable[[], bool]) -> None:
        super().__init__()
        self._act, self.kept, self.acted = act, 0, False

    def write(self, key: str, content: bytes) -> None:
        super().write(key, content)
        self.kept += 1
        if self.kept >= 2 and not self.acted:
            self.acted = self._act()


@pytest.mark.parametrize("dies", ["worker", "node"])
def test_an_evaluation_has_the_same_bytes_though_someone_dies(
    dies: str, place: Any, cluster: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(part_plan, "PART_EPISODES", (25, 25))
    here = CheckedEvaluation(EVALUATION).run().to_json()

    def kill() -> bool:
        if dies == "node":
            cluster.remove_node(list(cluster.worker_nodes)[-1], allow_graceful=False)
            return True
        working = workers()  # none, where both have just ended their parts
        if working:
            os.kill(working[0], signal.SIGKILL)
        return bool(working)

    store = FromTheSecondPartOn(kill)
    checked = CheckedEvaluation(EVALUATION)
    assert checked.parts.count == 16
    assert checked.run(place=place, store=store).to_json() == here
    assert store.acted and store.kept >= 16


def workers() -> list[int]:
    """Processes of Ray that do a job."""
    found = subprocess.run(["ps", "-eo", "pid,args"], capture_output=True, text=True, check=True).stdout
    return [int(line.split()[0]) for line in found.splitlines() if " ray::part-" in line]


@pytest.mark.parametrize("given", ["nowhere", "host", "host:", ":1", "host:0", "host:65536", "ray://host:1", "a:b"])
def test_what_is_no_address_is_refused(given: str) -> None:
    from pipenav_ray import RayPlace

    with pytest.raises(PipenavError, match="HOST:PORT"):
        RayPlace(given)


def test_an_address_where_nobody_is_is_refused() -> None:
    from pipenav_ray import RayPlace

    with pytest.raises(PipenavError, match=r"no Ray cluster answers at 127\.0\.0\.1:1, .*: look at"):
        run_jobs(RayPlace("127.0.0.1:1"), numbers(1))


def test_somebody_else_at_the_address_is_refused() -> None:
    from pipenav_ray import RayPlace

    program = "import http.server as h; s = h.HTTPServer(('127.0.0.1', 0), h.SimpleHTTPRequestHandler); "
    program += "print(s.server_port, flush=True); s.serve_forever()"
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as server:
        assert server.stdout is not None
        port = int(server.stdout.readline())
        try:
            with pytest.raises(PipenavError, match="is no Ray cluster: look at"):
                run_jobs(RayPlace(f"127.0.0.1:{port}"), numbers(1))
        finally:
            server.kill()


def test_a_cluster_of_our_own_leaves_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import tempfile

    from pipenav_ray import RayPlace, cluster

    monkeypatch.setattr(cluster, "_runs_here", lambda: False)
    monkeypatch.delenv("RAY_ADDRESS", raising=False)
    monkeypatch.setattr(tempfile, "tempdir", "/tmp")  # paths of sockets must be short
    before = set(Path("/tmp").glob("pipenav-ray-*"))
    handler = signal.getsignal(signal.SIGTERM)
    assert run_jobs(RayPlace("auto"), numbers(2))
    wait_until(lambda: set(Path("/tmp").glob("pipenav-ray-*")) <= before, "the temporary folder goes")
    assert signal.getsignal(signal.SIGTERM) == handler
    assert not list(tmp_path.iterdir())
