"""Runs inside FreeCAD's window: clicks through the three commands. PATCHWRIGHT_GUI_TEST names a folder for pictures and result.json.

It prints nothing that counts: gui_test.py reads result.json and the pictures.
"""
import json
import os
import pathlib
import time
import traceback

import FreeCAD
import FreeCADGui
from PySide2 import QtCore, QtGui, QtWidgets

FOLDER = pathlib.Path(os.environ["PATCHWRIGHT_GUI_TEST"])
WING = pathlib.Path(os.environ["PATCHWRIGHT_GUI_WING"])
LONGEST_WAIT_S = 120
STEP_MS = 150
SMALLEST = 0  # of Qt's PNG
SIZE = (1120, 740)


def window():
    return FreeCADGui.getMainWindow()


def find(kind, name, parent=None):
    """The widget of this name that can be seen."""
    found = [w for w in (parent or window()).findChildren(kind, name) if w.isVisible()]
    assert len(found) == 1, (name, len(found))
    return found[0]


def click(widget, at=None):
    at = at or widget.rect().center()
    for kind, buttons in ((QtCore.QEvent.MouseButtonPress, QtCore.Qt.LeftButton), (QtCore.QEvent.MouseButtonRelease, QtCore.Qt.NoButton)):
        event = QtGui.QMouseEvent(kind, at, widget.mapToGlobal(at), QtCore.Qt.LeftButton, buttons, QtCore.Qt.NoModifier)
        QtWidgets.QApplication.sendEvent(widget, event)


def command(text):
    """The button in the toolbar."""
    return next(b for b in window().findChildren(QtWidgets.QToolButton) if b.isVisible() and b.text().startswith(text))


def click_button(name):
    click(find(QtWidgets.QPushButton, name))


def click_close():
    click(next(b for b in window().findChildren(QtWidgets.QPushButton) if b.isVisible() and b.text().strip("&") == "Close"))


def write(name, text):
    edit = find(QtWidgets.QLineEdit, name)
    edit.setText(text)
    edit.setModified(True)


def verdict():
    return find(QtWidgets.QLabel, "verdict").text()


def ended():
    return find(QtWidgets.QPushButton, "start").isEnabled()


def rows():
    tree = find(QtWidgets.QTreeWidget, "places")
    return [(tree.topLevelItem(i).text(0), tree.topLevelItem(i).text(1)) for i in range(tree.topLevelItemCount())]


def click_row(number):
    tree = find(QtWidgets.QTreeWidget, "places")
    tree.scrollToItem(tree.topLevelItem(number))
    click(tree.viewport(), tree.visualItemRect(tree.topLevelItem(number)).center())


def selected():
    return [(s.Object.Label, list(s.SubElementNames)) for s in FreeCADGui.Selection.getSelectionEx()]


def camera_height():
    return FreeCADGui.ActiveDocument.ActiveView.getCameraNode().height.getValue()


def idle():
    """Waits for what was put off until the window has nothing else to do, as the colours of opened documents: timers of 0 ms, in their order."""
    passed = []
    QtCore.QTimer.singleShot(0, lambda: passed.append(True))
    return lambda: passed


def picture(name):
    QtWidgets.QApplication.processEvents()
    image = QtGui.QGuiApplication.primaryScreen().grabWindow(window().winId()).toImage()
    image.convertToFormat(QtGui.QImage.Format_RGB555).save(str(FOLDER / (name + ".png")), "PNG", SMALLEST)  # 5 bits a colour: half the size


def colours_shown(thing):
    """Shares of blue and of red among the pixels that an object covers, seen from above."""
    view = FreeCADGui.ActiveDocument.ActiveView
    shown = [t for t in FreeCAD.ActiveDocument.Objects if t.Visibility]
    for other in shown:
        other.Visibility = thing in other.OutList
    thing.Visibility = True
    view.viewTop()
    view.fitAll()
    view.saveImage(str(FOLDER / "field.png"), 200, 200, "Black")
    for other in sorted(FreeCAD.ActiveDocument.Objects, key=lambda t: not hasattr(t, "Group")):  # groups change what is in them
        other.Visibility = other in shown
    image = QtGui.QImage(str(FOLDER / "field.png"))
    pixels = [image.pixelColor(x, y).getRgb()[:3] for x in range(200) for y in range(200)]
    drawn = [p for p in pixels if max(p) > 25]
    return [sum(p[main] > 1.4 * p[other] for p in drawn) / len(drawn) for main, other in ((2, 0), (0, 2))]


def clicks(result):
    """Yields what to wait for: a function, or None for the next turn."""
    FreeCADGui.activateWorkbench("PatchwrightWorkbench")
    for dock in window().findChildren(QtWidgets.QDockWidget):
        if dock.objectName() in ("Python console", "Report view"):
            dock.hide()
    for bar in window().findChildren(QtWidgets.QToolBar):
        if bar.objectName() in ("Macro", "Structure"):
            bar.hide()
    window().resize(*SIZE)
    yield None
    step = FOLDER / "wing.step"
    yield command("Convert").isEnabled
    click(command("Convert"))
    yield None
    write("inputFile", str(WING))
    result["proposed"] = find(QtWidgets.QLineEdit, "output").text()
    write("output", str(step))
    write("tolerance", "1e-3rel")
    click_button("start")
    assert not ended() and find(QtWidgets.QPushButton, "cancel").isEnabled()
    stages = result["stages"] = []

    def converted():
        stage = find(QtWidgets.QLabel, "stage").text().split(",")[0]
        if stage and stage not in stages:
            stages.append(stage)
        return ended()
    yield converted
    yield None
    result["convert"] = {"verdict": verdict(), "rows": rows(), "height": camera_height(),
                         "tree": [[t.Label, [c.Label for c in getattr(t, "Group", [])]] for t in FreeCAD.ActiveDocument.Objects if hasattr(t, "Group")]}
    picture("convert")
    click_row(0)
    yield None
    result["place"] = {"selected": selected(), "height": camera_height()}
    picture("place")

    write("tolerance", "1e-8rel")
    write("output", str(FOLDER / "cancelled.step"))
    click_button("start")
    yield lambda: find(QtWidgets.QLabel, "stage").text().startswith("fit")
    click_button("cancel")
    yield ended
    result["cancel"] = verdict()
    click_close()
    yield None

    yield command("Compare").isEnabled
    click(command("Compare"))
    yield None
    for name, text in (("a", "A file:"), ("b", "wing")):
        box = find(QtWidgets.QComboBox, name)
        box.setCurrentIndex(box.findText(text))
    yield None
    write("aFile", str(WING))
    write("tolerance", "2e-5rel")
    click_button("start")
    yield ended
    yield None
    result["compare"] = {"verdict": verdict(), "rows": rows(), "visible": [t.Label for t in FreeCAD.ActiveDocument.Objects if t.Visibility]}
    picture("compare")
    fields = [t for t in FreeCAD.ActiveDocument.Objects if t.TypeId == "Mesh::Feature"]
    result["colours"] = [colours_shown(field) for field in fields]
    click_close()
    yield None

    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(next(t for t in FreeCAD.ActiveDocument.Objects if t.Label == "wing"))
    yield command("Inspect").isEnabled
    click(command("Inspect"))
    yield None
    result["preselected"] = find(QtWidgets.QComboBox, "input").currentText()
    click_button("start")
    yield ended
    yield None
    all_rows = rows()
    click_row(next(i for i, (what, _) in enumerate(all_rows) if "/root/" in what))
    yield None
    result["inspect"] = {"verdict": verdict(), "rows": all_rows, "selected": selected()}
    picture("inspect")
    click_close()
    yield None

    result["colours"] += [colours_shown(fields[1])]
    FreeCAD.ActiveDocument.saveAs(str(FOLDER / "wing.FCStd"))
    name = fields[1].Name
    FreeCAD.closeDocument(FreeCAD.ActiveDocument.Name)
    FreeCAD.openDocument(str(FOLDER / "wing.FCStd"))
    yield idle()
    result["colours"] += [colours_shown(FreeCAD.ActiveDocument.getObject(name))]

    QtCore.QTimer.singleShot(0, lambda: FreeCADGui.runCommand("Std_DlgPreferences", 0))
    yield lambda: QtWidgets.QApplication.activeModalWidget() is not None
    dialog = QtWidgets.QApplication.activeModalWidget()
    groups = dialog.findChild(QtWidgets.QListWidget, "listBox")
    groups.setCurrentItem(groups.findItems("Patchwright", QtCore.Qt.MatchExactly)[0])
    yield None
    result["preferences"] = find(QtWidgets.QWidget, "program", dialog).property("fileName")
    dialog.grab().save(str(FOLDER / "preferences.png"))
    dialog.reject()
    yield None


class Player(QtCore.QObject):
    def __init__(self):
        super().__init__()
        self.result, self.wait, self.since = {}, None, time.monotonic()
        self.clicks = clicks(self.result)
        self.timer = QtCore.QTimer(interval=STEP_MS)
        self.timer.timeout.connect(self.turn)
        self.timer.start()

    def turn(self):
        try:
            if self.wait is not None and not self.wait():
                assert time.monotonic() < self.since + LONGEST_WAIT_S, "waited too long"
                return
            self.wait, self.since = next(self.clicks), time.monotonic()
        except StopIteration:
            self.end()
        except Exception:
            self.result["error"] = traceback.format_exc()
            picture("error")
            self.end()

    def end(self):
        (FOLDER / "result.json").write_text(json.dumps(self.result, indent=1))
        os._exit(0)


player = Player()
