"""Which module imports which: at the top of a file, inside a function, or for type checking only."""

from collections.abc import Mapping
from functools import lru_cache

import grimp

ImportGraph = Mapping[str, frozenset[str]]
"""The imported modules, by module."""


@lru_cache(maxsize=1)
def import_graph(package: str = "movingout") -> ImportGraph:
    """The imports among the modules of an installed package."""
    graph = grimp.build_graph(package, cache_dir=None)
    return {module: frozenset(graph.find_modules_directly_imported_by(module)) for module in sorted(graph.modules)}


def import_circles(graph: ImportGraph) -> list[list[str]]:
    """The groups of modules that import one another, directly or through others."""
    reached = {module: _reached(graph, module) for module in graph}
    circles: list[list[str]] = []
    for module in graph:
        if module in reached[module] and not any(module in circle for circle in circles):
            circles.append(sorted(other for other in reached[module] if module in reached[other]))
    return circles


def _reached(graph: ImportGraph, start: str) -> set[str]:
    """All modules imported directly or indirectly; the module itself only if it is in a circle."""
    found: set[str] = set()
    pending = list(graph[start])
    while pending:
        module = pending.pop()
        if module not in found:
            found.add(module)
            pending += graph.get(module, ())
    return found
