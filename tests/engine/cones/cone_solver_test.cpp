#include <gtest/gtest.h>

#include "engine/cones/direct_cone_solver.h"
#include "joints/contact/bullet_mlcp.h"
#include "tests/engine/cones/cone_problems.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::cone_solver_test {
namespace {

const Vector3 kUp{0, 0, 1};
constexpr double kGravity = 9.81;

VectorX solve(ConeSolver&& solver, const ConeProblem& problem, double tolerance = 1e-13) {
  VectorX r = VectorX::Zero(problem.rows);
  const ConeResult result = solver.solve(problem, tolerance, r);
  EXPECT_TRUE(result.converged) << solver.name() << ": " << result.residual;
  EXPECT_LT(coulomb_error(problem, r), 1e-11) << solver.name();
  return r;
}

/// Impulses by all solvers, which must agree; where contacts are not redundant.
VectorX impulses(const ConeProblem& problem) {
  const VectorX r = solve(GaussSeidel({.sweeps = 5000}), problem);
  EXPECT_LT((solve(DirectConeSolver(), problem) - r).norm(), 1e-11 * (1 + r.norm()));
  EXPECT_LT((solve(AutomaticConeSolver(), problem) - r).norm(), 1e-11 * (1 + r.norm()));
  return r;
}

/// A ball on the ground, one time step after its weight has begun to pull it down.
TouchingBodies ball_on_ground(const Vector3& velocity, const Vector3& spin, double friction, double step = 0.01) {
  constexpr double kRadius = 0.1, kMass = 2;
  TouchingBodies scene;
  scene.bodies.push_back({kMass, Vector3::Constant(0.4 * kMass * kRadius * kRadius), kRadius * kUp,
                          velocity - kGravity * step * kUp, spin});
  scene.touches.push_back({.b = 0, .point = Vector3::Zero(), .normal = kUp, .friction = friction});
  return scene;
}

TEST(ConeProblem, VelocitiesByBodiesAreThoseByTheDelassusOperator) {
  const ConeProblem problem = random_heap(4).problem();
  const MatrixX W = problem.delassus();
  const VectorX r = VectorX::LinSpaced(problem.rows, -1, 2);
  VectorX u;
  problem.velocity(r, u);
  EXPECT_LT((u - W * r - problem.free).norm(), 1e-12 * u.norm());
  for (const int i : {0, 3, 7})
    for (const int j : {1, 3}) EXPECT_LT((problem.block(i, j) - W.block(3 * i, 3 * j, 3, 3)).norm(), 1e-14 * W.norm());
  EXPECT_LT((W - W.transpose()).norm(), 1e-14 * W.norm());
}

TEST(ConeProblem, ResidualIsTheWayToTheExactImpulse) {
  const TouchingBodies scene = ball_on_ground({1, 2, 0}, {0, 0, 0}, 0.3);
  const ConeProblem problem = scene.problem();
  VectorX r = impulses(problem), u;
  problem.velocity(r, u);
  EXPECT_LT(problem.residual(r, u), 1e-14);
  r[0] += 1e-3;
  problem.velocity(r, u);
  EXPECT_GT(problem.residual(r, u), 1e-5);
  r[0] = std::nan("");
  problem.velocity(r, u);
  EXPECT_FALSE(problem.residual(r, u) < 1e300);
}

TEST(ConeSolver, ASlidingBallIsHeldBackByFrictionTimesWeight) {
  for (const Vector3& velocity : {Vector3(3, 0, 0), Vector3(-1, 2, 0), Vector3(0.7, -0.7, 0)}) {
    const TouchingBodies scene = ball_on_ground(velocity, {0, 0, 5}, 0.4);
    const ConeProblem problem = scene.problem();
    const VectorX v = scene.after(problem, impulses(problem));
    const Vector3 expected = velocity - 0.4 * kGravity * 0.01 * velocity.normalized();
    EXPECT_LT((v.head<3>() - expected).norm(), 1e-13);
    EXPECT_NEAR(v[5], 5, 1e-13);  // no friction about the normal
  }
}

TEST(ConeSolver, ABallThatBarelySlidesRollsAfterwards) {
  const TouchingBodies scene = ball_on_ground({0.05, 0, 0}, {0, 0, 0}, 0.4);
  const ConeProblem problem = scene.problem();
  const VectorX v = scene.after(problem, impulses(problem));
  EXPECT_NEAR(v[0], 5.0 / 7 * 0.05, 1e-14);  // 2/7 of the slip goes into the spin
  EXPECT_NEAR(v[4], v[0] / 0.1, 1e-13);
}

TEST(ConeSolver, ABallThatRollsFeelsItsWeightAlone) {
  const TouchingBodies scene = ball_on_ground({1, 0, 0}, {0, 10, 0}, 0.4);
  const ConeProblem problem = scene.problem();
  const VectorX r = impulses(problem);
  EXPECT_NEAR(r[0], 2 * kGravity * 0.01, 1e-14);
  EXPECT_LT(r.tail(2).norm(), 1e-14);
}

TEST(ConeSolver, ABallThatLeavesFeelsNothing) {
  const TouchingBodies scene = ball_on_ground({1, 0, 0.2}, {0, 0, 0}, 0.4);
  EXPECT_EQ(impulses(scene.problem()).norm(), 0);
}

/// Equal balls in a row; the first one arrives with speed 1, e = 1, no friction.
VectorX speeds_of_cradle(int balls) {
  TouchingBodies scene;
  for (int i = 0; i < balls; ++i) scene.bodies.push_back({.position = {2.0 * i, 0, 0}});
  scene.bodies[0].velocity[0] = 1;
  for (int i = 0; i + 1 < balls; ++i)
    scene.touches.push_back({.a = i, .b = i + 1, .point = {2.0 * i + 1, 0, 0}, .normal = {1, 0, 0}, .restitution = 1});
  const ConeProblem problem = scene.problem();
  const VectorX v = scene.after(problem, impulses(problem));
  VectorX speeds(balls);
  for (int i = 0; i < balls; ++i) speeds[i] = v[6 * i];
  return speeds;
}

TEST(ConeSolver, NewtonsCradleAsOneProblemThrowsTheFirstBallBack) {
  // Simultaneous impacts by Newton's law: the others leave together with 2/N.
  EXPECT_LT((speeds_of_cradle(3) - Vector3(-1, 2, 2) / 3).norm(), 1e-12);
  VectorX five = VectorX::Constant(5, 0.4);
  five[0] = -0.6;
  EXPECT_LT((speeds_of_cradle(5) - five).norm(), 1e-11);
}

TEST(ConeSolver, PainlevesRodAlwaysHasAnImpulse) {
  // Uniform rod of 1 m and 1 kg at tan θ = 2 whose tip slides at 1 m/s, leaning back: beyond μ = 4/3 the normal
  // acceleration p N + b has p < 0, and no force answers; an impulse that stops the tip does.
  const double cosine = std::sqrt(0.2), sine = 2 * cosine, step = 1e-3;
  for (const double friction : {0.5, 1.2, 1.4, 1.8})
    for (const double spin : {0.0, 8.0}) {
      const double p = 1 + 3 * cosine * cosine - 3 * friction * sine * cosine;
      const double b = 0.5 * spin * spin * sine - kGravity;
      TouchingBodies scene;
      scene.bodies.push_back({1, {1, 1.0 / 12, 1}, 0.5 * Vector3(cosine, 0, sine), {-1, 0, b * step}});
      scene.touches.push_back({.b = 0, .point = Vector3::Zero(), .normal = kUp, .friction = friction});
      const ConeProblem problem = scene.problem();
      const VectorX r = impulses(problem), v = scene.after(problem, r);
      EXPECT_LE(scene.kinetic_energy(v), scene.kinetic_energy(scene.before()));
      if (b > 0) {
        EXPECT_EQ(r.norm(), 0) << friction;  // parts; beyond 4/3 one of two answers
      } else if (p > 0) {
        EXPECT_NEAR(r[0], -b * step / p, 1e-12) << friction;
        EXPECT_NEAR(r.tail(2).norm(), friction * r[0], 1e-13);
      } else {  // impact without collision: 0.3 and 0.4 N s for each m/s of slip, and the weight's part
        EXPECT_NEAR(r[0], 0.3 - 3.4 / 4 * b * step, 1e-12) << friction;
        EXPECT_NEAR(r.tail(2).norm(), 0.4 - 1.2 / 4 * b * step, 1e-12) << friction;
      }
    }
}

TEST(ConeSolver, ASpinningBallIsStoppedByTheFrictionAboutTheNormal) {
  // Spinning friction 1 mm: a step takes σ m g h of I ω, until what is left is less.
  constexpr double kSpinning = 1e-3, kInertia = 0.4 * 2 * 0.01;
  double spin = 1, steps = 0;
  while (spin > 0 && steps < 1000) {
    TouchingBodies scene = ball_on_ground({0, 0, 0}, {0, 0, spin}, 0.4);
    scene.touches[0].moments = true;
    scene.touches[0].spinning = kSpinning;
    const ConeProblem problem = scene.problem();
    const VectorX r = impulses(problem);
    spin = scene.after(problem, r)[5];
    ++steps;
    if (std::abs(spin) < 1e-15) break;
    EXPECT_NEAR(r[5], -kSpinning * 2 * kGravity * 0.01, 1e-15);
  }
  EXPECT_EQ(steps, std::ceil(kInertia * 1 / (kSpinning * 2 * kGravity * 0.01)));
}

TEST(ConeSolver, RollingFrictionHoldsABallOnAGentleSlope) {
  for (const double push : {0.5, 2.0}) {  // of ρ m g h, as a moment about the contact point
    constexpr double kRolling = 1e-3, kRadius = 0.1, kMass = 2, kStep = 0.01;
    TouchingBodies scene = ball_on_ground({push * kRolling / kRadius * kGravity * kStep, 0, 0}, {0, 0, 0}, 0.4);
    scene.touches[0].moments = true;
    scene.touches[0].rolling = kRolling;
    const ConeProblem problem = scene.problem();
    const VectorX r = impulses(problem), v = scene.after(problem, r);
    const double moment = std::min(push, 1.0) * kRolling * kMass * kGravity * kStep;
    EXPECT_NEAR(r.segment<2>(3).norm(), moment, 1e-13);
    EXPECT_NEAR(v[4], push > 1 ? moment / (1.4 * kMass * kRadius * kRadius) : 0, 1e-12);
  }
}

TEST(ConeSolver, TurningTheAxesAcrossChangesNothing) {
  TouchingBodies heap = random_heap(12, 6);
  const VectorX v = heap.after(heap.problem(), impulses(heap.problem()));
  for (auto& touch : heap.touches) touch.turned = 0.25 * M_PI;
  EXPECT_LT((heap.after(heap.problem(), impulses(heap.problem())) - v).norm(), 1e-10);
}

/// Cubes of 0.1 m on top of each other on the ground, four corners a face, one step after their weight sets in.
TouchingBodies stack(int cubes, double top_mass, double slope = 0, double friction = 0.5) {
  constexpr double kEdge = 0.1, kStep = 1.0 / 240;
  TouchingBodies scene;
  for (int i = 0; i < cubes; ++i) {
    scene.bodies.push_back(cube(i + 1 < cubes ? 1 : top_mass, kEdge, (i + 0.5) * kEdge * kUp,
                                kGravity * kStep * Vector3(std::sin(slope), 0, -std::cos(slope))));
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.5, 0.5})
        scene.touches.push_back(
            {.a = i - 1, .b = i, .point = kEdge * Vector3(x, y, i), .normal = kUp, .friction = friction});
  }
  return scene;
}

/// Sums of the normal impulses of each face, in weights of one cube.
VectorX interface_sums(const ConeProblem& problem, const VectorX& r) {
  VectorX sums = VectorX::Zero(static_cast<Eigen::Index>(problem.contacts.size()) / 4);
  for (std::size_t i = 0; i < problem.contacts.size(); ++i)
    sums[static_cast<Eigen::Index>(i) / 4] += r[problem.contacts[i].row] * 240 / kGravity;
  return sums;
}

TEST(DirectConeSolver, ABoxOnFourCornersRestsAQuarterOnEach) {
  const ConeProblem problem = stack(1, 1).problem();
  const VectorX r = solve(DirectConeSolver(), problem);
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(r[3 * i], kGravity / 240 / 4, 1e-15);
    EXPECT_LT(r.segment<2>(3 * i + 1).norm(), 1e-15);
  }
}

TEST(DirectConeSolver, StacksCarryTheirWeightHoweverHeavyTheTop) {
  for (const double top : {1.0, 100.0, 1000.0}) {
    const TouchingBodies scene = stack(10, top);
    const ConeProblem problem = scene.problem();
    const VectorX r = solve(DirectConeSolver(), problem, 1e-12);
    EXPECT_LT(scene.after(problem, r).norm(), 1e-11);
    const VectorX expected = VectorX::LinSpaced(10, 9, 0).array() + top;  // 98.1 N, 88.29 N, ... for equal ones
    EXPECT_LT((interface_sums(problem, r) - expected).norm(), 1e-10 * top);

    VectorX swept = VectorX::Zero(problem.rows);
    EXPECT_FALSE(GaussSeidel({.sweeps = 50}).solve(problem, 1e-12, swept).converged);
    const double error = (interface_sums(problem, swept) - expected).lpNorm<Eigen::Infinity>() / expected[0];
    RecordProperty("gauss_seidel_error_after_50_sweeps_top_" + std::to_string(static_cast<int>(top)),
                   std::to_string(error));
    EXPECT_GT(error, top > 1 ? 0.5 : 0.1);
  }
}

TEST(DirectConeSolver, AStackOnASlopeHoldsUpToTheFrictionAngle) {
  // Two cubes, which do not topple below a slope of 0.5.
  constexpr double kFriction = 0.3;
  const TouchingBodies steady = stack(2, 1, std::atan(0.29), kFriction);
  EXPECT_LT(steady.after(steady.problem(), solve(DirectConeSolver(), steady.problem())).norm(), 1e-12);
  // As a whole, at its foot: the cubes keep together and gain g (sin - μ cos) a second.
  const double slope = std::atan(0.31), speed = kGravity / 240 * (std::sin(slope) - kFriction * std::cos(slope));
  const TouchingBodies sliding = stack(2, 1, slope, kFriction);
  const VectorX v = sliding.after(sliding.problem(), solve(DirectConeSolver(), sliding.problem()));
  EXPECT_NEAR(v[0], speed, 1e-13);
  EXPECT_NEAR(v[6], speed, 1e-13);
}

TEST(DirectConeSolver, ImpulsesThatSolveTheProblemCostNoFactorisation) {
  const ConeProblem problem = stack(10, 100).problem();
  DirectConeSolver solver;
  VectorX r;
  EXPECT_GT(solver.solve(problem, 1e-12, r).iterations, 0);
  const VectorX first = r;
  EXPECT_EQ(solver.solve(problem, 1e-12, r).iterations, 0);
  EXPECT_EQ(r, first);
}

TEST(DirectConeSolver, IslandsAreSolvedByThemselves) {
  TouchingBodies both = stack(3, 100);
  const TouchingBodies other = stack(2, 10);
  const int before = static_cast<int>(both.bodies.size());
  both.bodies.insert(both.bodies.end(), other.bodies.begin(), other.bodies.end());
  for (auto touch : other.touches) {
    touch.a += touch.a < 0 ? 0 : before;
    touch.b += before;
    both.touches.insert(both.touches.begin(), touch);
  }
  const ConeProblem problem = both.problem();
  EXPECT_LT(both.after(problem, solve(DirectConeSolver(), problem)).norm(), 1e-11);
}

TEST(DirectConeSolver, RedundantHeapsWithMomentsObeyCoulomb) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    TouchingBodies heap = random_heap(seed, 10);
    for (auto& touch : heap.touches) {
      touch.moments = true;
      touch.rolling = 0.05;
      touch.spinning = seed % 2 ? 0.1 : 0;
    }
    const ConeProblem problem = heap.problem();
    const VectorX r = solve(DirectConeSolver(), problem), u = problem.delassus() * r + problem.free;
    for (const auto& contact : problem.contacts) {
      const auto roll = r.segment<2>(contact.row + 3), turn = u.segment<2>(contact.row + 3);
      const double limit = contact.rolling * r[contact.row];
      EXPECT_LE(roll.norm(), limit + 1e-12);
      EXPECT_NEAR(roll.dot(turn), -limit * turn.norm(), 1e-10);
      EXPECT_NEAR(r[contact.row + 5] * u[contact.row + 5],
                  -contact.spinning * r[contact.row] * std::abs(u[contact.row + 5]), 1e-10);
    }
    EXPECT_LE(heap.kinetic_energy(heap.after(problem, r)), heap.kinetic_energy(heap.before()));
  }
}

TEST(DirectConeSolver, RandomHeapsObeyCoulombAndGainNoEnergy) {
  int failures = 0, factorizations = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const TouchingBodies heap = random_heap(seed);
    const ConeProblem problem = heap.problem();
    DirectConeSolver solver;
    VectorX r;
    const ConeResult result = solver.solve(problem, 1e-12, r);
    failures += !result.converged;
    factorizations += result.iterations;
    EXPECT_LT(coulomb_error(problem, r), 1e-8) << seed;
    EXPECT_LE(heap.kinetic_energy(heap.after(problem, r)), heap.kinetic_energy(heap.before())) << seed;
  }
  EXPECT_EQ(failures, 0);
  RecordProperty("factorisations", factorizations / 300.0);
}

TEST(DirectConeSolver, WithoutFrictionItFindsTheOneVelocityThatEnumerationFinds) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    TouchingBodies heap = random_heap(seed, 6);
    for (auto& touch : heap.touches) touch.friction = 0;
    const ConeProblem problem = heap.problem();
    const int n = static_cast<int>(problem.contacts.size());
    const MatrixX all = problem.delassus();
    std::vector<int> rows;
    for (const auto& contact : problem.contacts) rows.push_back(contact.row);
    const MatrixX W = all(rows, rows);
    const VectorX free = problem.free(rows);
    // Every set of closed contacts; the least-norm impulses of one of them part nothing and pull nowhere.
    VectorX u;
    for (int set = 0; set < 1 << n && u.size() == 0; ++set) {
      std::vector<int> closed;
      for (int i = 0; i < n; ++i)
        if (set >> i & 1) closed.push_back(i);
      VectorX p = VectorX::Zero(n);
      if (!closed.empty()) p(closed) = least_norm(W(closed, closed), -free(closed));
      const VectorX found = W * p + free;
      const bool held = closed.empty() || found(closed).lpNorm<Eigen::Infinity>() < 1e-11;
      if (held && p.minCoeff() > -1e-12 && found.minCoeff() > -1e-12) u = found;
    }
    ASSERT_EQ(u.size(), n) << seed;
    const VectorX r = solve(DirectConeSolver(), problem);
    EXPECT_LT(((all * r + problem.free)(rows)-u).norm(), 1e-10) << seed;
  }
}

TEST(DirectConeSolver, ContactsBetweenThingsThatCannotMoveAreLeftAlone) {
  ConeProblem problem;
  problem.contacts.push_back({.friction = 0.5});
  problem.rows = 3;
  problem.free = Vector3(-1, 0, 0);
  VectorX r;
  for (ConeSolver* solver : std::initializer_list<ConeSolver*>{new GaussSeidel, new DirectConeSolver}) {
    solver->solve(problem, 1e-12, r);
    EXPECT_EQ(r, VectorX::Zero(3));
    delete solver;
  }
}

TEST(GaussSeidel, GivesTheSameBitsWhateverItSolvedBefore) {
  GaussSeidel fresh, used;
  const ConeProblem problem = random_heap(5).problem();
  VectorX a = VectorX::Zero(problem.rows), b = a, other;
  used.solve(random_heap(6).problem(), 0, other);
  fresh.solve(problem, 0, a);
  used.solve(problem, 0, b);
  EXPECT_EQ(a, b);
}

TEST(GaussSeidel, WhatItCallsSolvedObeysCoulombAndTheRestIsFinishedDirectly) {
  int solved = 0;
  for (unsigned seed = 300; seed < 400; ++seed) {
    const ConeProblem problem = random_heap(seed).problem();
    VectorX r;
    if (GaussSeidel({.sweeps = 300}).solve(problem, 1e-11, r).converged) {
      ++solved;
      EXPECT_LT(coulomb_error(problem, r), 1e-8) << seed;
    } else {
      EXPECT_TRUE(r.allFinite());
    }
    r.setZero();
    EXPECT_TRUE(AutomaticConeSolver().solve(problem, 1e-11, r).converged) << seed;
    EXPECT_LT(coulomb_error(problem, r), 1e-8) << seed;
  }
  EXPECT_GT(solved, 50);
}

TEST(GaussSeidel, ProjectedStepsEndWhereExactOnesDo) {
  const TouchingBodies scene = ball_on_ground({1, 2, 0}, {0, 3, 5}, 0.4);
  const ConeProblem problem = scene.problem();
  const VectorX r = solve(GaussSeidel({.sweeps = 200, .exact_blocks = false}), problem);
  EXPECT_LT((r - impulses(problem)).norm(), 1e-12);
}

TEST(GaussSeidel, AnswersTheFreeBodiesAndTheGeneralContactAlike) {
  // The same heap with each contact as one of six rows whose moments have no room.
  TouchingBodies heap = random_heap(9, 5);
  const VectorX free_bodies = heap.after(heap.problem(), impulses(heap.problem()));
  for (auto& touch : heap.touches) touch.moments = true;
  EXPECT_LT((heap.after(heap.problem(), impulses(heap.problem())) - free_bodies).norm(), 1e-10);
}

TEST(BulletMlcp, SolvesFrictionAlongTheAxesAndErrsBetweenThem) {
  using Method = BulletMlcp::Method;
  for (const Method method : {Method::dantzig, Method::lemke, Method::projected_gauss_seidel}) {
    BulletMlcp solver({.method = method, .iterations = 200});
    for (const double turned : {0.0, 0.25 * M_PI}) {
      TouchingBodies scene = ball_on_ground({3, 0, 0}, {0, 0, 0}, 0.4);
      // Axes across along the slip, or between: there the pyramid holds it back √2 times as much.
      const Vector3 across = kUp.unitOrthogonal();
      scene.touches[0].turned = turned - std::atan2(across[1], across[0]);
      const ConeProblem problem = scene.problem();
      VectorX r;
      const ConeResult result = solver.solve(problem, 1e-9, r);
      EXPECT_EQ(result.converged, turned == 0) << solver.name() << result.residual;
      const double loss = 3 - scene.after(problem, r)[0], factor = turned == 0 ? 1 : std::sqrt(2);
      EXPECT_NEAR(loss, factor * 0.4 * kGravity * 0.01, 1e-9) << solver.name();
    }
  }
}

TEST(BulletMlcp, AgreesWithTheConeWhereNothingSlides) {
  const TouchingBodies scene = ball_on_ground({0.05, 0.02, 0}, {0, 0, 0}, 0.4);
  const ConeProblem problem = scene.problem();
  using Method = BulletMlcp::Method;
  for (const Method method : {Method::dantzig, Method::lemke, Method::projected_gauss_seidel})
    EXPECT_LT((solve(BulletMlcp({.method = method}), problem) - impulses(problem)).norm(), 1e-12);
}

TEST(BulletMlcp, ReturnsNumbersEvenWhereItGivesUp) {
  using Method = BulletMlcp::Method;
  for (const Method method : {Method::dantzig, Method::lemke, Method::projected_gauss_seidel})
    for (unsigned seed = 0; seed < 20; ++seed) {
      const ConeProblem problem = random_heap(seed, 8).problem();
      VectorX r, u;
      const ConeResult result = BulletMlcp({.method = method, .iterations = 5}).solve(problem, 1e-9, r);
      ASSERT_TRUE(r.allFinite());
      problem.velocity(r, u);
      EXPECT_EQ(result.residual, problem.residual(r, u));
      EXPECT_EQ(result.converged, result.residual <= 1e-9);
    }
}

}  // namespace
}  // namespace lithe::test::cone_solver_test
