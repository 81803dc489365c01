// R09: a free body turning about its unstable middle axis; accuracy to 60 s, invariants to 200 s.
#include <gtest/gtest.h>

#include "tests/reference/accuracy.h"

namespace lithe::test::r09_free_body_test {
namespace {

const Vector3 kInertia(1, 2, 3), kStart(0.001, 1, 0.001);

struct Trial {
  Method method;
  double rates, invariants;  // rad/s and rad; relative
};

double check(Trial run) {
  const Table table = reference("R09_free_asymmetric_body/reference.csv");
  Scene scene = free_body(kInertia, kStart);
  const auto momentum = [&]() -> Vector3 {
    return rotation_matrix(scene.state.q.segment<4>(3)) * kInertia.cwiseProduct(scene.state.v.segment<3>(3));
  };
  const double energy_start = scene.energy();
  const Vector3 momentum_start = momentum();
  double rates = 0, attitude = 0, energy = 0, drift = 0, norm = 0;
  follow(scene, *run.method, table, 200, [&](std::span<const double> row) {
    const Vector4 e = scene.state.q.segment<4>(3);
    if (scene.state.time <= 60) {
      rates = std::max(rates, (scene.state.v.segment<3>(3) - Vector3(row[4], row[5], row[6])).norm());
      const Vector4 exact(row[0], row[1], row[2], row[3]);
      attitude = std::max(attitude, 2 * std::min((e - exact).norm(), (e + exact).norm()));
    }
    energy = std::max(energy, std::abs(scene.energy() / energy_start - 1));
    drift = std::max(drift, (momentum() - momentum_start).norm() / momentum_start.norm());
    norm = std::max(norm, std::abs(e.norm() - 1));
  });
  const std::string name = "R09, " + run.method->name();
  expect_below(name + ", rates to 60 s (rad/s; mark 1e-6)", rates, run.rates);
  expect_below(name + ", attitude to 60 s (rad)", attitude, run.rates);
  expect_below(name + ", energy to 200 s (relative)", energy, run.invariants);
  expect_below(name + ", momentum vector to 200 s (relative)", drift, run.invariants);
  expect_below(name + ", quaternion's norm", norm, 1e-14);
  return std::max(rates, attitude);
}

TEST(R09FreeBody, FlipsOnTimeAndKeepsItsInvariants) {
  check({runge_kutta(1e-10), 3e-8, 1e-9});
  check({ida(1e-11), 1e-7, 1e-8});
  check({index3(1e-3), 1e-6, 5e-7});
  check({index2(1e-3), 1e-6, 5e-7});
}

TEST(R09FreeBody, MeetsItsMarkByDefault) {
  check({automatic(1e-8), 1e-6, kAny});
  expect_accuracy(
      "R09", "rates and attitude to 60 s", 1,
      [](Method m) {
        return check({std::move(m), kAny, kAny});
      },
      60);
}

}  // namespace
}  // namespace lithe::test::r09_free_body_test
