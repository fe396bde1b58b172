"""Reads fields that patchwright writes with --field FILE.vtp. Neither FreeCAD nor Qt nor VTK."""
import array
import sys
import xml.etree.ElementTree
from dataclasses import dataclass

TYPES = {"Float32": "f", "Float64": "d", "Int32": "i", "Int64": "q"}
# From 0 to the end of the scale: blue, cyan, green, yellow, red, as in the program's reports.
STOPS = ((0.16, 0.22, 0.62), (0.15, 0.60, 0.75), (0.45, 0.78, 0.40), (0.98, 0.82, 0.25), (0.82, 0.15, 0.12))


@dataclass(frozen=True)
class Field:
    points: list     # (x, y, z), millimetres
    triangles: list  # (a, b, c)
    faces: list      # of each triangle: number of the face of the output
    deviation: list  # of each point, millimetres


class FieldError(Exception):
    pass


class _Reader:
    def __init__(self, file):
        with open(file, "rb") as stream:
            data = stream.read()
        begin = data.index(b"_", data.index(b"<AppendedData")) + 1
        self._bytes = data[begin:data.rindex(b"</AppendedData>")]
        self._tree = xml.etree.ElementTree.fromstring(data[:data.index(b"<AppendedData")] + b"</VTKFile>")
        if self._tree.get("byte_order") != sys.byteorder.capitalize() + "Endian" or self._tree.get("header_type") != "UInt64":
            raise FieldError(f"{file}: written on another kind of machine")

    def values(self, parent, name):
        for element in self._tree.iter(parent):
            for found in element.iter("DataArray"):
                if found.get("Name") == name:
                    return self._read(TYPES[found.get("type")], int(found.get("offset")))
        raise FieldError(f"the field has no '{name}'")

    def _read(self, kind, offset):
        size = int.from_bytes(self._bytes[offset:offset + 8], sys.byteorder)
        result = array.array(kind)
        result.frombytes(self._bytes[offset + 8:offset + 8 + size])
        return result


def read_field(file, millimetres=1.0):
    """@param millimetres  those of the file's unit of length"""
    reader = _Reader(file)
    xyz = [millimetres * x for x in reader.values("Points", "Points")]
    corners = reader.values("Polys", "connectivity")
    triangles = list(zip(corners[0::3], corners[1::3], corners[2::3]))
    used = 1 + max(corners, default=-1)  # then come the points of lines
    faces = list(reader.values("CellData", "face"))
    del faces[:len(faces) - len(triangles)]  # lines are numbered first
    deviation = [millimetres * d for d in reader.values("PointData", "deviation")[:used]]
    return Field(list(zip(xyz[0::3], xyz[1::3], xyz[2::3]))[:used], triangles, faces, deviation)


def colour(share):
    """Of a share of the scale, 0 to 1 and beyond: red, green, blue."""
    place = min(max(share, 0.0), 1.0) * (len(STOPS) - 1)
    left = min(int(place), len(STOPS) - 2)
    return tuple(a + (place - left) * (b - a) for a, b in zip(STOPS[left], STOPS[left + 1]))
