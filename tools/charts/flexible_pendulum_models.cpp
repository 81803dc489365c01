// Fidelities of the flexible pendulum against CalculiX's nonlinear finite elements, modelling error and cost on the
// same axes: rigid, one, three, nine modes, all nodal coordinates.  flexible_pendulum_models FOLDER
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

StudyScene pendulum(const FiniteElementModel& model, const std::string& name, int modes) {
  return {
      .name = name,
      .duration = 1,
      .characteristic_length = 0.1,  // m: the rod
      .draw = [&model, modes](SystemGraph& graph) -> std::vector<Sensor> {
        const std::vector<int>& edge = model.node_set("hinge");
        auto& rod = graph.add<FlexibleBody>("rod", {.basis = make_basis(model, HingeFrame{edge}, modes)});
        const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
        graph.add<RevoluteJoint>("hinge", {graph.ground().marker({0, 0.005, 0}, along_y), rod.average(edge, along_y)});
        return {position(rod.node(model.node_set("tip").front()), "tip")};
      }};
}

}  // namespace

int main(int count, char** arguments) {
  const std::string folder = count > 1 ? arguments[1] : "docs/charts";
  const std::string data = std::string(LITHE_EXAMPLE_DATA) + "/pendulum/hex8i/";
  const FiniteElementModel model = read_calculix(data + "calculix/matrices");
  Table reference = read_csv(data + "trajectory.csv");
  reference.columns = {"t", "tip_x", "tip_y", "tip_z", "tip_vx", "tip_vy", "tip_vz"};
  const WorkPrecision result =
      model_precision("models of the flexible pendulum against CalculiX",
                      {pendulum(model, "rigid", 0), pendulum(model, "1 mode", 1), pendulum(model, "3 modes", 3),
                       pendulum(model, "9 modes", 9), pendulum(model, "all nodal coordinates", kAllNodal)},
                      reference, select_methods(standard_methods(), {"generalized-alpha index 2"}).front(),
                      {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8}, {});
  std::printf("%s", result.table().c_str());
  result.write_csv(folder + "/flexible_pendulum_models.csv");
  result.write_chart(folder + "/flexible_pendulum_models");
}
