// Eight models of MSC ADAMS, drawn with our joints as they are printed in tests/data/adams/*.adm, and every column of
// the results that ADAMS computed. The bounds (tests/support/adams_results.cpp) are what ADAMS itself lacks: how far it
// is from an independent Newton-Euler run at 1e-12 (tests/data/adams/README.md), and the next step of its second digit.
// Ours runs at 1e-12 too, so that it must leave the same difference; measured, it leaves the same two digits. Columns
// that are zero: to round-off. They are a millionth to a thousandth of the quantities: a wrong sign, a wrong axis or
// the other marker's reaction leaves the whole of them.
#include <gtest/gtest.h>

#include <array>

#include "bodies/rigid_body.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/cylindrical_joint.h"
#include "joints/distance_joint.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/spring_damper.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "tests/support/adams_results.h"
#include "tests/support/methods.h"

namespace lithe::test::adams_test {
namespace {

/// REULER: body-fixed 3-1-3 angles, degrees.
Matrix3 reuler(double a, double b, double c) {
  const double degree = M_PI / 180;
  return rotation_about(Vector3::UnitZ(), a * degree) * rotation_about(Vector3::UnitX(), b * degree) *
         rotation_about(Vector3::UnitZ(), c * degree);
}

/// MARKER: QP and REULER, in the part's frame; all part frames are the world's at the start.
struct PrintedMarker {
  Vector3 qp{0, 0, 0};
  Matrix3 axes = Matrix3::Identity();
};

/// A model: ground, and PART/02 with its CM marker 0201 and IP.
class Printed {
 public:
  Printed(const PrintedMarker& cm, const Vector3& ip)
      : cm_(cm),
        part(graph.add<RigidBody>("part 02", {.mass = 1, .inertia = ip, .position = cm.qp, .orientation = cm.axes})),
        centre(part.marker()) {}

  Marker on_ground(const PrintedMarker& m) { return graph.ground().marker(m.qp, m.axes); }
  Marker on_part(const PrintedMarker& m) {
    return part.marker(cm_.axes.transpose() * (m.qp - cm_.qp), cm_.axes.transpose() * m.axes);
  }

  SystemGraph graph{{.gravity = {0, 0, -9.80665}}};

 private:
  PrintedMarker cm_;

 public:
  RigidBody& part;
  Marker centre;
};

/// `on_ground`: what joints and forces do to ground, about their marker I there; added up.
void compare(const std::string& name, Printed& model, const std::vector<Sensor>& on_ground) {
  const System system = assemble(model.graph);
  std::vector<Sensor> sensors = {position(model.centre),         velocity(model.centre),
                                 acceleration(model.centre),     orientation(model.centre),
                                 angular_velocity(model.centre), angular_acceleration(model.centre)};
  sensors.insert(sensors.end(), on_ground.begin(), on_ground.end());
  Recorder recorder(sensors);
  const Method method = runge_kutta8(1e-12);
  Simulation simulation(system, *method);
  simulation.observe(recorder, every(0.01));
  State state = system.initial_state();
  simulation.run(state, 5);

  std::array<std::vector<AddedColumns>, 8> columns;
  int next = 1;
  for (std::size_t k = 0; k < columns.size(); ++k)
    for (int c = 0; c < (k == 3 ? 4 : 3); ++c, ++next) {
      AddedColumns& sum = columns[k].emplace_back(1, next);
      for (int load = 1; k >= 6 && load < static_cast<int>(on_ground.size()); ++load) sum.push_back(next + 6 * load);
    }
  expect_adams_results(name, recorder.table(), columns);
}

const PrintedMarker kPin{{1, 2, 3}, reuler(180, 45, 180)}, kPendulum{{3, 2, 3}, reuler(180, 45, 180)};
const Vector3 kInertia(0.04, 0.1, 0.1);

// JOINT/1, ..., I = 0102 (ground), J = 0202 (part). A is J and B is I: what is measured of B against A is then that of
// I against J, and reaction(joint, 1) is JOINT(1, 0, ...), the load on I.

TEST(Adams, revolute_case_02) {
  Printed model(kPendulum, kInertia);
  const auto& joint = model.graph.add<RevoluteJoint>("1", {model.on_part(kPin), model.on_ground(kPin)});
  compare("Revolute_Case02", model, {reaction(joint, 1)});
}

TEST(Adams, spherical_case_02) {
  Printed model(kPendulum, kInertia);
  const auto& joint = model.graph.add<SphericalJoint>("1", {model.on_part(kPin), model.on_ground(kPin)});
  compare("Spherical_Case02", model, {reaction(joint, 1)});
}

TEST(Adams, prismatic_case_02) {
  Printed model(kPendulum, kInertia);
  const auto& joint = model.graph.add<PrismaticJoint>("1", {model.on_part(kPin), model.on_ground(kPin)});
  compare("Prismatic_Case02", model, {reaction(joint, 1)});
}

TEST(Adams, cylindrical_case_03) {
  Printed model(kPendulum, kInertia);
  const auto& joint = model.graph.add<CylindricalJoint>("1", {model.on_part(kPin), model.on_ground(kPin)});
  compare("Cylindrical_Case03", model, {reaction(joint, 1)});
}

// HOOKE keeps x of I at right angles to y of J, as UniversalJoint does with x of A and y of B: A is I here, B is J.
TEST(Adams, universal_case_02) {
  Printed model({{-2, 0, 0}, reuler(90, 90, -90)}, {0.1, 0.1, 0.04});
  const PrintedMarker cross{{0, 0, 0}, reuler(90, 90, -90)};
  const auto& joint = model.graph.add<UniversalJoint>("1", {model.on_ground(cross), model.on_part(cross)});
  compare("Universal_Case02", model, {reaction(joint, 0)});
}

/// A part in general motion on a universal joint between a marker on ground and one on it.
struct Gyration {
  Printed model{PrintedMarker{.qp = {0.3, 0.1, -0.4}}, Vector3(0.04, 0.1, 0.12)};
  Marker i, j;
  State state;

  /// The joint's own markers are turned from those that are looked at.
  Gyration(const Matrix3& i_axes, const Matrix3& j_axes, const Matrix3& turn_i, const Matrix3& turn_j)
      : i(model.on_ground({{0, 0, 0}, i_axes})), j(model.on_part({{0, 0, 0}, j_axes})) {
    model.graph.add<UniversalJoint>(
        "cross", {model.on_ground({{0, 0, 0}, i_axes * turn_i}), model.on_part({{0, 0, 0}, j_axes * turn_j})});
    model.graph.add<SpringDamper>("spring", {model.on_ground({{1, 2, 0.5}}), model.centre}, {.stiffness = 20});
  }
  /// Largest |column a of I · column b of J| over two seconds.
  double largest(int a, int b) {
    const System system = assemble(model.graph);
    Recorder recorder({Sensor{"dot", {"dot"}, [&](Snapshot& now, std::span<double> out) {
                                out[0] = now.marker(i).R.col(a).dot(now.marker(j).R.col(b));
                              }}});
    const Method method = runge_kutta8(1e-10);
    Simulation simulation(system, *method);
    simulation.observe(recorder, every(0.02));
    state = system.initial_state();
    simulation.run(state, 2);
    double found = 0;
    for (int row = 0; row < recorder.table().row_count(); ++row)
      found = std::max(found, std::abs(recorder.table().at(row, 1)));
    return found;
  }
};

TEST(Adams, hooke_is_x_of_the_first_marker_against_y_of_the_second) {
  const Matrix3 E = Matrix3::Identity();
  EXPECT_LT(Gyration(E, E, E, E).largest(0, 1), 1e-12);
  EXPECT_GT(Gyration(E, E, E, E).largest(1, 0), 0.05) << "the other order is another joint";
}

TEST(Adams, universal_is_z_against_z_and_ours_with_turned_markers) {
  const Matrix3 E = Matrix3::Identity(), x_to_z = rotation_about(Vector3::UnitY(), -M_PI / 2),
                y_to_z = rotation_about(Vector3::UnitX(), M_PI / 2);
  const Matrix3 across = rotation_about(Vector3::UnitX(), -M_PI / 2);  // z of J along y: at right angles to z of I
  EXPECT_LT(Gyration(E, across, x_to_z, y_to_z).largest(2, 2), 1e-12);
  EXPECT_GT(Gyration(E, across, x_to_z, y_to_z).largest(0, 1), 0.05);
}

// GCON/1, FUNCTION = DM(0202, 0102) - 2
TEST(Adams, distance_case_03) {
  Printed model({{0, 4, 0}, reuler(-90, 0, 0)}, kInertia);
  const auto& joint =
      model.graph.add<DistanceJoint>("1", {model.on_part({{0, 2, 0}}), model.on_ground({})}, {.length = 2});
  compare("Distance_Case03", model, {reaction(joint, 1)});
}

// SFORCE/1, TRANSLATIONAL: -k (DM - 2) - c VR, positive pushes I and J apart. The results are those of c = 5.
TEST(Adams, translational_spring_case_02) {
  Printed model({{0, 2, 0}}, kInertia);
  const auto& spring = model.graph.add<SpringDamper>("1", {model.on_part({{0, 2, 0}}), model.on_ground({})},
                                                     {.stiffness = 100, .damping = 5, .natural_length = 2});
  compare("TranSpring_Case02", model, {applied_force(spring, 1)});
}

// SFORCE/1, ROTATIONAL: the torque -k AZ(207, 208) - c WZ on I about z of J, AZ the angle of I from J. The results are
// those of k = 200 N m/rad and c = 10 N m s/rad.
TEST(Adams, rotational_spring_case_01) {
  const PrintedMarker pin{{0, 0, 0}, reuler(180, 90, 180)};
  Printed model({{2, 0, 0}, reuler(180, 90, 180)}, kInertia);
  auto& joint = model.graph.add<RevoluteJoint>("1", {model.on_part(pin), model.on_ground(pin)});
  const auto& spring = model.graph.add<CoordinateSpring>("SFORCE 1", {joint.angle()},
                                                         {.stiffness = 200, .damping = 10, .free_value = 0.0});
  compare("RotSpring_Case01", model, {reaction(joint, 1), applied_force(spring, 1)});
}

}  // namespace
}  // namespace lithe::test::adams_test
