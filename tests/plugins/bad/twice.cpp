// Exports one name twice.
#include "engine/plugin.h"

using namespace lithe;

class Ball final : public Joint<2, 3> {
 public:
  void evaluate(double, std::span<const MarkerView> m, ConstraintRows& rows) const override {
    coincident(m[0], m[1], rows);
  }
};

LITHE_EXPORT_JOINT(Ball, "ball")
LITHE_EXPORT_JOINT(Ball, "ball")
