"""Task panels of the three commands: input, progress, cancel, verdict, places."""
import os
import shutil
import tempfile

import FreeCAD
import FreeCADGui
from PySide2 import QtCore, QtGui, QtWidgets

from . import document, jobs, preferences, view
from .program import CANCELLED, ProgramError, Run, find_program

POLL_MS = 100
FILES = "Models (*.step *.stp *.igs *.iges *.brep *.stl *.obj)"
OUTPUTS = "CAD (*.step *.stp *.igs *.iges *.brep)"
GOOD, BAD, BUSY = "#1a7f37", "#c62828", "#555555"


class FileEdit(QtWidgets.QWidget):
    """A file's name with a button that asks for it."""

    def __init__(self, name, filters, saves=False):
        super().__init__()
        self.edit = QtWidgets.QLineEdit(objectName=name)
        self._filters, self._saves = filters, saves
        button = QtWidgets.QPushButton("…", clicked=self._choose)
        button.setFixedWidth(28)
        layout = QtWidgets.QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.edit)
        layout.addWidget(button)

    def _choose(self):
        ask = QtWidgets.QFileDialog.getSaveFileName if self._saves else QtWidgets.QFileDialog.getOpenFileName
        file, _ = ask(self, "Patchwright", self.edit.text(), self._filters)
        if file:
            self.edit.setText(file)


class SourceEdit(QtWidgets.QWidget):
    """A model of the document, or a file."""

    changed = QtCore.Signal()

    def __init__(self, name, selected=None):
        super().__init__()
        doc = FreeCAD.ActiveDocument
        self.things = document.models(doc) if doc else []
        self.box = QtWidgets.QComboBox(objectName=name, minimumContentsLength=10)
        self.box.setSizeAdjustPolicy(QtWidgets.QComboBox.AdjustToMinimumContentsLengthWithIcon)
        self.box.addItems([t.Label for t in self.things] + ["A file:"])
        self.file = FileEdit(name + "File", FILES)
        layout = QtWidgets.QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.box)
        layout.addWidget(self.file)
        self.box.setCurrentIndex(self.things.index(selected) if selected in self.things else len(self.things))
        self.box.currentIndexChanged.connect(self._show_file)
        self.file.edit.textChanged.connect(self.changed)
        self._show_file()

    def _show_file(self):
        self.file.setVisible(self.box.currentIndex() == len(self.things))
        self.changed.emit()

    def source(self):
        if self.box.currentIndex() < len(self.things):
            return jobs.Source(thing=self.things[self.box.currentIndex()])
        return jobs.Source(file=self.file.edit.text().strip())


class Panel:
    """Runs a job that `job` describes. FreeCAD asks for `form`, and calls `reject` at the end."""

    title = ""

    def __init__(self):
        self.form = QtWidgets.QWidget()
        self.form.setWindowTitle(self.title)
        self.form.setWindowIcon(QtGui.QIcon(preferences.icon("Patchwright")))
        layout = QtWidgets.QVBoxLayout(self.form)
        self.fields = QtWidgets.QFormLayout()
        layout.addLayout(self.fields)
        self.run = self.folder = self.current_job = self.shown = None
        self.start_button = QtWidgets.QPushButton("Start", objectName="start", clicked=self.start)
        self.cancel_button = QtWidgets.QPushButton("Cancel", objectName="cancel", clicked=self.cancel, enabled=False)
        buttons = QtWidgets.QHBoxLayout()
        buttons.addWidget(self.start_button)
        buttons.addWidget(self.cancel_button)
        layout.addLayout(buttons)
        self.bar = QtWidgets.QProgressBar(objectName="bar")
        self.stage = QtWidgets.QLabel(objectName="stage")
        self.verdict = QtWidgets.QLabel(objectName="verdict", wordWrap=True)
        self.verdict.setTextInteractionFlags(QtCore.Qt.TextSelectableByMouse)
        self.list = QtWidgets.QTreeWidget(objectName="places", rootIsDecorated=False)
        self.list.setHeaderLabels(["What", "Value"])
        self.list.setMinimumHeight(220)
        self.list.itemClicked.connect(lambda item, _: view.go_to(self.shown.rows[self.list.indexOfTopLevelItem(item)]))
        for widget in (self.bar, self.stage, self.verdict, self.list):
            layout.addWidget(widget)
        self.timer = QtCore.QTimer(interval=POLL_MS)
        self.timer.timeout.connect(self._poll)
        QtWidgets.QApplication.instance().aboutToQuit.connect(self.cancel)
        self.build([thing for thing in FreeCADGui.Selection.getSelection() if document.is_model(thing)])

    def add_field(self, label, widget):
        self.fields.addRow(label, widget)
        return widget

    def add_line(self, label, name, text="", hint=""):
        return self.add_field(label, QtWidgets.QLineEdit(text, objectName=name, placeholderText=hint))

    def build(self, selected):
        raise NotImplementedError

    def job(self):
        raise NotImplementedError

    def getStandardButtons(self):
        return int(QtWidgets.QDialogButtonBox.Close)

    def start(self):
        self.list.clear()
        self.bar.setValue(0)
        self.folder = tempfile.mkdtemp(prefix="patchwright")
        try:
            self.current_job = self.job()
            self.run = Run(find_program(preferences.program()), self.current_job.arguments(self.folder), self.folder)
        except ProgramError as error:
            self._end(str(error), BAD)
            return
        self._set_running(True)
        self._say("running", BUSY)
        self.timer.start()

    def cancel(self):
        if self.run:
            self.run.cancel()
            self._say("stopping", BUSY)

    def reject(self):
        """Closed: a run that goes on is cancelled."""
        self.timer.stop()
        if self.run:
            self.run.cancel()
            self.run.wait()
        self._clean()
        FreeCADGui.Control.closeDialog()
        return True

    def _set_running(self, running):
        self.start_button.setEnabled(not running)
        self.cancel_button.setEnabled(running)

    def _say(self, text, colour):
        self.verdict.setText(text)
        self.verdict.setStyleSheet(f"color: {colour}; font-weight: bold")

    def _poll(self):
        code = self.run.poll()
        if self.run.progress:
            progress = self.run.progress
            left = "" if progress.seconds_left is None else f", {progress.seconds_left:.0f} s left"
            self.stage.setText(f"{progress.stage}, {progress.seconds:.0f} s{left}")
            self.bar.setValue(progress.percent)
        if code is None:
            return
        self.timer.stop()
        if self.run.is_cancelled and code in (*CANCELLED, -9):
            self._end("cancelled; no file was written or changed", BUSY)
            return
        try:
            report = jobs.read_report(self.run, self.folder)
            self._show(report)
        except ProgramError as error:
            self._end(str(error), BAD)
            return
        text = "\n".join([report.sentence(), *self.shown.notices])
        self.bar.setValue(100)
        self._end(text, BAD if report.met is False else GOOD)

    def _show(self, report):
        self.stage.setText("opening the result")
        QtWidgets.QApplication.processEvents()
        doc = FreeCAD.ActiveDocument or FreeCAD.newDocument()
        doc.openTransaction(self.title)
        self.shown = self.current_job.show(doc, report, self.folder)
        doc.commitTransaction()
        for row in self.shown.rows:
            self.list.addTopLevelItem(QtWidgets.QTreeWidgetItem([row.what, row.value]))
        self.list.resizeColumnToContents(0)
        FreeCADGui.Selection.clearSelection()
        shown_view = FreeCADGui.getDocument(doc.Name).ActiveView
        shown_view.viewIsometric()
        shown_view.fitAll()

    def _end(self, text, colour):
        self.run = None
        self._set_running(False)
        self.stage.clear()
        self._say(text, colour)
        self._clean()

    def _clean(self):
        if self.folder:
            shutil.rmtree(self.folder, ignore_errors=True)
            self.folder = None


class ConvertPanel(Panel):
    title = "Convert to patches"

    def build(self, selected):
        self.source = self.add_field("Input", SourceEdit("input", selected[0] if selected else None))
        self.output = self.add_field("Output", FileEdit("output", OUTPUTS, saves=True))
        self.tolerance = self.add_line("Tolerance", "tolerance", preferences.tolerance())
        self.time_limit = self.add_field("Time limit", QtWidgets.QSpinBox(objectName="timeLimit", minimum=1, maximum=86400, suffix=" s"))
        self.time_limit.setValue(preferences.time_limit())
        self.more = self.add_line("Options", "more", hint="--layout remesh --unit m")
        self.source.changed.connect(self._propose)
        self._propose()

    def _propose(self):
        """An output beside the input or the document, unless the user has written one."""
        if self.output.edit.isModified():
            return
        source = self.source.source()
        folder = os.path.dirname(source.file) or (FreeCAD.ActiveDocument and os.path.dirname(FreeCAD.ActiveDocument.FileName))
        self.output.edit.setText(os.path.join(folder or os.path.expanduser("~"), f"{source.label or 'model'}_patches.step"))

    def job(self):
        return jobs.Convert(self.source.source(), self.output.edit.text().strip(), self.tolerance.text(), self.time_limit.value(),
                            self.more.text())


class ComparePanel(Panel):
    title = "Compare"

    def build(self, selected):
        first, second, *_ = [*selected, None, None]
        self.a = self.add_field("Input", SourceEdit("a", first))
        self.b = self.add_field("Output", SourceEdit("b", second))
        self.tolerance = self.add_line("Tolerance", "tolerance", hint="none; or 0.05mm, 1e-4rel")
        self.more = self.add_line("Options", "more", hint="--input-unit in")

    def job(self):
        return jobs.Compare(self.a.source(), self.b.source(), self.tolerance.text().strip(), self.more.text())


class InspectPanel(Panel):
    title = "Inspect patches"

    def build(self, selected):
        self.source = self.add_field("Model", SourceEdit("input", selected[0] if selected else None))
        self.more = self.add_line("Options", "more", hint="--no-heal")

    def job(self):
        return jobs.Inspect(self.source.source(), self.more.text())
