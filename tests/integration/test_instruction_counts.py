"""The check of instruction counts: what it adds up, what it lets pass and what it says."""

import contextlib
import io
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmark"))
from check_instructions import compare, own_instructions  # noqa: E402

PROFILE = """\
# callgrind format
positions: line
events: Ir
ob=(1) /lib/libc.so.6
fn=(1) memcpy
10 1000
ob=(2) /opt/program
fn=(2) ours
5 20
+1 3
cob=(1)
cfn=(1)
calls=2 10
* 5000
-2 4
ob=(1)
fn=(3) malloc
1 70
cob=(2)
cfn=(2)
calls=1 5
* 27
ob=(2)
fn=(4) ours too
7 100
totals: 1197
"""


class InstructionCounts(unittest.TestCase):
    def compared(self, counts: dict, recorded: dict) -> tuple:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            figures = compare(counts, recorded)
        return (*figures, printed.getvalue())

    def test_only_own_instructions_outside_calls_are_added_up(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            profile = Path(folder) / "profile"
            profile.write_text(PROFILE, encoding="utf-8")
            self.assertEqual(own_instructions(str(profile), "/opt/program"), 20 + 3 + 4 + 100)

    def test_five_percent_more_passes_and_a_little_more_fails(self) -> None:
        self.assertEqual(self.compared({"a": 1050}, {"a": 1000}), (1, 0, ""))
        passed, failed, text = self.compared({"a": 1051}, {"a": 1000})
        self.assertEqual((passed, failed), (0, 1))
        self.assertEqual(text, "a: 1,051 instructions, +5.1% of the 1,000 recorded; allowed is +5%. If the change is worth "
                               "it, renew the record: ./dev bench --record-instructions\n")

    def test_fewer_instructions_pass_and_ask_for_a_new_record(self) -> None:
        self.assertEqual(self.compared({"a": 901}, {"a": 1000}), (1, 0, ""))
        passed, failed, text = self.compared({"a": 899, "b": 10}, {"a": 1000, "b": 10})
        self.assertEqual((passed, failed), (2, 0))
        self.assertEqual(text, "fewer instructions than recorded: a -10.1%. Keep the gain: "
                               "./dev bench --record-instructions\n")

    def test_work_without_a_record_and_a_record_without_work_fail(self) -> None:
        passed, failed, text = self.compared({"a": 5}, {"b": 5})
        self.assertEqual((passed, failed), (0, 2))
        self.assertIn("a: 5 instructions, but no count is recorded. Record it: ./dev bench --record-instructions", text)
        self.assertIn("b: a count is recorded, but there is no such work any more. Renew the record", text)


if __name__ == "__main__":
    unittest.main()
