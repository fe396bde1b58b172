"""Runs inside Blender: imports cages, edits and exports them as the JSON file after `--` says; answers in a file beside it."""
import json
import pathlib
import sys

import bmesh
import bpy

from patchwright_cage import cage_mesh


def move(thing, number, by_mm):
    """In edit mode, as a user does."""
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(thing.data)
    edited.verts.ensure_lookup_table()
    for k in range(3):
        edited.verts[number].co[k] += 0.001 * by_mm[k]
    bmesh.update_edit_mesh(thing.data)


def set_crease(thing, v, w, value):
    edited = bmesh.new()
    edited.from_mesh(thing.data)
    layer = edited.edges.layers.crease.verify()
    edge, = [e for e in edited.edges if {x.index for x in e.verts} == {v, w}]
    edge[layer] = value
    edited.to_mesh(thing.data)


def extrude(thing, face):
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    edited = bmesh.from_edit_mesh(thing.data)
    edited.faces.ensure_lookup_table()
    edited.faces[face].select = True
    bmesh.update_edit_mesh(thing.data)
    bpy.ops.mesh.extrude_region_move(TRANSFORM_OT_translate={"value": (0, 0, 0.05)})


def preview(thing, levels):
    """Points of Blender's subdivided mesh, in the file's unit, after this many steps."""
    modifier = next(m for m in thing.modifiers if m.type == "SUBSURF")
    modifier.levels, modifier.use_limit_surface = levels, False
    shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    return [[o + x / thing[cage_mesh.SCALE] for o, x in zip(thing[cage_mesh.ORIGIN], v.co)] for v in shown.vertices]


def play(case):
    answer = {}
    try:
        if "cube" in case:
            bpy.ops.mesh.primitive_cube_add()
        else:
            bpy.ops.patchwright.import_cage(filepath=case["import"])
        thing = bpy.context.active_object
        for edit, *arguments in case.get("edits", []):
            {"move": move, "set_crease": set_crease, "extrude": extrude}[edit](thing, *arguments)
        if "shift_mm" in case:
            thing.location.x += 0.001 * case["shift_mm"]
        if "preview" in case:
            answer["preview"] = preview(thing, case["preview"])
        if "export" in case:
            answer["mode"] = thing.mode
            bpy.ops.patchwright.export_cage(filepath=case["export"])
            answer["mode_after"] = thing.mode
        if thing.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
    except RuntimeError as error:
        answer["error"] = str(error)
    return answer


file = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
file.with_suffix(".answers").write_text(json.dumps([play(case) for case in json.loads(file.read_text())]))
