"""espalier watch: draws again when a file changes, says what is wrong and goes on, ends with Ctrl-C."""

from __future__ import annotations

import queue
import signal
import subprocess
import tempfile
import threading
import unittest
from pathlib import Path

from support import SECONDS, program

MODEL = "Lsystem: 1\nderivation length: 2\nAxiom: F\nF --> F[+F]F\nendlsystem\n"


class Watch(unittest.TestCase):
    def setUp(self) -> None:
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)
        self.write("tree.l", MODEL)
        self.write("tree.v", "initial line width: 1 p\n")
        self.process = subprocess.Popen(
            [program(), "watch", str(self.folder / "tree.l"), "-o", str(self.folder / "tree.svg")],
            stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.lines: queue.Queue[str] = queue.Queue()
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()
        self.addCleanup(self.end)

    def end(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.reader.join()
        assert self.process.stderr is not None
        self.process.stderr.close()

    def read(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.lines.put(line)

    def write(self, name: str, text: str) -> None:
        # as editors save: never half a file
        (self.folder / "new").write_text(text, encoding="utf-8")
        (self.folder / "new").replace(self.folder / name)

    def until(self, part: str) -> str:
        """All lines up to the one that has `part`."""
        seen = ""
        while part not in seen:
            seen += self.lines.get(timeout=SECONDS)
        return seen

    def picture(self) -> str:
        return (self.folder / "tree.svg").read_text(encoding="utf-8")

    def test_changes_are_drawn_errors_said_and_ctrl_c_ends(self) -> None:
        self.assertIn("wrote ", self.until("press Ctrl-C to end"))
        first = self.picture()
        # the view file too
        self.write("tree.v", "initial line width: 7 p\n")
        self.until("press Ctrl-C to end")
        self.assertIn('stroke-width="7"', self.picture())
        self.assertIn('stroke-width="1"', first)
        # a mistake is said with its place, the picture stays
        self.write("tree.l", MODEL.replace("Axiom: F", "Axiom: F("))
        seen = self.until("press Ctrl-C to end")
        self.assertIn("error: ", seen)
        self.assertNotIn("wrote ", seen)
        self.assertIn('stroke-width="7"', self.picture())
        self.write("tree.l", MODEL.replace("length: 2", "length: 1"))
        self.assertIn("(step 1, ", self.until("press Ctrl-C to end"))
        self.process.send_signal(signal.SIGINT)
        self.assertEqual(self.process.wait(SECONDS), 0)


if __name__ == "__main__":
    unittest.main()
