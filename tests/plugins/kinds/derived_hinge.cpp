#include "engine/plugin.h"

using namespace lithe;

/// A revolute joint about z from its residual alone.
struct DerivedHinge final : JointByResidual<DerivedHinge, /*markers=*/2, /*rows=*/5> {
  template <class S>
  void residual(std::span<const PoseOf<S>> m, S* g) const {
    for (int i = 0; i < 3; ++i) g[i] = m[1].p[i] - m[0].p[i];
    g[3] = m[0].x().dot(m[1].z());
    g[4] = m[0].y().dot(m[1].z());
  }
};

LITHE_EXPORT_JOINT(DerivedHinge, "derived_hinge")
