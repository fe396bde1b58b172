"""Runs patchwright and reads its progress. Neither FreeCAD nor Qt."""
import os
import queue
import re
import shutil
import signal
import subprocess
import threading
import time
from dataclasses import dataclass

LONGEST_STOP_S = 4.0  # patchwright stops within 2 s
# As the command line draws it: stage, percentage, seconds, and perhaps what is left of the stage.
PROGRESS = re.compile(r"(?P<stage>\S.*?)\s+(?P<percent>\d+) %\s+(?P<seconds>[\d.]+) s(?:, (?P<left>\d+) s left)?")
ERASED_LINE = "\x1b[K"
CANCELLED = (130, 143)


class ProgramError(Exception):
    """What the user has to know; one line."""


@dataclass(frozen=True)
class Progress:
    stage: str
    percent: int
    seconds: float
    seconds_left: float = None  # None: the program does not say


def find_program(wanted=""):
    """The program at a path or of a name; by default patchwright on the path of commands."""
    found = shutil.which(wanted or "patchwright")
    if found is None:
        raise ProgramError(f"{wanted or 'patchwright'}: no such program; set its path in Edit > Preferences > Patchwright")
    return found


def parse_line(line):
    """A Progress, or the text of a message."""
    text = line.replace(ERASED_LINE, "").strip()
    match = PROGRESS.match(text)
    if not match:
        return text
    if match.end() < len(text):  # an error is written where the progress stood
        return text[match.end():].strip()
    left = match["left"]
    return Progress(match["stage"], int(match["percent"]), float(match["seconds"]), None if left is None else float(left))


class Run:
    """One run in the background; whoever shows it polls."""

    def __init__(self, program, arguments, folder):
        self.messages = []  # what it has said besides its progress
        self.progress = None
        self._lines = queue.Queue()
        self._cancelled_at = None
        group = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP} if os.name == "nt" else {}
        try:
            self._process = subprocess.Popen([program, *map(str, arguments), "--progress"], cwd=folder, stdin=subprocess.DEVNULL,
                                             stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, **group)
        except OSError as error:
            raise ProgramError(f"{program}: {error.strerror}") from error
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        rest = ""
        with self._process.stderr as stream:
            while data := stream.read1(4096):
                *lines, rest = re.split(r"[\r\n]", rest + data.decode(errors="replace"))
                for line in lines:
                    self._lines.put(line)
                # A line of progress ends where the next begins, which may be long after.
                if PROGRESS.fullmatch(rest.replace(ERASED_LINE, "").strip()):
                    self._lines.put(rest)
        self._lines.put(rest)

    def poll(self):
        """Takes in what has arrived; the exit code once the run has ended, else None."""
        ended = self._process.poll() is not None
        if ended:
            self._reader.join()
        while not self._lines.empty():
            line = parse_line(self._lines.get())
            if isinstance(line, Progress):
                self.progress = line
            elif line:
                self.messages.append(line)
        if self._cancelled_at is not None and not ended and time.monotonic() > self._cancelled_at + LONGEST_STOP_S:
            self._process.kill()
        return self._process.returncode if ended else None

    def wait(self):
        while self.poll() is None:
            time.sleep(0.05)
        return self._process.returncode

    @property
    def is_cancelled(self):
        return self._cancelled_at is not None

    def cancel(self):
        """Asks it to stop; it leaves no file behind."""
        if self._process.poll() is None and not self.is_cancelled:
            self._cancelled_at = time.monotonic()
            # SIGINT is ignored by what a script starts in the background, as it may have started FreeCAD.
            self._process.send_signal(signal.CTRL_BREAK_EVENT if os.name == "nt" else signal.SIGTERM)

    def error(self):
        """The message that it ended with."""
        own = [m.removeprefix("patchwright: ") for m in self.messages if not m.startswith("note: ")]
        return own[-1] if own else f"patchwright ended with code {self._process.returncode}"
