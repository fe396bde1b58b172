"""Selects places and flies to them."""
import FreeCAD
import FreeCADGui
from PySide2 import QtCore

from . import document

SHOWN_REL = 0.12  # of the model's diagonal: the height of what is seen around a place
STEEPEST = -0.2   # a surface turned further away than this from the eye is looked at from its own side


class Activated:
    """Gives fields their colours in documents that are opened: FreeCAD 0.20 tells Python only that they become active."""

    def slotActivateDocument(self, doc):
        QtCore.QTimer.singleShot(0, lambda name=doc.Name: self._show(name))  # once it has been read

    def _show(self, name):
        for thing in FreeCAD.getDocument(name).Objects if name in FreeCAD.listDocuments() else []:
            if hasattr(thing, "Deviation"):
                document.show_colours(thing)


def look_at(view, point, height, normal=None):
    """Centres a place, keeps the direction of view where the surface can be seen from it."""
    towards = view.getViewDirection()
    if normal is not None and towards.dot(normal) > STEEPEST:
        towards = -normal
        view.setCameraOrientation(upright(towards))
    camera = view.getCameraNode()
    distance = 2 * height
    camera.position.setValue(*(FreeCAD.Vector(*point) - distance * towards))
    camera.focalDistance.setValue(distance)
    if view.getCameraType() == "Orthographic":
        camera.height.setValue(height)
    view.redraw()


def upright(towards):
    """The rotation of a camera that looks this way with z up where it can be."""
    back = -towards
    up = FreeCAD.Vector(0, 0, 1) if abs(towards.z) < 0.99 else FreeCAD.Vector(0, 1, 0)
    right = up.cross(back).normalize()
    return FreeCAD.Rotation(right, back.cross(right), back, "ZXY")


def go_to(row):
    """Selects what a row is about, and shows it."""
    FreeCADGui.Selection.clearSelection()
    element = row.element or document.nearest_face(row.model, row.at)
    FreeCADGui.Selection.addSelection(row.model.Document.Name, row.model.Name, element)
    for thing, name in row.marks:
        FreeCADGui.Selection.addSelection(thing.Document.Name, thing.Name, name)
    box = document.box_of(row.model)
    height = SHOWN_REL * box.DiagonalLength
    if row.element:
        height = max(height, document.shape_of(row.model).getElement(row.element).BoundBox.DiagonalLength)
    look_at(FreeCADGui.ActiveDocument.ActiveView, row.at, height, document.normal_at(row.model, element, row.at))
