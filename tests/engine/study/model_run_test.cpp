// One run of a scene, sampled.
#include "engine/study/model_run.h"

#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "integrators/generalized_alpha.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"

namespace lithe::test::model_run_test {
namespace {

TEST(ModelRun, steps_that_end_at_every_sample_are_looked_at_there_alone) {
  constexpr int kSamples = 20, kSteps = 8;  // of a sample
  const auto swing = [](bool meets_samples, long& evaluations) {
    SystemGraph graph{{.gravity = {0, 0, -9.81}}};
    auto& bar = graph.add<RigidBody>("bar", {.mass = 1, .inertia = {1e-3, 0.02, 0.02}, .position = {0.25, 0, 0}});
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
    graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, along_y), bar.marker({-0.25, 0, 0}, along_y)});
    graph.add<UserForce>("wind", {bar.marker()}, {[&](double t, const MarkerView&) {
                           ++evaluations;
                           return force({std::sin(5 * t), 0, 0});
                         }});
    BodyModels none(graph);
    const ModelRun run =
        run_model(graph, none, {}, {position(bar.marker({0.25, 0, 0}), "tip"), velocity(bar.marker(), "speed")},
                  [](const Tolerance&) {
                    return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = 1.0 / 160});
                  },
                  {.duration = 1, .samples = kSamples, .dynamics = false, .meets_samples = meets_samples});
    EXPECT_TRUE(run.reached()) << run.why;
    EXPECT_EQ(run.statistics.steps, kSamples * kSteps);
    return run;
  };
  long always = 0, seldom = 0;
  const ModelRun all = swing(false, always), at_samples = swing(true, seldom);
  ASSERT_EQ(all.samples.row_count(), kSamples + 1);
  ASSERT_EQ(all.samples.values.size(), at_samples.samples.values.size());
  for (std::size_t i = 0; i < all.samples.values.size(); ++i)
    EXPECT_NEAR(all.samples.values[i], at_samples.samples.values[i], 1e-11) << i;
  EXPECT_NEAR(all.residual, at_samples.residual, 1e-11);
  EXPECT_LE(seldom, always - kSamples * (kSteps - 1));  // one less at every step that ends between samples
}

}  // namespace
}  // namespace lithe::test::model_run_test
