"""Published environment programs on pipes: chunks, unset values, and failures."""

import shutil
import tempfile
import unittest
from pathlib import Path

from support import Process, espalier, program

PROGRAM = Path(__file__).with_name("legacy_program.py")
MODEL = """Lsystem: 1
derivation length: 3
Axiom: F(1)A(7)?E(1,-1)
A(n) --> F(1)[+(90)f(0.25)?E(n,-1)]A(n+1)
endlsystem
"""
# the heights 1.25 and 1 (after the turn), then 2 …; a second value that was not set stays -1
FORMAT = "turtle position: P: %g %.9g %g\n"


class LegacyPrograms(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.model = self.folder / "m.l"
        self.model.write_text(MODEL, encoding="utf-8")
        # a name that no built-in process has
        shutil.copy(PROGRAM, self.folder / "heights")
        (self.folder / "heights").chmod(0o755)

    def field(self, mode: str, more: str = "") -> str:
        file = self.folder / "m.e"
        file.write_text(f"executable: ./heights {mode}\n{FORMAT}{more}", encoding="utf-8")
        return str(file)

    def derived(self, mode: str, more: str = "", *arguments: str) -> str:
        return espalier("derive", str(self.model), "--environment", self.field(mode, more), "--answered", "--every",
                        *arguments).stdout

    def test_a_program_that_is_not_built_in_answers(self) -> None:
        lines = self.derived("height").splitlines()
        self.assertEqual(lines[0], "0\tF(1)A(7)?E(1,1)")
        self.assertEqual(lines[1], "1\tF(1)F(1)[+(90)f(0.25)?E(7,2)]A(8)?E(1,2)")
        self.assertEqual(lines[2], "2\tF(1)F(1)[+(90)f(0.25)?E(7,2)]F(1)[+(90)f(0.25)?E(8,3)]A(9)?E(1,3)")

    def test_chunks_in_both_directions_change_nothing(self) -> None:
        wanted = self.derived("height", "", "--steps", "9")
        for mode in ("height", "chunks", "eager"):
            for size in (1, 2, 1000):
                with self.subTest(mode=mode, size=size):
                    self.assertEqual(self.derived(mode, f"communication type: pipes {size}\n", "--steps", "9"), wanted)

    def test_the_program_remembers_from_step_to_step(self) -> None:
        lines = self.derived("count").splitlines()
        self.assertEqual(lines[2], "2\tF(1)F(1)[+(90)f(0.25)?E(7,3)]F(1)[+(90)f(0.25)?E(8,3)]A(9)?E(1,3)")

    def test_many_modules_cannot_deadlock(self) -> None:
        self.model.write_text("Lsystem: 1\nderivation length: 13\nAxiom: ?E(1,2)\n?E(x,y) --> ?E(x,y)?E(x,y)\nendlsystem\n",
                              encoding="utf-8")
        for mode in ("height", "eager"):
            done = espalier("derive", str(self.model), "--environment", self.field(mode, "communication type: pipes 100000\n"),
                            "--quiet", "--statistics")
            self.assertIn('"queries":8191', done.stderr)

    def test_misbehaviour_ends_the_step_and_says_what_happened(self) -> None:
        for mode, words in (("quit", "ended with status 3 before it had answered. Run it by hand"),
                            ("garbage", "answered 'hello there', which is no answer"),
                            ("ill", "answered '0 E(nan)', which is no answer")):
            with self.subTest(mode=mode):
                done = espalier("derive", str(self.model), "--environment", self.field(mode), "--every", "--answered", status=1)
                self.assertEqual(len(done.stdout.splitlines()), 1)
                self.assertIn(f"environment program 'heights' {words}", done.stderr)
                self.assertIn("If it remembers earlier steps, run from the start", done.stderr)

    def test_offers_the_program_to_others_with_a_time_limit(self) -> None:
        wanted = espalier("derive", str(self.model), "--environment", self.field("height"), "--quiet").stdout
        served = Process([program(), "environment", "legacy", "--spec", self.field("chunks"), "--listen", "127.0.0.1:0"])
        self.addCleanup(served.stop)
        address = served.first_line.split()[-1]
        self.assertEqual(espalier("derive", str(self.model), "--environment", f"tcp://{address}", "--quiet").stdout, wanted)
        silent = (f"stdio:{program()} environment legacy --executable '{self.folder}/heights silent' --spec {self.field('height')} "
                  "--time-limit 0.2 --stdio")
        done = espalier("derive", str(self.model), "--environment", silent, "--quiet", status=1)
        self.assertIn("environment program 'heights' did not answer within 200 ms", done.stderr)

    def test_says_what_is_missing(self) -> None:
        self.assertIn("--spec FILE.e", espalier("environment", "legacy", "--describe", status=2).stderr)
        empty = self.folder / "empty.e"
        empty.write_text(FORMAT, encoding="utf-8")
        self.assertIn("names no program", espalier("environment", "legacy", "--spec", str(empty), "--describe", status=1).stderr)
        many = self.folder / "many.e"
        many.write_text("executable: ./heights height\nturtle position: %g %g %g %g\n", encoding="utf-8")
        self.assertIn("prints more numbers than there are",
                      espalier("environment", "legacy", "--spec", str(many), "--describe", status=1).stderr)
        # a program that is neither built in nor there
        gone = self.folder / "gone.e"
        gone.write_text("executable: ./hondda\n", encoding="utf-8")
        self.assertIn("environment process 'hondda' is unknown. Did you mean 'honda'?",
                      espalier("derive", str(self.model), "--environment", str(gone), status=1).stderr)


if __name__ == "__main__":
    unittest.main()
