// Against the sensitivities of CVODES and IDAS, for equations written by hand (tests/sundials).
#include <array>
#include <cstdio>
#include <map>

#include "bodies/rigid_body.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/lie_bdf.h"
#include "integrators/radau.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/gradient/gradient_support.h"

namespace lithe::test {
namespace {

/// The same pendulum on a cart.
ParametricScene cart_and_pendulum() {
  return {.name = "cart and pendulum",
          .duration = 0.8,
          .gravity = {0, 0, -9.80665},
          .draw =
              [](SystemGraph& graph, const SweepPoint& p) {
                constexpr double kTilt = 0.5;
                const Matrix3 along_x = rotation_about({0, 1, 0}, M_PI / 2), y = rotation_about({1, 0, 0}, -M_PI / 2);
                const Matrix3 R = rotation_about({0, 1, 0}, kTilt);
                const double a = p["length"], w = p["speed"];
                auto& cart = graph.add<RigidBody>("cart", {.mass = p["cart"], .inertia = {0.1, 0.1, 0.1}});
                auto& bob = graph.add<RigidBody>("bob", {.mass = p["mass"],
                                                         .inertia = {0.02, p["inertia"], 0.02},
                                                         .position = R * Vector3(0, 0, -a),
                                                         .orientation = R,
                                                         .velocity = R * Vector3(-a * w, 0, 0),
                                                         .angular_velocity = {0, w, 0}});
                auto& slide =
                    graph.add<PrismaticJoint>("slide", {graph.ground().marker({}, along_x), cart.marker({}, along_x)});
                auto& pin = graph.add<RevoluteJoint>("pin", {cart.marker({}, y), bob.marker({0, 0, a}, y)});
                graph.add<CoordinateSpring>("spring", {slide.displacement()},
                                            {.stiffness = p["stiffness"], .damping = p["damping"], .free_value = 0});
                return std::vector<Sensor>{position(cart.marker(), "cart"), coordinate(pin.angle(), "angle")};
              },
          .forward_dynamics = false};
}
const std::vector<DesignParameter> kCartNumbers{{"cart", 2},        {"mass", 0.8},  {"inertia", 0.01}, {"length", 0.3},
                                                {"stiffness", 150}, {"damping", 3}, {"speed", 1.5}};

/// A row a quantity, x and θ: its derivatives.
std::map<std::string, MatrixX> by_sundials() {
  std::map<std::string, MatrixX> found;
  FILE* pipe = popen(LITHE_TEST_SENSITIVITIES, "r");
  if (!pipe) return found;
  char package[16];
  while (std::fscanf(pipe, "%15s", package) == 1) {
    MatrixX& rows = found[package];
    rows.conservativeResize(rows.rows() + 1, static_cast<Eigen::Index>(kCartNumbers.size()));
    double value = 0;
    if (std::fscanf(pipe, "%lf", &value) != 1) break;
    for (Eigen::Index k = 0; k < rows.cols(); ++k)
      if (std::fscanf(pipe, "%lf", &rows(rows.rows() - 1, k)) != 1) rows(rows.rows() - 1, k) = std::nan("");
  }
  EXPECT_EQ(pclose(pipe), 0);
  return found;
}

TEST(SundialsGradients, OfCvodesAndIdasAreThose) {
  const std::map<std::string, MatrixX> expected = by_sundials();
  ASSERT_EQ(expected.size(), 2u);
  VectorX scales(static_cast<Eigen::Index>(kCartNumbers.size()));
  for (std::size_t k = 0; k < kCartNumbers.size(); ++k) scales[static_cast<Eigen::Index>(k)] = kCartNumbers[k].value;
  const MakeIntegrator methods[] = {
      [] {
        return std::make_unique<ExplicitRungeKutta>(
            ExplicitRungeKutta::Parameters{.method = ExplicitRungeKutta::Method::dormand_prince8, .step = 4e-3});
      },
      [] { return std::make_unique<Radau>(Radau::Parameters{.step = 2e-3, .newton_tolerance = 1e-13}); },
      [] { return std::make_unique<LieBdf>(LieBdf::Parameters{.tolerance = {.relative = 1e-11, .absolute = 1e-12}}); }};
  for (const MakeIntegrator& method : methods)
    for (const auto mode : {GradientOptions::Mode::tangent, GradientOptions::Mode::adjoint}) {
      ParametricScene scene = cart_and_pendulum();
      scene.integrator = method;
      const Gradient found =
          gradient(scene, {value_at("cart_x", 0.8), value_at("angle", 0.8)}, kCartNumbers, {.mode = mode});
      for (const auto& [package, derivatives] : expected)
        for (Eigen::Index i = 0; i < 2; ++i) {
          const VectorX scaled = derivatives.row(i).transpose().cwiseProduct(scales);
          const VectorX off = found.derivatives.row(i).transpose().cwiseProduct(scales) - scaled;
          const double error = off.lpNorm<Eigen::Infinity>() / scaled.lpNorm<Eigen::Infinity>();
          EXPECT_LE(error, 2e-8) << package << ", " << method()->name();
          if (std::getenv("LITHE_SHOW_ERRORS"))
            std::printf("%s, %s: off %.1e\n", package.c_str(), method()->name().c_str(), error);
        }
    }
}

}  // namespace
}  // namespace lithe::test
