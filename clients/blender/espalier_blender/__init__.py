"""Espalier in Blender: import of plants and of their growth, and a live link to a running simulation."""

import re
import sys
from pathlib import Path
from typing import Any, List, Set

import bpy
from bpy.app.handlers import persistent
from bpy.props import StringProperty
from bpy_extras.io_utils import ImportHelper

sys.path.insert(0, str(Path(__file__).with_name("packages")))  # the archive brings the Python package espalier of its own version
from espalier import glb  # noqa: E402

from . import link, scene  # noqa: E402

bl_info = {"name": "Espalier", "author": "The Espalier authors", "version": (0, 1, 0), "blender": (3, 4, 0), "category": "Import-Export",
           "location": "File > Import > Espalier; sidebar of the 3D view", "description": "Plants that grow: import, animation, live link"}

STEPS = "espalier_steps"  # custom property of a collection: the first file of a series
FILE = "espalier_file"  # of a collection: the file that it came from, of a series the first


def steps_of(path: Path) -> List[Path]:
    """The files of a series, growth-0000.glb, growth-0001.glb, ..., from one of them. A file without a number is alone, and so are
    variants, which begin with 1."""
    match = re.fullmatch(r"(.*?)(\d+)(\.glb)", path.name)
    if match is None:
        return [path]
    matches = [(re.fullmatch(re.escape(match[1]) + r"(\d+)\.glb", other.name), other) for other in path.parent.glob("*.glb")]
    numbered = {int(same[1]): other for same, other in matches if same}
    return [numbered[number] for number in sorted(numbered)] if 0 in numbered else [path]


def import_file(path: Path) -> str:
    """Shows a file. Of a series the frames of the scene become its steps. Returns the name of the collection: that of the file, with a
    number when a file of another folder has it."""
    files = steps_of(path)
    wanted = scene.short(re.sub(r"-?\d*$", "", path.stem) or path.stem if len(files) > 1 else path.stem, 55)
    file, name, count = str(files[0].resolve()), wanted, 1
    while name in bpy.data.collections and bpy.data.collections[name].get(FILE, file) != file:
        name, count = f"{wanted} {count + 1}", count + 1
    scene.show(glb.read(path.read_bytes()), name)
    collection = bpy.data.collections[name]
    collection[FILE] = file
    collection.pop(STEPS, None)
    if len(files) > 1:
        collection[STEPS] = file
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = 0, len(files) - 1
        show_frame(bpy.context.scene)
    return name


@persistent
def show_frame(at: Any, _graph: Any = None) -> None:
    """Shows the step of the scene's frame, in all collections that were imported as a series."""
    for collection in bpy.data.collections:
        if STEPS in collection:
            files = steps_of(Path(collection[STEPS]))
            if files:
                scene.show(glb.read(files[min(max(at.frame_current, 0), len(files) - 1)].read_bytes()), collection.name)


class ESPALIER_OT_import(bpy.types.Operator, ImportHelper):
    """Import plants (.glb); of a numbered series each step becomes a frame"""
    bl_idname = "espalier.import_glb"
    bl_label = "Import plants of Espalier"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".glb"
    filter_glob: StringProperty(default="*.glb", options={"HIDDEN"})  # type: ignore[valid-type]

    def execute(self, _context: Any) -> Set[str]:
        try:
            import_file(Path(self.filepath))
        except (glb.GlbError, OSError) as error:
            self.report({"ERROR"}, f"{self.filepath}: {error}")
            return {"CANCELLED"}
        return {"FINISHED"}


class ESPALIER_OT_connect(bpy.types.Operator):
    """Follow a simulation on a server"""
    bl_idname = "espalier.connect"
    bl_label = "Connect"
    address: StringProperty(name="Address", default="127.0.0.1:4321")  # type: ignore[valid-type]
    token: StringProperty(name="Token", subtype="PASSWORD", options={"SKIP_SAVE"})  # type: ignore[valid-type]
    simulation: StringProperty(name="Simulation", description="Empty: the newest")  # type: ignore[valid-type]

    def invoke(self, context: Any, _event: Any) -> Any:
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, _context: Any) -> Set[str]:
        try:
            link.open_link(self.address, self.token, self.simulation)
        except Exception as error:  # whatever the connection ends with is for the user
            self.report({"ERROR"}, f"{self.address}: {error}")
            return {"CANCELLED"}
        return {"FINISHED"}


class ESPALIER_OT_disconnect(bpy.types.Operator):
    """End the live link; the plants stay"""
    bl_idname = "espalier.disconnect"
    bl_label = "Disconnect"

    def execute(self, _context: Any) -> Set[str]:
        link.close_link()
        return {"FINISHED"}


class ESPALIER_OT_step(bpy.types.Operator):
    """Make one step of the simulation"""
    bl_idname = "espalier.step"
    bl_label = "Step"

    @classmethod
    def poll(cls, _context: Any) -> bool:
        return link.current is not None

    def execute(self, _context: Any) -> Set[str]:
        try:
            link.current.simulation.step()
        except Exception as error:  # as a model that fails
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class ESPALIER_PT_link(bpy.types.Panel):
    bl_label = "Espalier"
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "Espalier"

    def draw(self, _context: Any) -> None:
        now = link.current
        if now is None:
            self.layout.operator("espalier.connect")
            return
        self.layout.label(text=now.problem or f"step {now.step}")
        self.layout.operator("espalier.step")
        self.layout.operator("espalier.disconnect")


CLASSES = (ESPALIER_OT_import, ESPALIER_OT_connect, ESPALIER_OT_disconnect, ESPALIER_OT_step, ESPALIER_PT_link)


def _menu(self: Any, _context: Any) -> None:
    self.layout.operator("espalier.import_glb", text="Espalier (.glb)")


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.TOPBAR_MT_file_import.append(_menu)
    bpy.app.handlers.frame_change_post.append(show_frame)


def unregister() -> None:
    link.close_link()
    bpy.app.handlers.frame_change_post.remove(show_frame)
    bpy.types.TOPBAR_MT_file_import.remove(_menu)
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
