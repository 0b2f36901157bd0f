"""Files of a server over HTTP: exports, states, checkpoints and traces, for clients with permission."""

import base64
import http.client
import json
import os
import re
import socket
import tempfile
import unittest
from pathlib import Path
from typing import Dict, List, Tuple

from support import Server, espalier

from espalier import Client

MODEL = ("Lsystem: 1\nderivation length: 6\nAxiom: F(1)A?E(0)\n"
         "A > ?E(h) : h < 9 --> F(1)A\nA > ?E(h) : h >= 9 --> *\nendlsystem\n")


class Downloads(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def serve(self, *arguments: str) -> None:
        self.server = Server(*arguments)
        self.addCleanup(self.server.stop)

    def get(self, path: str, **headers: str) -> Tuple[int, Dict[str, str], bytes]:
        connection = http.client.HTTPConnection(self.server.http, timeout=60)
        try:
            connection.request("GET", path, headers=headers)
            response = connection.getresponse()
            return response.status, dict(response.getheaders()), response.read()
        finally:
            connection.close()

    def text(self, path: str, **headers: str) -> Tuple[int, str]:
        status, _, body = self.get(path, **headers)
        return status, body.decode("utf-8")

    def test_exports_states_checkpoints_and_traces(self) -> None:
        self.serve("--data", os.path.join(self.folder, "data"))
        with Client(self.server.address) as client:
            simulation = client.create(MODEL, environment=[{"type": "height"}], seed=1)
            name = simulation.identifier
            client.call("simulation.trace", {"simulation": name, "trace": True})
            simulation.step(2)
            client.call("simulation.save", {"simulation": name, "checkpoint": "at two", "snapshot": False})
            simulation.step(1)
            state = simulation.string()

            listed = json.loads(self.text("/simulations")[1])["simulations"]
            self.assertEqual([(one["simulation"], one["step"]) for one in listed], [(name, 3)])
            for suffix, start in (("png", b"\x89PNG"), ("svg", b"<?xml"), ("glb", b"glTF"), ("ply", b"ply"), ("obj", b"#")):
                status, headers, body = self.get(f"/simulations/{name}/plant.{suffix}")
                self.assertEqual(status, 200, body[:200])
                self.assertTrue(body.startswith(start), body[:20])
                self.assertEqual(headers["Content-Disposition"], f'attachment; filename="plant.{suffix}"')
            # the state goes on where it was, here and elsewhere
            for path, step in ((f"/simulations/{name}/now.snapshot", 3), (f"/simulations/{name}/checkpoints/at%20two", 2)):
                status, _, body = self.get(path)
                self.assertEqual(status, 200)
                kept = Path(self.folder) / "kept.snapshot"
                kept.write_bytes(body)
                packed = base64.b64encode(body).decode("ascii")
                restored = client.call("simulation.restore", {"simulation": name, "snapshot": packed})
                self.assertEqual(restored["step"], step)
                simulation.step(3 - step or 1)
                self.assertEqual(simulation.string() == state, step == 2)
            status, _, body = self.get(f"/simulations/{name}/traces/1")
            self.assertEqual(status, 200)
            trace = Path(self.folder) / "run.trace.zst"
            trace.write_bytes(body)
            self.assertRegex(espalier("replay", str(trace)).stdout, r"^\d+ steps with \d+ queries: the same as recorded$")

    def test_fields_of_the_environment(self) -> None:
        self.serve()
        soil = {"type": "soil-water", "gridSize": [4, 3, 2], "cellSize": [0.5, 0.25, 0.5], "position": [-1, -0.75, -0.5],
                "initialHead": -0.5, "rain": [[0, 0.002]], "layers": [[1, 0.045, 0.43, 14.5, 2.68, 7.128]]}
        with Client(self.server.address) as client:
            simulation = client.create(MODEL, environment=[soil], seed=1)
            name = simulation.identifier
            simulation.step(2)
            listed = json.loads(self.text(f"/simulations/{name}/fields")[1])
            self.assertEqual(listed["step"], 2)
            fields = {one["name"]: one for one in listed["fields"]}
            water = fields["waterContent"]
            self.assertEqual((water["cells"], water["position"], water["cellSize"]), ([4, 3, 2], [-1, -0.75, -0.5], [0.5, 0.25, 0.5]))
            self.assertTrue(0.045 <= water["least"] <= water["greatest"] <= 0.43, water)
            status, headers, body = self.get(f"/simulations/{name}/fields/waterContent.vti")
            self.assertEqual((status, headers["Content-Disposition"]), (200, 'attachment; filename="waterContent.vti"'))
            # the same values, as the command line reads them
            Path(self.folder, "water.vti").write_bytes(body)
            table = Path(self.folder, "water.csv")
            espalier("field", os.path.join(self.folder, "water.vti"), "--field", f"waterContent={table}")
            row = dict(zip(*[line.split(",") for line in table.read_text(encoding="utf-8").splitlines()[:2]]))
            least, greatest = (next(float(value) for key, value in row.items() if word in key) for word in ("min", "max"))
            self.assertEqual((least, greatest), (water["least"], water["greatest"]))
            status, text = self.text(f"/simulations/{name}/fields/heat.vti")
            self.assertEqual((status, text[:61]), (404, "The environment has no field 'heat'. Its fields: waterContent"))
            plain = client.create(MODEL).identifier
            self.assertEqual(json.loads(self.text(f"/simulations/{plain}/fields")[1])["fields"], [])

    def test_what_is_not_there_is_said(self) -> None:
        self.serve()
        with Client(self.server.address) as client:
            name = client.create(MODEL, environment=[{"type": "height"}]).identifier
            for path, words in (("/simulations/sim-0/a.png", "There is no simulation 'sim-0'."),
                                (f"/simulations/{name}/a.gif", "'a.gif' names no format. Suffixes: .snapshot .png"),
                                (f"/simulations/{name}/traces/1", "This simulation has no trace 1"),
                                (f"/simulations/{name}/checkpoints/a", "checkpoint"),
                                (f"/simulations/{name}/traces/..%2F..%2Fdata", "There is no such page."),
                                ("/simulations/..%2F..%2Fetc/passwd.png", "There is no simulation '../../etc'.")):
                status, text = self.text(path)
                self.assertEqual(status, 404, path)
                self.assertIn(words, text)

    def test_a_token_is_asked_for(self) -> None:
        self.serve("--token", "a secret")
        self.assertEqual(self.get("/simulations")[0], 401)
        self.assertEqual(self.get("/simulations")[1]["WWW-Authenticate"], "Bearer")
        self.assertEqual(self.get("/simulations", Authorization="Bearer a secre")[0], 401)
        self.assertEqual(self.get("/simulations", Authorization="Bearer a secret")[0], 200)
        # how the server is doing is no secret
        self.assertEqual(self.get("/health")[0], 200)

    def test_a_foreign_name_for_this_machine_gets_nothing(self) -> None:
        self.serve()
        self.assertEqual(self.get("/simulations", Host="evil.example")[0], 403)
        self.assertEqual(self.get("/simulations", Host="localhost")[0], 200)
        host, port = self.server.http.rsplit(":", 1)
        with socket.create_connection((host, int(port)), 30) as connection:
            connection.sendall((b"GET /espalier/1 HTTP/1.1\r\nHost: evil.example\r\nUpgrade: websocket\r\n"
                                b"Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                                b"Sec-WebSocket-Version: 13\r\nOrigin: http://evil.example\r\n\r\n"))
            self.assertIn("403 Forbidden", connection.recv(1000).decode("ascii"))

    def suffixes(self, name: str) -> List[str]:
        """Those of all formats, as the server names them."""
        status, text = self.text(f"/simulations/{name}/plant.nothing")
        self.assertEqual(status, 404)
        found = re.findall(r"\.([a-z]+)\b", text.partition(":")[2])
        self.assertGreater(len(found), 10, text)
        return found

    def test_a_download_beyond_the_limit_is_refused(self) -> None:
        for bound in (1000, 5000, 20_000):
            self.serve("--limit", f"blockBytes={bound}")
            with Client(self.server.address) as client:
                model = MODEL.replace("h < 9", "h < 50").replace("length: 6", "length: 50")
                simulation = client.create(model, environment=[{"type": "height"}])
                simulation.step(40)
                name = simulation.identifier
                refused = 0
                for suffix in self.suffixes(name):
                    status, _, body = self.get(f"/simulations/{name}/plant.{suffix}")
                    self.assertIn(status, (200, 413), suffix)
                    if status == 413:
                        refused += 1
                        self.assertIn(f"the limit 'blockBytes' is {bound}, and this is larger.", body.decode("utf-8"))
                self.assertGreater(refused, 3, bound)
                self.assertEqual(simulation.step(1).step, 41)
            self.server.stop()

    def test_a_download_without_memory_is_refused(self) -> None:
        chain = "Lsystem: 1\nderivation length: 534\nAxiom: !(0.3)A\nA --> F(1)+(7)/(11)A\nendlsystem\n"
        view = "line style: cylinder\ncontour sides: 48\n"
        statuses = set()
        for bound in (8_000_000, 10_000_000, 12_000_000, 14_000_000):
            self.serve("--limit", f"accountMemoryBytes={bound}")
            with Client(self.server.address) as client:
                simulation = client.create(files={"chain.l": chain, "chain.v": view}, main="chain.l")
                simulation.step(534)
                for suffix in self.suffixes(simulation.identifier):
                    statuses.add(self.get(f"/simulations/{simulation.identifier}/plant.{suffix}")[0])
                self.assertEqual(self.get("/simulations")[0], 200)
            self.server.stop()
        self.assertEqual(statuses, {200, 503})


if __name__ == "__main__":
    unittest.main()
