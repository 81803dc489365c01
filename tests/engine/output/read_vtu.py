"""Reads .vtu files through VTK's own reader, and .pvd series, and prints what it found.

    /usr/bin/python3 read_vtu.py frame.vtu series.pvd ...

A frame: points, cells, VTK cell types, volume (negative for cells turned inside out), largest distance of an
edge's middle node from the middle of its corners, then for each field its name, components, sum, and sum weighted
by 1, 2, 3 ... in the order of memory.
"""
import os
import sys
import xml.etree.ElementTree

try:
    import vtk
except ImportError as error:
    sys.exit(f"{error}: apt-get install python3-vtk9 (for /usr/bin/python3)")


def volume(grid):
    sizes = vtk.vtkCellSizeFilter()
    sizes.SetInputData(grid)
    sizes.Update()
    array = sizes.GetOutput().GetCellData().GetArray("Volume")
    return sum(array.GetValue(i) for i in range(array.GetNumberOfValues()))


def middle_node_error(grid):
    largest = 0.0
    for c in range(grid.GetNumberOfCells()):
        for e in range(grid.GetCell(c).GetNumberOfEdges()):
            points = grid.GetCell(c).GetEdge(e).GetPoints()
            if points.GetNumberOfPoints() == 3:
                first, second, middle = (points.GetPoint(i) for i in range(3))
                largest = max([largest] + [abs((a + b) / 2 - m) for a, b, m in zip(first, second, middle)])
    return largest


def describe_array(name, array):
    count = array.GetNumberOfValues()
    values = [array.GetValue(i) for i in range(count)]
    weighted = sum((i + 1) * value for i, value in enumerate(values))
    print(f"{name}: {array.GetNumberOfComponents()} components, sum {sum(values):.12g}, weighted {weighted:.12g}")


def describe(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.AddObserver("ErrorEvent", lambda *_: sys.exit(f"{path}: VTK's reader reports an error"))
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    types = sorted({grid.GetCellType(i) for i in range(grid.GetNumberOfCells())})
    print(f"{grid.GetNumberOfPoints()} points, {grid.GetNumberOfCells()} cells, types {types}, "
          f"volume {volume(grid):.9g}, middle nodes off by {middle_node_error(grid):.9g}")
    describe_array("positions", grid.GetPoints().GetData())
    for i in range(grid.GetPointData().GetNumberOfArrays()):
        array = grid.GetPointData().GetArray(i)
        describe_array(array.GetName(), array)


for argument in sys.argv[1:]:
    if argument.endswith(".pvd"):
        for frame in xml.etree.ElementTree.parse(argument).iter("DataSet"):
            print(f"t = {frame.get('timestep')}, {frame.get('file')}")
            describe(os.path.join(os.path.dirname(argument), frame.get("file")))
    else:
        describe(argument)
