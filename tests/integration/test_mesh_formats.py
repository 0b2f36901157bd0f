"""One tree with bark, leaves with holes and forks in five mesh formats: read back, they are the same triangles."""

from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from typing import Tuple

from mesh_readers import READERS
from support import REPOSITORY, espalier

GALLERY = REPOSITORY / "clients" / "gallery"
Corner = Tuple[float, float, float]


class MeshFormats(unittest.TestCase):
    def compare(self, model: Path, triangles: int, backward: int, corners: Tuple[Corner, Corner], *arguments: str) -> None:
        """All files of the model have so many triangles, within a box between two corners."""
        with tempfile.TemporaryDirectory() as folder:
            files = {suffix: Path(folder) / f"plant.{suffix}" for suffix in READERS}
            outputs = [word for file in files.values() for word in ("-o", str(file))]
            run = espalier("run", str(model), "--seed", "5", *arguments, *outputs, "--quiet")
            self.assertEqual(run.returncode, 0, run.stderr)
            meshes = {suffix: READERS[suffix](file) for suffix, file in files.items()}
        # which has no triangles without an area
        self.assertLessEqual(len(meshes["stl"].triangles), len(meshes["glb"].triangles))
        first = meshes["stl"].without_slivers()
        low, high = corners
        size = max(b - a for a, b in zip(low, high))
        for suffix, mesh in meshes.items():
            with self.subTest(model=model.name, format=suffix):
                if suffix != "stl":
                    self.assertEqual(len(mesh.triangles), len(meshes["glb"].triangles))
                mesh = mesh.without_slivers()
                self.assertEqual(len(mesh.triangles), triangles)
                for found, expected in zip(mesh.bounds(), corners):
                    self.assertEqual(len(found), 3)
                    for a, b in zip(found, expected):
                        self.assertAlmostEqual(a, b, delta=1e-5 * size)
                self.assertAlmostEqual(mesh.area() / first.area(), 1.0, delta=1e-4)
                self.assertAlmostEqual(mesh.volume() / first.volume(), 1.0, delta=1e-3)
                # those of an .stl are of its triangles; of others the inner side of a sharp bend, within the tube, looks back
                self.assertEqual(mesh.backward_normals(), 0 if suffix == "stl" else backward)

    def test_a_textured_tree_is_the_same_in_every_format(self) -> None:
        corners = ((-3.728303, 0.0, -5.599810), (4.311015, 9.791170, 3.647262))
        self.compare(GALLERY / "textured-tree", 7152, 0, corners, "--detail", "0.4")

    def test_a_plant_with_every_kind_of_organ_is_the_same_in_every_format(self) -> None:
        corners = ((-4.417216, -0.303705, -2.668117), (1.472719, 4.021339, 2.024975))
        self.compare(REPOSITORY / "tests" / "gltf" / "organs", 3979, 408, corners)


if __name__ == "__main__":
    unittest.main()
