"""What a report (JSON) and a STEP file of patchwright say. Neither FreeCAD nor Qt."""
import json
import re
from dataclasses import dataclass

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8}
CONDITIONS = {
    "distance_to_input": "output to input",
    "distance_from_input": "input to output",
    "sharp_curves": "lost sharp curve",
    "folds": "fold",
    "kinks": "kink",
    "self_intersections": "self-intersection",
}
DEGREES = ("folds", "kinks")


@dataclass(frozen=True)
class Place:
    """Somewhere to look at; lengths in millimetres."""

    what: str
    value: str
    at: tuple
    on_output: bool = True  # else on the input


class Report:
    def __init__(self, data):
        self.data = data
        self.unit = data["unit"]
        self.scale = MILLIMETRES[self.unit]

    @classmethod
    def read(cls, file):
        with open(file, encoding="utf-8") as stream:
            return cls(json.load(stream))

    @property
    def met(self):
        """None: nothing was asked."""
        return self.data["verdict"]["met"] if "verdict" in self.data else None

    def sentence(self):
        if "verdict" in self.data:
            return self.data["verdict"]["sentence"]
        if "deviation" in self.data:
            both = self.data["deviation"]
            return "largest distance " + self.length(max(both[way]["max"] for way in ("output_to_input", "input_to_output")))
        return state_of(self.data["solid"])

    def length(self, value):
        return f"{value:.3g} {self.unit}"

    def point(self, at):
        return tuple(self.scale * x for x in at)

    def largest_mm(self):
        """The end of a colour scale: the tolerance, or without one the largest distance of the output."""
        for condition in self.data.get("verdict", {}).get("conditions", []):
            if condition["name"] == "distance_to_input" and condition["limit"] > 0:
                return self.scale * condition["limit"]
        return self.scale * self.data["deviation"]["output_to_input"]["max"]

    def places(self):
        """Conditions that are not met, then the worst places of each way, then what an inspection found."""
        return [*self._failed(), *self._worst(), *self._details()]

    def _failed(self):
        for condition in self.data.get("verdict", {}).get("conditions", []):
            name, at = condition["name"], condition.get("at")
            if condition["met"] or name not in CONDITIONS or not at or name.startswith("distance"):
                continue
            value = f"{condition['value']:.3g}" + (" degrees" if name in DEGREES else "")
            yield Place(CONDITIONS[name], value, self.point(at), name != "sharp_curves")

    def _worst(self):
        for way, what in (("output_to_input", "output to input"), ("input_to_output", "input to output")):
            for worst in self.data.get("deviation", {}).get(way, {}).get("worst", []):
                yield Place(what, self.length(worst["distance"]), self.point(worst["at"]), way == "output_to_input")

    def _details(self):
        details = self.data.get("details", {})
        if details.get("largest_kink_deg", 0.0) > 0.0:
            yield Place("largest kink", f"{details['largest_kink_deg']:.3g} degrees", self.point(details["largest_kink_at"]))
        if "shortest_edge" in details:
            edge = details["shortest_edge"]
            yield Place("shortest edge", self.length(edge["length"]), self.point(edge["at"]))


def state_of(solid):
    state = ", ".join(["closed" if solid["closed"] else "open", "valid" if solid["valid"] else "NOT VALID"])
    kinds = ", ".join(f"{count} {kind}" for kind, count in sorted(solid["faces_by_kind"].items()))
    return f"{state}: {solid['faces']} faces ({kinds})"


def patch_names(step_text):
    """Names of the faces of a STEP file, in the order of its shells."""
    names = {int(number): name for number, name in re.findall(r"#(\d+)\s*=\s*ADVANCED_FACE\s*\(\s*'((?:[^']|'')*)'", step_text)}
    shells = re.findall(r"=\s*(?:CLOSED|OPEN)_SHELL\s*\(\s*'(?:[^']|'')*'\s*,\s*\(([^)]*)\)", step_text)
    return [step_string(names.get(int(number), "")) for shell in shells for number in re.findall(r"#(\d+)", shell)]


def step_string(text):
    r"""ISO 10303-21: doubled apostrophes and backslashes, \X\HH and \X2\HHHH...\X0\."""
    text = re.sub(r"\\X2\\([0-9A-F]+)\\X0\\", lambda m: bytes.fromhex(m[1]).decode("utf-16-be"), text)
    text = re.sub(r"\\X\\([0-9A-F]{2})", lambda m: chr(int(m[1], 16)), text)
    return text.replace("''", "'").replace("\\\\", "\\")
