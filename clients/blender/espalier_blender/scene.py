"""Puts plants into a scene of Blender, and brings them up to date: one object for each plant, one mesh for each repeated organ."""

import hashlib
from typing import Any, Dict, List

import bpy
import numpy as np
from espalier import glb
from mathutils import Matrix

PLANT = "espalier_plant"  # custom property of objects: name of the plant
ORGAN = "espalier_organ"  # of copies of an organ: its name and number
LOOK = "espalier_look"  # of materials: what they were made from
TURN = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=np.float64)  # from y up, as in glTF, to z up


def short(name: str, most: int = 63) -> str:
    """A name that Blender keeps whole: it cuts names behind 63 bytes, and two long ones would become one."""
    content = name.encode("utf-8")
    if len(content) <= most:
        return name
    return content[:most - 9].decode("utf-8", "ignore") + " " + hashlib.sha256(content).hexdigest()[:8]


def show(scene: glb.Scene, name: str = "Espalier") -> List[Any]:
    """Shows the plants in the collection `name`. Objects that are there stay the same objects, with their modifiers, and get new
    meshes; plants that are gone are removed. Returns the objects of the plants."""
    collection = bpy.data.collections.get(name)
    if collection is None:
        collection = bpy.data.collections.new(name)
        bpy.context.scene.collection.children.link(collection)
    materials = [_material(material, name) for material in scene.materials]
    there = {thing[PLANT]: thing for thing in collection.objects if PLANT in thing and ORGAN not in thing}
    made = []
    for plant in scene.plants:
        thing = there.pop(plant.name, None)
        if thing is None:
            thing = bpy.data.objects.new(plant.name, bpy.data.meshes.new(plant.name))
            thing[PLANT] = plant.name
            collection.objects.link(thing)
        _fill(thing.data, plant.mesh, materials)
        _show_organs(collection, thing, plant, materials)
        made.append(thing)
    for thing in there.values():
        for organ in list(thing.children):
            _remove(organ)
        _remove(thing)
    return made


def _show_organs(collection: Any, parent: Any, plant: glb.Plant, materials: List[Any]) -> None:
    """An object for each copy; the copies of an organ share one mesh."""
    there: Dict[str, Any] = {thing[ORGAN]: thing for thing in parent.children if ORGAN in thing}
    for number, organ in enumerate(plant.instances):
        key = f"{number} {organ.name}"
        mesh_name = short(f"{collection.name} {plant.name} {key}")
        mesh = bpy.data.meshes.get(mesh_name) or bpy.data.meshes.new(mesh_name)
        _fill(mesh, organ.mesh, materials)
        for copy, place in enumerate(organ.places):
            thing = there.pop(f"{key} {copy}", None)
            if thing is None:
                thing = bpy.data.objects.new(organ.name, mesh)
                thing[PLANT], thing[ORGAN] = plant.name, f"{key} {copy}"
                thing.parent = parent
                collection.objects.link(thing)
            thing.data = mesh
            thing.matrix_local = Matrix((TURN @ place @ TURN.T).tolist())
    for thing in there.values():
        _remove(thing)


def _remove(thing: Any) -> None:
    mesh = thing.data
    bpy.data.objects.remove(thing)
    if mesh is not None and mesh.users == 0:
        bpy.data.meshes.remove(mesh)


def _fill(mesh: Any, source: glb.Mesh, materials: List[Any]) -> None:
    """Replaces vertices, faces, texture coordinates and materials of a mesh."""
    mesh.clear_geometry()
    count = len(source.triangles)
    mesh.vertices.add(len(source.places))
    turn = TURN[:3, :3].T
    mesh.vertices.foreach_set("co", (source.places @ turn).astype(np.float32).ravel())
    mesh.loops.add(3 * count)
    corners = source.triangles.ravel()
    mesh.loops.foreach_set("vertex_index", corners.astype(np.int32))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(count, 3, dtype=np.int32))
    # a mesh holds only the materials that it wears
    worn, slots = np.unique(source.materials, return_inverse=True)
    mesh.materials.clear()
    for number in worn:
        mesh.materials.append(materials[number])
    mesh.polygons.foreach_set("material_index", slots.astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(count, dtype=bool))
    if source.coordinates is not None:
        layer = mesh.uv_layers.get("UVMap") or mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", source.coordinates[corners].astype(np.float32).ravel())
    mesh.update(calc_edges=True)
    if source.normals is not None and count:
        if hasattr(mesh, "use_auto_smooth"):  # before Blender 4.1
            mesh.use_auto_smooth = True
        mesh.normals_split_custom_set_from_vertices((source.normals @ turn).astype(np.float32).tolist())


def _material(source: glb.Material, owner: str) -> Any:
    """The material of a name; it is made again only when the model's has changed, so changes of the user stay."""
    name = short(f"{owner} {source.name}")
    picture = "" if source.picture is None else hashlib.sha256(source.picture).hexdigest()
    look = repr((source.colour, source.roughness, source.is_masked, picture))
    material = bpy.data.materials.get(name) or bpy.data.materials.new(name)
    if material.get(LOOK) == look:
        return material
    material[LOOK] = look
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    surface = nodes.new("ShaderNodeBsdfPrincipled")
    links.new(surface.outputs["BSDF"], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    surface.inputs["Base Color"].default_value = source.colour
    surface.inputs["Roughness"].default_value = source.roughness
    surface.inputs["Alpha"].default_value = source.colour[3]
    material.diffuse_color = source.colour
    if source.is_masked:
        material.blend_method = "CLIP"
    if source.picture is not None:
        image = nodes.new("ShaderNodeTexImage")
        image.image = _image(source.picture, picture)
        colour = nodes.new("ShaderNodeMixRGB")
        colour.blend_type = "MULTIPLY"
        colour.inputs["Fac"].default_value = 1.0
        colour.inputs["Color2"].default_value = source.colour
        links.new(image.outputs["Color"], colour.inputs["Color1"])
        links.new(colour.outputs["Color"], surface.inputs["Base Color"])
        links.new(image.outputs["Alpha"], surface.inputs["Alpha"])
    return material


def _image(content: bytes, digest: str) -> Any:
    """A picture, packed into the .blend file; equal pictures are there once."""
    name = f"Espalier {digest[:16]}"
    if name in bpy.data.images:
        return bpy.data.images[name]
    image = bpy.data.images.new(name, 1, 1)
    image.source = "FILE"
    image.pack(data=content, data_len=len(content))
    return image
