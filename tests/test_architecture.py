"""Imports run one way over the floors of docs/architecture.md; heavy libraries load only where they are needed."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
CORE = ROOT / "pipenav"
PLUGINS = sorted(path.name for path in (ROOT / "plugins").iterdir() if (path / "__init__.py").is_file())

FLOORS: list[set[str]] = [
    {"errors", "units", "arrays"},
    {"storage", "processes"},
    {"jobs", "pipes", "robots"},
    {"backends", "drawing", "networks", "pages"},
    {"tasks", "disturbances", "locating", "export", "testing"},
    {"policies", "motions", "envs"},
    {"certify"},
    {"evaluation", "deployment", "comparison"},
    {"driving", "learning", "recording", "survey", "portable"},
    {"experiments", "tuning"},
    {"cli"},
]
"""Packages (and the modules of the lowest floor) from the bottom to the top: each imports only what lies below it."""

DOORS = {"__init__": 0, "__main__": 11, "env": 9, "train": 9}
"""Modules beside the packages, and the floor above which each stands: the ways in that other people's code knows."""

OPEN_TO_PLUGINS = {"backends", "jobs", "robots", "pipes", "errors", "arrays", "units"}
"""Packages of pipenav that a plugin may import."""

SIMULATORS = {"mujoco", "pybullet", "serial", "dynamixel_sdk"}
HEAVY = {"torch", "stable_baselines3", "gymnasium", "matplotlib", "mujoco", "pybullet", "tensorboard", "trimesh"} | {
    "manifold3d",
    "mcap",
    "onnx",
    "onnxruntime",
    "optuna",
    "mido",
    "pygame",
    "rerun",
    "shapely",
}


def modules(folder: Path) -> dict[str, Path]:
    """Dotted names of the modules in a package, with their files."""
    named = {}
    for path in sorted(folder.rglob("*.py")):
        parts = path.relative_to(folder.parent).with_suffix("").parts
        named[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return named


ALL = modules(CORE)
IN_PLUGINS = {name: path for plugin in PLUGINS for name, path in modules(ROOT / "plugins" / plugin).items()}


@cache
def imported(path: Path, everywhere: bool = True, for_types: bool = False) -> set[str]:
    """Modules that a file imports: anywhere, or only at module level; with those under TYPE_CHECKING if asked."""

    def nodes(body: list[ast.stmt]) -> Iterator[ast.stmt]:
        for node in body:
            yield node
            if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test) and not for_types:
                continue
            if everywhere or not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                for child in ("body", "orelse", "finalbody", "handlers"):
                    inner = getattr(node, child, [])
                    handled = [s for part in inner for s in (part.body if child == "handlers" else [part])]
                    yield from nodes(handled)

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


def room(module: str) -> str:
    """The package that a module of pipenav belongs to, or the module itself where it lies beside the packages."""
    return "__init__" if module == "pipenav" else module.split(".")[1]


def floor(module: str) -> int:
    """The floor that a module stands on, from 1; a door stands above the floor that it opens."""
    name = room(module)
    if name in DOORS:
        return DOORS[name] + 1
    floors = [number for number, rooms in enumerate(FLOORS, 1) if name in rooms]
    assert floors, f"{module} belongs to no package of the table: give it one, or its package a floor"
    return floors[0]


@pytest.mark.parametrize("module", ALL)
def test_every_module_imports_only_its_own_package_and_what_lies_below(module: str) -> None:
    ours = {name for name in imported(ALL[module], for_types=True) if name in ALL and name != "pipenav"}
    beside = sorted(n for n in ours if room(n) != room(module) and floor(n) >= floor(module))
    assert not beside, f"{module}, on floor {floor(module)}, imports from its own floor or above: {beside}"


def test_imports_for_types_count_only_where_asked(tmp_path: Path) -> None:
    path = tmp_path / "module.py"
    path.write_text("if TYPE_CHECKING:\n    from pipenav.cli import train\nimport numpy\n")
    assert imported(path) == {"numpy"}
    assert imported(path, for_types=True) == {"numpy", "pipenav.cli.train"}


def test_packages_of_the_table_exist() -> None:
    assert {name for rooms in FLOORS for name in rooms} | set(DOORS) == {room(module) for module in ALL}


def test_few_modules_lie_beside_the_packages() -> None:
    beside = {path.name for path in CORE.glob("*.py")} - {"__init__.py", "__main__.py"}
    assert len(beside) <= 8, sorted(beside)


def test_no_module_imports_itself_through_others() -> None:
    graph = {module: (imported(path) & ALL.keys()) - {module, "pipenav"} for module, path in ALL.items()}
    packages = {module for module, path in ALL.items() if path.name == "__init__.py"}
    for module, names in graph.items():
        graph[module] = {n for n in names if not (n in packages and module.startswith(f"{n}."))}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"modules import each other in a circle: {' -> '.join(error.args[1])}")


@pytest.mark.parametrize("module", ALL)
def test_the_core_imports_no_plugin_simulator_or_serial_library(module: str) -> None:
    assert not tops(imported(ALL[module])) & (SIMULATORS | set(PLUGINS))


@pytest.mark.parametrize("module", IN_PLUGINS)
def test_plugins_stand_on_the_open_packages_alone(module: str) -> None:
    names = imported(IN_PLUGINS[module], for_types=True)
    others = set(PLUGINS) - {module.partition(".")[0]}
    assert not tops(names) & others, f"{module} imports another plugin"
    closed = sorted(n for n in names if n.startswith("pipenav.") and n.split(".")[1] not in OPEN_TO_PLUGINS)
    assert not closed, f"{module} imports what plugins may not: {closed}"


def brought_in(module: str, seen: set[str]) -> set[str]:
    """Top-level packages that importing a module of ours brings in, by way of our modules and their packages."""
    if module in seen or module not in ALL:
        return set()
    seen.add(module)
    above = module.rpartition(".")[0]
    names = imported(ALL[module], everywhere=False) | ({above} if above else set())
    return tops(names).union(*(brought_in(name, seen) for name in names))


LIGHT = [module for module in ALL if floor(module) < 6 or room(module) in ("policies", "motions", "cli", "__main__")]


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
    assert not loaded & (HEAVY | SIMULATORS | set(PLUGINS) | {"numpy"})
