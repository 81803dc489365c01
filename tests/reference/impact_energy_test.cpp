// The energy of impacts of rigid surfaces on every kind of body: e = 1 keeps it, e < 1 never adds to it, also where the
// step does not resolve how a body responds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/surface_mesh.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/model/system_graph.h"
#include "engine/observe/contact_sensors.h"
#include "engine/observe/sensors.h"
#include "engine/observe/snapshot.h"
#include "engine/run/simulation.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/contact/contact.h"
#include "plugins/inertial_body/inertial_body.h"
#include "tests/support/methods.h"

namespace lithe::test::impact_energy_test {
namespace {

enum class Kind { rigid, modal, all_modes, nodal };
const char* name_of(Kind kind) {
  constexpr const char* kNames[] = {"rigid", "modal", "all modes", "nodal"};
  return kNames[static_cast<int>(kind)];
}

const Vector3 kSize(0.4, 0.02, 0.02);  // m
constexpr double kYoung = 2e9, kPoisson = 0.3, kDensity = 1200;
constexpr double kMass = 0.4 * 0.02 * 0.02 * kDensity;

struct NodalRod {
  int divisions = 8;
  double young = kYoung;
};
constexpr double kTilt = 0.1;

/// A rod in nodal coordinates that falls on a table, its lowest corner first.
const Contact& add_nodal_rod(SystemGraph& graph, const NodalRod& of, double speed, const Contact::Parameters& law) {
  const auto mesh =
      std::make_shared<const BrickMesh>(brick_block(kSize, {of.divisions, 1, 1}, {of.young, kPoisson, kDensity}));
  auto& rod = graph.add<InertialBody>("rod", {.mesh = mesh,
                                              .position = {0, 0, 1e-4 + kSize[0] * std::sin(kTilt)},
                                              .orientation = rotation_about({0, 1, 0}, kTilt),
                                              .velocity = {law.friction.coefficient > 0 ? speed : 0, 0, -speed}});
  ElementBlock block{.type = "C3D8"};
  for (const auto& element : mesh->elements) block.nodes.emplace_back(element.begin(), element.end());
  std::vector<Marker> nodes;
  std::vector<Vector3> points;
  for (int i = 0; i < mesh->node_count(); ++i) {
    nodes.push_back(rod.node(mesh->node_ids[i]));
    points.push_back(mesh->nodes.col(i) - mesh->nodes.col(0));
  }
  const auto skin = shape::surface(nodes, points, boundary_triangles({block}, mesh->nodes));
  return graph.add<Contact>("table", {{graph.ground().marker(), shape::half_space()}, {nodes[0], skin}}, law);
}

/// A rod that falls on a table, its lowest corner first.
const Contact& add_rod(SystemGraph& graph, Kind kind, double speed, const Contact::Parameters& law) {
  if (kind == Kind::nodal) return add_nodal_rod(graph, {}, speed, law);
  const Matrix3 turned = rotation_about({0, 1, 0}, kTilt);
  const Vector3 corner(0, 0, 1e-4 + kSize[0] * std::sin(kTilt));
  const Vector3 velocity(law.friction.coefficient > 0 ? speed : 0, 0, -speed);
  const Collider table{graph.ground().marker(), shape::half_space()};
  if (kind == Kind::rigid) {
    const Vector3 squares = kSize.cwiseAbs2();
    auto& rod =
        graph.add<RigidBody>("rod", {.mass = kMass,
                                     .inertia = Vector3(kMass / 12 * (Vector3::Constant(squares.sum()) - squares)),
                                     .position = corner + turned * kSize / 2,
                                     .orientation = turned,
                                     .velocity = velocity});
    return graph.add<Contact>("table", {table, {rod.marker(), shape::box(kSize)}}, law);
  }
  const FiniteElementModel model =
      brick_mesh({.size = kSize, .divisions = {8, 1, 1}, .type = "C3D8I", .material = {kYoung, kPoisson, kDensity}});
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = make_basis(model, MeanAxisFrame{}, kind == Kind::modal ? 6 : 90),
                                              .position = corner,
                                              .orientation = turned,
                                              .velocity = velocity});
  const SurfaceMesh skin = surface(rod);
  return graph.add<Contact>(
      "table", {table, {skin.frame, shape::surface(skin.nodes, skin.points, skin.triangles, skin.reach)}}, law);
}

/// Energy over a run, of the kinetic energy at its start.
struct Course {
  double contact = 0, gained = 0;  // changes in steps with contact, and those of them upwards
  double flight = 0;               // changes upwards in steps without
  double highest = 0;              // above its start
  double deepest = 0;              // m
};

Course run(Kind kind, bool alpha, double step, double restitution, double friction, double speed, double end) {
  SystemGraph graph;
  const Contact& contact = add_rod(
      graph, kind, speed, {.law = RigidSurfaces{.restitution = restitution}, .friction = {.coefficient = friction}});
  const System system = assemble(graph);
  State state = system.initial_state();
  Method method;
  if (alpha)
    method = std::make_unique<NonsmoothGeneralizedAlpha>(NonsmoothGeneralizedAlpha::Parameters{.step = step});
  else
    method = std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = step});
  Simulation simulation(system, *method);
  Snapshot now(system, state);
  const Sensor energy = total_energy(), motion = kinetic_energy(), overlap = penetration(contact),
               force = contact_force(contact, 1);
  const double scale = motion.value(now);
  const double first = energy.value(now);
  double last = first;
  Course course;
  for (int k = 1; k * step < end; ++k) {
    simulation.run(state, k * step);
    now.evaluate(state);
    const double change = (energy.value(now) - last) / scale;
    last = energy.value(now);
    course.highest = std::max(course.highest, (last - first) / scale);
    course.deepest = std::max(course.deepest, overlap.value(now));
    double push[6];
    force.evaluate(now, push);
    if (push[2] > 0)
      course.contact += change, course.gained += std::max(0.0, change);
    else
      course.flight += std::max(0.0, change);
  }
  return course;
}

/// What steps with contact may add. The modes and elements have frequencies up to 40 times what these steps resolve.
/// Moreau-Jean's own rules keep the energy of linear bodies and of solids in nodal coordinates; the impulses of the
/// latter are found as for linear ones where their law takes energy anyway. Generalized-alpha restarts at every impact.
double may_gain(Kind kind, bool alpha) {
  if (kind == Kind::rigid) return 1e-7;
  if (kind == Kind::modal) return 5e-4;
  if (alpha) return 2.5e-2;
  return kind == Kind::nodal ? 1.5e-4 : 3e-4;
}

/// Where a solid in nodal coordinates bends more than a step resolves, corrections after an impact do not end, and the
/// step is halved. They were not looked at: the first two ran until numbers were not finite, the third gained 0.3 %.
TEST(ImpactEnergy, is_kept_where_corrections_after_an_impact_do_not_end) {
  struct Fall {
    double young, speed, step, bound;
  };
  for (const Fall& fall : {Fall{2e9, 20, 1e-4, 5e-5}, Fall{2e9, 5, 1e-4, 1e-6}, Fall{2e7, 1, 1e-3, 1e-5}}) {
    SystemGraph graph;
    add_nodal_rod(graph, {.divisions = 4, .young = fall.young}, fall.speed, {.law = RigidSurfaces{.restitution = 1}});
    const System system = assemble(graph);
    State state = system.initial_state();
    MoreauJean method({.step = fall.step});
    Simulation simulation(system, method);
    Snapshot now(system, state);
    const double first = total_energy().value(now), scale = kinetic_energy().value(now);
    double worst = 0;
    for (int k = 1; k < 60; ++k) {
      simulation.run(state, k * fall.step);
      now.evaluate(state);
      worst = std::max(worst, std::abs(total_energy().value(now) - first) / scale);
    }
    EXPECT_GT(simulation.statistics().steps, 59) << "none was halved";
    expect_below("elastic impact at " + std::to_string(fall.speed) + " m/s, of the energy", worst, fall.bound);
  }
}

TEST(ImpactEnergy, is_kept_by_elastic_impacts_and_never_added_to_by_others) {
  for (const bool alpha : {false, true})
    for (const Kind kind : {Kind::rigid, Kind::modal, Kind::all_modes, Kind::nodal})
      for (const double step : {1e-4, 5e-5})
        for (const double e : {0.0, 0.5, 1.0})
          for (const double friction : {0.0, 0.4}) {
            if (step < 1e-4 && e != (friction > 0 ? 0.5 : 1.0)) continue;  // all at the longer step
            const Course found = run(kind, alpha, step, e, friction, kind == Kind::nodal ? 0.1 : 1, 0.03);
            const std::string name = std::string(alpha ? "alpha, " : "Moreau-Jean, ") + name_of(kind) + ", step " +
                                     std::to_string(step) + ", e " + std::to_string(e) +
                                     (friction > 0 ? ", rubbing" : "");
            if (std::getenv("LITHE_PRINT"))
              std::printf("%-60s contact %9.2e, gained %.2e; flight %.2e; deepest %.1e\n", name.c_str(), found.contact,
                          found.gained, found.flight, found.deepest);
            EXPECT_LT(found.gained, may_gain(kind, alpha)) << name;
            if (kind == Kind::nodal && !alpha) {
              EXPECT_LT(found.flight, 1e-8) << name;
            }
            if (e < 1 || friction > 0) {
              EXPECT_LT(found.contact, 0) << name;
            } else if (!alpha && (kind != Kind::all_modes || step < 1e-4)) {  // else: below
              EXPECT_LT(std::abs(found.contact), kind == Kind::nodal ? 3e-3 : may_gain(kind, alpha)) << name;
            }
          }
}

/// All modes at the longer step: at some speeds an impact loses up to 4 %, at none it gains; at the other step none
/// loses. Which speeds these are is decided by what steps do not resolve.
TEST(ImpactEnergy, of_all_modes_is_lost_at_some_speeds_where_steps_are_long) {
  for (const double step : {1e-4, 5e-5}) {
    int losing = 0;
    for (int k = -10; k <= 10; ++k) {
      const Course found = run(Kind::all_modes, false, step, 1, 0, 1 + 0.002 * k, 0.03);
      EXPECT_LT(found.gained, may_gain(Kind::all_modes, false)) << k;
      EXPECT_GT(found.contact, -0.05) << k;
      if (found.contact < -may_gain(Kind::all_modes, false)) ++losing;
    }
    EXPECT_LE(losing, step < 1e-4 ? 0 : 4) << step;
  }
}

/// A solid in nodal coordinates that falls ten times as fast and bounces some ten times, with elements a hundred times
/// as fast as the step. MoreauJean's forces are the mean along the step, which keeps its energy, also over elastic
/// impacts. The midpoint rule alone rose by 3e-2 at the longer step and 4e-3 at the other; its first iterate gained 24
/// % by half of this time, then burst. Generalized-alpha damps.
TEST(ImpactEnergy, of_a_solid_that_no_step_resolves_does_not_grow) {
  for (const bool alpha : {false, true})
    for (const double step : {1e-4, 5e-5}) {
      const Course found = run(Kind::nodal, alpha, step, 1, 0, 1, step < 1e-4 ? 0.1 : 0.2);
      const std::string name = (alpha ? "alpha, step " : "Moreau-Jean, step ") + std::to_string(step);
      if (std::getenv("LITHE_PRINT"))
        std::printf("%-60s contact %9.2e, gained %.2e; flight %.2e; highest %.2e\n", name.c_str(), found.contact,
                    found.gained, found.flight, found.highest);
      EXPECT_LT(found.highest, alpha ? 3e-4 : 6e-6) << name;
      EXPECT_LT(found.deepest, 1e-4) << name;
    }
}

}  // namespace
}  // namespace lithe::test::impact_energy_test
