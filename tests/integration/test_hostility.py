"""Hostile peers of every kind at once, half a minute in all, the second half over TLS; `./dev soak` does it for longer."""

import os
import tempfile
import unittest

from hostility import attack


class HostilePeersAtOnce(unittest.TestCase):
    def attacked(self, seconds: float, is_encrypted: bool = False) -> None:
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(attack(seconds, folder, is_encrypted), [])

    def test_the_server_lives_and_a_client_that_means_well_gets_its_answers(self) -> None:
        self.attacked(15)
        self.attacked(15, is_encrypted=True)

    @unittest.skipUnless(os.environ.get("ESPALIER_LONG_TESTS") == "yes", "takes minutes: ./dev test --all soak")
    def test_long_the_same_for_minutes(self) -> None:
        seconds = float(os.environ.get("ESPALIER_HOSTILE_SECONDS", "300"))
        self.attacked(0.75 * seconds)
        self.attacked(0.25 * seconds, is_encrypted=True)


if __name__ == "__main__":
    unittest.main()
