// An FMU for model exchange with more markers than one force element may have: six joints, 24 states.
#include <gtest/gtest.h>

#include <deque>

#include "bodies/rigid_body.h"
#include "engine/archive/archive.h"
#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "joints/revolute_joint.h"
#include "models/fmu/model_exchange_fmu.h"
#include "tests/models/fmu/drive_fmu.h"
#include "tests/support/methods.h"

namespace lithe::test::wide_fmu_test {
namespace {

constexpr int kJoints = 6;
using Reads = ModelExchangeFmu::Reads;

/// Robot of tests/data/fmi/equations.cpp, by FMI 3.0; with directional derivatives, or without.
TestFmu robot_fmu(bool differentiates) {
  std::string text = R"xml(<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Robot" instantiationToken="robot">
  <ModelExchange modelIdentifier="Robot" canGetAndSetFMUState="true" canSerializeFMUState="true")xml";
  text += differentiates ? " providesDirectionalDerivatives=\"true\"/>\n" : "/>\n";
  std::string structure;
  const auto variable = [&](const std::string& name, int reference, const std::string& rest) {
    text += "<Float64 name=\"" + name + "\" valueReference=\"" + std::to_string(reference) + "\" " + rest + "/>\n";
  };
  text += "<ModelVariables>\n";
  for (int j = 0; j < kJoints; ++j) {
    const std::string n = std::to_string(j + 1);
    const int own = 13 + 9 * j;
    variable("angle" + n, 1 + j, "causality=\"input\" start=\"0\"");
    variable("speed" + n, 7 + j, "causality=\"input\" start=\"0\"");
    variable("torque" + n, own, "causality=\"output\"");
    int at = own;
    for (const char* state : {"integral", "current", "heat", "work"}) {
      variable(state + n, ++at, "start=\"0\"");
      const std::string derivative = "derivative=\"" + std::to_string(at++) + "\"";
      variable("der(" + (state + n) + ")", at, derivative);
      structure += "<ContinuousStateDerivative valueReference=\"" + std::to_string(at) + "\"/>\n";
    }
  }
  variable("lag", 67, "causality=\"parameter\" variability=\"fixed\" start=\"1\"");
  variable("cross", 68, "causality=\"parameter\" variability=\"fixed\" start=\"0\"");
  text += "</ModelVariables>\n<ModelStructure>\n" + structure + "</ModelStructure>\n</fmiModelDescription>\n";
  return {3, "Robot", LITHE_TEST_EQUATIONS "Robot.so", text};
}

/// Six links of 0.2 m in a row, held at one end, hinged about y and z by turns; nothing rubs.
struct RobotArm {
  explicit RobotArm(Method with) : method(std::move(with)) {
    for (int j = 0; j < kJoints; ++j) {
      const Matrix3 axes = j % 2 == 0 ? rotation_about({1, 0, 0}, -M_PI / 2) : Matrix3::Identity();
      auto& link = graph.add<RigidBody>(
          "link " + std::to_string(j), {.mass = 0.1, .inertia = {1e-4, 4e-4, 4e-4}, .position = {0.1 + 0.2 * j, 0, 0}});
      const Marker from = before_body ? before_body->marker({0.1, 0, 0}, axes) : graph.ground().marker({}, axes);
      hinges.push_back(
          &graph.add<RevoluteJoint>("hinge " + std::to_string(j), {from, link.marker({-0.1, 0, 0}, axes)}));
      before_body = &link;
    }
  }
  RobotArm& by_one(double lag, double cross, bool differentiates = true) {
    ModelExchangeFmu::Parameters wires{.values = {{"lag", lag}, {"cross", cross}}};
    for (int j = 0; j < kJoints; ++j) {
      const std::string n = std::to_string(j + 1);
      wires.inputs.push_back({"angle" + n, hinges[j]->angle()});
      wires.inputs.push_back({"speed" + n, hinges[j]->angle(), Reads::rate});
      wires.outputs.push_back({"torque" + n, hinges[j]->angle()});
    }
    fmus.emplace_back(graph, "robot", robot_fmu(differentiates).packed(), wires);
    return finish();
  }
  RobotArm& by_six(double lag) {
    const TestFmu file = drive_fmu(3);
    for (int j = 0; j < kJoints; ++j)
      fmus.emplace_back(
          graph, "drive " + std::to_string(j), file.packed(),
          ModelExchangeFmu::Parameters{
              .inputs = {{"motion[1]", hinges[j]->angle()}, {"motion[2]", hinges[j]->angle(), Reads::rate}},
              .laws = {{"target", constant(0.4)}},
              .outputs = {{"torque", hinges[j]->angle()}},
              .values = {{"gains[1]", 12}, {"gains[2]", 40}, {"gains[3]", 0.5}, {"lag", lag}}});
    return finish();
  }
  RobotArm& finish() {
    system = std::make_unique<System>(assemble(graph));
    simulation = std::make_unique<Simulation>(*system, *method);
    for (ModelExchangeFmu& fmu : fmus) fmu.join(*simulation);
    state = system->initial_state();
    return *this;
  }
  VectorX run(double end) {
    simulation->run(state, end);
    VectorX angles(kJoints);
    Snapshot now(*system, state);
    for (int j = 0; j < kJoints; ++j) angles[j] = coordinate(hinges[j]->angle(), "angle").value(now);
    return angles;
  }
  double value(const std::string& variable) {
    Snapshot now(*system, state);
    return fmus[0].sensor(variable).value(now);
  }
  double energy() {
    Snapshot now(*system, state);
    return total_energy("energy").value(now);
  }

  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  RigidBody* before_body = nullptr;
  std::vector<RevoluteJoint*> hinges;
  Method method;
  std::deque<ModelExchangeFmu> fmus;
  std::unique_ptr<System> system;
  std::unique_ptr<Simulation> simulation;
  State state;
};

struct WideCase {
  const char* name;
  Method (*make)();
  double bound;  // rad
};
const WideCase kWide[] = {
    {"automatic", [] { return automatic(1e-8); }, 1e-7},
    {"runge_kutta", [] { return runge_kutta(1e-9); }, 1e-7},
    {"radau", [] { return radau(1e-8); }, 1e-6},
    {"bdf", [] { return bdf(1e-8); }, 1e-6},
    {"ida", [] { return ida(1e-8); }, 1e-6},
    {"index3", [] { return index3(1e-3); }, 1e-4},
};

TEST(WideFmu, MovesARobotAsSixFmusOfOneJointEach) {
  const VectorX six = RobotArm(runge_kutta(1e-10)).by_six(0.01).run(0.4);
  EXPECT_GT(six.lpNorm<Eigen::Infinity>(), 0.1);
  for (const WideCase& c : kWide) {
    RobotArm one(c.make());
    const double energy = one.by_one(0.01, 0).energy();
    expect_below(std::string("angles by ") + c.name, (one.run(0.4) - six).lpNorm<Eigen::Infinity>(), c.bound);
    // States that none of the six have: the work done is what the arm has gained.
    double work = 0;
    for (int j = 1; j <= kJoints; ++j) work += one.value("work" + std::to_string(j));
    expect_below(std::string("energy by ") + c.name, std::abs(one.energy() - energy - work), 20 * c.bound);
    EXPECT_GT(std::abs(work), 0.1);
  }
}

TEST(WideFmu, ThatIsStiffCostsImplicitMethodsFewSteps) {
  for (const bool differentiates : {true, false}) {
    for (auto* make : {+[] { return radau(1e-6); }, +[] { return bdf(1e-6); }}) {
      RobotArm stiff(make());
      const VectorX angles = stiff.by_one(1e-6, 0.5, differentiates).run(0.2);
      const IntegratorStatistics cost = stiff.simulation->statistics();
      expect_below("steps of " + stiff.method->name(), static_cast<double>(cost.steps), 200);
      expect_below("failures of Newton of " + stiff.method->name(), static_cast<double>(cost.newton_failures), 2);
      // From slower ones, by a method without derivatives, the limit of fast amplifiers.
      static const VectorX slower = RobotArm(runge_kutta(1e-8)).by_one(2e-4, 0.5).run(0.2);
      static const VectorX slow = RobotArm(runge_kutta(1e-8)).by_one(4e-4, 0.5).run(0.2);
      expect_below("angles of " + stiff.method->name(), (angles - (2 * slower - slow)).lpNorm<Eigen::Infinity>(), 1e-4);
    }
  }
}

TEST(WideFmu, GoesOnFromACheckpointWithTheSameBits) {
  RobotArm first(radau(1e-6)), second(radau(1e-6));
  first.by_one(0.01, 0.3).run(0.1);
  Archive archive;
  first.simulation->save(first.state, archive);
  archive.rewind();
  second.by_one(0.01, 0.3);
  second.state = second.simulation->resume(archive);
  for (RobotArm* arm : {&first, &second}) arm->run(0.2);
  EXPECT_EQ(first.state.v, second.state.v);
  EXPECT_EQ(first.state.q, second.state.q);
}

}  // namespace
}  // namespace lithe::test::wide_fmu_test
