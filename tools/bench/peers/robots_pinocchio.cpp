// Pinocchio's articulated-body algorithm on a robot saved by its Python package: built and called by
// tools/bench/robots.py, from headers alone, so that it has the compiler's flags of Lithe.
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/serialization.hpp>

#include "tools/bench/measure.h"

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const std::string file = arguments.text("model", "");
    const int evaluations = arguments.integer("evaluations", 100000), repeats = arguments.integer("repeat", 5);
    arguments.finish();
    pinocchio::Model model;
    model.loadFromText(file);
    pinocchio::Data data(model);
    Eigen::VectorXd q = pinocchio::neutral(model), v = Eigen::VectorXd::Zero(model.nv), tau = v;
    for (int i = 1; i < model.njoints; ++i) {
      if (model.joints[i].nv() != 1) continue;
      const bool slides = model.joints[i].shortname().rfind("JointModelP", 0) == 0;
      q[model.joints[i].idx_q()] = slides ? 0.01 : 0.3;
      v[model.joints[i].idx_v()] = slides ? 0.05 : 0.5;
    }
    double least = 1e300, sum = 0;
    const auto time = [&](pinocchio::Convention convention) {
      const double started = cpu_seconds();
      for (int i = 0; i < evaluations; ++i) sum += pinocchio::aba(model, data, q, v, tau, convention)[0];
      least = std::min(least, cpu_seconds() - started);
    };
    for (int r = 0; r < repeats; ++r) time(pinocchio::Convention::WORLD), time(pinocchio::Convention::LOCAL);
    JsonLine line;
    line.add("engine", "Pinocchio").add("version", PINOCCHIO_VERSION).add("freedoms", model.nv);
    line.add("us_per_acceleration", 1e6 * least / evaluations, 5).add("sum", sum);
    line.print();
  });
}
