"""Movies: `run --every -o growth.mp4` and `run --turntable N -o turn.gif`, made by the program ffmpeg."""

import os
import shutil
import stat
import subprocess
import tempfile
import unittest
from pathlib import Path

from support import REPOSITORY, program

MODEL = str(REPOSITORY / "clients" / "gallery" / "parametric-tree")

# keeps what it is sent and says how it was called
STAND_IN = """#!/bin/sh
for last; do :; done
printf '%s\\n' "$*" >"$last.words"
cat >"$last"
"""
PNG = b"\x89PNG\r\n\x1a\n"


class Movies(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "bin").mkdir()

    def run_with(self, path: str, *arguments: str) -> subprocess.CompletedProcess:
        return subprocess.run([program(), "run", MODEL, "--steps", "4", "--size", "64x48", *arguments], cwd=self.folder, text=True,
                              capture_output=True, check=False, timeout=120, env={**os.environ, "PATH": path})

    def with_stand_in(self, script: str) -> str:
        ffmpeg = self.folder / "bin" / "ffmpeg"
        ffmpeg.write_text(script, encoding="utf-8")
        ffmpeg.chmod(ffmpeg.stat().st_mode | stat.S_IXUSR)
        return f"{self.folder / 'bin'}:{os.environ['PATH']}"

    def test_ffmpeg_gets_a_picture_of_each_step_or_of_each_part_of_a_turn(self) -> None:
        path = self.with_stand_in(STAND_IN)
        for arguments, count in ((("--every",), 5), (("--turntable", "6", "--frame-rate", "24"), 6)):
            with self.subTest(arguments[0]):
                done = self.run_with(path, *arguments, "-o", "a.mp4")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn(f"wrote a.mp4 ({count} pictures)", done.stderr)
                self.assertEqual((self.folder / "a.mp4").read_bytes().count(PNG), count)
        words = (self.folder / ".a-partial.mp4.words").read_text(encoding="utf-8")
        self.assertIn("-framerate 24 -i -", words)

    def test_the_pictures_of_a_turn_are_files_too_and_differ(self) -> None:
        done = self.run_with(os.environ["PATH"], "--turntable", "4", "-o", "turn.png")
        self.assertEqual(done.returncode, 0, done.stderr)
        pictures = [(self.folder / f"turn-000{k}.png").read_bytes() for k in range(4)]
        self.assertEqual(len(set(pictures)), 4)

    def test_a_movie_that_ffmpeg_cannot_make_leaves_no_file(self) -> None:
        path = self.with_stand_in("#!/bin/sh\necho 'no such codec' >&2\nexit 3\n")
        done = self.run_with(path, "--every", "-o", "a.webm")
        self.assertEqual(done.returncode, 1)
        self.assertIn("no such codec", done.stderr)
        self.assertIn("a.webm", done.stderr)
        self.assertEqual([file.name for file in self.folder.iterdir()], ["bin"])

    def test_without_ffmpeg_and_without_frames_a_sentence_says_what_to_do(self) -> None:
        done = self.run_with(str(self.folder / "bin"), "--every", "-o", "a.gif")
        self.assertEqual(done.returncode, 1)
        self.assertIn("install it (apt install ffmpeg)", done.stderr)
        done = self.run_with(os.environ["PATH"], "-o", "a.gif")
        self.assertEqual(done.returncode, 2)
        self.assertIn("give --every", done.stderr)

    def test_files_that_the_options_do_not_fit_are_refused(self) -> None:
        (self.folder / "dir.mp4").mkdir()
        (self.folder / "a.l").write_text("Lsystem: 1\nderivation length: 1\nAxiom: F\nendlsystem\n", encoding="utf-8")
        path = self.with_stand_in(STAND_IN)
        for arguments, status, words in ((("--turntable", "3", "-o", "a.glb"), 2, "--turntable writes .png"),
                                         (("--variants", "2", "--turntable", "3", "-o", "a.png"), 2, "excludes"),
                                         (("--render", "-o", "a.svg"), 2, "--render draws .png"),
                                         (("--render", "--view-height", "nan", "-o", "a.png"), 2, "give a number from -89 to 89"),
                                         (("--detail", "nan", "-o", "a.glb"), 2, "give a number from 0.01 to 100"),
                                         (("--every", "-o", "dir.mp4"), 1, "it is a folder"),
                                         (("--every", "-o", "nowhere/a.mp4"), 1, "there is no folder for it")):
            with self.subTest(" ".join(arguments)):
                done = self.run_with(path, *arguments)
                self.assertEqual(done.returncode, status, done.stderr)
                self.assertIn(words, done.stderr)
        model = (self.folder / "a.l").read_bytes()
        done = subprocess.run([program(), "run", "a.l", "-o", "a.l", "--format", "png"], cwd=self.folder, text=True,
                              capture_output=True, check=False, timeout=120)
        self.assertEqual(done.returncode, 2)
        self.assertIn("'a.l' is the model", done.stderr)
        self.assertEqual((self.folder / "a.l").read_bytes(), model)
        self.assertEqual(sorted(file.name for file in self.folder.iterdir()), ["a.l", "bin", "dir.mp4"])

    @unittest.skipUnless(shutil.which("ffmpeg"), "ffmpeg is not installed")
    def test_the_real_ffmpeg_makes_all_three_kinds(self) -> None:
        done = self.run_with(os.environ["PATH"], "--every", "-o", "a.mp4", "-o", "a.webm", "-o", "a.gif")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.folder / "a.mp4").read_bytes()[4:8], b"ftyp")
        self.assertEqual((self.folder / "a.webm").read_bytes()[:4], b"\x1aE\xdf\xa3")
        self.assertEqual((self.folder / "a.gif").read_bytes()[:6], b"GIF89a")


if __name__ == "__main__":
    unittest.main()
