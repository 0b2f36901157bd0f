"""Published environment programs on pipes: the dialogue line by line, chunks, unset values, permission, and failures."""

import shutil
import tempfile
import unittest
from pathlib import Path
from typing import Any

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
ALLOWED = "--allow-folder-programs"
# chunks of two from the master, each answered by one line; then the program's own chunks without a line between them
DIALOGUE = """< \x01
> 0 E(1)f(3)
>  P: 0 0 0
> 2 E(2)f(3)
>  P: 0 3 0
> Control: 1 0
< Control: 5
> 3 E(3)f(3)
>  P: 0 6 0
> 4 E(4)f(3)
>  P: 0 9 0
> Control: 0 0
< Control: 5
> 5 E(5)
>  P: 0 12 0
> Control: 4 {}
< 0 E(0)
< 2 E(0)
< Control: 1
< 3 E(0)
< 4 E(0)
< Control: 0
< 5 E(0)
< Control: 4
"""


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

    def field(self, mode: str, more: str = "", command: str = "./heights") -> str:
        file = self.folder / "m.e"
        file.write_text(f"executable: {command} {mode}\n{FORMAT}{more}", encoding="utf-8")
        return str(file)

    def run_field(self, mode: str, more: str = "", *arguments: str, command: str = "./heights", status: int = 0) -> Any:
        return espalier("derive", str(self.model), "--environment", self.field(mode, more, command), "--answered", "--every",
                        ALLOWED, *arguments, status=status)

    def derived(self, mode: str, more: str = "", *arguments: str) -> str:
        return str(self.run_field(mode, more, *arguments).stdout)

    def listen(self, mode: str, more: str = "") -> Process:
        bridge = Process([program(), "environment", "legacy", "--spec", self.field(mode, more), "--listen", "127.0.0.1:0"])
        self.addCleanup(bridge.stop)
        return bridge

    def test_a_program_that_is_not_built_in_answers(self) -> None:
        lines = self.derived("height").splitlines()
        self.assertEqual(lines[0], "0\tF(1)A(7)?E(1,1)")
        self.assertEqual(lines[1], "1\tF(1)F(1)[+(90)f(0.25)?E(7,2)]A(8)?E(1,2)")
        self.assertEqual(lines[2], "2\tF(1)F(1)[+(90)f(0.25)?E(7,2)]F(1)[+(90)f(0.25)?E(8,3)]A(9)?E(1,3)")

    def test_the_dialogue_is_that_of_the_published_library(self) -> None:
        self.model.write_text("Lsystem: 1\nderivation length: 2\nAxiom: ?E(1)f(3)?E(2)f(3)?E(3)f(3)?E(4)f(3)?E(5)\n"
                              "E(x) --> E(x)\nendlsystem\n", encoding="utf-8")
        log = self.folder / "log"
        # all points are on one vertical line: they block each other, every answer is 0
        self.run_field(f"discs {log}", "communication type: pipes 2\n")
        steps = DIALOGUE.format(0) + DIALOGUE.format(1).split("\n", 1)[1]
        head, second = steps[:len(DIALOGUE) - 1], steps[len(DIALOGUE) - 1:]
        for name in "12345":  # in the second step all parameters are 0
            second = second.replace(f" E({name})", " E(0)")
        wanted = head + second + "> Control: 8 1\n< \x01\n"
        self.assertEqual(log.read_text(encoding="utf-8"), wanted)
        log.unlink()
        # the same behind a bridge that listens, which says goodbye when it is stopped at the latest
        bridge = self.listen(f"discs {log}", "communication type: files 2\n")
        espalier("derive", str(self.model), "--environment", f"tcp://{bridge.address}", "--compat", "cpfg", "--quiet")
        bridge.stop()
        self.assertEqual(log.read_text(encoding="utf-8"), wanted)

    def test_the_arguments_of_a_started_program_are_its_own(self) -> None:
        # a built-in process would ignore them, which is an error with --strict
        done = self.run_field(f"height {self.folder / 'log'}", "", "--strict")
        self.assertNotIn("is ignored", done.stderr)
        self.assertEqual(done.stdout, self.derived("height"))

    def test_the_position_is_read_behind_the_blank_of_the_format(self) -> None:
        # a blank less, and (1,5,1) is read as (5,1,...): all three points block each other
        self.model.write_text("Lsystem: 1\nderivation length: 1\nAxiom: @M(1,5,1)?E(7)@M(2,5,9)?E(7)@M(3,5,30)?E(7)\nendlsystem\n",
                              encoding="utf-8")
        self.assertIn("@M(1,5,1)?E(1)@M(2,5,9)?E(1)@M(3,5,30)?E(1)", self.derived("discs"))

    def test_the_following_module_has_both_characters_of_a_pair(self) -> None:
        self.model.write_text("Lsystem: 1\nderivation length: 1\nAxiom: ?E(1)@M(1,2,3)?E(2)~l(3)?E(3)@Gs(4)?E(4)]?E(5)\nendlsystem\n",
                              encoding="utf-8")
        log = self.folder / "log"
        wanted = ["E(1)@M(1,2,3)", "E(2)~l(3)", "E(3)@G", "E(4)]", "E(5)"]

        def records() -> list[str]:
            return [line.split(" ", 2)[2] for line in log.read_text(encoding="utf-8").splitlines()
                    if " E(" in line and line[0] == ">"]

        self.run_field(f"height {log}")
        self.assertEqual(records(), wanted)
        log.unlink()
        # the same behind a bridge that listens
        bridge = self.listen(f"height {log}")
        espalier("derive", str(self.model), "--environment", f"tcp://{bridge.address}", "--quiet")
        self.assertEqual(records(), wanted)

    def test_chunks_in_both_directions_change_nothing(self) -> None:
        wanted = self.derived("height", "", "--steps", "9")
        for mode in ("height", "eager"):
            for size in (1, 2, 1000):
                with self.subTest(mode=mode, size=size):
                    self.assertEqual(self.derived(mode, f"communication type: pipes {size}\n", "--steps", "9"), wanted)

    def test_every_communication_type_becomes_pipes(self) -> None:
        wanted = self.derived("height")
        more = (self.folder / "m.e").read_bytes()
        for kind, command in (("files", "./heights"), ("files 2", "heights"), ("memory", "heights -e m.e"), ("sockets 3", "./heights"),
                              ("sockets", f"heights -e {self.folder}/m.e")):
            with self.subTest(kind=kind, command=command):
                self.assertEqual(self.run_field("height", f"communication type:{kind}\n", command=command).stdout, wanted)
        # the file itself stays; the copies are gone
        self.assertIn(b"communication type:sockets\n", (self.folder / "m.e").read_bytes())
        self.assertNotIn(b"communication", more)

    def test_the_program_remembers_from_step_to_step(self) -> None:
        lines = self.derived("count").splitlines()
        self.assertEqual(lines[2], "2\tF(1)F(1)[+(90)f(0.25)?E(7,3)]F(1)[+(90)f(0.25)?E(8,3)]A(9)?E(1,3)")

    def test_many_modules_cannot_deadlock(self) -> None:
        self.model.write_text("Lsystem: 1\nderivation length: 13\nAxiom: ?E(1,2)\n?E(x,y) --> ?E(x,y)?E(x,y)\nendlsystem\n",
                              encoding="utf-8")
        for mode in ("height", "eager"):
            done = espalier("derive", str(self.model), "--environment", self.field(mode, "communication type: pipes 100000\n"),
                            ALLOWED, "--quiet", "--statistics")
            self.assertIn('"queries":8191', done.stderr)

    def test_misbehaviour_ends_the_step_and_says_what_happened(self) -> None:
        for mode, words in (("quit", "ended with status 3 before it had answered. Run it by hand"),
                            ("garbage", "answered 'hello there', which is no answer"),
                            ("flags", "answered 'Control: done', which is no answer: expected '<id> E(value,,value)'"),
                            ("ill", "answered '0 E(nan)', which is no answer"),
                            ("silent", "did not answer within 3000 ms: expected '<id> E(value,,value)' for each module, and 'Control: 4'"),
                            ("flood", "did not answer within 3000 ms: expected")):
            with self.subTest(mode=mode):
                limit = ("--environment-timeout", "3") if mode in ("silent", "flood") else ()
                done = self.run_field(mode, "", *limit, status=1)
                self.assertEqual(len(done.stdout.splitlines()), 1)
                self.assertIn(f"environment program 'heights' {words}", done.stderr)
                # whatever line the words stand on
                self.assertIn("If it remembers earlier steps, run from the start", " ".join(done.stderr.split()))

    def test_offers_the_program_to_others_with_a_time_limit(self) -> None:
        wanted = espalier("derive", str(self.model), "--environment", self.field("height"), "--quiet", ALLOWED).stdout
        bridge = self.listen("height", "communication type: files 2\n")
        self.assertEqual(espalier("derive", str(self.model), "--environment", f"tcp://{bridge.address}", "--quiet").stdout, wanted)
        silent = (f"stdio:{program()} environment legacy --executable '{self.folder}/heights silent' --spec {self.field('height')} "
                  "--time-limit 0.2 --stdio")
        done = espalier("derive", str(self.model), "--environment", silent, "--quiet", status=1)
        self.assertIn("environment program 'heights' did not answer within 200 ms", done.stderr)

    def test_a_program_starts_only_with_permission(self) -> None:
        mark = self.folder / "mark"
        field = self.field(f"height {mark}")
        for command in ("derive", "check"):
            with self.subTest(command=command):
                done = espalier(command, str(self.model), "--environment", field, status=1)
                self.assertIn("m.e:1:13: error: the environment file names a program that is not built in: 'heights'", done.stderr)
                self.assertIn("--allow-folder-programs starts it, for folders that you trust; a server never does", done.stderr)
                self.assertFalse(mark.exists())
        # a check does not start it even so
        espalier("check", str(self.model), "--environment", field, ALLOWED)
        self.assertFalse(mark.exists())

    def test_the_program_of_the_folder_replaces_the_built_in_one(self) -> None:
        shutil.copy(self.folder / "heights", self.folder / "honda81")
        (self.folder / "m.e").write_text(f"executable: honda81 height\n{FORMAT}", encoding="utf-8")
        field = str(self.folder / "m.e")
        self.model.write_text("Lsystem: 1\nderivation length: 1\nAxiom: F(2)?E(3,4)\nendlsystem\n", encoding="utf-8")
        answered = ("derive", str(self.model), "--environment", field, "--answered", "--every")
        self.assertIn("F(2)?E(3,2)", espalier(*answered, ALLOWED).stdout)
        # the built-in process has no file 'height' to read
        self.assertIn("cannot read the specification file", espalier(*answered, status=1).stderr)

    def test_a_folder_runs_as_its_specifications_say(self) -> None:
        (self.folder / "plant.v").write_text("angle increment: 90\n", encoding="utf-8")
        (self.folder / "specifications").write_text(
            "m.l\nplant.v\nsurroundings\nheights\nignore:\n*\nplant:\n\tgenerate:\n\t\tcpfg -e surroundings m.l plant.v\n"
            "\torgan:\n\t\tcpfg m.l plant.v\n", encoding="utf-8")
        (self.folder / "surroundings").write_text(
            f"executable: heights -e surroundings height\ncommunication type: memory\n{FORMAT}", encoding="utf-8")
        # the copy that names pipes has the suffix of an environment file
        done = espalier("derive", str(self.folder), ALLOWED, "--answered", "--every")
        self.assertIn("1\tF(1)F(1)[+(90)f(0.25)?E(7,2)]A(8)?E(1,2)", done.stdout)
        self.assertIn("starting the program 'heights'", done.stderr)
        # the other object has no environment
        done = espalier("derive", str(self.folder), "--object", "organ", ALLOWED, "--steps", "0")
        self.assertIn("F(1)A(7)?E(1,-1)", done.stdout)
        done = espalier("derive", str(self.folder), "--object", "leaf", ALLOWED, status=1)
        self.assertIn("has no object 'leaf': give one of 1 'plant / generate' (m.l), 2 'plant / organ' (m.l)", done.stderr)

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
                      espalier("derive", str(self.model), "--environment", str(gone), ALLOWED, status=1).stderr)


if __name__ == "__main__":
    unittest.main()
