# SPDX-License-Identifier: Apache-2.0
"""Opens the run.xdmf of write_example_snapshots with every XDMF reader of ParaView and compares times, counts, ranges.

usage: pvpython paraview_check.py RUN.xdmf      (exit code 1 on failure)
"""
import sys

from paraview import servermanager
from paraview.simple import XDMFReader, Xdmf3ReaderS, Xdmf3ReaderT

# time, elements, particles: see example_snapshots.hpp
EXPECTED = [(0.0, 5, 0), (1e-5, 3, 16), (2e-5, 0, 40), (3e-5, 0, 0), (1.0, 2, 24)]

failures = []


def check(what, found, expected, tolerance=1e-9):
    same = abs(found - expected) <= tolerance * max(1.0, abs(expected))
    if not same:
        failures.append(f"{what}: {found}, expected {expected}")


def leaves(data):
    """Unstructured grids of a tree of blocks."""
    if data is None:
        return []
    if data.IsA("vtkUnstructuredGrid"):
        return [data]
    if data.IsA("vtkMultiPieceDataSet"):
        return [data.GetPiece(i) for i in range(data.GetNumberOfPieces())]
    return [leaf for i in range(data.GetNumberOfBlocks()) for leaf in leaves(data.GetBlock(i))]


def of_type(grids, cell_type):
    return [g for g in grids if g is not None and g.GetNumberOfCells() > 0 and g.GetCellType(0) == cell_type]


def check_block(label, grids, count, expected_ranges, points):
    check(label + " blocks", len(grids), 1 if count else 0)
    check(label + " cells", sum(g.GetNumberOfCells() for g in grids), count)
    for grid in grids:
        check(label + " points", grid.GetNumberOfPoints(), points)
        velocity = grid.GetPointData().GetArray("velocity")
        check(label + " velocity components", velocity.GetNumberOfComponents() if velocity else 0, 3)
        for name, (low, high) in expected_ranges.items():
            array = grid.GetCellData().GetArray(name)
            if array is None:
                failures.append(f"{label}: no field '{name}'")
                continue
            check(f"{label} lowest {name}", array.GetRange()[0], low)
            check(f"{label} highest {name}", array.GetRange()[1], high)


def ranges(pressure, speed, temperature, constant, n):
    return {"pressure": (pressure, pressure + 1e3 * (n - 1)), "speed": (speed, speed + 100 * (n - 1)),
            "temperature": (temperature, temperature + n - 1), "damage": (constant, constant), "body": (constant, constant)}


def check_reader(name, reader):
    reader.UpdatePipelineInformation()
    times = list(reader.TimestepValues)
    check(name + " times", len(times), len(EXPECTED))
    for time, (expected_time, n_elements, n_particles) in zip(times, EXPECTED):
        check(name + " time", time, expected_time, 1e-12)
        reader.UpdatePipeline(time)
        grids = leaves(servermanager.Fetch(reader))
        label = f"{name} at {time:g} s"
        check_block(label + ", elements,", of_type(grids, 12), n_elements,
                    ranges(1e9, 8000, 294, 0, n_elements), 4 * (n_elements + 1))
        # a vertex (1) or a polyvertex (2) for each particle
        check_block(label + ", particles,", of_type(grids, 1) + of_type(grids, 2), n_particles,
                    ranges(-1e6, 0, 900, 1, n_particles), n_particles)


def main():
    path = sys.argv[1]
    check_reader("Xdmf3ReaderT", Xdmf3ReaderT(FileName=[path]))
    check_reader("XDMFReader", XDMFReader(FileNames=[path]))
    check_reader("Xdmf3ReaderS", Xdmf3ReaderS(FileName=[path]))
    for failure in failures:
        print("FAILED", failure)
    print(f"{path}: {len(EXPECTED)} times, {'failed' if failures else 'all as expected'}")
    sys.exit(1 if failures else 0)


main()
