// Closed loops with redundant rows as FMUs for model exchange.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "tests/scripting/exchange_importers.h"
#include "tests/scripting/exchange_instances.h"

namespace lithe::test::fmu_loops_test {
namespace {

/// A four-bar linkage in space, its three redundant rows and all: crank 0.2, coupler 0.5, rocker 0.4, ground 0.5 m.
struct Linkage {
  static constexpr double kCrank = 0.2, kCoupler = 0.5, kRocker = 0.4, kGround = 0.5;
  struct Pin {
    int a, b;            // bodies, -1: ground
    Vector3 on_a, on_b;  // in their axes
  };
  std::vector<Pin> pins;
  double friction = 0;  // coefficient, in the crank's pin

  StudyScene scene() {
    // The coupler's end is at 0.5 m from A and 0.4 m from C.
    const double d = kGround - kCrank, along = (d * d + kCoupler * kCoupler - kRocker * kRocker) / (2 * d);
    const Vector3 O{0, 0, 0}, A{kCrank, 0, 0}, C{kGround, 0, 0},
        B{kCrank + along, std::sqrt(kCoupler * kCoupler - along * along), 0};
    // Rates with which the loop stays closed: ω₁ z × (A - O) + ω₂ z × (B - A) = ω₃ z × (B - C).
    constexpr double kRate = 15;  // rad/s, of the crank
    const Vector3 AB = B - A, CB = B - C, of_A{0, kRate * kCrank, 0}, z{0, 0, 1};
    const double coupler_rate = -kRate * kCrank * CB[1] / (AB[0] * CB[1] - AB[1] * CB[0]);
    const double rocker_rate = coupler_rate * AB[1] / CB[1];
    return {
        .name = "linkage", .gravity = {0, 0, 0}, .draw = [=, this](SystemGraph& graph) -> std::vector<Sensor> {
          pins.clear();
          const auto bar = [&](const char* name, const Vector3& from, const Vector3& to, double mass, double rate,
                               const Vector3& of_from) -> RigidBody& {
            const Vector3 axis = to - from;
            const double inertia = mass * axis.squaredNorm() / 12;
            return graph.add<RigidBody>(name, {.mass = mass,
                                               .inertia = {0.1 * inertia, inertia, inertia},
                                               .position = 0.5 * (from + to),
                                               .orientation = rotation_about(z, std::atan2(axis[1], axis[0])),
                                               .velocity = of_from + rate * z.cross(0.5 * axis),
                                               .angular_velocity = rate * z});
          };
          auto& crank = bar("crank", O, A, 1, kRate, O);
          auto& coupler = bar("coupler", A, B, 0.5, coupler_rate, of_A);
          auto& rocker = bar("rocker", C, B, 0.8, rocker_rate, O);
          const auto pin = [&](const char* name, RigidBody* a, int number_a, const Vector3& on_a, RigidBody& b,
                               int number_b, const Vector3& on_b) {
            pins.push_back({number_a, number_b, on_a, on_b});
            return &graph.add<RevoluteJoint>(name, {a ? a->marker(on_a) : graph.ground().marker(on_a), b.marker(on_b)});
          };
          const Vector3 a{kCrank / 2, 0, 0}, b{kCoupler / 2, 0, 0}, c{kRocker / 2, 0, 0};
          auto* main = pin("main", nullptr, -1, O, crank, 0, -a);
          pin("elbow", &crank, 0, a, coupler, 1, -b);
          pin("head", &coupler, 1, b, rocker, 2, c);
          pin("foot", nullptr, -1, C, rocker, 2, -c);
          if (friction > 0)
            graph.add<JointFriction>("rub", {main->angle()},
                                     {.joint = main, .coefficient = friction, .creep_speed = 0.05, .radius = 0.02});
          return {total_energy("energy"), position(rocker.marker(c), "head"), coordinate(main->angle(), "turned"),
                  joint_reaction(*main, "main")};
        }};
  }
  /// Largest distance between the two sides of a pin, from states alone.
  double gap(const Values& x) const {
    const auto place = [&](int body, const Vector3& on) -> Vector3 {
      if (body < 0) return on;
      const double* q = x.data() + 7 * body;
      const Eigen::Map<const Vector4> e(q + 3);
      return Eigen::Map<const Vector3>(q) + rotation_matrix(e / e.norm()) * on;
    };
    double largest = 0;
    for (const Pin& p : pins)
      largest = std::max(largest, (place(p.a, p.on_a) - place(p.b, p.on_b)).cwiseAbs().maxCoeff());
    return largest;
  }
};

TEST(FmuLoops, AClosedLoopWithRedundantRowsStaysClosedOverAHundredThousandSteps) {
  Linkage linkage;
  const FmuModel model = model_of(linkage.scene());
  Direct one(model);
  const auto n = static_cast<int>(one.instance.states().size());
  const unsigned energy = reference(one.instance, "energy"), head = reference(one.instance, "head_x");
  const double begins = one.instance.get(energy);
  Importer importer(one, n, 0);
  double largest = 0, norm = 0, lost = 0;
  constexpr double kStep = 1e-3;
  for (int i = 1; i <= 100000; ++i) {
    importer.step(i * kStep - importer.time());
    if (i % 7 == 0) {
      largest = std::max(largest, linkage.gap(importer.states()));
      for (int body = 0; body < 3; ++body)
        norm = std::max(norm, std::abs(Eigen::Map<const Vector4>(importer.states().data() + 7 * body + 3).norm() - 1));
    }
    if (i == 2000) {
      Native native(linkage.scene());
      const Values exact = native.at(i * kStep);
      EXPECT_GT(std::abs(exact[4]), 8 * M_PI) << "whole turns are counted";
      for (unsigned k = 0; k < 4; ++k) EXPECT_NEAR(one.instance.get(head + k), exact[1 + k], 1e-6);
    }
    if (i % 1000 == 0) lost = std::max(lost, std::abs(one.instance.get(energy) / begins - 1));
  }
  std::printf("gaps to %.1e m, norms to %.1e, energy to %.1e, %ld corrections\n", largest, norm, lost,
              importer.corrections);
  EXPECT_LT(largest, 1e-8);
  EXPECT_LT(norm, 1e-8);
  EXPECT_LT(lost, 1e-5);
  EXPECT_GT(importer.corrections, 10);
}

TEST(FmuLoops, CvodeKeepsALoopClosed) {
  Linkage linkage;
  const FmuModel model = model_of(linkage.scene());
  Native native(linkage.scene());
  const Values exact = native.at(2);
  // Above 1e-10 the importer's own errors are allowed for, as it has told its tolerance.
  for (const auto& [tolerance, gap, error] : {std::array{1e-10, 1e-8, 1e-6}, {1e-7, 1e-6, 1e-4}}) {
    FmuInstance instance(model, FmuInstance::Form::model_exchange);
    instance.begin(0, tolerance);
    CvodeImporter importer(instance, tolerance);
    double largest = 0;
    importer.run(2, [&](const VectorX& x) { largest = std::max(largest, linkage.gap({x.begin(), x.end()})); });
    const double off = difference(outputs_of(instance), exact, 5);
    std::printf("CVODE at %.0e: %ld steps, %ld corrections, gaps to %.1e m, %.1e off the native run\n", tolerance,
                importer.steps, importer.corrections, largest, off);
    EXPECT_LT(largest, gap);
    EXPECT_LT(off, error);
    EXPECT_LT(10 * importer.corrections, importer.steps) << "its order would never grow";
  }
}

TEST(FmuLoops, ALoopThatRubsIsTheNativeMotionAndRollsBackBitForBit) {
  Linkage linkage{.pins = {}, .friction = 0.3};
  const FmuModel model = model_of(linkage.scene());
  Direct one(model), two(model);
  const auto n = static_cast<int>(one.instance.states().size());
  Importer importer(one, n, 0), other(two, n, 0);
  importer.run(0.5, 2e-4);
  Native native(linkage.scene());
  const Values exact = native.at(0.5), values = outputs_of(one.instance);
  EXPECT_LT(difference(values, exact), 1e-6);
  std::mt19937 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const std::vector<unsigned char> saved = one.instance.save(1);
    const double time = importer.time();
    const int steps = 1 + static_cast<int>(random() % 40);
    const auto go = [&](Importer<Direct>& by, Direct& instance) {
      by.go_on_from(time);
      Values all = outputs_of(instance.instance);
      for (int i = 0; i < steps; ++i) by.step(1e-3);
      const Values end = outputs_of(instance.instance);
      all.insert(all.end(), end.begin(), end.end());
      all.insert(all.end(), by.states().begin(), by.states().end());
      return all;
    };
    const Values forth = go(importer, one);
    one.instance.load(saved.data(), saved.size());
    ASSERT_EQ(go(importer, one), forth) << trial;
    two.instance.load(saved.data(), saved.size());
    ASSERT_EQ(go(other, two), forth) << trial;
  }
}

}  // namespace
}  // namespace lithe::test::fmu_loops_test
