"""Discovery without importing, loading one, and what a person reads when that fails."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from pkgutil import resolve_name
from typing import Protocol

import pytest

from pipenav.backends import plugins, requirements
from pipenav.backends.backend import BackendOptions
from pipenav.backends.moved import MOVED
from pipenav.backends.plugins import find_backends
from pipenav.backends.registry import load_backend, open_backend
from pipenav.backends.requirements import availability
from pipenav.errors import BackendUnavailable, ConfigError, UnknownName
from pipenav.robots.robot import load_robot
from pipenav.testing import KinematicBackend, KinematicOptions

GOOD = "from pipenav.testing import KinematicBackend as GoodBackend"


class Installer(Protocol):
    def __call__(
        self, name: str, source: str, *, module: str, dist: str = ..., requires: tuple[str, ...] = ...
    ) -> Path: ...


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Installer:
    """Install a distribution with one backend plugin: a module of this source, whose class is `GoodBackend`."""

    def install(name: str, source: str, *, module: str, dist: str = "", requires: tuple[str, ...] = ()) -> Path:
        dist = dist or module.replace("_", "-")
        info = tmp_path / f"{dist.replace('-', '_')}-1.2.dist-info"
        info.mkdir()
        needs = "".join(f"Requires-Dist: {text}\n" for text in requires)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {dist}\nVersion: 1.2\n{needs}")
        (info / "entry_points.txt").write_text(f"[{plugins.GROUP}]\n{name} = {module}:GoodBackend\n")
        package = tmp_path / module
        package.mkdir()
        (package / "__init__.py").write_text(source)
        return package

    monkeypatch.syspath_prepend(tmp_path)
    return install


def why_not(name: str) -> str:
    """The error of loading a backend, after checking that the listing knew it without importing."""
    known = availability(find_backends()[name])
    with pytest.raises(BackendUnavailable) as caught:
        load_backend(name)
    assert not known.can_load
    assert known.missing in str(caught.value)
    assert known.remedy in str(caught.value)
    return str(caught.value)


def test_a_strangers_backend_comes_in_by_the_same_door(install: Installer, tmp_path: Path) -> None:
    install("stranger", GOOD, module="strange_backend", dist="strange-robots")
    path = os.pathsep.join([str(tmp_path), *filter(None, sys.path)])
    listing = subprocess.run(
        [sys.executable, "-m", "pipenav", "backends"],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "stranger  yes        strange-robots 1.2" in listing.stdout
    backend = open_backend("stranger", load_robot("basic"), 2, {"speed_share": 0.5})
    assert isinstance(backend, KinematicBackend)
    backend.close()


def test_listing_imports_nothing(install: Installer) -> None:
    install("bomb", "raise SystemExit('imported')", module="bomb_backend")
    before = set(sys.modules)
    plugin = find_backends()["bomb"]
    assert availability(plugin).can_load
    assert set(sys.modules) == before
    assert (plugin.distribution, plugin.version, plugin.value) == ("bomb-backend", "1.2", "bomb_backend:GoodBackend")


def test_a_missing_extra_is_named_with_its_command(install: Installer) -> None:
    needs = ("numpy", "nopybullet>=3; extra == 'dev'", "nopybullet>=3; python_version < '4' and extra == 'bullet'")
    install("bullet", f"import nopybullet.core\n{GOOD}", module="bullet_backend", requires=needs)
    assert why_not("bullet") == (
        "backend 'bullet' cannot run: Python module 'nopybullet' is not installed; "
        "pip install 'bullet-backend[bullet]'."
    )


def test_a_missing_requirement_is_named_with_its_command(install: Installer) -> None:
    install("wire", f"import no_such_wire\n{GOOD}", module="wire_backend", requires=("no.such-wire >= 2",))
    assert "; pip install wire-backend." in why_not("wire")


def test_a_module_that_is_not_named_like_its_distribution(install: Installer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(requirements._DISTRIBUTION_OF, "nobus", "pynobus")
    install("bus", f"import nobus\n{GOOD}", module="bus_backend", requires=("pynobus>=3; extra == 'hardware'",))
    assert "pip install 'bus-backend[hardware]'" in why_not("bus")


def test_an_undeclared_requirement_gets_no_guessed_command(install: Installer) -> None:
    install("sloppy", f"import undeclared_thing\n{GOOD}", module="sloppy_backend")
    assert "'undeclared_thing' is not installed" in why_not("sloppy")
    assert "which sloppy-backend 1.2 does not declare" in why_not("sloppy")


def test_a_python_that_is_too_new_is_the_remedy(install: Installer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(requirements._LAST_PYTHON, "nowheels", (3, 10))
    install("old", f"import nowheels\n{GOOD}", module="old_backend", requires=("nowheels; extra == 'old'",))
    here = ".".join(map(str, sys.version_info[:2]))
    assert f"no wheels for Python {here}: use Python 3.10, and there pip install 'old-backend[old]'" in why_not("old")


def test_imports_are_followed_inside_the_package_only(install: Installer) -> None:
    package = install("deep", "from .inner import GoodBackend", module="deep_backend")
    (package / "inner.py").write_text(f"from . import further\n{GOOD}")
    (package / "further.py").write_text("class Settings:\n    import no_such_depth")
    (package / "unused.py").write_text("import never_needed")
    assert "'no_such_depth'" in why_not("deep")


def test_imports_that_a_module_can_do_without_do_not_count(install: Installer) -> None:
    source = "\n".join(
        [
            "import sys",
            "from typing import TYPE_CHECKING",
            "if TYPE_CHECKING:",
            "    import no_such_type",
            "try:",
            "    import no_such_speedup",
            "except ImportError:",
            "    pass",
            "def render():",
            "    import no_such_viewer",
            GOOD,
        ]
    )
    install("modest", source, module="modest_backend")
    assert availability(find_backends()["modest"]).can_load
    assert issubclass(load_backend("modest"), KinematicBackend)


def test_an_import_that_the_constructor_makes_is_named_when_it_is_opened(install: Installer) -> None:
    source = "\n".join(
        [
            GOOD.replace("GoodBackend", "Base"),
            "class GoodBackend(Base):",
            "    def __init__(self, *args):",
            "        import no_such_driver",
        ]
    )
    install("late", source, module="late_backend", requires=("no-such-driver; extra == 'late'",))
    with pytest.raises(BackendUnavailable, match=r"'no_such_driver' is not installed; pip install 'late-backend\[late"):
        open_backend("late", load_robot("basic"), 1, {})


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("1 / 0", "importing {} fails with ZeroDivisionError: division by zero; report it to the authors of"),
        ("", "importing {} fails with AttributeError"),
        ("GoodBackend = 3", "is not a subclass of pipenav.backends.Backend"),
        ("class GoodBackend: pass", "is not a subclass of pipenav.backends.Backend"),
        (
            "from pipenav.backends import Backend\nclass GoodBackend(Backend): pass",
            "does not implement close, read, reset, step",
        ),
        (f"{GOOD}\nclass GoodBackend(GoodBackend): Options = dict", "has no Options derived from"),
        ("from pipenav.errors import nothing_there", "cannot import name 'nothing_there'"),
        (
            "from pipenav.backends import Backend\nclass GoodBackend(Backend):\n    def truth(self): pass",
            "defines truth, as only a simulator does, but does not derive from pipenav.backends.Simulator; ",
        ),
    ],
)
def test_a_broken_plugin_harms_only_itself(install: Installer, source: str, message: str) -> None:
    module = f"broken{abs(hash(source))}"
    install("broken", source, module=module)
    install("sound", GOOD, module=f"sound_{module}")
    with pytest.raises(BackendUnavailable) as caught:
        load_backend("broken")
    assert message.format(module) in str(caught.value)
    assert load_backend("sound") is KinematicBackend


def test_a_syntax_error_shows_in_the_listing(install: Installer) -> None:
    install("typo", "def (", module="typo_backend")
    known = availability(find_backends()["typo"])
    assert not known.can_load
    assert "cannot be read" in known.missing


@pytest.mark.parametrize(
    ("imports", "sentence"),
    [
        ("from pipenav.backend import Backend", "it imports pipenav.backend (pipenav.backends now)"),
        ("import pipenav.state", "it imports pipenav.state (pipenav.backends now)"),
        ("from pipenav import kinematics", "it imports pipenav.kinematics (pipenav.robots.kinematics now)"),
        (
            "from pipenav.robot import load_robot\nfrom pipenav.pipe import Pipe\nfrom pipenav.backend import Backend",
            "it imports pipenav.backend (pipenav.backends now), pipenav.pipe.Pipe (pipenav.pipes.PipeCorner now), "
            "pipenav.robot (pipenav.robots now)",
        ),
        ("from pipenav.task.episode import sample", "it imports pipenav.task, which this pipenav no longer has"),
        (
            "from pipenav import assets, files",
            "it imports pipenav.assets, pipenav.files, which this pipenav no longer has",
        ),
    ],
)
def test_a_plugin_that_imports_old_names_is_told_the_new_ones(install: Installer, imports: str, sentence: str) -> None:
    install("elder", f"{imports}\n{GOOD}", module=f"elder{abs(hash(imports))}")
    assert why_not("elder") == (
        f"backend 'elder' cannot run: {sentence}; update it, as pipenav's guide 'Write a backend' shows."
    )


def test_an_old_module_inside_a_package_that_is_there_is_named(install: Installer) -> None:
    install("inner", f"import pipenav.learning.run_folder\n{GOOD}", module="inner_backend")
    with pytest.raises(
        BackendUnavailable, match=r"pipenav.learning.run_folder, which this pipenav no longer has; update"
    ):
        load_backend("inner")


def test_names_that_are_there_are_not_taken_for_old_ones(install: Installer) -> None:
    install("present", f"from pipenav import __version__, errors\n{GOOD}", module="present_backend")
    assert availability(find_backends()["present"]).can_load


def test_an_old_name_in_the_constructor_is_noticed_when_it_is_opened(install: Installer) -> None:
    late = "class GoodBackend(Base):\n    def __init__(self, *args):\n        import pipenav.machine"
    install("late_elder", f"{GOOD.replace('GoodBackend', 'Base')}\n{late}", module="late_elder_backend")
    with pytest.raises(BackendUnavailable, match=r"it imports pipenav.machine \(pipenav.backends now\); update it"):
        open_backend("late_elder", load_robot("basic"), 1, {})


@pytest.mark.parametrize(("old", "new"), MOVED.items())
def test_old_names_are_gone_and_new_ones_are_there(old: str, new: str) -> None:
    module = ".".join(old.split(".")[:2])
    assert find_spec(module) is None
    resolve_name(new)


def test_a_package_that_is_gone_is_to_be_reinstalled(install: Installer) -> None:
    package = install("gone", GOOD, module="gone_backend")
    (package / "__init__.py").unlink()
    package.rmdir()
    assert "reinstall gone-backend from where you got it" in why_not("gone")


def test_two_distributions_of_one_name_are_both_named(install: Installer) -> None:
    install("twin", GOOD, module="first_twin")
    install("twin", GOOD, module="other_twin")
    assert why_not("twin") == (
        "backend 'twin' cannot run: first-twin 1.2 and other-twin 1.2 both declare it; "
        "uninstall one of them: pip uninstall first-twin or pip uninstall other-twin."
    )


def test_an_unknown_name_suggests_the_nearest(install: Installer) -> None:
    install("kinematic", GOOD, module="kinematic_backend")
    with pytest.raises(UnknownName, match="unknown backend 'kinematik': did you mean 'kinematic'"):
        load_backend("kinematik")
    assert str(UnknownName("backend", "kinematik", [])) == "unknown backend 'kinematik': there are none."


def test_without_any_backend_the_remedy_is_to_install_pipenav(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plugins, "entry_points", lambda **_: ())
    with pytest.raises(BackendUnavailable, match=r"install pipenav itself \(pip install -e \. in a"):
        load_backend("mujoco")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"speed_shar": 0.5}, "options of backend 'k': unknown key 'speed_shar': did you mean 'speed_share'?"),
        ({"speed_share": 2.0}, "options of backend 'k': speed_share: input should be less than or equal to 1, given 2"),
        ({"speed_share": "0.5"}, "speed_share: input should be a valid number, given '0.5'"),
    ],
)
def test_options_that_do_not_fit_are_named(install: Installer, options: dict[str, object], message: str) -> None:
    install("k", GOOD, module="k_backend")
    with pytest.raises(ConfigError) as caught:
        open_backend("k", load_robot("basic"), 1, options)
    assert message in str(caught.value)


def test_options_may_be_an_instance_of_the_backends_own_class_only(install: Installer) -> None:
    install("k", GOOD, module="k_backend")
    backend = open_backend("k", load_robot("basic"), 1, KinematicOptions(speed_share=0.1))
    backend.close()

    class OtherOptions(BackendOptions):
        pass

    with pytest.raises(ConfigError, match="backend 'k' takes KinematicOptions, given OtherOptions"):
        open_backend("k", load_robot("basic"), 1, OtherOptions())
