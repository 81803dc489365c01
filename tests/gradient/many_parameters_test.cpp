#include "bodies/rigid_body.h"
#include "integrators/lie_bdf.h"
#include "integrators/radau.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "tests/gradient/gradient_support.h"

namespace lithe::test {
namespace {

/// A chain of hinged links that hangs in a bow, with springs and dampers in and across its hinges and forces on its
/// links: twenty parameters a link. Its start is consistent, and so it stays with parameters moved.
struct Chain {
  int links;
  double duration, step;

  static constexpr const char* kKinds[] = {
      "mass",  "inertia_x", "inertia_y", "inertia_z", "offset",  "rise",    "spring",  "damper", "free",  "preload",
      "cross", "rub",       "natural",   "pull",      "force_x", "force_y", "force_z", "couple", "place", "aside"};
  static double value(int kind, int i) {
    static constexpr double kValues[] = {0.4,  0.006, 0.01, 0.011, 0.01, 0.02, 6,   0.05, 0.1,  0.02,
                                         40.0, 0.3,   0.3,  0.5,   0.2,  0.1,  0.3, 0.02, 0.05, 0.03};
    return kValues[kind] * (1 + 0.1 * std::sin(1.7 * i + kind));
  }
  std::vector<DesignParameter> parameters() const {
    std::vector<DesignParameter> all;
    for (int i = 0; i < links; ++i)
      for (int k = 0; k < 20; ++k) all.push_back({kKinds[k] + std::to_string(i), value(k, i)});
    return all;
  }
  ParametricScene scene() const {
    return {.name = "chain",
            .duration = duration,
            .draw =
                [n = links](SystemGraph& graph, const SweepPoint& p) {
                  const auto of = [&](const char* kind, int i) { return p[kind + std::to_string(i)]; };
                  const double length = 0.2;
                  Vector3 end = Vector3::Zero();
                  RigidBody* last = nullptr;
                  Vector3 last_end;
                  for (int i = 0; i < n; ++i) {
                    const Matrix3 R = rotation_about({0, 1, 0}, 0.9 - 0.6 * i / n) * rotation_about({0, 0, 1}, 0.1);
                    // Marker places are in the link's axes; the link is placed so that the hinge closes.
                    const Vector3 a(-0.1, of("aside", i), of("rise", i)), b(length - 0.1, 0, 0.01);
                    auto& link =
                        graph.add<RigidBody>("link" + std::to_string(i),
                                             {.mass = of("mass", i),
                                              .inertia = {of("inertia_x", i), of("inertia_y", i), of("inertia_z", i)},
                                              .position = end - R * a,
                                              .orientation = R});
                    const Matrix3 tilt = rotation_about({1, 0.2, 0.1}, -M_PI / 2);
                    const Matrix3 in_last = i == 0 ? R * tilt : Matrix3(rotation(i - 1, n).transpose() * R * tilt);
                    auto& pin = graph.add<RevoluteJoint>(
                        "pin" + std::to_string(i),
                        {last ? last->marker(last_end, in_last) : graph.ground().marker({}, in_last),
                         link.marker(a, tilt)});
                    graph.add<CoordinateSpring>("spring" + std::to_string(i), {pin.angle()},
                                                {.stiffness = of("spring", i),
                                                 .damping = of("damper", i),
                                                 .free_value = of("free", i),
                                                 .preload = of("preload", i)});
                    graph.add<SpringDamper>("cross" + std::to_string(i),
                                            {last ? last->marker({0, of("place", i), 0.1})
                                                  : graph.ground().marker({0, of("place", i), 0.5}),
                                             link.marker({of("offset", i), 0, 0.1})},
                                            {.stiffness = of("cross", i),
                                             .damping = of("rub", i),
                                             .natural_length = of("natural", i),
                                             .preload = of("pull", i)});
                    graph.add<PointForce>("force" + std::to_string(i), {link.marker({0.05, 0, 0})},
                                          {.force = {of("force_x", i), of("force_y", i), of("force_z", i)},
                                           .torque = {0, of("couple", i), 0}});
                    end += R * (b - a);
                    last = &link;
                    last_end = b;
                  }
                  return std::vector<Sensor>{position(last->marker(last_end), "tip"), kinetic_energy("kinetic")};
                },
            .integrator = exact_alpha(step)};
  }
  static Matrix3 rotation(int i, int n) {
    return rotation_about({0, 1, 0}, 0.9 - 0.6 * i / n) * rotation_about({0, 0, 1}, 0.1);
  }
};

/// Sixty parameters, of which those with different terms are moved together, against the forward mode, which moves
/// each alone; tangents with the rows of dampers that turn; the start goes backwards too.
void expect_adjoint_is_tangent(const ParametricScene& scene, const std::vector<DesignParameter>& parameters) {
  const std::vector<Quantity> quantities{value_at("tip_z", 0.2), value_at("tip_x", 0.11), integral("kinetic")};
  const Gradient forwards = gradient(scene, quantities, parameters, {.mode = GradientOptions::Mode::tangent});
  const Gradient backwards = gradient(scene, quantities, parameters, {.mode = GradientOptions::Mode::adjoint});
  EXPECT_FALSE(backwards.differenced);
  EXPECT_LE(backwards.groups, 30);
  for (Eigen::Index i = 0; i < forwards.values.size(); ++i)  // sums in another order
    EXPECT_NEAR(forwards.values[i], backwards.values[i], 1e-14);
  for (Eigen::Index i = 0; i < forwards.derivatives.rows(); ++i) {
    double size = 0, off = 0;
    for (Eigen::Index k = 0; k < forwards.derivatives.cols(); ++k) {
      const double scale = Chain::value(static_cast<int>(k % 20), static_cast<int>(k / 20));
      size = std::max(size, std::abs(forwards.derivatives(i, k)) * scale);
      const double error = std::abs(forwards.derivatives(i, k) - backwards.derivatives(i, k)) * scale;
      if (std::getenv("LITHE_SHOW_ERRORS") && error > 1e-10 * size)
        std::printf("%s by %s: %g %g\n", forwards.quantities[i].c_str(), forwards.parameters[k].c_str(),
                    forwards.derivatives(i, k), backwards.derivatives(i, k));
      off = std::max(off, error);
    }
    if (std::getenv("LITHE_SHOW_ERRORS"))
      std::printf("%s: off %.1e of %.1e, %d groups\n", forwards.quantities[i].c_str(), off / size, size,
                  backwards.groups);
    EXPECT_LE(off, 1e-8 * size) << forwards.quantities[i];
  }
}
TEST(ManyParameters, AdjointByTermsIsTheTangent) {
  const Chain chain{3, 0.2, 4e-3};
  expect_adjoint_is_tangent(chain.scene(), chain.parameters());
}
TEST(ManyParameters, AdjointByTermsIsTheTangentOfRadau) {
  const Chain chain{2, 0.2, 4e-3};
  ParametricScene scene = chain.scene();
  scene.integrator = [] { return std::make_unique<Radau>(Radau::Parameters{.step = 4e-3, .newton_tolerance = 1e-13}); };
  expect_adjoint_is_tangent(scene, chain.parameters());
}
TEST(ManyParameters, AdjointByTermsIsTheTangentOfLieBdf) {
  const Chain chain{3, 0.2, 4e-3};
  ParametricScene scene = chain.scene();
  scene.integrator = [] {
    return std::make_unique<LieBdf>(LieBdf::Parameters{.tolerance = {.relative = 1e-8, .absolute = 1e-9}});
  };
  expect_adjoint_is_tangent(scene, chain.parameters());
}

/// A thousand parameters of twenty kinds in less than four times the run (docs/gradients.md has figures). The bound is
/// that of tests which share their processor.
TEST(ManyParameters, AThousandCostFourRuns) {
  const Chain chain{50, 1, 1e-3};
  ParametricScene scene = chain.scene();
  scene.integrator = [] { return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = 1e-3}); };
  const Gradient found = gradient(scene, {value_at("tip_z", 1)}, chain.parameters());
  EXPECT_EQ(found.mode, GradientOptions::Mode::adjoint);
  EXPECT_FALSE(found.differenced);
  std::printf("%.2f runs of %.3f s: %ld steps, %d evaluations a step for %zu parameters, tape %.1f MB\n",
              found.seconds / found.run_seconds, found.run_seconds, found.steps, found.groups, found.parameters.size(),
              static_cast<double>(found.tape_bytes) / 1e6);
  EXPECT_LT(found.seconds, 12 * found.run_seconds);
}

}  // namespace
}  // namespace lithe::test
