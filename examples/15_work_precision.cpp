// 15_work_precision: which method, with which setting, for a scene of one's own; and how fine a model.
//
// Shows: work_precision() runs every integrator over its tolerances (or steps) and draws CPU time over error, proved by
//        two references of different kind; model_precision() does the same over the fidelity of a model.
// Expect: results/work_precision/double_pendulum.svg/.png/.csv, and a table that ends with a recommendation for each
//         decade of error; models.svg/.png/.csv: each model's line comes to a stand at the error of the model.
//         `lithe chart examples/15_work_precision.cpp` charts scene() without a line of main().
#include <algorithm>
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

/// Two rods of 1 m and 1 kg on hinges, released level; watched is the end.
StudyScene scene() {
  return {
      .name = "double pendulum",
      .duration = 1,
      .characteristic_length = 1,  // m: errors are counted in it
      .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
        const Inertia slender{1e-3, 1.0 / 12, 1.0 / 12};
        const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
        auto& upper = graph.add<RigidBody>("upper", {.mass = 1, .inertia = slender, .position = {0.5, 0, 0}});
        auto& lower = graph.add<RigidBody>("lower", {.mass = 1, .inertia = slender, .position = {1.5, 0, 0}});
        graph.add<RevoluteJoint>("shoulder",
                                 {graph.ground().marker({0, 0, 0}, along_y), upper.marker({-0.5, 0, 0}, along_y)});
        graph.add<RevoluteJoint>("elbow", {upper.marker({0.5, 0, 0}, along_y), lower.marker({-0.5, 0, 0}, along_y)});
        return {position(lower.marker({0.5, 0, 0}), "end")};
      }};
}

namespace {

const std::string kRod = std::string(LITHE_EXAMPLE_DATA) + "/pendulum/hex8i/";

/// The flexible rod of example 02 on its hinge, with so many modes; 0: rigid.
StudyScene rod(const FiniteElementModel& model, int modes) {
  return {
      .name = modes == 0 ? "rigid" : std::to_string(modes) + (modes == 1 ? " mode" : " modes"),
      .duration = 0.5,
      .characteristic_length = 0.1,
      .draw = [&model, modes](SystemGraph& graph) -> std::vector<Sensor> {
        const std::vector<int>& edge = model.node_set("hinge");
        auto& body = graph.add<FlexibleBody>("rod", {.basis = make_basis(model, HingeFrame{edge}, modes)});
        const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
        graph.add<RevoluteJoint>("hinge", {graph.ground().marker({0, 0.005, 0}, along_y), body.average(edge, along_y)});
        return {position(body.node(model.node_set("tip").front()), "tip")};
      }};
}

const WorkPoint& last_reached(const WorkPrecision& result, const std::string& method) {
  const auto found = std::find_if(result.points.rbegin(), result.points.rend(), [&](const WorkPoint& point) {
    return point.method == method && point.outcome == StudyRun::Outcome::reached;
  });
  if (found == result.points.rend()) throw SimulationError("no run of '" + method + "' came to its end", "", "");
  return *found;
}

}  // namespace

int main() {
  // 1. All methods of integrators/ on the scene.
  const std::vector<StudyMethod> methods = standard_methods();
  const WorkPrecision result =
      work_precision(scene(), methods, {1e-3, 1e-4, 1e-5, 1e-6, 1e-7}, {.references = reference_methods()});
  result.write_csv("results/work_precision/double_pendulum.csv");
  result.write_chart("results/work_precision/double_pendulum");
  std::printf("%s\n", result.table().c_str());

  // 2. Four models of a flexible rod, beside what nonlinear finite elements say of its tip.
  const FiniteElementModel model = read_calculix(kRod + "calculix/matrices");
  Table reference = read_csv(kRod + "trajectory.csv");
  reference.columns = {"t", "tip_x", "tip_y", "tip_z", "tip_vx", "tip_vy", "tip_vz"};
  std::vector<StudyScene> models;
  for (int modes : {0, 1, 3, 9}) models.push_back(rod(model, modes));
  const WorkPrecision fidelity =
      model_precision("flexible pendulum against finite elements", models, reference,
                      select_methods(methods, {"explicit Runge-Kutta 5(4)"}).front(), {1e-2, 1e-3, 1e-4, 1e-5}, {});
  fidelity.write_csv("results/work_precision/models.csv");
  fidelity.write_chart("results/work_precision/models");
  std::printf("%s", fidelity.table().c_str());

  // 3. Check the answer: every method converges, each decade has a point that keeps it, finer models are closer.
  bool sound = result.reference_good() && !result.recommendations().empty();
  for (const StudyMethod& method : methods) {
    const auto first = std::find_if(result.points.begin(), result.points.end(),
                                    [&](const WorkPoint& point) { return point.method == method.name; });
    sound = sound && last_reached(result, method.name).error < 0.1 * first->error;
  }
  for (const auto& [error, point] : result.recommendations()) sound = sound && result.points.at(point).error <= error;
  const double rigid = last_reached(fidelity, "rigid").error, nine = last_reached(fidelity, "9 modes").error;
  std::printf("rigid: off by %.1e of the rod's length, nine modes by %.1e\n", rigid, nine);
  return sound && nine < 0.01 && rigid > 4 * nine ? 0 : 1;
}
