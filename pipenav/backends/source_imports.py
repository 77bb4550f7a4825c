"""Imports of a module, read from its source: nothing is executed.

Only imports that run unconditionally with the module are counted: not those in functions, under `if`, or in a `try`
with handlers, which a module can do without. Files of the module's own package are followed, other packages are not.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from importlib.util import find_spec, resolve_name
from pathlib import Path


def can_find(top: str) -> bool:
    """Whether a top-level package or module is installed; it is not imported."""
    if sys.modules.get(top) is not None:
        return True
    try:
        return find_spec(top) is not None
    except ValueError:
        return False


def imported_modules(module: str) -> Iterator[str]:
    """Names that importing `module` needs from other packages, after the name of its own top-level package.

    An import `from a import b` counts as a and as a.b, which may be a module.

    Raises:
        SyntaxError, ValueError, OSError: a file of the module's package cannot be read or parsed.
    """
    top = module.partition(".")[0]
    yield top
    waiting, seen = [module], {""}
    while waiting:
        name = waiting.pop()
        if name in seen:
            continue
        seen.add(name)
        waiting.append(name.rpartition(".")[0])  # importing a.b runs a first
        path = _source_of(name)
        if path is None:
            continue
        package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        for imported in _imported(ast.parse(path.read_bytes(), str(path)).body, package):
            if imported.partition(".")[0] == top:
                waiting.append(imported)
            else:
                yield imported


def _source_of(module: str) -> Path | None:
    """File of a module, found from its top-level package (finding a submodule's spec would import its parent)."""
    top, *rest = module.split(".")
    spec = find_spec(top)
    if spec is None:
        return None
    if not rest and spec.origin:
        return Path(spec.origin) if spec.origin.endswith(".py") else None
    for folder in spec.submodule_search_locations or ():
        base = Path(folder, *rest)
        for path in (base / "__init__.py", base.with_name(f"{base.name}.py")):
            if path.is_file():
                return path
    return None


def _imported(body: list[ast.stmt], package: str) -> Iterator[str]:
    """Modules that these statements import unconditionally; for `from a import b` also a.b."""
    for node in body:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            source = resolve_name("." * node.level + (node.module or ""), package) if node.level else str(node.module)
            yield source
            yield from (f"{source}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.ClassDef | ast.With) or (isinstance(node, ast.Try) and not node.handlers):
            yield from _imported(node.body, package)
