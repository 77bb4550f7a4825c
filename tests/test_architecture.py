"""Imports run one way, simulators stay in their plugins, and heavy libraries load only where they are needed."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
CORE = ROOT / "pipenav"
PLUGINS = sorted(path.name for path in (ROOT / "plugins").iterdir() if (path / "__init__.py").is_file())

LAYERS = [
    {"errors", "units", "assets", "files", "source_imports", "whole_folder"},
    {
        "any_pipe",
        "convex",
        "pipe",
        "pipe_run",
        "pipe_run_legs",
        "pipe_shapes",
        "pipe_export",
        "pipe_drawing",
        "pipe_set",
        "pipe_run_set",
        "pipe_run_shapes",
        "pipe_run_export",
        "pipe_run_drawing",
        "pipe_run_view",
        "scenes",
        "drafting",
        "robot",
        "robot_parts",
        "kinematics",
        "laser",
        "state",
        "wall_boxes",
        "contact_force",
    },
    {"backend", "space", "task"},
    {"registry"},
    set[str](),  # all other modules: environments, policies, training, evaluation, ...
    {"cli", "__main__"},
]
"""A module imports modules of its own layer or of those before it."""

MACHINES = {"mujoco", "pybullet", "serial", "dynamixel_sdk"}
HEAVY = {"torch", "stable_baselines3", "gymnasium", "matplotlib", "mujoco", "pybullet", "tensorboard", "trimesh"}


def modules(folder: Path) -> dict[str, Path]:
    """Dotted names of the modules in a package, with their files."""
    named = {}
    for path in sorted(folder.rglob("*.py")):
        parts = path.relative_to(folder.parent).with_suffix("").parts
        named[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return named


ALL = modules(CORE)


def imported(path: Path, everywhere: bool = True) -> set[str]:
    """Modules that a file imports: anywhere but under TYPE_CHECKING, or only at module level."""

    def nodes(body: list[ast.stmt]) -> Iterator[ast.stmt]:
        for node in body:
            yield node
            if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
                continue
            if everywhere or not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                for child in ("body", "orelse", "finalbody", "handlers"):
                    inner = getattr(node, child, [])
                    yield from nodes([s for part in inner for s in getattr(part, "body", [part])])

    names = set()
    for node in nodes(ast.parse(path.read_text(encoding="utf-8")).body):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute here"
            submodules = {f"{node.module}.{alias.name}" for alias in node.names} & ALL.keys()
            names |= submodules or {str(node.module)}
    return names


def tops(names: set[str]) -> set[str]:
    return {name.partition(".")[0] for name in names}


def layer(module: str) -> int:
    noun = module.split(".")[1] if "." in module else "errors"
    return next((i for i, layer in enumerate(LAYERS) if noun in layer), len(LAYERS) - 2)


@pytest.mark.parametrize("module", ALL)
def test_imports_run_one_way(module: str) -> None:
    ours = {name for name in imported(ALL[module]) if name in ALL and name != "pipenav"}
    upwards = sorted(name for name in ours if layer(name) > layer(module))
    assert not upwards, f"{module} imports from a higher layer: {upwards}"


def test_no_module_imports_itself_through_others() -> None:
    graph = {module: (imported(path) & ALL.keys()) - {module, "pipenav"} for module, path in ALL.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"modules import each other in a circle: {' -> '.join(error.args[1])}")


@pytest.mark.parametrize("module", ALL)
def test_the_core_imports_no_plugin_simulator_or_serial_library(module: str) -> None:
    assert not tops(imported(ALL[module])) & (MACHINES | set(PLUGINS))


@pytest.mark.parametrize("plugin", PLUGINS)
def test_plugins_do_not_import_each_other(plugin: str) -> None:
    others = set(PLUGINS) - {plugin}
    for module, path in modules(ROOT / "plugins" / plugin).items():
        assert not tops(imported(path)) & others, module


def brought_in(module: str, seen: set[str]) -> set[str]:
    """Top-level packages that importing a module of ours brings in, by way of our modules."""
    if module in seen or module not in ALL:
        return set()
    seen.add(module)
    names = imported(ALL[module], everywhere=False)
    return tops(names).union(*(brought_in(name, seen) for name in names))


LIGHT = [module for module in ALL if layer(module) != len(LAYERS) - 2 or module.startswith("pipenav.testing")]


@pytest.mark.parametrize("module", LIGHT)
def test_heavy_libraries_load_inside_the_function_that_needs_them(module: str) -> None:
    assert not brought_in(module, set()) & HEAVY


def test_help_loads_nothing_heavy() -> None:
    """The real thing, in a fresh interpreter: the list of commands also leaves numpy alone."""
    program = (
        "import sys\n"
        "from pipenav.cli import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit as done:\n    assert done.code == 0\n"
        "print('LOADED', *sys.modules)\n"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    loaded = set(result.stdout.rpartition("LOADED")[2].split())
    assert "gen-pipe" in result.stdout
    assert not loaded & (HEAVY | MACHINES | set(PLUGINS) | {"numpy"})
