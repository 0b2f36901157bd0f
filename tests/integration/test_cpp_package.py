"""The C++ client library as an installed CMake package, used by a project outside the tree."""

import shutil
import subprocess
import unittest

from installation import Installed, run
from support import REPOSITORY, SECONDS

from espalier import Server


class CppPackage(Installed):
    def test_a_project_outside_the_tree_finds_builds_and_grows(self) -> None:
        project = self.folder / "project"
        shutil.copytree(REPOSITORY / "clients" / "cpp" / "example", project)
        out = self.build_project(project)
        with Server(str(self.prefix / "bin" / "espalier"), arguments=["--log-level", "off"]) as server:
            grown = run(str(out / "grow"), server.address)
            many = run(str(out / "grow_many"), server.address)
            # an installed program finds its gallery
            with server.connect() as client:
                self.assertIn("light-tree", client.gallery())
            wrong = subprocess.run([str(out / "grow_many"), "127.0.0.1:1"], capture_output=True, text=True,
                                   timeout=SECONDS, check=False)
        lines = [line.split("\t") for line in grown.splitlines()]
        self.assertEqual([line[0] for line in lines], ["1", "2", "3", "4", "5"])
        # an apex at the heights 0, 1 and 2 grows, an apex at 3 does not
        self.assertEqual([line[1] for line in lines],
                         ["FA?E(0)", "FFA?E(0)", "FFFA?E(0)", "FFFA?E(3)", "FFFA?E(3)"])
        # the coroutines: four plants over one connection, in the order in which they finish
        self.assertEqual(sorted(many.splitlines()),
                         [f"{height}\t{'F' * height}A?E({height})" for height in range(1, 5)])
        # and its conformance suite
        suite = run(str(self.prefix / "bin" / "espalier"), "conformance", "001", "178")
        self.assertIn("2 passed, 0 failed", suite)
        self.assertTrue((self.prefix / "share" / "espalier" / "conformance" / "README.md").is_file())
        self.assertEqual((wrong.returncode, "Cannot connect to 127.0.0.1:1" in wrong.stderr), (1, True))


if __name__ == "__main__":
    unittest.main()
