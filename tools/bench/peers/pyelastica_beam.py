"""PyElastica's rod on the problems of beam_problem.py; one JSON line. Optional: pip install pyelastica.

    python tools/bench/peers/pyelastica_beam.py --problem falling_rod --method verlet --n 32 --dt 2e-5

Stiffnesses and inertia are set to those of the problem. The compiler of numba has run before the clock starts.
"""
import importlib.metadata
import math
import time

import elastica
import numpy as np

import beam_problem


class Simulator(elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing):
    pass


class TurnedClamp(elastica.ConstraintBase):
    """The first node rests, the first element's directors turn with the hub."""

    def __init__(self, *arguments, angle, **more):
        super().__init__(*arguments, **more)
        self.angle = angle

    def constrain_values(self, system, time):
        a, _ = self.angle(float(time))
        system.position_collection[:, 0] = 0
        c, s = math.cos(a), math.sin(a)
        system.director_collection[:, :, 0] = ((-s, c, 0), (0, 0, 1), (c, s, 0))

    def constrain_rates(self, system, time):
        _, w = self.angle(float(time))
        system.velocity_collection[:, 0] = 0
        system.omega_collection[:, 0] = (0, w, 0)


def draw(problem, n):
    radius = math.sqrt(4 * problem.inertia / problem.mass)
    area = math.pi * radius ** 2
    simulator = Simulator()
    rod = elastica.CosseratRod.straight_rod(
        n, np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), problem.length, radius, problem.mass / area,
        youngs_modulus=problem.EA / area, shear_modulus=problem.GJ / (area * radius ** 2 / 2))
    rod.shear_matrix[0, 0, :] = rod.shear_matrix[1, 1, :] = problem.GA
    rod.shear_matrix[2, 2, :] = problem.EA
    rod.bend_matrix[0, 0, :] = rod.bend_matrix[1, 1, :] = problem.EI
    rod.bend_matrix[2, 2, :] = problem.GJ
    simulator.append(rod)
    if problem.name == "spin_up":
        simulator.constrain(rod).using(TurnedClamp, angle=problem.hub_angle)
    else:
        simulator.constrain(rod).using(
            elastica.GeneralConstraint, constrained_position_idx=(0,),
            translational_constraint_selector=np.array([True, True, True]))
    if problem.gravity:
        simulator.add_forcing_to(rod).using(elastica.GravityForces, acc_gravity=np.array([0, -problem.gravity, 0]))
    simulator.finalize()
    return simulator, rod


def run(problem, stepper, n, dt):
    simulator, rod = draw(problem, n)
    steps = round(problem.period / dt)
    dt = problem.period / steps
    now = stepper.step(simulator, 0.0, 1e-12)  # compiles; too short to matter
    now, found = 0.0, []
    begun = time.process_time()
    for _ in problem.times:
        for _ in range(steps):
            now = stepper.step(simulator, now, dt)
        x = rod.position_collection
        found.append((x[0, n // 2], x[1, n // 2], x[0, n], x[1, n]))
        if not np.all(np.isfinite(x)):
            found += [(math.nan,) * 4] * (len(problem.times) - len(found))
            break
    return time.process_time() - begun, found


def main():
    given = beam_problem.arguments(["verlet", "pefrl"])
    problem = beam_problem.Problem(given.problem)
    stepper = elastica.PositionVerlet() if given.method == "verlet" else elastica.PEFRL()
    runs = [run(problem, stepper, given.n, given.dt) for _ in range(given.repeat)]
    beam_problem.report("PyElastica", importlib.metadata.version("pyelastica"), given, problem, runs)


main()
