"""espalier.glb: plants of .glb files as arrays, whole and damaged ones."""

import json
import random
import struct
import tempfile
import unittest
from pathlib import Path
from typing import Any, Dict

from support import espalier, model

try:
    import numpy as np
    from espalier import glb
except ImportError:
    np = None  # type: ignore[assignment]


@unittest.skipIf(np is None, "NumPy is not installed")
class Reader(unittest.TestCase):
    whole: bytes
    tables: Dict[str, Any]

    @classmethod
    def setUpClass(cls) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "plant.glb"
            espalier("run", model("textured-tree"), "--steps", "2", "--instancing", "--quiet", "-o", str(file))
            cls.whole = file.read_bytes()
        cls.tables = json.loads(cls.whole[20:20 + struct.unpack_from("<I", cls.whole, 12)[0]])

    def test_meshes_and_organs_are_those_of_the_tables(self) -> None:
        scene = glb.read(self.whole)
        self.assertEqual([plant.name for plant in scene.plants], ["plant_0"])
        self.assertEqual([material.name for material in scene.materials], [material["name"] for material in self.tables["materials"]])
        plant = scene.plants[0]
        accessors = self.tables["accessors"]
        copied = next(node for node in self.tables["nodes"] if "extensions" in node)
        copies = copied["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"]
        self.assertEqual([organ.places.shape for organ in plant.instances], [(accessors[copies]["count"], 4, 4)])
        bark = [part for node in self.tables["nodes"] if "mesh" in node and "extensions" not in node
                for part in self.tables["meshes"][node["mesh"]]["primitives"]]
        self.assertEqual(len(plant.mesh.triangles), sum(accessors[part["indices"]]["count"] // 3 for part in bark))
        # y is up, as in the file
        tops = [accessors[part["attributes"]["POSITION"]]["max"] for part in bark]
        np.testing.assert_allclose(plant.mesh.places.max(axis=0), np.max(tops, axis=0), rtol=1e-6)
        np.testing.assert_allclose(np.linalg.norm(plant.mesh.normals, axis=1), 1, rtol=1e-4)

    def test_damaged_files_are_refused_or_read_and_never_anything_else(self) -> None:
        length = struct.unpack_from("<I", self.whole, 12)[0]
        draw = random.Random(1)
        refused = 0
        for _ in range(400):
            content = bytearray(self.whole)
            if draw.random() < 0.3:
                del content[draw.randrange(len(content)):]
            for _ in range(draw.randint(0, 3)):
                if content:  # mostly where the tables are
                    content[draw.randrange(min(20 + length, len(content)))] = draw.randrange(256)
            try:
                with np.errstate(all="ignore"):
                    glb.read(bytes(content))
            except glb.GlbError as error:
                refused += 1
                self.assertIn("Write it", str(error))
        self.assertGreater(refused, 100)


if __name__ == "__main__":
    unittest.main()
