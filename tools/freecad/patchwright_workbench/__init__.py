"""A FreeCAD workbench around the program patchwright.

program, results and field know neither FreeCAD nor Qt; document and jobs need FreeCAD without a display; the rest is the interface.
"""
