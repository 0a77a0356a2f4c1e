"""The structure of the package: imports run one way, and modules stay small."""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

import vfwidget

ROOT = Path(vfwidget.__file__).parent
VIEW = ROOT.parent / "js" / "src"
ROOMS = (
    "errors deprecation limits threads arrays files outline font export text raster solver energy "
    "overlap motion matching design plot view"
).split()
"""What stands later may import what stands earlier, and never the reverse."""
LONGEST = 400


def modules() -> list[Path]:
    return sorted(ROOT.rglob("*.py"))


def imported(module: Path) -> Iterator[tuple[str, ...]]:
    """The modules of the package that a module imports, at its top or within a function."""
    package = module.relative_to(ROOT).parts[:-1]
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = package[: len(package) + 1 - node.level]
            names = tuple(node.module.split(".")) if node.module else ()
            if names:
                yield (*base, *names)
            else:
                yield from ((*base, alias.name) for alias in node.names)


def test_every_room_has_its_place_in_the_order() -> None:
    rooms = {module.relative_to(ROOT).with_suffix("").parts[0] for module in modules()}
    assert rooms - {"__init__"} <= set(ROOMS)


def test_imports_run_one_way() -> None:
    upwards = []
    for module in modules():
        room = module.relative_to(ROOT).with_suffix("").parts[0]
        if room == "__init__":
            continue
        for target in imported(module):
            if target[0] in ROOMS and ROOMS.index(target[0]) > ROOMS.index(room):
                upwards.append(f"{module.relative_to(ROOT)} imports {'.'.join(target)}")
    assert not upwards


def assert_no_circles(graph: Mapping[Any, Collection[Any]]) -> None:
    done = set()

    def visit(name: Any, trail: tuple[Any, ...]) -> None:
        assert name not in trail, f"a circle: {[*trail[trail.index(name) :], name]}"
        if name in done or name not in graph:
            return
        for target in graph[name]:
            visit(target, (*trail, name))
        done.add(name)

    for name in graph:
        visit(name, ())


def test_no_two_modules_import_each_other() -> None:
    graph = {}
    for module in modules():
        name = module.relative_to(ROOT).with_suffix("").parts
        # A package's own __init__ gathers its modules; they name each other, not the package.
        graph[name[:-1] if name[-1] == "__init__" else name] = set(imported(module)) - {()}
    assert_no_circles(graph)


def test_no_two_modules_of_the_view_import_each_other() -> None:
    if not VIEW.is_dir():
        pytest.skip("the sources of the view belong to a checkout")
    graph = {
        module: [
            (module.parent / target).resolve()
            for target in re.findall(r'^import .* from "(\..*)";$', module.read_text("utf-8"), re.M)
        ]
        for module in VIEW.rglob("*.js")
    }
    assert sum(map(len, graph.values())) > len(graph)
    assert_no_circles(graph)


def test_modules_hold_one_idea_each() -> None:
    lengths = {m: len(m.read_text(encoding="utf-8").splitlines()) for m in modules()}
    assert {m.name: n for m, n in lengths.items() if n > LONGEST} == {}
