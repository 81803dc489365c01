"""Exudyn's beams on the problems of beam_problem.py; one JSON line. Optional: pip install exudyn.

    python tools/bench/peers/exudyn_beam.py --problem falling_rod --method plane_alpha --n 16 --dt 1e-3

--method ELEMENT_STEPPER: plane (geometrically exact, planar, two nodes), plane3 (three nodes), ancf (planar ANCF cable,
without shear), space (geometrically exact, spatial); alpha (generalized-alpha), trapezoidal (index 2), rk4 (explicit,
fixed steps).
"""
import importlib.metadata
import time

import exudyn
import exudyn.itemInterface as items
import numpy as np
from exudyn.beams import GenerateBeamElementsAlongLine

import beam_problem

ELEMENTS = ("plane", "plane3", "ancf", "space")
STEPPERS = {"alpha": exudyn.DynamicSolverType.GeneralizedAlpha,
            "trapezoidal": exudyn.DynamicSolverType.TrapezoidalIndex2,
            "rk4": exudyn.DynamicSolverType.RK44}


def hold(mbs, node, coordinate, offset=None, rate=None):
    """A coordinate of a node at its drawn value, or moved from it by functions of time."""
    ground = mbs.AddMarker(items.MarkerNodeCoordinate(
        nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0))
    marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
    moves = {"offsetUserFunction": offset, "offsetUserFunction_t": rate} if offset else {}
    mbs.AddObject(items.CoordinateConstraint(markerNumbers=[ground, marker], **moves))


def draw_planar(mbs, problem, element, n):
    common = {"massPerLength": problem.mass, "bendingStiffness": problem.EI, "axialStiffness": problem.EA}
    if element == "ancf":
        beam = items.ObjectANCFCable2D(**common)
    else:
        beam = items.ObjectBeamGeometricallyExact2D(crossSectionInertia=problem.inertia, shearStiffness=problem.GA,
                                                    **common)
        if element == "plane3":
            beam.nodeNumbers = [-1, -1, -1]
    made = GenerateBeamElementsAlongLine(mbs, [0, 0, 0], [problem.length, 0, 0], n, beam,
                                         gravity=[0, -problem.gravity, 0])
    nodes = made["nodes"]
    hold(mbs, nodes[0], 0)
    hold(mbs, nodes[0], 1)
    if problem.name == "spin_up":
        if element == "ancf":
            raise SystemExit("the clamp of the ANCF cable turns its slope, which coordinates cannot prescribe alone")
        hold(mbs, nodes[0], 2, lambda mbs, t, item, offset: problem.hub_angle(t)[0],
             lambda mbs, t, item, offset: problem.hub_angle(t)[1])
    return nodes


def draw_spatial(mbs, problem, n):
    section = exudyn.BeamSection()
    section.stiffnessMatrix = np.diag([problem.EA, problem.GA, problem.GA, problem.GJ, problem.EI, problem.EI])
    section.inertia = np.diag([2 * problem.inertia, problem.inertia, problem.inertia])
    section.massPerLength = problem.mass
    length = problem.length / n
    nodes = [mbs.AddNode(items.NodeRigidBodyRotVecLG(referenceCoordinates=[length * i, 0, 0, 0, 0, 0],
                                                     initialVelocities=[0] * 6)) for i in range(n + 1)]
    for a, b in zip(nodes, nodes[1:]):
        beam = mbs.AddObject(items.ObjectBeamGeometricallyExact(nodeNumbers=[a, b], length=length,
                                                                sectionData=section))
        if problem.gravity:
            mass = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=beam))
            mbs.AddLoad(items.LoadMassProportional(markerNumber=mass, loadVector=[0, -problem.gravity, 0]))
    if problem.name == "spin_up":
        raise SystemExit("a spatial node cannot be turned by coordinates; with a GenericJoint that turns, Newton fails")
    for coordinate in range(3):
        hold(mbs, nodes[0], coordinate)
    return nodes


def run(problem, element, stepper, n, dt):
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    nodes = draw_spatial(mbs, problem, n) if element == "space" else draw_planar(mbs, problem, element, n)
    watched = [mbs.AddSensor(items.SensorNode(nodeNumber=nodes[at], storeInternal=True,
                                              outputVariableType=exudyn.OutputVariableType.Position))
               for at in ((len(nodes) - 1) // 2, len(nodes) - 1)]
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime = problem.end
    integration.numberOfSteps = round(problem.period / dt) * len(problem.times)
    integration.verboseMode = 0
    integration.newton.useModifiedNewton = True
    # The residuals of stiff beams do not fall to the 1e-8 of its defaults.
    integration.newton.relativeTolerance = integration.newton.absoluteTolerance = 1e-5
    integration.generalizedAlpha.spectralRadius = 0.9
    integration.automaticStepSize = False
    integration.adaptiveStep = False
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = problem.period * (1 - 1e-6)
    settings.parallel.numberOfThreads = 1
    begun = time.process_time()
    mbs.SolveDynamic(settings, solverType=STEPPERS[stepper])
    seconds = time.process_time() - begun
    tables = [mbs.GetSensorStoredData(sensor) for sensor in watched]
    found = []
    for t in problem.times:
        rows = [table[np.argmin(np.abs(table[:, 0] - t))] for table in tables]
        if abs(rows[0][0] - t) > 1e-6:
            raise SystemExit(f"no sample at {t} s: the run ended at {tables[0][-1, 0]} s")
        found.append((rows[0][1], rows[0][2], rows[1][1], rows[1][2]))
    return seconds, found


def main():
    given = beam_problem.arguments([f"{element}_{stepper}" for element in ELEMENTS for stepper in STEPPERS])
    problem = beam_problem.Problem(given.problem)
    element, stepper = given.method.split("_")
    runs = [run(problem, element, stepper, given.n, given.dt) for _ in range(given.repeat)]
    beam_problem.report("Exudyn", importlib.metadata.version("exudyn"), given, problem, runs)


main()
