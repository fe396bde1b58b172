"""Cages as meshes of Blender and back.

Blender keeps single precision and its own creases from 0 to 1. What these cannot hold is beside them, in attributes that follow
edits of the mesh: the rest of each coordinate, and the sharpness in the file's numbers.
"""
import math
import os

import bmesh
import bpy
import numpy

from .cage_file import INFINITE, Cage, CageError

REST, SHARPNESS, CORNER = "patchwright_rest", "patchwright_sharpness", "patchwright_corner"
SECTOR, SECTOR_NORMAL, NAME = "patchwright_sector", "patchwright_sector_normal", "patchwright_name"
PINS = "patchwright pin"
ORIGIN, SCALE, MATRIX, BOUNDARY = "patchwright_origin", "patchwright_scale", "patchwright_matrix", "patchwright_boundary"
CREASE_RULE = "patchwright_crease_rule"
SAME_CREASE = 1e-6  # Blender's creases are single precision
HELD_DIGITS = 13    # of the model's extent: two single-precision numbers hold 48 bits
DOUBLE_DIGITS = 16  # of the largest coordinate: below that a sum in double precision is not exact
BOUNDARY_RULES = {1: "ALL", 2: "PRESERVE_CORNERS"}
PREVIEW_LEVELS = 2


def crease_of(sharpness):
    """Blender subdivides an edge of crease c with the sharpness 10 c²."""
    return math.sqrt(min(max(sharpness, 0.0), INFINITE) / INFINITE)


def sharpness_of(crease, known):
    """What a crease means: the number it came from, unless somebody has changed it since."""
    if abs(crease - crease_of(known)) <= SAME_CREASE:
        return float(str(numpy.float32(known)))
    return INFINITE if crease >= 1.0 else float(str(numpy.float32(INFINITE * crease * crease)))


def to_object(cage, name, scale):
    """A new object of the scene. @param scale  metres of the file's unit"""
    mesh = bpy.data.meshes.new(name)
    low, high = ([pick(p[k] for p in cage.points) for k in range(3)] for pick in (min, max))
    origin = [(a + b) / 2 for a, b in zip(low, high)]
    local = [[scale * (x - o) for x, o in zip(point, origin)] for point in cage.points]
    mesh.from_pydata(local, [], cage.faces)
    if len(mesh.polygons) != len(cage.faces):
        raise CageError(f"{name}: Blender has made {len(mesh.polygons)} of {len(cage.faces)} faces")
    rest = mesh.attributes.new(REST, "FLOAT_VECTOR", "POINT")
    for vertex, point, entry in zip(mesh.vertices, local, rest.data):
        entry.vector = [x - held for x, held in zip(point, vertex.co)]
    _add_names(mesh, cage)
    _add_sectors(mesh, cage)
    _add_creases(mesh, cage)
    thing = bpy.data.objects.new(name, mesh)
    thing.location = [scale * o for o in origin]
    thing[ORIGIN], thing[SCALE], thing[BOUNDARY] = origin, float(scale), cage.boundary_rule
    thing[CREASE_RULE] = cage.crease_rule
    thing[MATRIX] = [x for row in thing.matrix_basis for x in row]
    if cage.pins:
        thing.vertex_groups.new(name=PINS).add(sorted(cage.pins), 1.0, "REPLACE")
    preview = thing.modifiers.new("Limit surface", "SUBSURF")
    preview.levels = preview.render_levels = PREVIEW_LEVELS
    preview.show_in_editmode = True
    preview.boundary_smooth = BOUNDARY_RULES[cage.boundary_rule]
    return thing


def _add_names(mesh, cage):
    """Names of faces are materials, which Blender keeps through every edit; faces without a name have an empty slot."""
    slots = {}
    for polygon, name in zip(mesh.polygons, cage.names):
        if name not in slots and any(cage.names):
            slots[name] = len(slots)
            mesh.materials.append(None if name is None else _material(name))
        polygon.material_index = slots.get(name, 0)


def _material(name):
    for material in bpy.data.materials:
        if material.get(NAME) == name:
            return material
    material = bpy.data.materials.new(name)  # which may get another name: they are short and unique
    material[NAME] = name
    number = len(bpy.data.materials)
    material.diffuse_color = [0.45 + 0.3 * math.cos(2.4 * number + k) for k in (0, 2, 4)] + [1]
    return material


def _add_sectors(mesh, cage):
    if not cage.sectors:
        return
    angles = mesh.attributes.new(SECTOR, "FLOAT", "CORNER").data
    normals = mesh.attributes.new(SECTOR_NORMAL, "FLOAT_VECTOR", "CORNER").data
    for (v, face), (angle, normal) in cage.sectors.items():
        corner = next(i for i in mesh.polygons[face].loop_indices if mesh.loops[i].vertex_index == v)
        angles[corner].value = angle
        normals[corner].vector = normal or (0, 0, 0)


def _layers(elements, name):
    """Blender's creases and the sharpness beside them, as layers of a BMesh."""
    own = elements.layers.crease.verify() if hasattr(elements.layers, "crease") else _float_layer(elements, name[0])
    return own, _float_layer(elements, name[1])


def _float_layer(elements, name):
    return elements.layers.float.get(name) or elements.layers.float.new(name)


EDGES, VERTICES = ("crease_edge", SHARPNESS), ("crease_vert", CORNER)  # the first: from Blender 4.0 on


def _add_creases(mesh, cage):
    editable = bmesh.new()
    editable.from_mesh(mesh)
    # A layer that is added moves the others: first all, then values.
    for elements, names in ((editable.edges, EDGES), (editable.verts, VERTICES)):
        _layers(elements, names)
    crease, sharpness = _layers(editable.edges, EDGES)
    for edge in editable.edges:
        value = cage.creases.get(tuple(sorted(v.index for v in edge.verts)), 0.0)
        edge[crease], edge[sharpness] = crease_of(value), value
    crease, sharpness = _layers(editable.verts, VERTICES)
    for vertex in editable.verts:
        value = cage.corners.get(vertex.index, 0.0)
        vertex[crease], vertex[sharpness] = crease_of(value), value
    editable.to_mesh(mesh)
    editable.free()


def from_object(thing, scale):
    """The cage of an object, without its modifiers. @param scale  for objects that were not imported"""
    mesh = thing.data
    cage = Cage(faces=[list(polygon.vertices) for polygon in mesh.polygons])
    cage.points = _points(thing, thing.get(SCALE, scale))
    cage.names = [_name_of(mesh, polygon) for polygon in mesh.polygons]
    _take_creases(mesh, cage)
    group = thing.vertex_groups.get(PINS)
    if group:
        cage.pins = {v.index for v in mesh.vertices if any(g.group == group.index and g.weight > 0 for g in v.groups)}
    if SECTOR in mesh.attributes:
        _take_sectors(mesh, cage)
    preview = next((m for m in thing.modifiers if m.type == "SUBSURF"), None)
    rules = {kind: rule for rule, kind in BOUNDARY_RULES.items()}
    cage.boundary_rule = rules[preview.boundary_smooth] if preview else int(thing.get(BOUNDARY, 1))
    cage.crease_rule = thing.get(CREASE_RULE, cage.crease_rule)
    return cage


def _points(thing, scale):
    mesh = thing.data
    rest = mesh.attributes.get(REST)
    held = [[x + r for x, r in zip(v.co, rest.data[v.index].vector)] if rest else list(v.co) for v in mesh.vertices]
    matrix = [x for row in thing.matrix_world for x in row]
    if ORIGIN in thing and matrix == list(thing[MATRIX]):
        points = [[o + x / scale for o, x in zip(thing[ORIGIN], point)] for point in held]
    else:
        points = [[(sum(a * x for a, x in zip(row, point)) + row[3]) / scale for row in thing.matrix_world[:3]] for point in held]
    extent = max((max(axis) - min(axis) for axis in zip(*points)), default=0.0)
    largest = max((abs(x) for point in points for x in point), default=0.0)
    decimals = min((digits - math.ceil(math.log10(size)) for digits, size in ((HELD_DIGITS, extent), (DOUBLE_DIGITS, largest))
                    if size > 0), default=0)
    return [[round(x, decimals) for x in point] for point in points]


def _name_of(mesh, polygon):
    material = mesh.materials[polygon.material_index] if polygon.material_index < len(mesh.materials) else None
    return material and material.get(NAME, material.name)


def _take_creases(mesh, cage):
    editable = bmesh.new()
    editable.from_mesh(mesh)
    for elements, names in ((editable.edges, EDGES), (editable.verts, VERTICES)):
        _layers(elements, names)
    crease, sharpness = _layers(editable.edges, EDGES)
    for edge in editable.edges:
        if edge[crease] > 0 and edge.link_faces:
            cage.creases[tuple(sorted(v.index for v in edge.verts))] = sharpness_of(edge[crease], edge[sharpness])
    crease, sharpness = _layers(editable.verts, VERTICES)
    for vertex in editable.verts:
        if vertex[crease] > 0:
            cage.corners[vertex.index] = sharpness_of(vertex[crease], vertex[sharpness])
    editable.free()


def _take_sectors(mesh, cage):
    angles, normals = mesh.attributes[SECTOR].data, mesh.attributes[SECTOR_NORMAL].data
    for polygon in mesh.polygons:
        for i in polygon.loop_indices:
            if angles[i].value != 0.0:
                normal = tuple(float(str(numpy.float32(x))) for x in normals[i].vector)
                cage.sectors[mesh.loops[i].vertex_index, polygon.index] = (
                    float(str(numpy.float32(angles[i].value))), normal if any(normal) else None)


def file_name(file):
    return os.path.splitext(os.path.basename(file))[0]
