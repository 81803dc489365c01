// A table without its most important function.
#include "engine/plugin.h"

using namespace lithe;

class Ball final : public Joint<2, 3> {
 public:
  void evaluate(double, std::span<const MarkerView> m, ConstraintRows& rows) const override {
    coincident(m[0], m[1], rows);
  }
};

namespace {
void without_evaluate(const lithe_host& host, const char* name) {
  static lithe_joint_type table = plugin::joint_type<Ball>(name);
  table.evaluate = nullptr;
  host.add_joint(host.context, &table);
}
const plugin::Export exported(without_evaluate, "idle_ball");
}  // namespace
