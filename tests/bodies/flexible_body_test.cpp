#include "bodies/flexible/flexible_body.h"

#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "tests/bodies/flexible_models.h"
#include "tests/support/body_checks.h"

namespace lithe::test::flexible_body_test {
namespace {

struct Case {
  std::string frame;
  int modes;
  bool damped = false;
};

class FlexibleBodyKinds : public testing::TestWithParam<Case> {};

TEST_P(FlexibleBodyKinds, owe_what_every_body_owes) {
  const Case& c = GetParam();
  const FiniteElementModel model = pendulum_model("hex8i");
  SystemGraph graph{{.gravity = {1, 2, -9.81}}};
  FlexibleBody::Parameters parameters{.basis = make_basis(model, frame_of(model, c.frame), c.modes)};
  if (c.damped) parameters.damping = {.mass_proportional = 3, .stiffness_proportional = 1e-4, .modal_ratios = {}};
  if (c.damped && c.modes > 0) parameters.damping.modal_ratios = {0.02};
  auto& body = graph.add<FlexibleBody>("rod", parameters);
  const Matrix3 turn = rotation_about({1, 2, 3}, 0.7);
  check_body(graph, body,
             {body.node(50), body.node(26, turn), body.average({49, 50, 51, 52, 53, 54}, turn), body.average({1, 2, 3}),
              body.frame(turn)},
             {.mass = 0.26,
              .speed = 3,
              .deformation = c.modes == kAllNodal ? 1e-4 : 1e-3,
              .dissipation = c.damped ? 1.0 : 0.0,
              .tolerance = 1e-7});
}

TEST_P(FlexibleBodyKinds, have_the_frames_part_of_their_position_tangent) {
  const Case& c = GetParam();
  const FiniteElementModel model = pendulum_model("hex8i");
  SystemGraph graph{{.gravity = {1, 2, -9.81}}};
  auto& body = graph.add<FlexibleBody>(
      "rod", FlexibleBody::Parameters{.basis = make_basis(model, frame_of(model, c.frame), c.modes)});
  check_position_tangent(graph, body, 3, c.modes == kAllNodal ? 1e-4 : 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Frames, FlexibleBodyKinds,
                         testing::Values(Case{"frameA", 9}, Case{"frameB", 9, true}, Case{"frameC", 4},
                                         Case{"hinge", 9}, Case{"clamp", 6}, Case{"mean axes", 9},
                                         Case{"mean axes", 5, true}, Case{"frameA", 0}, Case{"frameA", kAllNodal},
                                         Case{"clamp", kAllNodal}),
                         [](const auto& test) {
                           std::string name =
                               test.param.frame +
                               (test.param.modes == kAllNodal ? "_nodal" : "_" + std::to_string(test.param.modes)) +
                               (test.param.damped ? "_damped" : "");
                           for (char& c : name)
                             if (c == ' ') c = '_';
                           return name;
                         });

TEST(RigidBody, owes_what_every_body_owes) {
  SystemGraph graph{{.gravity = {1, 2, -9.81}}};
  Matrix3 J;
  J << 2, 0.3, -0.2, 0.3, 3, 0.1, -0.2, 0.1, 4;
  auto& body = graph.add<RigidBody>("brick", {.mass = 2.5, .inertia = J});
  check_body(graph, body, {body.marker({0.3, -0.2, 0.5}, rotation_about({1, 1, 0}, 1.1)), body.marker()},
             {.mass = 2.5, .speed = 3});
}

TEST(FlexibleBody, as_rigid_it_has_the_mass_properties_of_its_mesh) {
  const FiniteElementModel model = pendulum_model("hex8i");
  const ModelCheck mesh = check(model);
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  auto& body = graph.add<FlexibleBody>("rod", {.basis = make_basis(model, MeanAxisFrame{}, 9), .mode_count = 0});
  const auto cache = body.make_cache();
  VectorX q(7), v(6);
  body.initial_state(q, v);
  const BodyState state{q.data(), v.data(), cache.get()};
  body.evaluate(state, Level::velocity);
  const MatrixX M = body.mass_matrix(state);
  EXPECT_NEAR(M(0, 0), 0.26, 1e-13);
  EXPECT_LT((q.head<3>() - mesh.center).norm(), 1e-15);
  EXPECT_LT((M.bottomRightCorner<3, 3>() - mesh.inertia).cwiseAbs().maxCoeff(), 1e-12 * mesh.inertia.maxCoeff());
  EXPECT_LT(M.topRightCorner(3, 3).cwiseAbs().maxCoeff(), 1e-14);  // frame at the centre of mass
}

TEST(FlexibleBody, truncating_a_basis_is_making_a_smaller_one) {
  const FiniteElementModel model = pendulum_model("hex8i");
  SystemGraph graph;
  auto& part = graph.add<FlexibleBody>("part", {.basis = make_basis(model, MeanAxisFrame{}, 9), .mode_count = 3});
  auto& whole = graph.add<FlexibleBody>("whole", {.basis = make_basis(model, MeanAxisFrame{}, 3)});
  VectorX q(10), v(9);
  whole.initial_state(q, v);
  q.tail<3>() << 1e-3, -2e-3, 5e-4;
  v << 1, 2, 3, 4, 5, 6, 0.1, 0.2, 0.3;
  MatrixX M[2];
  VectorX f[2];
  int i = 0;
  for (FlexibleBody* body : {&part, &whole}) {
    const auto cache = body->make_cache();
    const BodyState state{q.data(), v.data(), cache.get()};
    body->evaluate(state, Level::velocity);
    M[i] = body->mass_matrix(state);
    f[i++] = body->quadratic_velocity_force(state);
  }
  EXPECT_LT((M[0] - M[1]).cwiseAbs().maxCoeff(), 1e-9 * M[1].cwiseAbs().maxCoeff());
  EXPECT_LT((f[0] - f[1]).cwiseAbs().maxCoeff(), 1e-9 * f[1].cwiseAbs().maxCoeff());
}

}  // namespace
}  // namespace lithe::test::flexible_body_test
