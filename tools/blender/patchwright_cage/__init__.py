"""Blender add-on: cages of patchwright in and out, with creases, corners, names of faces, pins and sectors."""
import bpy
from bpy.props import EnumProperty, StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from . import cage_file, cage_mesh

bl_info = {
    "name": "Patchwright cages",
    "description": "Import and export control meshes (OBJ) with creases and corners",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "File > Import-Export",
    "category": "Import-Export",
}
METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254, "ft": 0.3048}


def unit_property(description):
    return EnumProperty(name="Unit", description=description, items=[(unit, unit, "") for unit in METRES], default="mm")


class ImportCage(bpy.types.Operator, ImportHelper):
    """Import a control mesh: quads and polygons with creases, corners and names of faces"""

    bl_idname = "patchwright.import_cage"
    bl_label = "Import cage"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".obj"
    filter_glob: StringProperty(default="*.obj", options={"HIDDEN"})
    unit: unit_property("Of the file's numbers; Blender's are metres")

    def execute(self, context):
        try:
            cage = cage_file.read_cage(self.filepath)
            thing = cage_mesh.to_object(cage, cage_mesh.file_name(self.filepath), METRES[self.unit])
        except (OSError, cage_file.CageError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        context.collection.objects.link(thing)
        for other in context.selected_objects:
            other.select_set(False)
        thing.select_set(True)
        context.view_layer.objects.active = thing
        self.report({"INFO"}, f"{len(cage.faces)} faces, {len(cage.creases)} creases, {len(cage.corners)} corners")
        return {"FINISHED"}


class ExportCage(bpy.types.Operator, ExportHelper):
    """Export the active mesh as a control mesh, without its modifiers"""

    bl_idname = "patchwright.export_cage"
    bl_label = "Export cage"
    filename_ext = ".obj"
    filter_glob: StringProperty(default="*.obj", options={"HIDDEN"})
    unit: unit_property("Of the file's numbers, for objects that were not imported as cages; those keep theirs")

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.type == "MESH"

    def execute(self, context):
        mode = context.active_object.mode
        if mode != "OBJECT":  # attributes can be read in no other
            bpy.ops.object.mode_set(mode="OBJECT")
        context.view_layer.update()
        try:
            cage = cage_mesh.from_object(context.active_object, METRES[self.unit])
            cage_file.write_cage(cage, self.filepath)
        except OSError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            if mode != "OBJECT":
                bpy.ops.object.mode_set(mode=mode)
        self.report({"INFO"}, f"{len(cage.faces)} faces, {len(cage.creases)} creases, {len(cage.corners)} corners")
        return {"FINISHED"}


def draw_import(menu, _):
    menu.layout.operator(ImportCage.bl_idname, text="Patchwright cage (.obj)")


def draw_export(menu, _):
    menu.layout.operator(ExportCage.bl_idname, text="Patchwright cage (.obj)")


def register():
    for kind in (ImportCage, ExportCage):
        bpy.utils.register_class(kind)
    bpy.types.TOPBAR_MT_file_import.append(draw_import)
    bpy.types.TOPBAR_MT_file_export.append(draw_export)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(draw_export)
    bpy.types.TOPBAR_MT_file_import.remove(draw_import)
    for kind in (ExportCage, ImportCage):
        bpy.utils.unregister_class(kind)
