"""Fields at points as grids are refined by: .vtu files as VTK writes them in every way, and broken ones.

Usage: vtu_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import base64
import itertools
import random
import struct
import sys
import unittest
import zlib

import numpy
import vtk
from vtk.util.numpy_support import numpy_to_vtk

from command_line import SAMPLES, CliTest, run

CAGE = SAMPLES / "cages" / "torus.obj"
ENCODINGS = {"ascii": ("Ascii", False), "binary": ("Binary", False), "raw": ("Appended", False), "base64": ("Appended", True)}


def vtu_of(points, cells=(), **arrays):
    """An unstructured grid; arrays named cell_X are the cells' X."""
    grid = vtk.vtkUnstructuredGrid()
    held = vtk.vtkPoints()
    held.SetData(numpy_to_vtk(numpy.asarray(points), deep=True))
    grid.SetPoints(held)
    for cell in cells:
        grid.InsertNextCell({1: vtk.VTK_VERTEX, 3: vtk.VTK_TRIANGLE, 4: vtk.VTK_QUAD}[len(cell)], len(cell), cell)
    for name, values in arrays.items():
        array = numpy_to_vtk(numpy.asarray(values), deep=True)
        array.SetName(name.removeprefix("cell_"))
        (grid.GetCellData() if name.startswith("cell_") else grid.GetPointData()).AddArray(array)
    return grid


def write_vtu(file, grid, mode="raw", header=64, big=False, compressor="None", block=None):
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(str(file))
    writer.SetInputData(grid)
    data_mode, encoded = ENCODINGS[mode]
    getattr(writer, f"SetDataModeTo{data_mode}")()
    writer.SetEncodeAppendedData(encoded)
    getattr(writer, f"SetHeaderTypeToUInt{header}")()
    getattr(writer, f"SetByteOrderTo{'Big' if big else 'Little'}Endian")()
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    if block:
        writer.SetBlockSize(block)
    assert writer.Write() == 1
    return file


class Fields(CliTest):
    def setUp(self):
        super().setUp()
        rng = numpy.random.default_rng(5)
        self.points = numpy.round(60 * rng.standard_normal((700, 3)), 3)
        self.sizes = numpy.round(4 + 8 * rng.random(700), 3)

    def grid(self, name, *arguments):
        """The bytes of the grid that is written."""
        out = self.path(name)
        result = run("grid", CAGE, "-o", out, "--points", 3, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return out.read_bytes()

    def by_csv(self, points, sizes):
        numpy.savetxt(self.path("sizes.csv"), numpy.column_stack([points, sizes]), delimiter=",", fmt="%.17g")
        return self.grid("csv.xyz", "--size-field", self.path("sizes.csv"))

    def refused(self, content, *parts, code=2, arguments=()):
        file = self.path("bad.vtu")
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        self.check_error(run("grid", CAGE, "-o", self.path("x.xyz"), "--size-field", file, *arguments), code, *parts)
        self.assertFalse(self.path("x.xyz").exists())

    def test_every_encoding_gives_the_grid_of_the_same_numbers_as_text(self):
        expected = self.by_csv(self.points, self.sizes)
        self.assertGreater(len(expected), len(self.grid("coarse.xyz")))
        data = vtu_of(self.points, [[i] for i in range(len(self.points))], size=self.sizes, pressure=self.sizes * 0 + 1)
        for mode, header, big, compressor in itertools.product(ENCODINGS, (32, 64), (False, True), ("None", "ZLib")):
            with self.subTest(mode=mode, header=header, big=big, compressor=compressor):
                # Compressed in several blocks, the last of another size.
                file = write_vtu(self.path("field.vtu"), data, mode, header, big, compressor, block=1 << 12)
                self.assertEqual(self.grid("vtu.xyz", "--size-field", file), expected)

    def test_types_pieces_and_cells(self):
        for points, sizes in ((self.points.astype(numpy.float32), self.sizes.astype(numpy.float32)),
                              (self.points.astype(numpy.int32), self.sizes.astype(numpy.uint8)), (self.points, self.sizes.astype(numpy.int16))):
            file = write_vtu(self.path("field.vtu"), vtu_of(points, size=sizes))
            self.assertEqual(self.grid("vtu.xyz", "--size-field", file), self.by_csv(points, sizes))
        # Of cells: sizes at their middles.
        cells = [[i, i + 1, i + 2] + ([i + 3] if i % 2 else []) for i in range(0, 690, 5)]
        middles = [self.points[cell].mean(axis=0) for cell in cells]
        file = write_vtu(self.path("field.vtu"), vtu_of(self.points, cells, cell_size=self.sizes[:len(cells)]), "binary", compressor="ZLib")
        self.assertEqual(self.grid("vtu.xyz", "--size-field", file), self.by_csv(middles, self.sizes[:len(cells)]))
        # Pieces, as parallel writers make them, with lengths and data in base64 each on its own.
        def data(name, values, components=1):
            raw = numpy.asarray(values).tobytes()
            text = base64.b64encode(struct.pack("<I", len(raw))) + base64.b64encode(raw)
            return f'<DataArray type="Float64" Name="{name}" NumberOfComponents="{components}" format="binary">\n {text.decode()}\n</DataArray>'
        pieces = "".join(f'<Piece NumberOfPoints="{len(part)}" NumberOfCells="0"><Points>{data("Points", self.points[part], 3)}</Points>'
                         f'<PointData>{data("size", self.sizes[part])}</PointData></Piece>' for part in numpy.array_split(range(700), 3))
        file = self.path("pieces.vtu", f'<VTKFile type="UnstructuredGrid" byte_order="LittleEndian"><UnstructuredGrid>{pieces}</UnstructuredGrid></VTKFile>')
        self.assertEqual(self.grid("vtu.xyz", "--size-field", file), self.by_csv(self.points, self.sizes))

    def test_which_array(self):
        expected = self.by_csv(self.points, self.sizes)
        file = write_vtu(self.path("field.vtu"), vtu_of(self.points, h=self.sizes, velocity=self.points))
        self.assertEqual(self.grid("vtu.xyz", "--size-field", file), expected)  # the only one with one number a point
        file = write_vtu(self.path("field.vtu"), vtu_of(self.points, h=self.sizes, size=1 + self.sizes, velocity=self.points))
        self.assertEqual(self.grid("vtu.xyz", "--size-field", file, "--size-array", "h"), expected)
        self.assertNotEqual(self.grid("vtu.xyz", "--size-field", file), expected)
        content = write_vtu(self.path("two.vtu"), vtu_of(self.points, h=self.sizes, p=self.sizes)).read_bytes()
        self.refused(content, "bad.vtu", "no array 'size'", "'h', 'p'")
        self.refused(content, "no array 'q'", arguments=("--size-array", "q"))
        content = file.read_bytes()
        self.refused(content, "'velocity'", "3 components", arguments=("--size-array", "velocity"))
        self.check_error(run("grid", CAGE, "-o", self.path("x.xyz"), "--size-array", "h"), 1, "--size-field")
        self.check_error(run("grid", CAGE, "-o", self.path("x.xyz"), "--size-field", self.path("sizes.csv"), "--size-array", "h"), 1, "sizes.csv", ".vtu")

    def test_units(self):
        file = write_vtu(self.path("field.vtu"), vtu_of(self.points, size=self.sizes))
        expected = self.by_csv(self.points, self.sizes)
        inches = self.grid("vtu.xyz", "--size-field", file, "--cage-unit", "in", "--unit", "in")
        self.assertEqual(len(inches), len(expected))
        numpy.testing.assert_allclose(*(numpy.frombuffer(grid[-8000:]) for grid in (inches, expected)), rtol=0, atol=1e-9)

    def test_refused(self):
        text = write_vtu(self.path("field.vtu"), vtu_of(self.points[:4], size=[1.0, 2.0, 3.0, 4.0]), "ascii").read_text()
        self.refused(text.replace("4</", "x</").replace(" 4\n", " x\n"), "'size'", "'x'", "number")
        for value in ("nan", "inf", "-inf", "1e300"):
            self.refused(text.replace("1 2 3 4", f"1 2 {value} 4"), "'size'", "value 3", "finite")
        self.refused(text.replace("1 2 3 4", "1 2 0 4"), "'size'", "point 2", "size is 0")
        self.refused(text.replace("1 2 3 4", "1 2 3"), "'size'", "3 numbers where 4")
        self.refused(text.replace('NumberOfPoints="4"', 'NumberOfPoints="400000000000000"'), "NumberOfPoints")
        self.refused(text.replace('NumberOfPoints="4"', 'NumberOfPoints="-4"'), "NumberOfPoints", "-4")
        self.refused(text.replace('NumberOfPoints="4"', 'NumberOfPoints="40"'), "where 120 are expected")
        self.refused(text.replace("UnstructuredGrid", "PolyData"), "PolyData", "line")
        self.refused(text.replace("VTKFile", "html"), "html")
        self.refused(text.replace('type="Float64" Name="size"', 'type="Complex" Name="size"'), "Complex")
        self.refused(text.replace('byte_order="LittleEndian"', 'byte_order="Middle"'), "Middle")
        self.refused(text.replace('Name="size"', 'Name="a&#10;b"').replace("1 2 3 4", "0 0 0 0"), "'a b'")
        self.refused(text.replace("<VTKFile", '<!DOCTYPE x [<!ENTITY e "1">]><VTKFile', 1), "document type")
        self.refused(text[:len(text) // 2], "bad.vtu, line")
        self.refused("", "bad.vtu")
        self.refused("0,0,0,1\n", "bad.vtu, line 1")
        self.refused('<VTKFile type="UnstructuredGrid"/>', "no <Piece>")
        content = write_vtu(self.path("lz4.vtu"), vtu_of(self.points, size=self.sizes), compressor="LZ4").read_bytes()
        self.refused(content, "vtkLZ4DataCompressor", "SetCompressorTypeToNone")

    def test_lengths_that_lie(self):
        """They are told before memory is asked for: none is refused for want of it."""
        def with_size(data, compressor=""):
            text = base64.b64encode(data).decode()
            return (f'<VTKFile type="UnstructuredGrid" byte_order="LittleEndian" header_type="UInt64"{compressor}><UnstructuredGrid><Piece NumberOfPoints="2" '
                    'NumberOfCells="0"><Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0 1 1 1</DataArray></Points>'
                    f'<PointData><DataArray type="Float64" Name="size" format="binary">{text}</DataArray></PointData></Piece></UnstructuredGrid></VTKFile>')
        compressed = ' compressor="vtkZLibDataCompressor"'
        numbers = struct.pack("<2d", 5, 6)
        packed = zlib.compress(numbers)
        def header(*values):
            return struct.pack(f"<{len(values)}Q", *values)
        for good in (with_size(header(16) + numbers), with_size(header(1, 16, 0, len(packed)) + packed, compressed),
                     with_size(header(1, 1024, 16, len(packed)) + packed, compressed)):
            self.grid("good.xyz", "--size-field", self.path("good.vtu", good))
        huge = 1 << 62
        for bad in (header(16) + numbers[:9], header(17) + numbers, header(huge) + numbers, header(0), b"", b"12345"):
            self.refused(with_size(bad), "'size'")
        for bad in (header(huge, 16, 0, len(packed)) + packed, header(1, huge, 0, len(packed)) + packed, header(1, 16, huge, len(packed)) + packed,
                    header(1, 16, 0, huge) + packed, header(1, 16, 0, len(packed)) + packed[:-3], header(1, 16, 0, 3) + packed, header(2, 8, 0, 9, 9) + packed,
                    header(1, 16, 0, len(packed)) + packed[::-1], header(0, 16, 0), header(1), header(2, 16, 0, huge, huge) + packed):
            self.refused(with_size(bad, compressed), "'size'")
        self.refused(with_size(header(16) + numbers).replace("AAA", "A?A", 1), "base64")
        self.refused(with_size(header(16) + numbers).replace('format="binary"', 'format="appended" offset="99"'), "offset")

    def test_mutated_files_are_read_or_refused(self):
        """Bytes changed, taken out and doubled; by a seed."""
        rng = random.Random(7)
        cells = [[i, i + 1, i + 2] for i in range(30)]
        data = vtu_of(self.points[:32], cells, cell_size=self.sizes[:30])
        for case in range(120):
            mode, compressor = rng.choice(list(ENCODINGS)), rng.choice(("None", "ZLib"))
            content = bytearray(write_vtu(self.path("field.vtu"), data, mode, rng.choice((32, 64)), False, compressor).read_bytes())
            for _ in range(rng.choice((1, 1, 2, 5))):
                at = rng.randrange(len(content))
                change = rng.randrange(4)
                if change == 0:
                    content[at] = rng.randrange(256)
                elif change == 1:
                    del content[at:at + rng.randrange(1, 40)]
                elif change == 2:
                    content[at:at] = content[at:at + 20]
                else:
                    content[at:at] = rng.choice((b"-1", b"99999999999999999999", b"\x00", b"nan", b"<", b"&"))
            file = self.path("mutated.vtu")
            file.write_bytes(content)
            result = run("grid", CAGE, "-o", self.path("x.xyz"), "--points", 2, "--size-field", file)
            with self.subTest(case=case):
                self.assertIn(result.returncode, (0, 1, 2), result.stderr)  # 1: sizes that are too small for the memory
                if result.returncode:
                    self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
