"""The TypeScript client: its types fit, and its tests pass in Node.js against a real server."""

import os
import re
import shutil
import subprocess
import unittest
from pathlib import Path

from support import REPOSITORY, SECONDS, program

WEB = REPOSITORY / "clients" / "web"
CLIENT = REPOSITORY / "clients" / "typescript"
# the build of the program fetches the packages
COMPILER = WEB / "node_modules" / "typescript" / "bin" / "tsc"


def node(*arguments: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(["node", *arguments], cwd=folder, text=True, capture_output=True, check=False, stdin=subprocess.DEVNULL,
                          timeout=10 * SECONDS, env={**os.environ, "ESPALIER_PROGRAM": program()})


@unittest.skipUnless(shutil.which("node") and COMPILER.is_file(), "Node.js or the packages of clients/web are not there (./dev build fetches them)")
class TypeScript(unittest.TestCase):
    def test_the_client_compiles_and_passes_its_tests(self) -> None:
        self.assertEqual(node("generate.js", folder=CLIENT).returncode, 0)
        built = node(str(COMPILER), "--typeRoots", str(WEB / "node_modules" / "@types"), folder=CLIENT)
        self.assertEqual((built.returncode, built.stdout), (0, ""), built.stdout)
        tested = node("--test", "test/", folder=CLIENT)
        self.assertEqual(tested.returncode, 0, tested.stdout[-6000:])
        found = re.search(r"^# pass (\d+)", tested.stdout, re.MULTILINE)
        self.assertGreaterEqual(int(found.group(1)) if found else 0, 5)


if __name__ == "__main__":
    unittest.main()
