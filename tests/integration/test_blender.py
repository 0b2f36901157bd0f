"""The add-on for Blender, in a Blender without a screen: import, growth by frames, live link."""

import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import warnings
from pathlib import Path
from typing import Any, Dict, List, Tuple

from espalier import Server
from support import GALLERY, REPOSITORY, espalier, model, program

ADDON = REPOSITORY / "clients" / "blender"
WALK = REPOSITORY / "tests" / "blender" / "walk.py"


def gltf_of(file: Path) -> Dict[str, Any]:
    content = file.read_bytes()
    parsed: Dict[str, Any] = json.loads(content[20:20 + struct.unpack_from("<I", content, 12)[0]])
    return parsed


def organs(file: Path, plant: str) -> Tuple[int, int]:
    """The instances of the organs of a plant, and the faces of all of them."""
    gltf = gltf_of(file)
    root = next(node for node in gltf["nodes"] if node.get("name") == plant)
    count = faces = 0
    for node in (gltf["nodes"][child] for child in root["children"] if "extensions" in gltf["nodes"][child]):
        copies = gltf["accessors"][node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"]]["count"]
        count += copies
        faces += copies * sum(gltf["accessors"][part["indices"]]["count"] // 3 for part in gltf["meshes"][node["mesh"]]["primitives"])
    return count, faces


def counts(file: Path, plant: str) -> Tuple[int, int]:
    """Vertices and faces of the meshes of a plant that stand once, from the file's own tables."""
    gltf = gltf_of(file)
    root = next(node for node in gltf["nodes"] if node.get("name") == plant)
    parts = [part for child in root["children"] if "extensions" not in gltf["nodes"][child]
             for part in gltf["meshes"][gltf["nodes"][child]["mesh"]]["primitives"]]
    return (sum(gltf["accessors"][part["attributes"]["POSITION"]]["count"] for part in parts),
            sum(gltf["accessors"][part["indices"]]["count"] // 3 for part in parts))


@unittest.skipUnless(shutil.which("blender"), "blender is not installed")
class Blender(unittest.TestCase):
    saw: Dict[str, Any]

    @classmethod
    def setUpClass(cls) -> None:
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        archive, result = cls.folder / "addon.zip", cls.folder / "saw.json"
        subprocess.run([sys.executable, str(ADDON / "make_addon.py"), str(archive)], check=True, timeout=60)
        cls.leafy, cls.pair = cls.folder / "leafy.glb", cls.folder / "pair.glb"
        espalier("run", model("textured-tree"), "--steps", "5", "--instancing", "--quiet", "-o", str(cls.leafy))
        espalier("run", str(GALLERY / "two-trees"), "--steps", "4", "--quiet", "-o", str(cls.pair))
        espalier("run", str(GALLERY / "two-trees"), "--steps", "3", "--every", "--quiet", "-o", str(cls.folder / "growth-%04d.glb"))
        # variants are plants of their own; the same name in another folder, and a name that Blender would cut
        long = "a-plant-with-a-name-that-is-longer-than-what-blender-keeps-of-a-name"
        cls.others = [cls.folder / "variant-001.glb", cls.folder / "variant-002.glb", cls.folder / "other" / "pair.glb",
                      cls.folder / f"{long}-a.glb", cls.folder / f"{long}-b.glb"]
        (cls.folder / "other").mkdir()
        for each in cls.others:
            shutil.copy(cls.pair, each)
        (cls.folder / "cut.glb").write_bytes(cls.pair.read_bytes()[:-100])
        with warnings.catch_warnings(), Server(program(), arguments=["--gallery", str(GALLERY)]) as server, server.connect() as client:
            warnings.simplefilter("ignore")  # no environment answers these trees
            # with leaves, which are instances
            simulation = client.create(gallery="textured-tree", seed=7, plants=[(-2, 0, 0), (2, 0, 0)])
            cls.states: List[Path] = []
            other = client.create(gallery="textured-tree", seed=7, plants=[(-2, 0, 0), (2, 0, 0)])
            for step in range(4):
                cls.states.append(cls.folder / f"state{step}.glb")
                cls.states[-1].write_bytes(other.geometry())
                if step < 3:
                    other.step()
            done = subprocess.run(
                ["blender", "-b", "--factory-startup", "--python", str(WALK), "--", str(archive), str(result), str(cls.leafy), str(cls.pair),
                 *map(str, cls.others), str(cls.folder / "growth-0000.glb"), str(cls.folder / "cut.glb"), "--live", server.address, "", simulation.identifier],
                capture_output=True, text=True, timeout=120, check=False,
                env={**os.environ, "BLENDER_USER_SCRIPTS": str(cls.folder / "scripts"), "BLENDER_USER_CONFIG": str(cls.folder / "config")})
        if not result.exists():
            raise AssertionError(f"Blender ended with {done.returncode}:\n{done.stdout}\n{done.stderr}")
        cls.saw = json.loads(result.read_text(encoding="utf-8"))

    def test_a_plant_is_one_object_with_materials_and_texture_coordinates(self) -> None:
        plants = self.saw["files"]["pair.glb"]
        self.assertEqual([plant["name"] for plant in plants], ["plant_0", "plant_1"])
        for plant in plants:
            self.assertEqual((plant["vertices"], plant["faces"]), counts(self.pair, plant["name"]))
            self.assertEqual((plant["uv"], plant["isValid"]), (1, True))
            self.assertEqual(plant["used"], list(range(len(plant["materials"]))), "each material is worn")
        wooden = gltf_of(self.pair)["materials"]
        for material in wooden:
            made = self.saw["materials"][f"pair {material['name']}"]
            for found, expected in zip(made["colour"], material["pbrMetallicRoughness"]["baseColorFactor"], strict=True):
                self.assertAlmostEqual(found, expected, 6)

    def test_up_is_up_and_places_are_those_of_the_file(self) -> None:
        gltf = gltf_of(self.pair)
        branches = gltf["accessors"][gltf["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
        plant = self.saw["files"]["pair.glb"][0]
        self.assertLessEqual(plant["low"][0], branches["min"][0] + 1e-5)
        self.assertAlmostEqual(plant["low"][2], 0, 5)
        self.assertGreaterEqual(plant["high"][2] + 1e-5, branches["max"][1])

    def test_repeated_organs_share_one_mesh(self) -> None:
        plant = self.saw["files"]["leafy.glb"][0]
        self.assertEqual((plant["organs"], plant["organFaces"]), organs(self.leafy, plant["name"]))
        self.assertEqual(plant["organMeshes"], 1)
        # the same leaves written one by one reach as high
        single = self.folder / "single.glb"
        espalier("run", model("textured-tree"), "--steps", "5", "--quiet", "-o", str(single))
        tops = [accessor["max"][1] for accessor in gltf_of(single)["accessors"] if "max" in accessor]
        self.assertAlmostEqual(max(plant["organHigh"], plant["high"][2]), max(tops), 4)
        leaf = self.saw["materials"]["leafy leaf"]
        self.assertIn("ShaderNodeTexImage", leaf["kinds"])
        self.assertTrue(leaf["pictures"][0][0] > 0 and leaf["pictures"][0][2], "the picture is in the .blend file")

    def test_frames_of_the_scene_are_steps_of_a_series(self) -> None:
        self.assertEqual(len(self.saw["frames"]), 4)
        for step, plants in enumerate(self.saw["frames"]):
            file = self.folder / f"growth-{step:04d}.glb"
            self.assertEqual([(plant["vertices"], plant["faces"]) for plant in plants], [counts(file, plant["name"]) for plant in plants])
        self.assertEqual(len({plant["pointer"] for plants in self.saw["frames"] for plant in plants}), 2, "two plants stay two objects")

    def test_each_file_has_a_collection_of_its_own(self) -> None:
        names = self.saw["collections"]
        self.assertEqual([names[str(each)] for each in (self.pair, *self.others[:3])], ["pair", "variant-001", "variant-002", "pair 2"])
        self.assertEqual(len({names[str(each)] for each in self.others[3:]}), 2)

    def test_a_live_link_shows_each_step_in_the_same_objects(self) -> None:
        self.assertEqual([step for step, _ in self.saw["live"]], [0, 1, 2, 3])
        for (_, plants), state in zip(self.saw["live"], self.states, strict=True):
            self.assertEqual([(plant["vertices"], plant["faces"]) for plant in plants], [counts(state, plant["name"]) for plant in plants])
        self.assertEqual(len({plant["pointer"] for _, plants in self.saw["live"] for plant in plants}), 2)

    def test_a_live_link_shows_the_organs_of_each_step(self) -> None:
        seen = []
        for step, plants in self.saw["live"]:
            single = self.folder / f"live{step}.glb"
            espalier("run", model("textured-tree"), "--seed", "7", "--steps", str(step), "--quiet", "-o", str(single))
            top = max(accessor["max"][1] for accessor in gltf_of(single)["accessors"] if "max" in accessor)
            for plant in plants:
                self.assertEqual((plant["organs"], plant["organFaces"]), organs(self.states[step], plant["name"]))
                self.assertEqual(plant["organMeshes"], 1)
                self.assertAlmostEqual(max([plant["organHigh"], *plant["high"][2:]]), top, 4)
            seen.append(plants[0]["organs"])
        # one leaf more would be seen
        self.assertEqual((len(seen), len(set(seen))), (4, 4), seen)

    def test_what_cannot_be_used_is_said_in_one_sentence(self) -> None:
        self.assertIn("The file is no .glb of Espalier, or is damaged", self.saw["errors"]["cut.glb"])
        self.assertIn("the server has no simulation 'none'. It has: ", self.saw["errors"]["live"])


if __name__ == "__main__":
    unittest.main()
