"""The workbench's commands."""
import FreeCADGui

from . import panels, preferences


class Command:
    def __init__(self, panel, text, tip):
        self._panel, self._text, self._tip = panel, text, tip

    def GetResources(self):
        return {"MenuText": self._text, "ToolTip": self._tip, "Pixmap": preferences.icon(self.name)}

    @property
    def name(self):
        return "Patchwright_" + self._panel.__name__.removesuffix("Panel")

    def IsActive(self):
        return FreeCADGui.Control.activeDialog() is False

    def Activated(self):
        FreeCADGui.Control.showDialog(self._panel())


def add_commands():
    commands = [
        Command(panels.ConvertPanel, "Convert to patches…", "One watertight solid of few smooth patches from CAD or triangles"),
        Command(panels.ComparePanel, "Compare…", "How far two models are from each other, both ways"),
        Command(panels.InspectPanel, "Inspect patches…", "Patches of a model, whether it is closed and valid, its worst places"),
    ]
    for command in commands:
        FreeCADGui.addCommand(command.name, command)
    return [command.name for command in commands]
