"""What the user prefers, as FreeCAD keeps it; preferences.ui shows the same entries."""
import os

import FreeCAD

FOLDER = os.path.dirname(__file__)
ICONS = os.path.join(FOLDER, "icons")
PAGE = os.path.join(FOLDER, "preferences.ui")


def icon(name):
    return os.path.join(ICONS, name + ".svg")


def _group():
    return FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Mod/Patchwright")


def program():
    """Path or name of the program; empty: patchwright on the path of commands."""
    return _group().GetString("Program", "")


def tolerance():
    return _group().GetString("Tolerance", "1e-4rel")


def time_limit():
    """seconds"""
    return _group().GetInt("TimeLimit", 60)


def most_patches():
    """Above this many, patches have no objects of their own: FreeCAD's tree becomes slow."""
    return _group().GetInt("MostPatches", 500)
