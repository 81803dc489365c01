// A scene split over two FMUs, a crane and the hydraulic actuator that lifts it, which an importer couples, against the
// same scene in one piece.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/scripting/exchange_instances.h"

namespace lithe::test::fmu_split_test {
namespace {

const Vector3 kFoot(0.4, 0, -1.2), kLug(1.4, 0, 0);  // of the cylinder, on ground and boom
const double kLength = (kLug - kFoot).norm();
constexpr double kReach = 4, kEnd = 0.8;

HydraulicCylinder& add_cylinder(SystemGraph& graph, Marker A, Marker B) {
  auto& oil = graph.add<FirstOrderStates>("oil", {.start = HydraulicCylinder::start(4e6, 1e6)});
  return graph.add<HydraulicCylinder>(
      "lift", {A, B, oil.point(0)},
      {.bore = 0.1,
       .rod = 0.06,
       .stroke = 0.8,
       .closed_length = kLength - 0.4,
       .cap_dead_volume = 2e-3,
       .rod_dead_volume = 2e-3,
       .friction = 1e4,
       .valve = {
           .area = 3e-5, .command = smooth_step(0, 1, 0.1, 0.4), .time_constant = 0.02, .supply = constant(2e7)}});
}

/// A boom, a load on a rod at its tip; `lift` says what pushes from the foot to the lug.
std::vector<Sensor> draw_crane(SystemGraph& graph, const std::function<void(Marker foot, Marker lug)>& lift) {
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  auto& boom = graph.add<RigidBody>("boom", {.mass = 180, .inertia = {2, 240, 240}, .position = {kReach / 2, 0, 0}});
  auto& load = graph.add<RigidBody>("load", {.mass = 600, .inertia = {40, 40, 40}, .position = {kReach, 0, -1}});
  graph.add<RevoluteJoint>("hinge", {graph.ground().marker({}, along_y), boom.marker_at_world({0, 0, 0}, along_y)});
  graph.add<RevoluteJoint>("hook", {boom.marker_at_world({kReach, 0, 0}, along_y), load.marker({0, 0, 1}, along_y)});
  lift(graph.ground().marker(kFoot), boom.marker_at_world(kLug));
  return {position(boom.marker_at_world({kReach, 0, 0}), "tip"), position(load.marker(), "load")};
}

FmuModel model(std::string name, std::function<std::vector<Sensor>(SystemGraph&)> draw) {
  return {{.name = std::move(name), .duration = kEnd, .draw = std::move(draw)},
          [] {
            return std::make_unique<Radau>(Radau::Parameters{.tolerance = {1e-6, 1e-8}});
          },
          "split"};
}

/// An FMU by the names of its variables.
struct Part {
  explicit Part(const FmuModel& of) : instance(of) { instance.begin(0); }
  double get(const std::string& name) { return instance.get(reference(instance, name)); }
  void set(const std::string& name, double value) { instance.set(reference(instance, name), value, false); }
  FmuInstance instance;
};

FmuModel crane() {
  return model("crane", [](SystemGraph& graph) {
    JointCoordinate length{};
    std::vector<Sensor> sensors = draw_crane(graph, [&](Marker foot, Marker lug) {
      length = {JointCoordinate::Kind::distance, foot, lug};
      graph.add<CoordinateMotor>("lift", {length}, {.effort = graph.add<Input>("push", {.unit = "N"})});
    });
    sensors.push_back(coordinate(length, "length"));
    return sensors;
  });
}

/// The cylinder between ground and a rod that goes where its input says.
FmuModel actuator() {
  return model("actuator", [](SystemGraph& graph) {
    const Matrix3 along_x = rotation_about({0, 1, 0}, M_PI / 2);
    auto& rod = graph.add<RigidBody>("rod", {.mass = 1, .inertia = {1, 1, 1}, .position = {kLength, 0, 0}});
    auto& guide = graph.add<PrismaticJoint>("guide", {graph.ground().marker({}, along_x), rod.marker({}, along_x)});
    auto& length = graph.add<Input>("length", {.unit = "m", .value = kLength, .between = Input::Between::linear});
    graph.add<CoordinateDrive>("drive", {guide.displacement()}, {.motion = length});
    const HydraulicCylinder& lift = add_cylinder(graph, graph.ground().marker(), rod.marker());
    return std::vector<Sensor>{lift.force("push")};
  });
}

using Place = Eigen::Vector3d;  // height of the tip, x and z of the load, m

/// At the end, coupled at intervals: the crane moves with the force held, then the actuator over the length that it
/// got.
Place coupled(double interval) {
  const FmuModel first = crane(), second = actuator();
  Part lifted(first), lifting(second);
  const int steps = static_cast<int>(std::lround(kEnd / interval));
  for (int k = 0; k < steps; ++k) {
    lifted.set("push", lifting.get("push"));
    lifted.instance.step(k * interval, interval);
    lifting.set("length", lifted.get("length"));
    lifting.instance.step(k * interval, interval);
  }
  return {lifted.get("tip_z"), lifted.get("load_x"), lifted.get("load_z")};
}

TEST(FmuSplit, ACraneAndItsActuatorMoveAsInOnePiece) {
  const FmuModel whole = model("whole", [](SystemGraph& graph) {
    return draw_crane(graph, [&](Marker foot, Marker lug) { add_cylinder(graph, foot, lug); });
  });
  Part one(whole);
  one.instance.step(0, kEnd);
  const Place exact{one.get("tip_z"), one.get("load_x"), one.get("load_z")};
  EXPECT_GT(exact.x(), 0.1) << "it has been lifted";
  const Place coarse = coupled(1e-3) - exact, fine = coupled(5e-4) - exact;
  std::printf("off at 1 ms %.3g m, at 0.5 ms %.3g m, lifted %.3f m\n", coarse.norm(), fine.norm(), exact.x());
  // A force that is held errs by the interval, to first order; extrapolated, to second.
  EXPECT_LT(fine.norm(), 1e-4);
  EXPECT_NEAR(coarse.norm() / fine.norm(), 2, 0.3);
  EXPECT_LT((2 * fine - coarse).norm(), 0.15 * fine.norm());
}

}  // namespace
}  // namespace lithe::test::fmu_split_test
