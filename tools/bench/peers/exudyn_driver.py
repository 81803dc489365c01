"""Exudyn on the chain and the four-bars of mechanisms.h and the flexible pendulum; one JSON line, as the other drivers print. Optional:
pip install exudyn.

    python tools/bench/peers/exudyn_driver.py --problem chain --n 16 --joint revolute --method tree_rk4 --dt 1e-3 \
        --reference tools/bench/data/chain_16.txt

--method: space (rigid bodies with rotation vectors and joints) or plane (planar bodies and pins), each with alpha
(generalized-alpha, index 3) or trapezoidal (index 2): fixed steps; tree (joint coordinates, hinges alone) with rk4
(fixed steps) or dopri5 (error-controlled).
"""
import argparse
import csv
import importlib.metadata
import json
import math
import pathlib
import time

import exudyn
import exudyn.itemInterface as items
import numpy as np

ROD = pathlib.Path(__file__).resolve().parents[3] / "examples/data/pendulum/hex8i"
GRAVITY = 9.81  # m/s²
MASS = LENGTH = 1.0  # kg, m
ACROSS, ALONG = 1 / 12, 1.25e-3  # kg m², central
TYPES = exudyn.DynamicSolverType
STEPPERS = {"alpha": TYPES.GeneralizedAlpha, "trapezoidal": TYPES.TrapezoidalIndex2, "rk4": TYPES.RK44,
            "dopri5": TYPES.DOPRI5}
METHODS = {("chain", "spherical"): ("space_alpha", "space_trapezoidal"),
           ("chain", "revolute"): ("plane_alpha", "plane_trapezoidal", "tree_rk4", "tree_dopri5"),
           ("four_bar", ""): ("plane_alpha", "plane_trapezoidal"),
           ("pendulum", ""): ("modes_alpha",)}


def planar_rod(mbs, center, angle, rates=(0, 0, 0)):
    """A rod and its markers at both ends; angle: of its axis."""
    node = mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[*center, angle], initialVelocities=list(rates)))
    body = mbs.AddObject(items.ObjectRigidBody2D(mass=MASS, inertia=ACROSS, nodeNumber=node))
    middle = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=node))
    mbs.AddLoad(items.LoadForceVector(markerNumber=middle, loadVector=[0, -MASS * GRAVITY, 0]))
    return [mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[s * LENGTH / 2, 0, 0]))
            for s in (-1, 1)]


def at_ground(mbs, ground, point):
    return mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground, localPosition=point))


def planar_chain(mbs, n):
    before = at_ground(mbs, mbs.AddObject(items.ObjectGround()), [0, 0, 0])
    ends = []
    for i in range(n):
        near, far = planar_rod(mbs, [(i + 0.5) * LENGTH, 0], 0)
        mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=[before, near]))
        before = far
        ends.append(far)
    return lambda: [mbs.GetMarkerOutput(end, exudyn.OutputVariableType.Position)[:2] for end in ends]


def spatial_chain(mbs, n):
    before = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=mbs.AddObject(items.ObjectGround()),
                                                 localPosition=[0, 0, 0]))
    ends = []
    for i in range(n):
        node = mbs.AddNode(items.NodeRigidBodyRotVecLG(referenceCoordinates=[(i + 0.5) * LENGTH, 0, 0, 0, 0, 0],
                                                       initialVelocities=[0] * 6))
        body = mbs.AddObject(items.ObjectRigidBody(physicsMass=MASS, physicsInertia=[ALONG, ACROSS, ACROSS, 0, 0, 0],
                                                   nodeNumber=node))
        middle = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=body))
        mbs.AddLoad(items.LoadMassProportional(markerNumber=middle, loadVector=[0, 0, -GRAVITY]))
        near, far = (mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=[s * LENGTH / 2, 0, 0]))
                     for s in (-1, 1))
        mbs.AddObject(items.ObjectJointSpherical(markerNumbers=[before, near]))
        before = far
        ends.append(far)
    return lambda: [mbs.GetMarkerOutput(end, exudyn.OutputVariableType.Position)[[0, 2]] for end in ends]


def tree_chain(mbs, n):
    """About y, drawn along x; angles are relative."""
    node = mbs.AddNode(items.NodeGenericODE2(referenceCoordinates=[0] * n, initialCoordinates=[0] * n,
                                             initialCoordinates_t=[0] * n, numberOfODE2Coordinates=n))
    inertias, shifts = exudyn.Matrix3DList(), exudyn.Vector3DList()
    turns, centers = exudyn.Matrix3DList(), exudyn.Vector3DList()
    inertia = np.diag([ALONG, ACROSS, ACROSS])
    for i in range(n):
        inertias.Append(inertia)
        shifts.Append([0 if i == 0 else LENGTH, 0, 0])
        turns.Append(np.eye(3))
        centers.Append([LENGTH / 2, 0, 0])
    mbs.AddObject(items.ObjectKinematicTree(
        nodeNumber=node, jointTypes=[exudyn.JointType.RevoluteY] * n, linkParents=[i - 1 for i in range(n)],
        jointTransformations=turns, jointOffsets=shifts, linkInertiasCOM=inertias, linkCOMs=centers,
        linkMasses=[MASS] * n, gravity=[0, 0, -GRAVITY]))

    def ends():
        angles = np.cumsum(mbs.systemData.GetODE2Coordinates())
        return np.stack([np.cumsum(LENGTH * np.cos(angles)), np.cumsum(-LENGTH * np.sin(angles))], axis=1)
    return ends


def four_bars(mbs, windows):
    """Uprights and couplers; the end of the first upright."""
    ground = mbs.AddObject(items.ObjectGround())
    tops = []
    for i in range(windows + 1):
        foot, top = planar_rod(mbs, [i * LENGTH, LENGTH / 2], math.pi / 2, (0.5, 0, -1 / LENGTH))
        mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=[at_ground(mbs, ground, [i * LENGTH, 0, 0]), foot]))
        tops.append(top)
    for i in range(windows):
        near, far = planar_rod(mbs, [(i + 0.5) * LENGTH, LENGTH], 0, (1, 0, 0))
        mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=[tops[i], near]))
        mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=[far, tops[i + 1]]))
    return tops[0]


def flexible_pendulum(mbs, n):
    """The rod of examples/data/pendulum/hex8i with n free modes; its first edge turns about y. The place of its tip."""
    from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface
    from scipy.io import mmread
    fem = FEMinterface()
    with open(ROD / "nodes.csv", encoding="utf8") as file:
        rows = [[float(row[name]) for name in ("x", "y", "z")] for row in csv.DictReader(file)]
    fem.nodes = {"Position": np.array(rows)}
    fem.massMatrix, fem.stiffnessMatrix = (mmread(ROD / name).tocsr() for name in ("M.mtx", "K.mtx"))
    fem.ComputeEigenmodes(n, excludeRigidBodyModes=6, useSparseSolver=False)
    rod = ObjectFFRFreducedOrderInterface(fem).AddObjectFFRFreducedOrder(mbs, gravity=[0, 0, -GRAVITY])["oFFRFreducedOrder"]
    ground = mbs.AddObject(items.ObjectGround())
    for node, axes in ((0, [1, 1, 1]), (2, [1, 0, 1])):  # nodes on a line make no rigid marker
        edge = mbs.AddMarker(items.MarkerSuperElementPosition(bodyNumber=rod, meshNodeNumbers=[node],
                                                              weightingFactors=[1]))
        fixed = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground, localPosition=rows[node]))
        mbs.AddObject(items.ObjectJointSpherical(markerNumbers=[fixed, edge], constrainedAxes=axes))
    tip = mbs.AddMarker(items.MarkerSuperElementPosition(bodyNumber=rod, meshNodeNumbers=[49], weightingFactors=[1]))
    return lambda: mbs.GetMarkerOutput(tip, exudyn.OutputVariableType.Position)


def first_top(windows, times):
    """The angle of all uprights, as mechanisms.h has it: θ'' = κ sin θ."""
    from scipy.integrate import solve_ivp
    n = windows
    kappa = GRAVITY / LENGTH * ((n + 1) / 2 + n) / ((n + 1) / 3 + n)
    angle = solve_ivp(lambda t, y: [y[1], kappa * math.sin(y[0])], (0, times[-1]), [0, 1 / LENGTH], method="DOP853",
                      rtol=1e-13, atol=1e-13, t_eval=times).y[0]
    return np.stack([LENGTH * np.sin(angle), LENGTH * np.cos(angle)], axis=1)


def run(given, method):
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    draw, stepper = method.split("_")
    watched = None
    if given.problem == "four_bar":
        top = four_bars(mbs, given.n)
        watched = mbs.AddSensor(items.SensorMarker(markerNumber=top, storeInternal=True,
                                                   outputVariableType=exudyn.OutputVariableType.Position))
    elif given.problem == "pendulum":
        tip = flexible_pendulum(mbs, given.n)
    else:
        ends = {"space": spatial_chain, "plane": planar_chain, "tree": tree_chain}[draw](mbs, given.n)
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime = given.T
    integration.verboseMode = 0
    integration.newton.useModifiedNewton = True
    integration.generalizedAlpha.spectralRadius = 0.9
    integration.explicit.computeEndOfStepAccelerations = False
    if given.tol:
        integration.automaticStepSize = True
        integration.relativeTolerance = integration.absoluteTolerance = given.tol
        integration.numberOfSteps = 10
        integration.minimumStepSize = 1e-9
    else:
        integration.automaticStepSize = False
        integration.adaptiveStep = False
        integration.numberOfSteps = round(given.T / given.dt)
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = given.T / 1000
    settings.parallel.numberOfThreads = 1
    begun = time.process_time()
    mbs.SolveDynamic(settings, solverType=STEPPERS[stepper])
    seconds = time.process_time() - begun
    steps = mbs.sys["dynamicSolver"].it.currentStepIndex - 1
    if watched is not None:
        table = mbs.GetSensorStoredData(watched)
        if abs(table[-1, 0] - given.T) > 1e-6:
            raise SystemExit(f"the run ended at {table[-1, 0]} s")
        right = first_top(given.n, table[1:, 0])
        return seconds, steps, float(np.max(np.linalg.norm(table[1:, 1:3] - right, axis=1)))
    if given.problem == "pendulum":
        return seconds, steps, [float(x) for x in tip()]
    right = np.loadtxt(given.reference)
    return seconds, steps, float(np.max(np.linalg.norm(np.array(ends()) - right, axis=1)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problem", default="chain", choices=("chain", "four_bar", "pendulum"))
    parser.add_argument("--joint", default="")
    parser.add_argument("--method", required=True)
    parser.add_argument("--n", type=int, default=16)
    parser.add_argument("--T", type=float, default=1)
    parser.add_argument("--dt", type=float, default=1e-3)
    parser.add_argument("--tol", type=float)
    parser.add_argument("--reference")
    parser.add_argument("--repeat", type=int, default=1)
    given = parser.parse_args()
    known = METHODS[given.problem, given.joint]
    if given.method not in known:
        raise SystemExit(f"no method '{given.method}' here; known are {', '.join(known)}")
    seconds, steps, error = min(run(given, given.method) for _ in range(given.repeat))
    print(json.dumps({"engine": "Exudyn", "version": importlib.metadata.version("exudyn"), "problem": given.problem,
                      "method": given.method, "n": given.n, "steps": steps, "cpu_seconds": seconds,
                      {"chain": "joint_error", "four_bar": "error", "pendulum": "tip"}[given.problem]: error}))


main()
