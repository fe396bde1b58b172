"""Grid files as the libraries of their formats read them."""
import ctypes
import ctypes.util

import numpy
import vtk
from vtk.util.numpy_support import vtk_to_numpy


def vtk_blocks(file):
    """Name, number of points along i, j and k, points, places and velocities (where there are some) of each block."""
    reader = vtk.vtkXMLMultiBlockDataReader()
    reader.SetFileName(str(file))
    reader.Update()
    blocks = reader.GetOutput()
    for b in range(blocks.GetNumberOfBlocks()):
        block, data = blocks.GetBlock(b), blocks.GetBlock(b).GetPointData()
        arrays = [data.GetArray("cage " + name) for name in ("face", "u", "v", "sector")]
        velocity = data.GetArray("velocity")
        yield (blocks.GetMetaData(b).Get(vtk.vtkCompositeDataSet.NAME()), block.GetDimensions(), vtk_to_numpy(block.GetPoints().GetData()),
               [vtk_to_numpy(array) for array in arrays if array], velocity and vtk_to_numpy(velocity))


def cgns_arrays(file, node):
    """Per zone's name the arrays in its first node of this kind, as the CGNS library reads them."""
    library = ctypes.CDLL(ctypes.util.find_library("cgns"))
    handle, count = ctypes.c_int(), ctypes.c_int()
    assert library.cg_open(str(file).encode(), 0, ctypes.byref(handle)) == 0
    library.cg_nzones(handle, 1, ctypes.byref(count))
    zones = {}
    for zone in range(1, count.value + 1):
        name, kind, rank, sizes = ctypes.create_string_buffer(33), ctypes.c_int(), ctypes.c_int(), (ctypes.c_int * 12)()
        library.cg_zone_read(handle, 1, zone, name, sizes)
        arrays = zones[name.value.decode()] = {}
        assert library.cg_goto(handle, 1, b"Zone_t", zone, node.encode(), 1, b"end") == 0
        library.cg_narrays(ctypes.byref(count))
        for a in range(1, count.value + 1):
            library.cg_array_info(a, name, ctypes.byref(kind), ctypes.byref(rank), sizes)
            values = arrays[name.value.decode()] = numpy.empty(int(numpy.prod(sizes[:rank.value])), numpy.int32 if kind.value == 2 else numpy.float64)
            assert library.cg_array_read(a, values.ctypes.data_as(ctypes.c_void_p)) == 0
    library.cg_close(handle)
    return zones
