"""The R page: its script as it is, against the real server."""

import shutil
import subprocess
import unittest

from support import GALLERY, REPOSITORY, SECONDS, program

from espalier import Server


@unittest.skipUnless(shutil.which("Rscript"), "R is not installed (Debian: r-base-core)")
class REnvironment(unittest.TestCase):
    def test_a_tree_grows_by_the_light_that_r_answers(self) -> None:
        server = Server(program(), arguments=["--gallery", str(GALLERY), "--log-level", "off"])
        self.addCleanup(server.stop)
        host, port = server.address.split(":")
        script = subprocess.Popen(["Rscript", str(REPOSITORY / "clients" / "r" / "light.R"), host, port],
                                  stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert script.stderr is not None
        self.assertEqual(script.stderr.readline().strip(), "r-light is offered")
        with server.connect(timeout=60) as client:
            simulation = client.create(gallery="light-tree", environment=[{"type": "offered", "name": "r-light"}], seed=7)
            grown = [made.statistics for made in simulation.steps()]
            self.assertTrue(all(made["answers"] == made["queries"] for made in grown))
            # in full light every bud makes three: 3^7 = 2187 in the last step
            self.assertEqual([made["queries"] for made in grown[:5]], [1, 3, 9, 27, 81])
            self.assertLess(grown[-1]["queries"], 3 ** 7)
            bare = client.create("Lsystem: 1\nderivation length: 2\nAxiom: F\nF --> FF\nendlsystem\n",
                                 environment=[{"type": "offered", "name": "r-light"}])
            self.assertTrue(bare.step(2).finished)
        server.stop()
        self.assertEqual(script.communicate(timeout=SECONDS)[0], "")
        self.assertEqual(script.returncode, 0)


if __name__ == "__main__":
    unittest.main()
