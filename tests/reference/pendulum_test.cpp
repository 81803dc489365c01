// The flexible pendulum against nonlinear finite elements: a linear floating-frame body must deviate by just so much,
// neither more nor less (reference: pendulum/ffrf_deviation.csv, an independent simulation of the same model).
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "engine/output/csv.h"
#include "integrators/generalized_alpha.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/three_node_fixation.h"
#include "tests/bodies/flexible_models.h"

namespace lithe::test::pendulum_test {
namespace {

constexpr double kSpans[] = {0.1, 0.15, 0.2, 0.3, 0.5, 1.0};

struct Row {  // of ffrf_deviation.csv
  std::string body, basis, frame, hinge;
  std::vector<double> deviation;  // dz, dvz for each span
  double first_z, first_vz;       // 2: never
};

std::vector<Row> rows() {
  std::ifstream in(std::string(LITHE_EXAMPLE_DATA) + "/pendulum/ffrf_deviation.csv");
  std::vector<Row> out;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::vector<std::string> cell;
    std::stringstream stream(line);
    for (std::string c; std::getline(stream, c, ',');) cell.push_back(c);
    if (cell.size() != 20) throw std::runtime_error("ffrf_deviation.csv: " + line);
    if (cell[5] != "no") continue;  // geometric stiffness: not there yet
    if (cell[2] != "9") continue;   // nine modes; the in-plane bases are of another make
    Row row{cell[0], cell[1], cell[3], cell[4], {}, 2, 2};
    for (int i = 6; i < 18; ++i) row.deviation.push_back(std::stod(cell[i]));
    if (cell[18] != "never") row.first_z = std::stod(cell[18]);
    if (cell[19] != "never") row.first_vz = std::stod(cell[19]);
    out.push_back(row);
  }
  return out;
}

class PendulumDeviation : public testing::TestWithParam<Row> {};

TEST_P(PendulumDeviation, is_that_of_a_linear_floating_frame_body) {
  const Row& row = GetParam();
  const FiniteElementModel model = pendulum_model(row.body);
  const bool hinged = row.frame == "turns about the hinge edge";
  SystemGraph graph;
  auto& rod =
      graph.add<FlexibleBody>("rod", {.basis = make_basis(model, frame_of(model, hinged ? "hinge" : row.frame), 9)});
  const auto& edge = model.node_set("hinge");
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  if (row.hinge == "all hinge nodes held" && edge.size() == 3) {
    graph.add<ThreeNodeFixation>("hinge",
                                 {graph.ground().marker(), rod.node(edge[0]), rod.node(edge[1]), rod.node(edge[2])});
  } else if (row.hinge == "all hinge nodes held") {
    for (int id : edge)
      graph.add<SphericalJoint>("node " + std::to_string(id),
                                {graph.ground().marker(model.nodes.col(model.node_index(id))), rod.node(id)});
  } else {
    graph.add<RevoluteJoint>("hinge", {graph.ground().marker({0, 0.005, 0}, along_y), rod.average(edge, along_y)});
  }
  const Marker tip = rod.node(model.node_set("tip").front());
  const System system = assemble(graph);
  Evaluator equations(system);
  State state = system.initial_state();
  GeneralizedAlpha integrator({.step = 5e-5, .spectral_radius = 0.9});
  integrator.start(equations, state);

  const Table reference = read_csv(std::string(LITHE_EXAMPLE_DATA) + "/pendulum/" + row.body + "/trajectory.csv");
  double dz = 0, dv = 0, first_z = 2, first_vz = 2;
  std::size_t span = 0;
  for (int ms = 1; ms <= 1000; ++ms) {
    const double t = ms * 1e-3;
    while (state.time < t) ASSERT_TRUE(integrator.step(equations, state, t).ok());
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    const MarkerKinematics k = marker_kinematics(equations, tip, Level::velocity);
    dz = std::max(dz, std::abs(k.p.z() - reference.at(ms, 3)));
    dv = std::max(dv, std::abs(k.v.z() - reference.at(ms, 6)));
    if (dz > 4e-4) first_z = std::min(first_z, t);
    if (dv > 4e-2) first_vz = std::min(first_vz, t);
    // Nine free modes held at three nodes on the symmetry plane: round-off grows out of plane from 0.15 s on, in every
    // integrator here; the reference stays in the plane. Compared as far as the motion is determined.
    if (row.body == "hex8i" && row.frame == "mean axes" && row.hinge == "all hinge nodes held" && t > 0.16) break;
    if (t > kSpans[span] - 1e-9) {
      EXPECT_NEAR(dz / row.deviation[2 * span], 1, 0.03) << "dz up to " << kSpans[span];
      EXPECT_NEAR(dv / row.deviation[2 * span + 1], 1, 0.03) << "dvz up to " << kSpans[span];
      ++span;
    }
  }
  EXPECT_NEAR(first_z, row.first_z, 2.1e-3);
  EXPECT_NEAR(first_vz, row.first_vz, 2.1e-3);  // samples are 1 ms apart
}

INSTANTIATE_TEST_SUITE_P(Rows, PendulumDeviation, testing::ValuesIn(rows()), [](const auto& test) {
  std::string name = test.param.body + "_" + test.param.frame + "_" + test.param.hinge;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
});

TEST(StiffFlexibleBody, swings_like_a_rigid_one) {
  const FiniteElementModel model = pendulum_model("stiff");
  SystemGraph graph;
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = make_basis(model, HingeFrame{model.node_set("hinge")}, 3)});
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  graph.add<RevoluteJoint>(
      "hinge", {graph.ground().marker({0, 0.005, 0}, along_y), rod.average(model.node_set("hinge"), along_y)});
  const Marker tip = rod.node(model.node_set("tip").front());
  const System system = assemble(graph);
  Evaluator equations(system);
  State state = system.initial_state();
  GeneralizedAlpha integrator({.step = 1e-4, .spectral_radius = 0.8});
  integrator.start(equations, state);
  const Table rigid = read_csv(std::string(LITHE_EXAMPLE_DATA) + "/pendulum/rigid_pendulum.csv");
  const std::vector<double> t = rigid.column("t"), z = rigid.column("z");
  double worst = 0;
  for (std::size_t i = 1; i < t.size() && t[i] <= 0.5; ++i) {
    while (state.time < t[i]) ASSERT_TRUE(integrator.step(equations, state, t[i]).ok());
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    worst = std::max(worst, std::abs(marker_kinematics(equations, tip, Level::velocity).p.z() - z[i]));
  }
  EXPECT_LT(worst, 1e-6);  // nonlinear finite elements: 1.6e-7 m, the rest is the time step
}

}  // namespace
}  // namespace lithe::test::pendulum_test
