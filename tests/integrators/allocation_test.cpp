// Nothing is allocated in a step.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstddef>

#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/readers/calculix.h"
#include "integrators/generalized_alpha.h"
#include "joints/forces/point_force.h"
#include "joints/revolute_joint.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define LITHE_TEST_NO_COUNT
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__GLIBC__)
#define LITHE_TEST_NO_COUNT
#endif

namespace {
std::atomic<long> allocations{0};
}

#ifndef LITHE_TEST_NO_COUNT
// Every allocation of this program, operator new and Eigen's included, ends here; glibc keeps its own under these
// names.
extern "C" {
void* __libc_malloc(std::size_t);               // NOLINT
void* __libc_calloc(std::size_t, std::size_t);  // NOLINT
void* __libc_realloc(void*, std::size_t);       // NOLINT
void* malloc(std::size_t size) noexcept {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* at, std::size_t size) noexcept {
  ++allocations;
  return __libc_realloc(at, size);
}
}
#endif

namespace lithe::test {
namespace {

TEST(Step, AllocatesNothing) {
#ifdef LITHE_TEST_NO_COUNT
  GTEST_SKIP() << "a sanitizer owns malloc";
#endif
  const long before_any = allocations;
  VectorX probe(100);
  EXPECT_GT(allocations, before_any) << "the counter does not count";

  for (Method& method : std::array<Method, 15>{
           runge_kutta(1e-6), runge_kutta_fixed(1e-3), runge_kutta8(1e-6), adams(1e-6), radau(1e-6), radau_fixed(2e-3),
           bdf(1e-6), hht(1e-3), index3(1e-3), index2(1e-3),
           std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.tolerance = {1e-4, 1e-4}}), rattle(1e-3),
           energy_momentum(1e-3), linearly_implicit(1e-3, 1), linearly_implicit(1e-3, 2)}) {
    for (bool revolute : {false, true}) {
      Scene scene = box_chain(8, revolute);
      scene.run(*method, 0.01);
      const long before = allocations;
      bool ok = true;
      while (scene.state.time < 0.2) ok &= method->step(scene.equations, scene.state, 0.2).ok();
      const long counted = allocations - before;
      EXPECT_TRUE(ok);
      EXPECT_EQ(counted, 0) << method->name() << ", " << method->statistics().steps << " steps";
    }
  }
}

TEST(Step, AllocatesNothingForALoadedFlexibleBody) {
#ifdef LITHE_TEST_NO_COUNT
  GTEST_SKIP() << "a sanitizer owns malloc";
#endif
  const FiniteElementModel rod = read_calculix(std::string(LITHE_EXAMPLE_DATA) + "/pendulum/hex8i/calculix/matrices");
  for (Deflection deflection : {Deflection::linear, Deflection::stiffened, Deflection::quadratic}) {
    const auto basis = make_basis(rod, HingeFrame{rod.node_set("hinge")}, 9, {.deflection = deflection});
    for (Method& method : std::array<Method, 3>{index3(1e-4), runge_kutta(1e-5), radau(1e-5)}) {
      Scene scene({0, 0, -9.81}, [&](SystemGraph& graph) {
        auto& body = graph.add<FlexibleBody>("rod", {.basis = basis});
        const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
        graph.add<RevoluteJoint>(
            "pin", {graph.ground().marker({0, 0.005, 0}, along_y), body.average(rod.node_set("hinge"), along_y)});
        graph.add<PointForce>("push", {body.average(rod.node_set("root_face"))}, {.force = {0, 0, 1}});
      });
      scene.run(*method, 0.01);
      const long before = allocations;
      bool ok = true;
      while (scene.state.time < 0.03) ok &= method->step(scene.equations, scene.state, 0.03).ok();
      EXPECT_TRUE(ok);
      EXPECT_EQ(allocations - before, 0) << method->name();
    }
  }
}

}  // namespace
}  // namespace lithe::test
