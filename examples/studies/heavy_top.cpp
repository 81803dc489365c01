// The heavy top of the benchmarks (R08, variant A): fast, through the lower vertical, on a spherical joint. Smooth: the
// chart shows orders.  lithe chart heavy_top
#include "lithe/lithe.h"

using namespace lithe;

StudyScene scene() {
  return {.name = "heavy top",
          .duration = 1,
          .characteristic_length = 1,  // m: from the tip to the centre of mass
          .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
            const Vector3 center(0, 1, 0), omega(0, 150, -4.61538);
            auto& top = graph.add<RigidBody>("top", {.mass = 15,
                                                     .inertia = {0.234375, 0.46875, 0.234375},
                                                     .position = center,
                                                     .velocity = omega.cross(center),
                                                     .angular_velocity = omega});
            graph.add<SphericalJoint>("tip", {graph.ground().marker(), top.marker(-center)});
            return {position(top.marker(), "center")};
          }};
}
