"""Models of the gallery over the wire: their files, pictures and colours, and explanations of modules."""

import base64
import http.client
import tempfile
import unittest
from pathlib import Path
from typing import Any, Tuple

from support import GALLERY, Server, espalier

from espalier import Client, ServerError

COLOURED = "Lsystem: 1\nderivation length: 2\nAxiom: A(1)F\nA(x) : x < 9 --> F(x)A(x+1)\nA(x) : x >= 9 --> F\nendlsystem\n"


class GalleryModels(unittest.TestCase):
    def serve(self, *arguments: str) -> Client:
        self.server = Server(*arguments)
        self.addCleanup(self.server.stop)
        client = Client(self.server.address)
        self.addCleanup(client.close)
        return client

    def get(self, path: str) -> Tuple[int, bytes]:
        connection = http.client.HTTPConnection(self.server.http, timeout=60)
        try:
            connection.request("GET", path)
            response = connection.getresponse()
            return response.status, response.read()
        finally:
            connection.close()

    def test_the_files_of_a_model_make_the_same_plant(self) -> None:
        client = self.serve()
        # textures are no text; one of several models of a folder; an environment of published files
        for name in ("textured-tree", "chapter-open-l-systems/bush.txt", "shadow-trees", "insect-on-a-plant"):
            read = client.call("model.read", {"gallery": name})
            made = {"files": read["files"], "binaryFiles": read["binaryFiles"], "main": read["main"]}
            environment = {"environment": read["environment"]} if "environment" in read else {}
            grown = []
            for model, more in (({"gallery": name}, {}), (made, environment)):
                created = client.call("simulation.create", {"model": model, "seed": 7, "derivationLength": 3, **more})
                client.call("simulation.run", {"simulation": created["simulation"]})
                grown.append(client.call("simulation.get", {"simulation": created["simulation"], "what": "string"})["string"])
            self.assertEqual(grown[0], grown[1], name)
        read = client.call("model.read", {"gallery": "textured-tree"})
        self.assertEqual(base64.b64decode(read["binaryFiles"]["bark.png"]), (GALLERY / "textured-tree" / "bark.png").read_bytes())
        self.assertNotIn("textured-tree.png", read["binaryFiles"])
        self.assertIn("README.md", read["files"])
        with self.assertRaisesRegex(ServerError, "no gallery model '\.\.'"):
            client.call("model.read", {"gallery": "../light-tree"})

    def test_a_model_is_kept_on_the_disk_of_the_server(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        client = self.serve("--models", folder.name)
        self.assertEqual(client.call("model.list", {})["saved"], [])
        read = client.call("model.read", {"gallery": "textured-tree"})
        first = client.call("model.save", {"name": "my tree", "files": read["files"], "binaryFiles": read["binaryFiles"]})
        self.assertEqual((Path(folder.name) / "my tree" / "bark.png").read_bytes(), (GALLERY / "textured-tree" / "bark.png").read_bytes())
        again = client.call("model.read", {"saved": "my tree"})
        self.assertEqual((again["main"], again["files"], again["binaryFiles"], again["revision"]),
                         ("textured-tree.l", read["files"], read["binaryFiles"], first["revision"]))
        # another program changes it, as an editor on the server
        (Path(folder.name) / "my tree" / "README.md").write_text("changed", encoding="utf-8")
        with self.assertRaisesRegex(ServerError, "somebody else has saved or changed it") as caught:
            client.call("model.save", {"name": "my tree", "files": {"a.l": ""}, "revision": first["revision"]})
        self.assertEqual(caught.exception.code, 1017)
        client.call("model.save", {"name": "my tree", "files": {"a.l": ""}, "revision": caught.exception.data["revision"]})
        self.assertEqual(sorted(path.name for path in Path(folder.name).iterdir()), ["my tree"])
        # a server without the option says so
        none = self.serve()
        self.assertNotIn("saved", none.call("model.list", {}))
        with self.assertRaisesRegex(ServerError, "start it with --models FOLDER"):
            none.call("model.save", {"name": "mine", "files": {"a.l": ""}})
        self.assertIn("there is no folder '/nowhere' for models", espalier("serve", "--listen", "127.0.0.1:0", "--models", "/nowhere", status=1).stderr)

    def test_each_named_picture_is_there_and_nothing_else(self) -> None:
        client = self.serve()
        pictures = client.call("model.list", {})["pictures"]
        self.assertEqual(pictures["chapter-open-l-systems/bush.txt"], "/gallery/chapter-open-l-systems/bush.png")
        for path in list(pictures.values())[::7]:
            status, bytes_ = self.get(path)
            self.assertEqual((status, bytes_[:4]), (200, b"\x89PNG"), path)
        for path in ("/gallery/light-tree/light-tree.l", "/gallery/light-tree/..%2Fpictures.txt", "/gallery/..%2Fweb/x.png",
                     "/gallery/light-tree/none.png"):
            self.assertEqual(self.get(path)[0], 404, path)

    def test_the_palette_says_whether_the_model_sets_colours(self) -> None:
        client = self.serve()

        def palette(view: str) -> Any:
            model = {"files": {"a.l": COLOURED, "a.v": view}, "main": "a.l"}
            created = client.call("simulation.create", {"model": model, "seed": 1})
            return client.call("simulation.get", {"simulation": created["simulation"], "what": "palette"})

        plain = palette("line style: cylinder\n")
        self.assertEqual((plain["isOfModel"], len(plain["colours"]), plain["colours"][128]), (False, 256, [84, 132, 62]))
        self.assertEqual(plain["background"], [250, 248, 242])

    def test_an_explanation_is_that_of_the_command_line(self) -> None:
        client = self.serve()
        simulation = client.create(COLOURED, seed=1)
        simulation.step()
        said = client.call("simulation.get", {"simulation": simulation.identifier, "what": "explanation", "module": 2})["explanation"]
        with tempfile.TemporaryDirectory() as folder:
            model = Path(folder) / "a.l"
            model.write_text(COLOURED, encoding="utf-8")
            wanted = espalier("explain", str(model), "--step", "2", "--module", "2", "--seed", "1").stdout
        without_place = wanted.replace(str(model), "model.l")
        self.assertEqual(said, without_place)
        self.assertIn("A(2)", said)
        with self.assertRaises(ServerError):
            client.call("simulation.get", {"simulation": simulation.identifier, "what": "explanation", "module": 99})


if __name__ == "__main__":
    unittest.main()
