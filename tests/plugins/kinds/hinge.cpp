#include "engine/plugin.h"

using namespace lithe;

/// A revolute joint about z, composed: its rows bring their own stiffness under load.
class Hinge final : public Joint</*markers=*/2, /*rows=*/5> {
 public:
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    coincident(A, B, rows);
    perpendicular(A, A.x(), B, B.z(), rows);
    perpendicular(A, A.y(), B, B.z(), rows);
  }
};

LITHE_EXPORT_JOINT(Hinge, "hinge")
