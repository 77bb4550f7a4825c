"""Matplotlib without the `matplotlibrc` of the current folder, which it would read before any other."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType

NAME = "matplotlibrc"


class _BlindLoader(Loader):
    """Runs Matplotlib's own loader while a file of that name in the current folder seems not to be there."""

    def __init__(self, loader: Loader) -> None:
        self._loader = loader

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return self._loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        assert module.__spec__ is not None
        module.__spec__.loader = module.__loader__ = self._loader
        exists = os.path.exists
        os.path.exists = lambda path: path != NAME and exists(path)
        try:
            self._loader.exec_module(module)
        finally:
            os.path.exists = exists


class _BlindFinder(MetaPathFinder):
    """Finds Matplotlib, for the blind loader to load."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname != "matplotlib":
            return None
        spec = PathFinder.find_spec(fullname, path, target)
        if spec is not None and spec.loader is not None:
            spec.loader = _BlindLoader(spec.loader)
        return spec


def ignore_local_matplotlibrc() -> None:
    """Make later imports of Matplotlib ignore a matplotlibrc in the current folder; calling it twice is harmless."""
    if not any(isinstance(finder, _BlindFinder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _BlindFinder())
