"""Runs inside Blender: installs the add-on from its archive, imports, plays and follows plants, and writes what it saw as JSON.

blender -b --factory-startup --python walk.py -- ARCHIVE RESULT FILE... [--live ADDRESS TOKEN SIMULATION]
"""

import json
import sys
import time
from pathlib import Path
from typing import Any, Dict, List

import bpy


def seen(name: str) -> List[Dict[str, Any]]:
    """The plants of a collection, by their names."""
    # a background Blender computes places only when it is asked
    bpy.context.view_layer.update()
    found = []
    for thing in sorted(bpy.data.collections[name].objects, key=lambda each: str(each["espalier_plant"])):
        if thing.parent is not None:
            continue
        mesh = thing.data
        corners = [thing.matrix_world @ vertex.co for vertex in mesh.vertices]
        found.append({
            "name": thing["espalier_plant"], "pointer": thing.as_pointer(), "vertices": len(mesh.vertices), "faces": len(mesh.polygons),
            "materials": [material.name for material in mesh.materials], "uv": len(mesh.uv_layers),
            "used": sorted({face.material_index for face in mesh.polygons}),
            "low": [min(corner[axis] for corner in corners) for axis in range(3)] if corners else [],
            "high": [max(corner[axis] for corner in corners) for axis in range(3)] if corners else [],
            "isValid": not mesh.validate(),
            "organs": len(thing.children), "organMeshes": len({organ.data.name for organ in thing.children}),
            "organFaces": sum(len(organ.data.polygons) for organ in thing.children),
            "organHigh": max([(thing.matrix_world @ organ.matrix_local @ corner.co)[2] for organ in thing.children for corner in organ.data.vertices],
                             default=None)})
    return found


def materials() -> Dict[str, Dict[str, Any]]:
    found = {}
    for material in bpy.data.materials:
        if material.use_nodes and "espalier_look" in material:
            kinds = [node.bl_idname for node in material.node_tree.nodes]
            pictures = [node.image for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeTexImage"]
            found[material.name] = {"colour": list(material.diffuse_color), "kinds": sorted(kinds),
                                    "pictures": [[*image.size, image.packed_file is not None] for image in pictures]}
    return found


def main(archive: str, result: str, *rest: str) -> None:
    bpy.ops.preferences.addon_install(filepath=archive)
    bpy.ops.preferences.addon_enable(module="espalier_blender")
    import espalier_blender
    live = rest.index("--live") if "--live" in rest else len(rest)
    saw: Dict[str, Any] = {"files": {}, "errors": {}, "collections": {}, "frames": [], "live": []}
    for file in rest[:live]:
        try:
            bpy.ops.espalier.import_glb(filepath=file)
            name = espalier_blender.import_file(Path(file))
            saw["files"][Path(file).name] = seen(name)
            saw["collections"][file] = name
        except RuntimeError as error:
            saw["errors"][Path(file).name] = str(error)
    series = [collection.name for collection in bpy.data.collections if "espalier_steps" in collection]
    for name in series:
        for frame in range(bpy.context.scene.frame_end + 1):
            bpy.context.scene.frame_set(frame)
            saw["frames"].append(seen(name))
    saw["materials"] = materials()
    if live < len(rest):
        address, token, simulation = rest[live + 1:]
        bpy.ops.espalier.connect(address=address, token=token, simulation=simulation)
        link = espalier_blender.link.current
        for step in range(4):
            if step > 0:
                bpy.ops.espalier.step()
            end = time.monotonic() + 30
            # a background Blender has no timers: the walk is the timer
            while link.step < step and time.monotonic() < end and not link.problem:
                link.show()
                time.sleep(0.01)
            saw["live"].append([link.step, seen("Espalier")])
        bpy.ops.espalier.disconnect()
        saw["problem"] = link.problem
        try:
            bpy.ops.espalier.connect(address=address, token=token, simulation="none")
        except RuntimeError as error:
            saw["errors"]["live"] = str(error)
    bpy.ops.preferences.addon_disable(module="espalier_blender")
    Path(result).write_text(json.dumps(saw), encoding="utf-8")


try:
    main(*sys.argv[sys.argv.index("--") + 1:])
except BaseException:
    import traceback
    traceback.print_exc()
    sys.exit(1)
