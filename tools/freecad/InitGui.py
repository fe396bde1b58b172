import FreeCAD
import FreeCADGui

from patchwright_workbench import view


class PatchwrightWorkbench(FreeCADGui.Workbench):
    """FreeCAD runs this file without a name of its own: what methods need they import themselves."""

    def __init__(self):
        from patchwright_workbench import preferences

        self.__class__.MenuText = "Patchwright"
        self.__class__.ToolTip = "CAD to few smooth B-spline patches, compared and inspected"
        self.__class__.Icon = preferences.icon("Patchwright")
        FreeCADGui.addIconPath(preferences.ICONS)
        FreeCADGui.addPreferencePage(preferences.PAGE, "Patchwright")

    def Initialize(self):
        from patchwright_workbench import commands

        names = commands.add_commands()
        self.appendToolbar("Patchwright", names)
        self.appendMenu("&Patchwright", names)

    def GetClassName(self):
        return "Gui::PythonWorkbench"


FreeCADGui.addWorkbench(PatchwrightWorkbench())
FreeCAD.addDocumentObserver(view.Activated())
