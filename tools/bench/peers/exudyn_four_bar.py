"""Which way does the flexible four-bar of F05 leave its collinear pose (stability laboratory, S44)? By Exudyn.

    python tools/bench/peers/exudyn_four_bar.py --tilt x --sign 1 --n 12 --dt 1e-3      # --static: equilibria

One JSON line: the crank's and rocker's angles at 120 degrees of the crank (deg), where joint C is (m), the largest force
at A (N). Geometrically exact beams of --n elements (the coupler 2 n) with lumped masses. Optional: pip install exudyn.
"""
import argparse
import json

import exudyn
import exudyn.itemInterface as items
import numpy as np
from exudyn.utilities import RotationMatrix2RotXYZ

SPEED, LAST, TILT = 0.6, np.radians(120), np.radians(5)  # rad/s; crank angle of the end; of the axis at C
POINTS = np.array([[0, 0, 0], [0, 0.12, 0], [0.24, 0.12, 0], [0.24, 0, 0]])  # A ... D, m


def axes(x, z):
    """A rotation whose z is `z` and whose x is near to `x`."""
    z = z / np.linalg.norm(z)
    x = x - x.dot(z) * z
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def crank_angle(t):
    """From rest to 0.6 rad/s within a second."""
    s = min(t, 1)
    return SPEED * (s**4 * (2.5 - 3 * s + s * s) + max(t - 1, 0))


def crank_speed(t):
    s = min(t, 1)
    return SPEED * s**3 * (10 - 15 * s + 6 * s * s)


def draw_bar(mbs, start, end, side, n):
    """Nodes of a steel bar of square section, and its axes."""
    young, shear, density, area = 2.07e11, 2.07e11 / 2.6, 7800, side**2
    bending, torsion = side**4 / 12, 0.1405770 * side**4
    section = exudyn.BeamSection()
    section.stiffnessMatrix = np.diag([young * area, 5 / 6 * shear * area, 5 / 6 * shear * area, shear * torsion,
                                       young * bending, young * bending])
    length, R = np.linalg.norm(end - start) / n, axes(end - start, np.array([0, 0, 1.0]))
    turn = list(RotationMatrix2RotXYZ(R))
    nodes = [mbs.AddNode(items.NodeRigidBodyRxyz(referenceCoordinates=list(start + (end - start) * i / n) + turn))
             for i in range(n + 1)]
    for i, node in enumerate(nodes):
        mass = density * area * length * (0.5 if i in (0, n) else 1)
        round_axis = 2 * bending / area
        across = bending / area + length**2 / 12
        mbs.AddObject(items.ObjectRigidBody(nodeNumber=node, physicsMass=mass,
                                            physicsInertia=[mass * round_axis, mass * across, mass * across, 0, 0, 0]))
    for i in range(n):
        mbs.AddObject(items.ObjectBeamGeometricallyExact(nodeNumbers=nodes[i:i + 2], length=length,
                                                         sectionData=section))
    return nodes, R


def run(tilt, sign, n, dt, static):
    mbs = exudyn.SystemContainer().AddSystem()
    ground = mbs.AddObject(items.ObjectGround())
    A, B, C, D = POINTS
    s, c = np.sin(TILT), np.cos(TILT)
    tilted = axes(np.array([1.0, 0, 0]), np.array([s, 0, c]) if tilt == "y" else np.array([0, -s, c]))
    crank, R_crank = draw_bar(mbs, A, B, 0.016, n)
    coupler, R_coupler = draw_bar(mbs, B, C, 0.016, 2 * n)
    rocker, R_rocker = draw_bar(mbs, C, D, 0.008, n)

    def at(node):
        return mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node))

    def tie(a, R_a, b, R_b, free=0):
        return mbs.AddObject(items.GenericJoint(markerNumbers=[a, b], constrainedAxes=[1] * 5 + [1 - free],
                                                rotationMarker0=R_a, rotationMarker1=R_b))

    # A hub whose turn about z is prescribed.
    hub = mbs.AddNode(items.NodeRigidBodyRxyz(referenceCoordinates=[0] * 6))
    mbs.AddObject(items.ObjectRigidBody(nodeNumber=hub, physicsMass=0.01, physicsInertia=[1e-6] * 3 + [0] * 3))
    fixed = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0))
    angle = (lambda t: t * LAST) if static else crank_angle
    for k in range(6):
        turn = {"offsetUserFunction": lambda mbs, t, item, offset: sign * angle(t),
                "offsetUserFunction_t": lambda mbs, t, item, offset: 0 if static else sign * crank_speed(t)}
        marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=hub, coordinate=k))
        mbs.AddObject(items.CoordinateConstraint(markerNumbers=[fixed, marker], **(turn if k == 5 else {})))
    clamp = tie(at(hub), np.eye(3), at(crank[0]), R_crank.T)
    tie(at(crank[-1]), R_crank.T, at(coupler[0]), R_coupler.T, free=1)
    tie(at(coupler[-1]), R_coupler.T @ tilted, at(rocker[0]), R_rocker.T @ tilted, free=1)
    tie(at(rocker[-1]), R_rocker.T, mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=list(D))),
        np.eye(3), free=1)

    forces = []

    def note_force(mbs, t):
        forces.append(np.linalg.norm(mbs.GetObjectOutput(clamp, exudyn.OutputVariableType.ForceLocal)))
        return True

    mbs.SetPostStepUserFunction(note_force)
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    settings.solutionSettings.writeSolutionToFile = False
    settings.linearSolverType = exudyn.LinearSolverType.EigenSparse
    if static:
        settings.staticSolver.numberOfLoadSteps = 480
        settings.staticSolver.newton.relativeTolerance = 1e-7
        mbs.SolveStatic(settings)
    else:
        stepping = settings.timeIntegration
        stepping.endTime = LAST / SPEED + 0.5
        stepping.numberOfSteps = int(round(stepping.endTime / dt))
        stepping.generalizedAlpha.spectralRadius = 0.6
        stepping.newton.relativeTolerance = 1e-8
        stepping.newton.absoluteTolerance = 1e-4  # nothing loads it at rest
        mbs.SolveDynamic(settings)
    R = mbs.GetNodeOutput(rocker[-1], exudyn.OutputVariableType.RotationMatrix).reshape(3, 3)
    place = mbs.GetNodeOutput(coupler[-1], exudyn.OutputVariableType.Position)
    return {"tilt": tilt, "sign": sign, "n": n, "dt": None if static else dt,
            "crank": np.degrees(mbs.GetNodeOutput(hub, exudyn.OutputVariableType.Rotation)[2]),
            "rocker": np.degrees(np.arctan2(R[0, 0], -R[1, 0])), "C": list(place), "largest_force": max(forces)}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tilt", choices=("x", "y"), default="x")
    parser.add_argument("--sign", type=int, choices=(1, -1), default=1)
    parser.add_argument("--n", type=int, default=6)
    parser.add_argument("--dt", type=float, default=2e-3)
    parser.add_argument("--static", action="store_true")
    given = parser.parse_args()
    print(json.dumps(run(given.tilt, given.sign, given.n, given.dt, given.static)))
