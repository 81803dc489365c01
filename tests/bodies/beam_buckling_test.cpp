#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "bodies/beam/beam.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "tests/support/json_file.h"
#include "tests/support/methods.h"

/// Critical loads: where the lowest stiffness of the loaded beam vanishes.
namespace lithe::test::beam_buckling_test {
namespace {

/// With the shear factor of the references.
BeamSection rectangle(double edge_2, double edge_3, const Material& material) {
  BeamSection section = BeamSection::rectangle(edge_2, edge_3, material);
  const double G = material.young / (2 * (1 + material.poisson));
  section.stiffness(1, 1) = section.stiffness(2, 2) = 5.0 / 6 * G * edge_2 * edge_3;
  return section;
}

BeamAxis along_x(double length) { return BeamAxis::straight({0, 0, 0}, {length, 0, 0}, {0, 1, 0}); }

/// A scene that is clamped, with one dead load, of which time is the size in N.
struct Loaded {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  Beam *first, *last;

  Loaded(const BeamAxis& axis, const BeamSection& section, int elements)
      : first(&add("beam", axis, section, elements)) {
    last = first;
    graph.add<FixedJoint>("clamp", {graph.ground().marker(axis.pose(0).position, axis.pose(0).axes), first->marker(0)});
  }
  Beam& add(const std::string& name, const BeamAxis& axis, const BeamSection& section, int elements) {
    return graph.add<Beam>(name, {.axis = axis, .sections = {{0, section}}, .elements = elements});
  }
  void push(const Vector3& direction) {
    graph.add<UserForce>("load", {last->marker(last->length())},
                         {[direction](double size, const MarkerView&) { return force(size * direction); }});
  }
};

/// The load near `guess` (N) at which ω² of the lowest mode is zero: the secant.
double critical_load(Loaded& scene, double guess) {
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  const auto lowest = [&](double load) {
    state.time = load;
    state = find_equilibrium(system, state).state;
    return linearize(system, state, {.mode_count = 2}).lowest_stiffness();
  };
  double before = 0.9 * guess, load = 0.95 * guess, lowest_before = lowest(before);
  for (int i = 0; i < 8 && std::abs(load - before) > 1e-8 * guess; ++i) {
    const double now = lowest(load), next = load - now * (load - before) / (now - lowest_before);
    before = load, lowest_before = now, load = next;
  }
  return load;
}

/// On two meshes: the error of the coarse one falls by four, and extrapolation leaves less than `bound`.
void expect_critical(const std::string& what, double exact, double bound,
                     const std::function<double(int refinement)>& find) {
  const double coarse = find(1), fine = find(2);
  EXPECT_NEAR((coarse - exact) / (fine - exact), 4, 0.2) << what;
  expect_below(what + ", coarse", std::abs(coarse / exact - 1), 0.02);
  expect_below(what + ", extrapolated", std::abs((4 * fine - coarse) / 3 / exact - 1), bound);
}

TEST(BeamBuckling, RightAngleFrameBucklesSideways) {
  const auto file = read_json(LITHE_TEST_DATA "/beams/S08_right_angle_frame.json");
  const auto& d = file["data"];
  const double L = d["L"];
  const BeamSection section = rectangle(d["height"], d["thickness"], {d["E"], d["nu"], 2700});
  for (const double sense : {1.0, -1.0}) {
    const std::string name = std::string("torsion exact, force ") + (sense > 0 ? "+x" : "-x");
    const double exact = file["P_cr_N"][name]["P_cr"];
    expect_critical("right-angle frame, " + name, exact, 2e-5, [&](int refinement) {
      Loaded scene(along_x(L), section, 6 * refinement);
      scene.last = &scene.add("second", BeamAxis::straight({L, 0, 0}, {L, -L, 0}, {1, 0, 0}), section, 6 * refinement);
      const Matrix3 turn = scene.last->axes(0).transpose() * scene.first->axes(0);
      scene.graph.add<FixedJoint>("corner", {scene.first->marker(L), scene.last->marker(0, {}, turn)});
      scene.push({sense, 0, 0});
      return critical_load(scene, exact);
    });
  }
}

TEST(BeamBuckling, ThinCantileverTipsOver) {
  expect_critical("lateral buckling", 2973.84644, 1e-5, [&](int refinement) {
    Loaded scene(along_x(1), rectangle(0.1, 0.01, {7.3e10, 0.3, 2700}), 10 * refinement);
    scene.push({0, -1, 0});
    return critical_load(scene, 2973.84644);
  });
}

TEST(BeamBuckling, ColumnBuckles) {
  const BeamSection section = rectangle(0.01, 0.01, {2.1e11, 0.3, 7850});
  expect_critical("column", 431.7763719282804, 1e-5, [&](int refinement) {
    Loaded scene(along_x(1), section, 8 * refinement);
    scene.push({-1, 0, 0});
    return critical_load(scene, 431.7763719282804);
  });
}

/// A load along the column magnifies what a small load aside does.
TEST(BeamBuckling, ColumnIsSofterUnderLoad) {
  const double euler = 431.79519254765944;
  const auto deflection = [&](double share, int elements) {
    Loaded scene(along_x(1), rectangle(0.01, 0.01, {2.1e11, 0.3, 7850}), elements);
    const Marker tip = scene.last->marker(1);
    scene.graph.add<UserForce>("aside", {tip}, {[](double, const MarkerView&) { return force({0, 1e-3, 0}); }});
    scene.push({-share * euler, 0, 0});
    const System system = assemble(scene.graph);
    State state = system.initial_state();
    state.time = 1;
    const Equilibrium found = find_equilibrium(system, state, {.tolerance = 1e-13});
    Snapshot now(system, found.state);
    return now.marker(tip).p[1];
  };
  const double exact[][3] = {{0.3, 1.4228260471406238, 1e-6},
                             {0.6, 2.479327066951714, 1e-6},
                             {0.9, 9.874793308653146, 5e-5},
                             {0.95, 19.742354523384073, 5e-4}};
  for (const auto& [share, amplification, bound] : exact) {
    const double coarse = deflection(share, 16) / deflection(0, 16), fine = deflection(share, 32) / deflection(0, 32);
    expect_below("column, amplification at " + std::to_string(share),
                 std::abs((4 * fine - coarse) / 3 / amplification - 1), bound);
  }
}

}  // namespace
}  // namespace lithe::test::beam_buckling_test
