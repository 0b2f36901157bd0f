"""An environment that throws, hangs, answers rubbish or dies: the step fails, the environment is named, nothing is lost.

Every kind of environment times every kind of misbehaviour, from the command line: a plug-in in the program, a program on
standard input and output, a program that is dialled, a built-in process. The run fails in step 3, leaves a snapshot of
step 2, and goes on from it to the string of an undisturbed run once the environment is mended."""

import socket
import subprocess
import tempfile
import time
import unittest
from contextlib import ExitStack
from pathlib import Path
from typing import Dict

from soak import resident_bytes
from support import SECONDS, Process, espalier, model, program, python, stdio

from espalier import Server

MODEL = ("Lsystem: 1\nderivation length: 5\nAxiom: A?E(0)\n"
         "A > ?E(x) --> F(x)A\nendlsystem\n")
GROWN = "F(1)F(2)F(3)F(4)F(5)A?E(5)"

# counts its steps, which is its state, and misbehaves in step 3 as long as the file is there
MISBEHAVING = """import os, sys, threading
from espalier import Environment

class Misbehaving(Environment):
    steps = 0

    def save(self):
        return self.steps

    def restore(self, state):
        self.steps = state

    def step(self, queries):
        bad = self.completed_steps == 2 and os.path.exists({file!r})
        if bad and {does!r} == "throw":
            raise RuntimeError("the well is dry")
        if bad and {does!r} == "hang":
            threading.Event().wait()
        if bad and {does!r} == "die":
            os._exit(9)
        self.steps = self.completed_steps + 1
        return [[float("nan") if bad else self.steps] for query in queries]

Misbehaving.serve()
"""

THREW, HUNG, NO_NUMBER = "the well is dry", "1000 ms", "nan"


class Failures(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "model.l").write_text(MODEL, encoding="utf-8")
        self.switch = self.folder / "misbehaves"

    def goes_wrong_and_on(self, environment: str, *said: str) -> None:
        """Fails in step 3, saying so; goes on from the snapshot of step 2 after the environment was mended."""
        model, rest = str(self.folder / "model.l"), str(self.folder / "rest.snapshot")
        self.switch.touch()
        failed = espalier("run", model, "--environment", environment, "--environment-timeout", "1", "-o", rest, status=1)
        for words in ("step 3", "The simulation stays at step 2.", "the snapshot holds step 2: continue from it with --resume", *said):
            self.assertIn(words, " ".join(failed.stderr.split()))  # long lines are broken
        self.switch.unlink()
        espalier("run", "--resume", rest, "--environment", environment, "-o", str(self.folder / "end.string"))
        self.assertEqual((self.folder / "end.string").read_text(encoding="utf-8").strip(), GROWN)

    def test_a_plugin(self) -> None:
        library = Path(program()).parents[1] / "lib" / "misbehaving.so"
        for does, words in {"throw": THREW, "hang": HUNG, "nan": NO_NUMBER, "fail": "it is not my day"}.items():
            with self.subTest(does):
                entry = self.folder / "plugin.json"
                entry.write_text('{"type":"plugin","library":"%s","does":"%s","in":3,"while":"%s"}'
                                 % (library, does, self.switch), encoding="utf-8")
                self.goes_wrong_and_on(str(entry), "'misbehaving'", words)

    def test_a_plugin_is_checked_in_a_process_of_its_own(self) -> None:
        libraries = Path(program()).parents[1] / "lib"
        found = espalier("environment", "check", str(libraries / "ceiling.so")).stdout
        self.assertIn("describe: ceiling, needs position", found)
        self.assertTrue(found.endswith("all is right\n"), found)
        # with its configuration, in either form
        for kind in ('"type":"plugin","library":"%s",' % (libraries / "misbehaving.so"), ""):
            (self.folder / "plugin.json").write_text('{%s"does":"die","in":1,"while":"%s"}' % (kind, self.switch), encoding="utf-8")
            call = ("environment", "check", str(libraries / "misbehaving.so"), "--configuration", str(self.folder / "plugin.json"))
            self.assertIn("all is right", espalier(*call).stdout)
            self.switch.touch()
            found = espalier(*call, status=1).stdout
            self.switch.unlink()
            self.assertRegex(found, "wrong shapes: .*ended")
        self.assertIn("there is no plug-in 'none.so'", espalier("environment", "check", "none.so", status=1).stderr)
        (self.folder / "text.so").write_text("no library", encoding="utf-8")
        found = espalier("environment", "check", str(self.folder / "text.so"), status=1)
        self.assertIn("text.so", found.stdout)
        # a name with a version is a library, too; it was read as the text of a published environment
        (self.folder / "text.so.1").write_text("no library", encoding="utf-8")
        said = espalier("derive", model("growth-to-a-height"), "--environment", str(self.folder / "text.so.1"), status=1).stderr
        self.assertRegex(said, r"the plug-in .*text\.so\.1' cannot be loaded")

    def test_results_that_find_no_room_on_standard_output_are_a_failure(self) -> None:
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = subprocess.run([program(), "derive", model("classic-algae")], stdout=full, stderr=subprocess.PIPE, text=True, timeout=SECONDS,
                                  check=False, stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 1)
        self.assertIn("the results could not be written to standard output: No space left on device", done.stderr)

    def scripts(self) -> Dict[str, str]:
        """The words by which each kind of misbehaviour is known."""
        return {"throw": THREW, "hang": HUNG, "nan": NO_NUMBER, "die": "ended"}

    def script(self, does: str) -> Path:
        path = self.folder / f"{does}.py"
        path.write_text(MISBEHAVING.format(file=str(self.switch), does=does), encoding="utf-8")
        return path

    def test_a_program_on_standard_input_and_output(self) -> None:
        for does, words in self.scripts().items():
            with self.subTest(does):
                self.goes_wrong_and_on(stdio(python(self.script(does))), words, f"{does}.py")

    def test_a_program_that_starts_slowly_is_opened_when_it_answers(self) -> None:
        # longer than hello and describe are waited for: on a busy machine Python alone may need that
        slowly = ["sh", "-c", 'sleep 5; exec "$@"', "slowly", *python(self.script("throw"))]
        self.assertEqual(espalier("derive", str(self.folder / "model.l"), "--environment", stdio(slowly)).stdout.strip(), GROWN)

    def test_a_program_that_is_dialled(self) -> None:
        for does, words in self.scripts().items():
            if does == "die":
                continue  # its address is gone with it; see test_environments
            with self.subTest(does):
                served = Process(python(self.script(does), "--listen", "127.0.0.1:0"))
                self.addCleanup(served.stop)
                self.goes_wrong_and_on(f"tcp://{served.address}", words, served.address)

    def test_silent_connections_keep_no_server_out(self) -> None:
        # more than the process may have descriptors
        served = Process(["bash", "-c", 'ulimit -n 50; exec "$0" environment height --listen 127.0.0.1:0', program()])
        self.addCleanup(served.stop)
        host, port = served.address.rsplit(":", 1)
        with ExitStack() as stack:
            for _ in range(100):
                stack.enter_context(socket.create_connection((host, int(port)), 60))
            model = str(self.folder / "model.l")
            self.assertEqual(espalier("derive", model, "--environment", f"tcp://{served.address}").stdout,
                             espalier("derive", model, "--environment", "height").stdout)

    def test_connections_that_have_spoken_once_keep_no_server_out(self) -> None:
        served = Process(["bash", "-c", 'ulimit -n 50; exec "$0" environment height --listen 127.0.0.1:0', program()])
        self.addCleanup(served.stop)
        host, port = served.address.rsplit(":", 1)
        with ExitStack() as stack:
            for _ in range(100):
                peer = stack.enter_context(socket.create_connection((host, int(port)), SECONDS))
                lines = stack.enter_context(peer.makefile("rb"))
                peer.sendall(b'{"jsonrpc":"2.0","id":7,"method":"environment.describe"}\n')
                self.assertIn(b"result", lines.readline())
            model = str(self.folder / "model.l")
            self.assertEqual(espalier("derive", model, "--environment", f"tcp://{served.address}").stdout,
                             espalier("derive", model, "--environment", "height").stdout)

    def test_an_idle_connection_keeps_no_memory_of_its_largest_message(self) -> None:
        served = Process([program(), "environment", "height", "--listen", "127.0.0.1:0"])
        self.addCleanup(served.stop)
        host, port = served.address.rsplit(":", 1)
        before = resident_bytes(served.process.pid)
        with ExitStack() as stack:
            for _ in range(4):
                peer = stack.enter_context(socket.create_connection((host, int(port)), 60))
                lines = stack.enter_context(peer.makefile("rb"))
                peer.sendall(b'{"jsonrpc":"2.0","id":7,"method":"environment.step","params":{"queries":[' + b"1," * 10_000_000 + b"1]}}\n")
                self.assertIn(b'"id":7', lines.readline())
            self.assert_small(served.process.pid, before)

    def assert_small(self, process_id: int, before: int) -> None:
        end = time.monotonic() + SECONDS
        while resident_bytes(process_id) - before > 60_000_000 and time.monotonic() < end:
            time.sleep(0.1)
        self.assertLess(resident_bytes(process_id) - before, 60_000_000)

    def test_a_built_in_process_that_takes_too_long(self) -> None:
        # 32768 rays from each of 300 leaves past each other take longer than a tenth of a second
        (self.folder / "slow.l").write_text("Lsystem: 1\nderivation length: 2\nAxiom: A(0)\n"
                                            "A(n) : n < 300 --> f(1)?E(1,0,0,0)A(n+1)\nendlsystem\n", encoding="utf-8")
        slow = self.folder / "slow.json"
        slow.write_text('{"type":"chiba","radius":50,"sampleCount":30000}', encoding="utf-8")
        failed = espalier("derive", str(self.folder / "slow.l"), "--steps", "300", "--environment", str(slow),
                          "--environment-timeout", "0.1", status=1)
        self.assertIn("environment 'chiba' did not finish step", failed.stderr)
        self.assertIn("within 100 ms", failed.stderr)

    def test_each_snapshot_has_the_state_of_its_own_step(self) -> None:
        # the answer is the state, so a snapshot with the state of an earlier step shows
        script = self.folder / "counting.py"
        script.write_text("from espalier import Environment\n\nclass Counting(Environment):\n    steps = 0\n\n"
                          "    def save(self):\n        return self.steps\n\n"
                          "    def restore(self, state):\n        self.steps = state\n\n"
                          "    def step(self, queries):\n        self.steps += 1\n"
                          "        return [[self.steps] for query in queries]\n\nCounting.serve()\n", encoding="utf-8")
        served = Process(python(script, "--listen", "127.0.0.1:0"))
        self.addCleanup(served.stop)
        with Server(program(), arguments=["--log-level", "error", "--allow-dial", served.address]) as server, \
                server.connect(timeout=60) as client:
            plant = client.create(MODEL, environment=[{"type": "tcp", "address": served.address}])
            plant.step()
            first = plant.save()
            plant.step()
            second = plant.save()
            plant.step(3)
            self.assertEqual(plant.string(), GROWN)
            for snapshot, steps in ((second, 3), (first, 4)):
                plant.restore(snapshot)
                plant.step(steps)
                self.assertEqual(plant.string(), GROWN)

    def test_a_run_without_a_snapshot_is_told_of_it(self) -> None:
        self.switch.touch()
        failed = espalier("run", str(self.folder / "model.l"), "--environment", stdio(python(self.script("throw"))),
                          "-o", str(self.folder / "plant.string"), status=1)
        self.assertIn("with -o FILE.snapshot a failed run saves its last complete step", failed.stderr)
        self.assertFalse((self.folder / "plant.string").exists())


if __name__ == "__main__":
    unittest.main()
