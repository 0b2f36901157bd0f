"""The modules of the package depend on each other in one direction."""

import ast
import unittest
from pathlib import Path
from typing import Dict, List, Optional, Set

PACKAGE = Path(__file__).resolve().parents[1] / "espalier"


def imported(source: str, names: Set[str]) -> Set[str]:
    """The modules of the package that a module imports, also inside functions and for types only."""
    found: Set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            found |= {node.module} if node.module else {alias.name for alias in node.names}
    return found & names


def circle(imports: Dict[str, Set[str]]) -> Optional[List[str]]:
    """A path of imports that leads back to its first module, if there is one."""
    done: Set[str] = set()

    def visit(name: str, path: List[str]) -> Optional[List[str]]:
        if name in path:
            return [*path[path.index(name):], name]
        if name not in done:
            for following in sorted(imports[name]):
                found = visit(following, [*path, name])
                if found:
                    return found
            done.add(name)
        return None

    return next((found for found in (visit(name, []) for name in sorted(imports)) if found), None)


class Imports(unittest.TestCase):
    def test_go_in_no_circle(self) -> None:
        modules = {path.stem: path.read_text(encoding="utf-8") for path in PACKAGE.glob("*.py")}
        imports = {name: imported(source, set(modules)) for name, source in modules.items()}
        self.assertIn("errors", imports["wire"])
        found = circle(imports)
        self.assertIsNone(found, f"these modules import each other: {' -> '.join(found or [])}")

    def test_a_circle_is_found_wherever_the_import_stands(self) -> None:
        sources = {"a": "from .b import x", "b": "def f():\n    from . import c", "c": "if TYPE_CHECKING:\n    from .a import y"}
        imports = {name: imported(source, set(sources)) for name, source in sources.items()}
        self.assertEqual(circle(imports), ["a", "b", "c", "a"])
        self.assertIsNone(circle({"a": {"b", "c"}, "b": {"c"}, "c": set()}))


if __name__ == "__main__":
    unittest.main()
