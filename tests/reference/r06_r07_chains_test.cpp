// R06, R07: chains of box links with spherical and with revolute joints; mark 1e-6 m at t = 1 s.
#include <gtest/gtest.h>

#include "tests/reference/accuracy.h"

namespace lithe::test::r06_r07_chains_test {
namespace {

struct Trial {
  Method method;
  double tip, energy;  // bounds: m, relative to the energy that has been converted
};

double check_chain(int links, bool revolute, Trial run) {
  const std::string id = revolute ? "R07_chain_revolute" : "R06_chain_spherical";
  const Table table = reference(id + "/reference_N" + std::to_string(links) + ".csv");
  const bool has_middle = table.columns.size() == 10;
  Scene scene = box_chain(links, revolute);
  const double start = scene.energy();
  scene.equations.evaluate(0, scene.state.q, scene.state.v, Level::velocity);
  double tip = 0, middle = 0, energy = 0, swing = 0;
  follow(scene, *run.method, table, 1, [&](std::span<const double> row) {
    tip = std::max(tip, (link_end(scene, links) - Vector3(row[0], row[1], row[2])).norm());
    if (has_middle) middle = std::max(middle, (link_end(scene, links / 2) - Vector3(row[6], row[7], row[8])).norm());
    energy = std::max(energy, std::abs(scene.energy() - start));
    swing = std::max(swing, scene.equations.energy().kinetic);
  });
  const std::string name = id.substr(0, 3) + " N = " + std::to_string(links) + ", " + run.method->name();
  expect_below(name + ", tip over 1 s (m)", tip, run.tip);
  expect_below(name + ", middle joint over 1 s (m)", middle, run.tip);
  expect_below(name + ", energy (relative)", energy / swing, run.energy);
  expect_below(name + ", |g|", scene.violation(Level::position), 1e-9);
  return std::max(tip, middle);
}

TEST(R06SphericalChain, MeetsTheTableFromOneToSixteenLinks) {
  for (int links : {1, 2, 4, 8, 16}) {
    check_chain(links, false, {runge_kutta(1e-8), 2e-8, 2e-8});
    check_chain(links, false, {ida(1e-9), 2e-7, 5e-7});
  }
}

TEST(R07RevoluteChain, MeetsTheTableFromOneToSixteenLinks) {
  for (int links : {1, 2, 4, 8, 16}) {
    check_chain(links, true, {runge_kutta(1e-8), 2e-8, 2e-8});
    check_chain(links, true, {ida(1e-9), 2e-7, 5e-7});
  }
}

TEST(R06R07Chains, GeneralizedAlphaMeetsTheMarkAtSmallSteps) {
  for (bool revolute : {false, true}) {
    check_chain(4, revolute, {index3(5e-5), 1e-6, 1e-6});
    check_chain(4, revolute, {index2(5e-5), 1e-6, 1e-6});
    check_chain(16, revolute, {index3(2e-4), 2e-5, 1e-5});
    check_chain(16, revolute, {index2(2e-4), 2e-5, 1e-5});
  }
}

TEST(R06R07Chains, MeetTheirMarksByDefault) {
  for (bool revolute : {false, true})
    for (int links : {1, 2, 4, 8, 16}) {
      check_chain(links, revolute, {automatic(1e-6), 1e-6, kAny});
      expect_accuracy((revolute ? "R07 N = " : "R06 N = ") + std::to_string(links), "tip and middle joint",
                      0.25 * links, [=](Method m) {
                        return check_chain(links, revolute, {std::move(m), kAny, kAny});
                      });
    }
}

}  // namespace
}  // namespace lithe::test::r06_r07_chains_test
