"""The same bits on every processor: hashes of states and files against tests/bits/hashes.txt."""

import os
import sys
import tempfile
import unittest
from pathlib import Path
from typing import List

from support import GALLERY, REPOSITORY, espalier, program

sys.path.insert(0, str(REPOSITORY / "tests" / "bits"))

from hashes import MASKS, Programs, differences, recorded  # noqa: E402

FOLDER = str(Path(program()).parent)

# of models that take longer than a second only the long test makes all steps
LONG = {"gallery stand-year", "gallery roots-in-soil", "gallery self-organizing-tree", "gallery self-thinning"}
RANDOM_MODELS = 500


@unittest.skipUnless(os.access(f"{FOLDER}/espalier_bits", os.X_OK), "espalier_bits is not built")
class Bits(unittest.TestCase):
    def compare(self, programs: Programs, kinds: List[str]) -> None:
        wanted = {name: value for name, value in recorded().items()
                  if name.split()[0] in kinds and name not in LONG
                  and not (name.startswith("random ") and int(name.split()[1]) >= RANDOM_MODELS)}
        self.assertTrue(wanted)
        self.assertEqual(differences(wanted, programs.again(list(wanted))), [])

    def test_states_and_files_are_the_recorded_ones(self) -> None:
        self.compare(Programs(FOLDER), ["gallery", "state", "drawing", "random"])

    def test_they_are_without_fused_multiply_add_and_by_two_threads(self) -> None:
        self.compare(Programs(FOLDER, MASKS[0], threads=2), ["gallery", "random"])

    def test_they_are_without_avx(self) -> None:
        self.compare(Programs(FOLDER, MASKS[1], threads=4), ["state", "drawing", "random"])

    def test_a_mask_changes_what_the_c_library_computes(self) -> None:
        # without this the tests above could not fail: the compatible mode computes with the C library
        with tempfile.TemporaryDirectory() as folder:
            model = Path(folder) / "waves.l"
            model.write_text("Lsystem: 1\nderivation length: 3000\nStart: {t = 1;}\n"
                             "StartEach: {t = 90*sin(t*37)*exp(cos(t*17)) + fabs(t)^0.37;}\n"
                             "Axiom: A\nA --> A\nendlsystem\n", encoding="utf-8")
            own = ["derive", str(model), "--hash", "--quiet"]
            published = [*own, "--compat", "cpfg"]
            self.assertEqual(espalier(*own).stdout, espalier(*own, GLIBC_TUNABLES=MASKS[0]).stdout)
            if "fma" in Path("/proc/cpuinfo").read_text(encoding="utf-8"):
                self.assertNotEqual(espalier(*published).stdout, espalier(*published, GLIBC_TUNABLES=MASKS[0]).stdout)

    def test_a_replay_and_an_environment_elsewhere_give_the_same_states(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            for name in ("shadow-trees", "roots-and-stones", "stochastic-bush"):
                with self.subTest(name):
                    model = str(GALLERY / name)
                    here = espalier("derive", model, "--every", "--hash", "--quiet", "--seed", "3",
                                    "--trace", f"{folder}/trace").stdout
                    self.assertEqual(here, espalier("derive", model, "--every", "--hash", "--quiet", "--seed", "3",
                                                    "--threads", "7", GLIBC_TUNABLES=MASKS[1]).stdout)
                    espalier("replay", f"{folder}/trace", GLIBC_TUNABLES=MASKS[0])

    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes minutes: ./dev test --all long")
    def test_long_all_lines_for_any_number_of_threads(self) -> None:
        wanted = {name: value for name, value in recorded().items() if not name.startswith("random ")}
        for threads in (1, 2, 3, 4, 7):
            with self.subTest(threads=threads):
                self.assertEqual(differences(wanted, Programs(FOLDER, threads=threads).again(list(wanted))), [])


if __name__ == "__main__":
    unittest.main()
