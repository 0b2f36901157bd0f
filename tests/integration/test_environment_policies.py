"""The behaviour of the command line when an environment in another process fails."""

import os
import tempfile
import unittest
from pathlib import Path

from support import espalier, python

# answers the height, and ends itself in the step it is told to
MORTAL = """import sys
from espalier import Environment

class Mortal(Environment):
    def answer(self, query):
        if self.completed_steps == 2:
            sys.exit(3)
        return [query.position[1]]

Mortal.serve()
"""
MODEL = ("Lsystem: 1\nderivation length: 4\nAxiom: F(1)A?E(0)\n"
         "A > ?E(h) : h < 9 --> F(1)A\nendlsystem\n")


class Policies(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        script = self.folder / "mortal.py"
        script.write_text(MORTAL, encoding="utf-8")
        self.model = str(self.folder / "model.l")
        Path(self.model).write_text(MODEL, encoding="utf-8")
        self.environment = "stdio:" + " ".join(f"'{word}'" for word in python(script))

    def test_a_failure_fails_the_step_unless_told_otherwise(self) -> None:
        failed = espalier("derive", self.model, "--environment", self.environment, status=1)
        self.assertIn("The simulation stays at step 2.", failed.stderr)

    def test_keep_and_fallback_go_on_and_say_so(self) -> None:
        kept = espalier("derive", self.model, "--environment", self.environment, "--environment-policy", "keep")
        self.assertIn("step 2: ", kept.stderr)
        self.assertIn("The modules keep what they sent.", kept.stderr)
        trace = os.path.join(self.folder, "run.trace")
        replaced = espalier("derive", self.model, "--environment", self.environment, "--environment-policy",
                            "fallback:height", "--trace", trace)
        self.assertIn("The built-in 'height' answers in its place.", replaced.stderr)
        whole = espalier("derive", self.model, "--environment", "height")
        self.assertEqual(replaced.stdout, whole.stdout)
        # the choice is in the trace, which is replayed with what was answered in its place
        self.assertIn(b"answers in its place", Path(trace).read_bytes())
        self.assertIn("the same as recorded", espalier("replay", trace).stdout)

    def test_an_entry_of_a_configuration_says_it_for_itself(self) -> None:
        entry = self.folder / "environment.json"
        command = self.environment[len("stdio:"):]
        entry.write_text('{"type":"stdio","command":"%s","policy":"keep","timeoutMilliseconds":20000}' % command,
                         encoding="utf-8")
        self.assertIn("The modules keep what they sent.",
                      espalier("derive", self.model, "--environment", str(entry)).stderr)
        entry.write_text('{"type":"stdio","command":"%s","policy":"hope"}' % command, encoding="utf-8")
        self.assertIn("policy: expected fail, keep or fallback:NAME of a built-in",
                      espalier("derive", self.model, "--environment", str(entry), status=1).stderr)

    def test_a_slow_one_has_so_much_time(self) -> None:
        slow = self.folder / "slow.py"
        slow.write_text(MORTAL.replace("sys.exit(3)", "__import__('time').sleep(60)"), encoding="utf-8")
        address = "stdio:" + " ".join(f"'{word}'" for word in python(slow))
        failed = espalier("derive", self.model, "--environment", address, "--environment-timeout", "2", status=1)
        self.assertIn("did not answer within 2000 ms", failed.stderr)

    def test_wrong_options_are_refused(self) -> None:
        self.assertIn("expected fail, keep or fallback:NAME of a built-in",
                      espalier("derive", self.model, "--environment-policy", "hope", status=2).stderr)

    def test_a_coupling_is_iterated(self) -> None:
        halver = self.folder / "halver.py"
        halver.write_text("from espalier import Environment\n\n\nclass Halver(Environment):\n"
                          "    def answer(self, query):\n        return [1 + query.parameters[0] / 2]\n\n\n"
                          "Halver.serve()\n", encoding="utf-8")
        Path(self.model).write_text("Lsystem: 1\nderivation length: 1\nAxiom: ?E(0)\n?E(x) --> ?E(x)\nendlsystem\n",
                                    encoding="utf-8")
        address = "stdio:" + " ".join(f"'{word}'" for word in python(halver))
        grown = espalier("derive", self.model, "--environment", address, "--iterations", "100", "--tolerance", "1e-4")
        self.assertTrue(grown.stdout.startswith("?E(1.9999"), grown.stdout)
        unsettled = espalier("derive", self.model, "--environment", address, "--iterations", "2")
        self.assertEqual(unsettled.stdout.strip(), "?E(1.5)")
        self.assertIn("did not settle in 2 iterations", unsettled.stderr)


if __name__ == "__main__":
    unittest.main()
