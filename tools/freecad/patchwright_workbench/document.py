"""Models, patches, fields and places as objects of a FreeCAD document. Needs no display, and colours only where there is one."""
import math
import os
import re

import FreeCAD
import Mesh
import Part

from . import field, results

GAP_REL = 0.15  # between a model and its field, of the model's extent that way
POINT_SIZE = 9  # pixels
SMOOTH_DEG = 30  # triangles of a field that meet below this are shaded as one


def is_model(thing):
    """Whether an object has what patchwright can read."""
    if thing.isDerivedFrom("Mesh::Feature"):
        return thing.Mesh.CountFacets > 0
    return thing.isDerivedFrom("Part::Feature") and not thing.Shape.isNull() and bool(thing.Shape.Faces)


def models(document):
    """What can be chosen as an input: not the fields and single patches that this workbench has added, nor the steps of a body."""
    return [thing for thing in document.Objects if is_model(thing) and not hasattr(thing, "Deviation")
            and not any(hasattr(user, "PatchesOf") or user.TypeId == "PartDesign::Body" for user in thing.InList)]


def shape_of(thing):
    """Where it stands in the document: objects in parts have a shape of their part."""
    shape = thing.Shape.copy()
    shape.Placement = _container(thing) * shape.Placement
    return shape


def mesh_of(thing):
    mesh = thing.Mesh.copy()
    mesh.Placement = _container(thing) * mesh.Placement
    return mesh


def _container(thing):
    return thing.getGlobalPlacement() * thing.Placement.inverse()


def export(thing, folder):
    """Writes an object of the document for patchwright: CAD as STEP, triangles as STL, both in millimetres."""
    name = re.sub(r"[^\w.-]+", "_", thing.Label).strip("._") or "model"
    if hasattr(thing, "Shape"):
        file = os.path.join(folder, name + ".step")
        shape_of(thing).exportStep(file)
    else:
        file = os.path.join(folder, name + ".stl")
        mesh_of(thing).write(file)
    return file


def is_triangles(file):
    return os.path.splitext(file)[1].lower() in (".stl", ".obj")


def add_group(document, label, report):
    group = document.addObject("App::DocumentObjectGroup", "Patchwright")
    group.Label = label
    group.addProperty("App::PropertyString", "Verdict", "Patchwright", "What the program said")
    group.Verdict = report.sentence()
    return group


def hide_earlier(document, group):
    """Fields and places of earlier results, which would lie over those of this one."""
    for other in document.Objects:
        if hasattr(other, "Verdict") and other != group:
            for thing in other.Group:
                if hasattr(thing, "Deviation") or hasattr(thing, "PlacesOf"):
                    thing.Visibility = False


def add_model(document, group, file, label, millimetres=1.0):
    """A CAD file as one object, which knows the names of its faces; triangles as a mesh.
    @param millimetres  those of the numbers of files that have no unit"""
    if is_triangles(file):
        thing = document.addObject("Mesh::Feature", "Model")
        mesh = Mesh.Mesh(file)
        matrix = FreeCAD.Matrix()
        matrix.scale(millimetres, millimetres, millimetres)
        mesh.transform(matrix)
        thing.Mesh = mesh
    else:
        thing = document.addObject("Part::Feature", "Model")
        thing.Shape = Part.read(file)
        set_patch_names(thing, names_in(file, thing.Shape))
    thing.Label = label
    group.addObject(thing)
    return thing


def names_in(file, shape):
    """Names of the faces of a STEP file as FreeCAD has read it; none where it has made other faces."""
    if os.path.splitext(file)[1].lower() not in (".step", ".stp"):
        return []
    with open(file, encoding="latin-1") as stream:
        names = results.patch_names(stream.read())
    return names if len(names) == len(shape.Faces) else []


def set_patch_names(thing, names):
    if not hasattr(thing, "PatchNames"):
        thing.addProperty("App::PropertyStringList", "PatchNames", "Patchwright", "Names of the faces")
    thing.PatchNames = names


def patch_name(thing, number):
    names = getattr(thing, "PatchNames", [])
    return names[number] if number < len(names) and names[number] else f"patch {number}"


def add_patches(document, group, solid):
    """Each patch as an object of its own, hidden, so that it can be shown, measured or exported alone."""
    patches = document.addObject("App::DocumentObjectGroup", "Patches")
    patches.Label = f"{len(solid.Shape.Faces)} patches"
    patches.addProperty("App::PropertyLinkHidden", "PatchesOf", "Patchwright", "The model")
    patches.PatchesOf = solid
    group.addObject(patches)
    for number, face in enumerate(solid.Shape.Faces):
        patch = document.addObject("Part::Feature", "Patch")
        patch.Label = patch_name(solid, number)
        patch.Shape = face
        patch.Visibility = False
        patches.addObject(patch)
    return patches


def beside(box):
    """Where a copy of what is in this box stands next to it: along the shorter horizontal side."""
    if box.XLength < box.YLength:
        return FreeCAD.Vector((1 + GAP_REL) * box.XLength, 0, 0)
    return FreeCAD.Vector(0, (1 + GAP_REL) * box.YLength, 0)


def add_field(document, group, measured, scale_mm, box):
    """The deviation as a mesh with colours of vertices, beside the model."""
    thing = document.addObject("Mesh::Feature", "Deviation")
    mesh = Mesh.Mesh()
    mesh.addFacets(([FreeCAD.Vector(*p) for p in measured.points], measured.triangles))
    thing.Mesh = mesh
    thing.Label = f"Deviation, blue 0 to red {scale_mm:.3g} mm"
    thing.addProperty("App::PropertyFloatList", "Deviation", "Patchwright", "At the vertices, millimetres")
    thing.Deviation = measured.deviation
    thing.addProperty("App::PropertyColorList", "VertexColors", "Patchwright", "Of the deviation")
    thing.VertexColors = [field.colour(d / scale_mm) for d in measured.deviation]
    thing.Placement.Base = beside(box)
    group.addObject(thing)
    document.recompute()  # takes the colours away, and later ones leave the mesh alone
    if thing.ViewObject:
        thing.ViewObject.CreaseAngle = SMOOTH_DEG
        show_colours(thing)
    return thing


def show_colours(thing):
    """Of a field's vertices; also after a file is opened, when FreeCAD says that they are on and shows none."""
    thing.ViewObject.Coloring = False
    thing.ViewObject.Coloring = True


def add_places(document, group, model, places):
    """All places as one object; place number i is its vertex i + 1."""
    thing = document.addObject("Part::Feature", "Places")
    thing.Shape = Part.makeCompound([Part.Vertex(*place.at) for place in places])
    thing.Label = "Worst places"
    thing.addProperty("App::PropertyLinkHidden", "PlacesOf", "Patchwright", "The model")
    thing.PlacesOf = model
    if thing.ViewObject:
        thing.ViewObject.PointSize = POINT_SIZE
        thing.ViewObject.PointColor = (0.85, 0.0, 0.0)
    group.addObject(thing)
    return thing


def face_colour(number):
    """Of neighbouring numbers far apart: hues by the golden angle, as in the program's reports."""
    hue, lightness = 6 * (number * 0.61803398875 % 1), 0.5 + 0.14 * (number % 3)
    chroma = 0.45 * (1 - abs(2 * lightness - 1))

    def channel(offset):
        place = (hue + offset) % 6
        return lightness + chroma * (min(max(min(place, 4 - place), 0), 1) - 0.5)
    return channel(2), channel(0), channel(4)


def colour_patches(solid):
    if solid.ViewObject and hasattr(solid, "Shape"):
        solid.ViewObject.DiffuseColor = [face_colour(number) for number in range(len(solid.Shape.Faces))]


def nearest_face(thing, point):
    """Name of the face of an object that a point is on or next to; empty for meshes."""
    if not hasattr(thing, "Shape"):
        return ""
    shape = shape_of(thing)
    _, _, ((kind, number, *_), *_) = shape.distToShape(Part.Vertex(*point))
    if kind == "Face":
        return f"Face{number + 1}"
    element = (shape.Edges if kind == "Edge" else shape.Vertexes)[number]
    beside_it = next(i for i, face in enumerate(shape.Faces) if any(element.isSame(other) for other in face.Edges + face.Vertexes))
    return f"Face{beside_it + 1}"


def box_of(thing):
    return shape_of(thing).BoundBox if hasattr(thing, "Shape") else mesh_of(thing).BoundBox


def describe_patch(face):
    """Kind, size in control points and area of a face."""
    surface = face.Surface
    area = f"{face.Area:.4g} mm²"
    if surface.TypeId == "Part::GeomBSplineSurface":
        return f"B-spline {surface.UDegree}x{surface.VDegree}, {surface.NbUPoles} x {surface.NbVPoles} control points, {area}"
    return f"{surface.TypeId.removeprefix('Part::Geom').lower()}, {area}"


def normal_at(thing, name, point):
    """The unit normal of a face next to a point; None where there is none."""
    if not name:
        return None
    face = shape_of(thing).getElement(name)
    normal = face.normalAt(*face.Surface.parameter(FreeCAD.Vector(*point)))
    return normal if math.isfinite(normal.Length) and normal.Length > 0 else None
