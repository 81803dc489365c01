// 23_world_placement: a crank-rocker drawn as a CAD program tells it: everything in world coordinates.
//
// Shows: joints placed once, by a point and an axis; orientations from Euler angles and from a matrix printed with six
//        digits; a point mass; a planar pin that closes the loop without redundant rows; the sum of reactions.
// Expect: the rocker follows the closed form of the loop to 1e-10 rad; averaged over a turn the bearings carry the
//         weight of all parts to 1e-9 of it.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

constexpr double kCrank = 0.1, kCoupler = 0.35, kRocker = 0.3, kBase = 0.4;  // m

/// A point of the xz plane, at an angle from x towards z.
Vector3 point(const Vector3& from, double length, double angle) {
  return from + length * Vector3(std::cos(angle), 0, std::sin(angle));
}

/// Angle of the rocker for an angle of the crank: the triangle of rocker, coupler and the line between their ends.
double rocker_angle(double crank) {
  const Vector3 d = point({-kBase, 0, 0}, kCrank, crank);
  const double s = d.norm();
  return M_PI + std::atan2(-d.z(), -d.x()) -
         std::acos((kRocker * kRocker + s * s - kCoupler * kCoupler) / (2 * kRocker * s));
}

}  // namespace

int main() {
  // 1. The points of the drawing: two bearings, the ends of crank and rocker.
  constexpr double kStart = M_PI / 3;
  const Vector3 left(0, 0, 0), right(kBase, 0, 0), along(0, -1, 0);  // the axis of all joints
  const Vector3 crank_end = point(left, kCrank, kStart), rocker_end = point(right, kRocker, rocker_angle(kStart));

  // 2. Three rods in the middle between their ends. Orientations: yaw, pitch and roll, or a matrix from a file.
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  const auto rod = [&](const char* name, const Vector3& a, const Vector3& b, const Matrix3& axes) -> RigidBody& {
    const double length = (b - a).norm(), mass = 2 * length, J = mass * length * length / 12;
    return graph.add<RigidBody>(
        name, {.mass = mass, .inertia = {J / 100, J, J}, .position = (a + b) / 2, .orientation = axes});
  };
  const Vector3 reach = rocker_end - crank_end;
  Matrix3 printed;
  printed << -0.223086, 0, -0.974799, 0, 1, 0, 0.974799, 0, -0.223086;
  auto& crank = rod("crank", left, crank_end, rotation_from_euler_321(0, -kStart, 0));
  auto& coupler =
      rod("coupler", crank_end, rocker_end, rotation_from_euler_321(0, -std::atan2(reach.z(), reach.x()), 0));
  auto& rocker = rod("rocker", right, rocker_end, nearest_rotation(printed));
  auto& lump = graph.add<PointMass>("lump", {.mass = 0.5, .position = rocker_end + Vector3(0, 0, 0.1)});

  // 3. Joints, each placed once. The last pin holds two rows: a hinge there would repeat three.
  auto& motor = graph.add<RevoluteJoint>("motor", at_world(graph.ground(), crank, {.point = left, .axis = along}));
  auto& bearing =
      graph.add<RevoluteJoint>("bearing", at_world(graph.ground(), rocker, {.point = right, .axis = along}));
  graph.add<RevoluteJoint>("crank pin", at_world(crank, coupler, {.point = crank_end, .axis = along}));
  graph.add<PlanarPinJoint>("rocker pin", at_world(coupler, rocker, {.point = rocker_end, .axis = along}));
  graph.add<SphericalJoint>("weight", at_world(coupler, lump, {.point = lump.parameters().position}));
  graph.add<CoordinateDrive>("drive", {motor.angle()}, {.motion = ramp(0, 2 * M_PI)});

  // 4. One turn. The two bearings together: force on ground, moment about the left one.
  const System system = assemble(graph);
  std::printf("%d degrees of freedom, %zu redundant rows\n", system.degrees_of_freedom(),
              system.redundant_rows().size());
  State state = system.initial_state();
  Recorder recorder{{coordinate(bearing.angle(), "rocker"),
                     total_reaction(graph.ground(), {&motor, &bearing}, graph.ground().marker(), kWorldAxes, "frame")}};
  Kinematics kinematics{{.step = 1e-2}};
  Simulation simulation{system, kinematics};
  simulation.observe(recorder, every(1e-2));
  simulation.run(state, 1.0);

  // 5. Check the answer.
  const auto t = recorder.table().column("t"), angle = recorder.table().column("rocker"),
             force = recorder.table().column("frame_force_z");
  double off = 0, mean = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    off = std::max(off, std::abs(angle[i] - rocker_angle(kStart + 2 * M_PI * t[i]) + rocker_angle(kStart)));
    if (i > 0) mean += force[i] * (t[i] - t[i - 1]);  // over whole turns: as good as exact
  }
  const double weight = 9.81 * (2 * (kCrank + reach.norm() + kRocker) + 0.5);
  std::printf("rocker off by %.1e rad; mean force on the frame %.6f N, weight %.6f N\n", off, mean, weight);
  return off < 1e-10 && std::abs(mean + weight) < 1e-9 * weight ? 0 : 1;
}
