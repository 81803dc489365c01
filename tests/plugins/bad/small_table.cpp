// One table as a young interface had it, and a good one beside it: neither is to be registered.
#include "engine/plugin.h"

using namespace lithe;

class Ball final : public Joint<2, 3> {
 public:
  void evaluate(double, std::span<const MarkerView> m, ConstraintRows& rows) const override {
    coincident(m[0], m[1], rows);
  }
};

LITHE_EXPORT_JOINT(Ball, "good_ball")

namespace {
void small(const lithe_host& host, const char* name) {
  static lithe_joint_type table = plugin::joint_type<Ball>(name);
  table.struct_size = 40;
  host.add_joint(host.context, &table);
}
const plugin::Export exported(small, "small_ball");
}  // namespace
