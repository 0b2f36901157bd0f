"""The C++ client library as an installed CMake package, used by a project outside the tree."""

import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from support import REPOSITORY, SECONDS, program

from espalier import Server


class CppPackage(unittest.TestCase):
    @unittest.skipUnless(shutil.which("cmake"), "there is no cmake")
    def test_a_project_outside_the_tree_finds_builds_and_grows(self) -> None:
        build = Path(program()).resolve().parents[1]
        with tempfile.TemporaryDirectory() as folder:
            prefix, project, out = Path(folder) / "prefix", Path(folder) / "project", Path(folder) / "out"
            shutil.copytree(REPOSITORY / "clients" / "cpp" / "example", project)
            for command in (["cmake", "--install", str(build), "--prefix", str(prefix)],
                            ["cmake", "-S", str(project), "-B", str(out), "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}"],
                            ["cmake", "--build", str(out)]):
                done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
                self.assertEqual(done.returncode, 0, f"{' '.join(command)}\n{done.stdout}{done.stderr}")
            with Server(str(prefix / "bin" / "espalier"), arguments=["--log-level", "off"]) as server:
                grown = subprocess.run([str(out / "grow"), server.address], capture_output=True, text=True,
                                       timeout=SECONDS, check=True)
                many = subprocess.run([str(out / "grow_many"), server.address], capture_output=True, text=True,
                                      timeout=SECONDS, check=True)
                # an installed program finds its gallery
                with server.connect() as client:
                    self.assertIn("light-tree", client.gallery())
                wrong = subprocess.run([str(out / "grow_many"), "127.0.0.1:1"], capture_output=True, text=True,
                                       timeout=SECONDS, check=False)
        lines = [line.split("\t") for line in grown.stdout.splitlines()]
        self.assertEqual([line[0] for line in lines], ["1", "2", "3", "4", "5"])
        # what stands at the heights 0, 1 and 2 grows, what stands at 3 does not
        self.assertEqual([line[1] for line in lines],
                         ["FA?E(0)", "FFA?E(0)", "FFFA?E(0)", "FFFA?E(3)", "FFFA?E(3)"])
        # the coroutines: four plants over one connection, in the order in which they are done
        self.assertEqual(sorted(many.stdout.splitlines()),
                         [f"{height}\t{'F' * height}A?E({height})" for height in range(1, 5)])
        self.assertEqual((wrong.returncode, "Cannot connect to 127.0.0.1:1" in wrong.stderr), (1, True))


if __name__ == "__main__":
    unittest.main()
