// One flexible body at several fidelities: what FlexibleBody::set_fidelity() owes, against bodies that were made so.
#include <gtest/gtest.h>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/inertia_integrals.h"
#include "bodies/flexible/selected_basis.h"
#include "bodies/rigid_body.h"
#include "engine/observe/sensors.h"
#include "engine/observe/snapshot.h"
#include "engine/study/certificate.h"
#include "tests/bodies/fe_models.h"
#include "tests/support/body_checks.h"
#include "tests/support/motion.h"

namespace lithe::test::fidelity_test {
namespace {

using Modes = std::vector<int>;
constexpr int kModes = 6;
const Modes kAllModes = {0, 1, 2, 3, 4, 5}, kSome = {0, 2, 5};

/// A soft bar in a three-node frame, in which no inertia integral vanishes; its far face keeps its shape.
const FiniteElementModel& bar() {
  static const FiniteElementModel model =
      brick_mesh({.size = {0.4, 0.02, 0.01}, .divisions = {6, 2, 1}, .type = "C3D8I", .material = {5e7, 0.35, 1150}});
  return model;
}
std::shared_ptr<const ModalBasis> basis_of(Deflection deflection) {
  static const auto make = [](Deflection d) {
    const auto& near = bar().node_set("x_min");
    return make_basis(bar(), ThreeNodeFrame{near[0], bar().node_set("x_max")[0], near[4]}, kModes,
                      {.rigid = {bar().node_set("x_max")}, .deflection = d, .deflection_tolerance = 1e-4});
  };
  static const std::shared_ptr<const ModalBasis> bases[] = {make(Deflection::linear), make(Deflection::stiffened),
                                                            make(Deflection::quadratic)};
  return bases[static_cast<int>(deflection)];
}

/// A body with a marker of every kind.
struct Drawn {
  explicit Drawn(FlexibleBody::Parameters parameters) : body(graph.add<FlexibleBody>("bar", std::move(parameters))) {
    const Matrix3 turned = rotation_about({1, 2, 3}, 0.7);
    const Modes tip = bar().node_set("x_max"), side = bar().node_set("y_max");
    markers = {body.node(tip.back(), turned), body.average(side, turned), body.rigid(tip, turned), body.frame(turned)};
    const NodalLoad load = body.nodal_load(side, RandomNumbers(3).matrix3x(static_cast<int>(side.size()), 1));
    markers.insert(markers.end(), load.markers.begin(), load.markers.end());
    load_forces = load.forces;
  }
  SystemGraph graph{{.gravity = {1, -2, -9.81}}};
  FlexibleBody& body;
  std::vector<Marker> markers;
  std::vector<Vector3> load_forces;
};

/// What a body shows at a state: its mass, its forces, its energy, every node, its markers.
using Sight = std::vector<std::pair<std::string, MatrixX>>;

Sight look(const FlexibleBody& body, const std::vector<Marker>& markers, const VectorX& eta, const VectorX& eta_rate) {
  const auto n = eta.size();
  VectorX q(7 + n), v(6 + n);
  q << 0.3, -0.2, 0.5, quaternion_of(rotation_about({3, -1, 2}, 1.1)), eta;
  v << 0.4, -0.7, 0.2, 3, -5, 2, eta_rate;
  const VectorX acceleration = RandomNumbers(11).vector(6 + n);
  const auto cache = body.make_cache();
  const BodyState state{q.data(), v.data(), cache.get()};
  body.evaluate(state, Level::acceleration);
  const Vector3 gravity(1, -2, -9.81);
  const BodyEnergy energy = body.energy(state, gravity);
  Sight sight = {{"mass matrix", body.mass_matrix(state)},
                 {"quadratic velocity force", body.quadratic_velocity_force(state)},
                 {"gravity", body.gravity_force(state, gravity)},
                 {"elastic force", body.elastic_force(state)},
                 {"damping", body.damping_force(state)},
                 {"energy", Vector3(energy.kinetic, energy.elastic, energy.gravity)},
                 {"momenta", (MatrixX(3, 2) << body.linear_momentum(state), body.angular_momentum(state)).finished()}};
  const auto motion = body.nodal_motion(state, acceleration.data());
  sight.insert(sight.end(), {{"places of nodes", motion.position},
                             {"velocities of nodes", motion.velocity},
                             {"accelerations of nodes", motion.acceleration}});
  for (const Marker& marker : markers) {
    MarkerKinematics k;
    body.marker_kinematics(state, marker.index, Level::acceleration, k);
    MatrixX all(3, 8 + 2 * n);
    all.leftCols(8) << k.p, k.R, k.v, k.w, k.bias_v, k.bias_w;
    Matrix6X elastic = Matrix6X::Zero(6, n);
    if (k.elastic) elastic = Eigen::Map<const Matrix6X>(k.elastic, 6, n);
    all.rightCols(2 * n) << elastic.topRows(3), elastic.bottomRows(3);
    sight.emplace_back("marker " + std::to_string(marker.index), all);
  }
  return sight;
}

void expect_same(const Sight& found, const Sight& expected, double tolerance) {
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) {
    const auto& [what, A] = found[i];
    const MatrixX& B = expected[i].second;
    ASSERT_EQ(A.cols(), B.cols()) << what;
    EXPECT_LE((A - B).cwiseAbs().maxCoeff(), tolerance * std::max(1e-12, B.cwiseAbs().maxCoeff())) << what;
  }
}

VectorX some_eta(int n) { return RandomNumbers(5).vector(n, 1.5e-3); }
VectorX some_rate(int n) { return RandomNumbers(6).vector(n, 0.1); }

/// Columns of the basis by hand, its integrals left to be computed from the nodes.
std::shared_ptr<const ModalBasis> columns(const ModalBasis& whole, const Modes& modes) {
  auto part = std::make_shared<ModalBasis>(whole);
  const VectorX stiffness = VectorX(whole.stiffness.diagonal())(modes);
  part->modes = whole.modes(Eigen::all, modes);
  part->stiffness = MatrixX(stiffness.asDiagonal()).sparseView();
  part->modal_mass = MatrixX::Identity(stiffness.size(), stiffness.size()).sparseView();
  part->frequencies = whole.frequencies(modes);
  part->integrals = {};
  part->deflection = nullptr;
  return part;
}

TEST(Fidelity, all_modes_of_linear_deflection_are_the_body_of_the_linear_basis) {
  // The quadratic basis has the same modes, but for the direction in which the eigensolver gives them.
  Drawn drawn({.basis = basis_of(Deflection::quadratic)});
  EXPECT_EQ(drawn.body.fidelity(), (Fidelity{kAllModes, Deflection::quadratic}));
  drawn.body.set_fidelity({kAllModes, Deflection::linear});
  auto linear = std::make_shared<ModalBasis>(*basis_of(Deflection::quadratic));
  linear->deflection = nullptr;
  const Drawn expected({.basis = linear});
  expect_same(look(drawn.body, drawn.markers, some_eta(kModes), some_rate(kModes)),
              look(expected.body, expected.markers, some_eta(kModes), some_rate(kModes)), 1e-13);
}

TEST(Fidelity, some_modes_are_the_body_of_these_columns_whatever_it_was_before) {
  FlexibleDamping damping{.mass_proportional = 0.3, .stiffness_proportional = 1e-4, .modal_ratios = {}};
  for (int k = 0; k < kModes; ++k) damping.modal_ratios.push_back(0.01 * (k + 1));
  Drawn drawn({.basis = basis_of(Deflection::quadratic), .damping = damping});
  const VectorX eta = some_eta(3), rate = some_rate(3);
  damping.modal_ratios = {0.01, 0.03, 0.06};
  const Drawn expected({.basis = columns(*basis_of(Deflection::quadratic), kSome), .damping = damping});
  const Sight sight = look(expected.body, expected.markers, eta, rate);
  drawn.body.set_fidelity({kSome, Deflection::linear});
  expect_same(look(drawn.body, drawn.markers, eta, rate), sight, 1e-10);
  EXPECT_EQ(drawn.body.mode_count(), 3);
  EXPECT_EQ(drawn.body.coordinates().v_count(), 9);
  for (size_t i = 0; i < drawn.load_forces.size(); ++i)
    EXPECT_EQ(drawn.load_forces[i], expected.load_forces[i]) << "a load spread over nodes";

  // Rigid, then again: bit for bit as before.
  const Sight first = look(drawn.body, drawn.markers, eta, rate);
  drawn.body.set_fidelity({});
  const Drawn rigid({.basis = basis_of(Deflection::linear), .mode_count = 0});
  expect_same(look(drawn.body, drawn.markers, VectorX(0), VectorX(0)),
              look(rigid.body, rigid.markers, VectorX(0), VectorX(0)), 1e-12);
  drawn.body.set_fidelity({{1, 3}, Deflection::quadratic});
  drawn.body.set_fidelity({kSome, Deflection::linear});
  expect_same(look(drawn.body, drawn.markers, eta, rate), first, 0);
}

TEST(Fidelity, markers_made_at_any_fidelity_serve_at_all) {
  Drawn early({.basis = basis_of(Deflection::stiffened)});
  SystemGraph graph;
  auto& body = graph.add<FlexibleBody>("bar", {.basis = basis_of(Deflection::stiffened)});
  body.set_fidelity({});
  const Marker frame = body.body_frame();
  const Marker node = body.node(bar().node_set("x_max").back());
  body.set_fidelity({{1}, Deflection::linear});
  const Marker mean = body.average(bar().node_set("y_max"));
  EXPECT_EQ(body.body_frame(), frame);
  const Marker twin_frame = early.body.frame(), twin_node = early.body.node(bar().node_set("x_max").back()),
               twin_mean = early.body.average(bar().node_set("y_max"));
  for (const Fidelity& f : {Fidelity{}, Fidelity{kSome, Deflection::linear}, Fidelity{kSome, Deflection::stiffened},
                            Fidelity{kAllModes, Deflection::stiffened}}) {
    const auto n = static_cast<int>(f.modes.size());
    body.set_fidelity(f), early.body.set_fidelity(f);
    const auto rows = [&](const Sight& sight) { return Sight(sight.end() - 3, sight.end()); };
    Sight late = rows(look(body, {frame, node, mean}, some_eta(n), some_rate(n)));
    Sight twin = rows(look(early.body, {twin_frame, twin_node, twin_mean}, some_eta(n), some_rate(n)));
    expect_same(late, twin, 0);
  }
}

TEST(Fidelity, a_modal_marker_keeps_its_place_and_the_columns_of_the_modes_in_use) {
  RandomNumbers random(9);
  const Matrix3X Bm = random.matrix3x(kModes), Theta = random.matrix3x(kModes);
  SystemGraph graph;
  auto& body = graph.add<FlexibleBody>("bar", {.basis = basis_of(Deflection::linear)});
  const Marker marker = body.modal_marker({0.1, 0.2, 0.3}, Bm, Theta, Matrix3::Identity());
  auto& same = graph.add<FlexibleBody>("some", {.basis = columns(*basis_of(Deflection::linear), kSome)});
  const Marker expected =
      same.modal_marker({0.1, 0.2, 0.3}, Bm(Eigen::all, kSome), Theta(Eigen::all, kSome), Matrix3::Identity());
  body.set_fidelity({kSome, Deflection::linear});
  expect_same({look(body, {marker}, some_eta(3), some_rate(3)).back()},
              {look(same, {expected}, some_eta(3), some_rate(3)).back()}, 1e-13);
  expect_error<SceneError>(
      [&] {
        body.modal_marker({0, 0, 0}, Bm.leftCols(3), Theta.leftCols(3), Matrix3::Identity());
      },
      {"modal marker", "set_fidelity"});
}

TEST(Fidelity, a_modal_marker_of_fewer_modes_than_candidates_bears_no_others) {
  RandomNumbers random(9);
  const Matrix3X Bm = random.matrix3x(3), Theta = random.matrix3x(3);
  SystemGraph graph;
  auto& body = graph.add<FlexibleBody>("bar", {.basis = basis_of(Deflection::linear), .mode_count = 3});
  const Marker marker = body.modal_marker({0.1, 0.2, 0.3}, Bm, Theta, Matrix3::Identity());
  auto& same = graph.add<FlexibleBody>("some", {.basis = columns(*basis_of(Deflection::linear), {0, 2})});
  const Marker expected = same.modal_marker({0.1, 0.2, 0.3}, Bm(Eigen::all, Modes{0, 2}),
                                            Theta(Eigen::all, Modes{0, 2}), Matrix3::Identity());
  body.set_fidelity({{0, 2}, Deflection::linear});
  expect_same({look(body, {marker}, some_eta(2), some_rate(2)).back()},
              {look(same, {expected}, some_eta(2), some_rate(2)).back()}, 1e-13);
  expect_error<SceneError>([&] { body.set_fidelity({{0, 3}, Deflection::linear}); }, {"'bar'", "3 modes", "mode 3"});
}

TEST(Fidelity, a_part_of_the_modes_deflects_to_second_order_as_the_whole_does_with_the_others_at_rest) {
  for (Deflection deflection : {Deflection::stiffened, Deflection::quadratic}) {
    Drawn part({.basis = basis_of(deflection)}), linear({.basis = basis_of(deflection)});
    const Drawn whole({.basis = basis_of(deflection)});
    part.body.set_fidelity({kSome, deflection});
    linear.body.set_fidelity({kSome, Deflection::linear});
    RandomNumbers random(21);
    for (int trial = 0; trial < 3; ++trial) {
      const VectorX eta = random.vector(3, 3e-3), rate = random.vector(3, 0.2);
      VectorX eta_whole = VectorX::Zero(kModes), rate_whole = VectorX::Zero(kModes);
      eta_whole(kSome) = eta, rate_whole(kSome) = rate;
      const Sight a = look(part.body, part.markers, eta, rate),
                  b = look(whole.body, whole.markers, eta_whole, rate_whole),
                  first_order = look(linear.body, linear.markers, eta, rate);
      const auto energy = [](const Sight& s) { return s[5].second(1); };
      EXPECT_NEAR(energy(a) / energy(b), 1, 1e-12);
      if (deflection == Deflection::quadratic)
        EXPECT_GT(energy(a), 1.001 * energy(first_order));
      else
        EXPECT_NEAR(energy(a) / energy(first_order), 1, 1e-12);
      for (int i : {7, 8}) {  // places and velocities
        const double second = (b[i].second - first_order[i].second).cwiseAbs().maxCoeff();
        ASSERT_GT(second, 1e-5);
        EXPECT_LT((a[i].second - b[i].second).cwiseAbs().maxCoeff(), 2e-3 * second) << a[i].first;
      }
      for (size_t m = 10; m < a.size(); ++m) {  // markers: place and axes
        const MatrixX pose = a[m].second.leftCols(4), pose_whole = b[m].second.leftCols(4);
        const double second = (pose_whole - first_order[m].second.leftCols(4)).cwiseAbs().maxCoeff();
        EXPECT_LE((pose - pose_whole).cwiseAbs().maxCoeff(), 5e-3 * second) << a[m].first;
      }
      const MatrixX M = a[0].second, M_whole = b[0].second;
      Modes rows = {0, 1, 2, 3, 4, 5};
      for (int k : kSome) rows.push_back(6 + k);
      const double second = (M_whole(rows, rows) - first_order[0].second).cwiseAbs().maxCoeff();
      EXPECT_LT((M - M_whole(rows, rows)).cwiseAbs().maxCoeff(), 2e-3 * second);
    }
  }
}

TEST(Fidelity, elastic_force_of_a_part_is_the_slope_of_its_strain_energy) {
  Drawn drawn({.basis = basis_of(Deflection::quadratic)});
  for (Deflection deflection : {Deflection::stiffened, Deflection::quadratic}) {
    drawn.body.set_fidelity({kSome, deflection});
    const VectorX eta = some_eta(3), still = VectorX::Zero(3);
    const auto energy = [&](const VectorX& x) { return look(drawn.body, {}, x, still)[5].second(1); };
    const VectorX force = look(drawn.body, {}, eta, still)[3].second;
    for (int k = 0; k < 3; ++k) {
      const double slope = derivative([&](double t) { return energy(eta + t * VectorX::Unit(3, k)); }, 1e-4);
      EXPECT_NEAR(force[6 + k] / -slope, 1, 1e-8);
    }
  }
}

class PartOfABody : public testing::TestWithParam<Fidelity> {};

TEST_P(PartOfABody, owes_what_every_body_owes) {
  Drawn drawn({.basis = basis_of(Deflection::quadratic), .velocity = {0.1, 0.2, -0.3}});
  drawn.body.set_fidelity(GetParam());
  check_body(drawn.graph, drawn.body, drawn.markers, {.mass = 0.092, .speed = 3, .deformation = 2e-3});
}

INSTANTIATE_TEST_SUITE_P(Kinds, PartOfABody,
                         testing::Values(Fidelity{{}, Deflection::linear}, Fidelity{kSome, Deflection::linear},
                                         Fidelity{kSome, Deflection::stiffened}, Fidelity{{1}, Deflection::quadratic},
                                         Fidelity{kSome, Deflection::quadratic}),
                         [](const auto& test) {
                           return to_string(test.param.deflection) + "_" + std::to_string(test.param.modes.size()) +
                                  "_modes";
                         });

TEST(Fidelity, deformation_at_the_start_belongs_to_its_mode) {
  FlexibleBody::Parameters parameters{.basis = basis_of(Deflection::quadratic), .mode_count = 4};
  parameters.modal_coordinates = (VectorX(4) << 1e-3, 2e-3, 3e-3, 4e-3).finished();
  parameters.modal_velocities = (VectorX(4) << 0.1, 0.2, 0.3, 0.4).finished();
  parameters.position = {1, 2, 3};
  Drawn drawn(parameters);
  EXPECT_EQ(drawn.body.fidelity(), (Fidelity{{0, 1, 2, 3}, Deflection::quadratic}));
  EXPECT_EQ(drawn.body.candidate_stiffness().size(), kModes);
  VectorX whole(11), whole_rate(10);
  drawn.body.initial_state(whole, whole_rate);
  for (Deflection deflection : {Deflection::linear, Deflection::quadratic}) {
    drawn.body.set_fidelity({{1, 3, 5}, deflection});
    VectorX q(10), v(9);
    drawn.body.initial_state(q, v);
    EXPECT_EQ(q.tail(3), Vector3(2e-3, 4e-3, 0));  // of mode 5 nothing was drawn
    EXPECT_EQ(v.tail(3), Vector3(0.2, 0.4, 0));
    EXPECT_EQ(q.head(7), whole.head(7));
    EXPECT_EQ(v.head(6), whole_rate.head(6));
  }
}

TEST(Fidelity, sensors_of_modal_coordinates_keep_each_column_to_its_mode) {
  FlexibleBody::Parameters parameters{.basis = basis_of(Deflection::linear)};
  parameters.position = {1, 2, 3};
  parameters.modal_coordinates = VectorX::LinSpaced(kModes, 1e-3, 6e-3);
  parameters.modal_velocities = VectorX::LinSpaced(kModes, 0.1, 0.6);
  Drawn drawn(parameters);
  const Sensor eta = modal_coordinates(drawn.body), rate = modal_rates(drawn.body), q = coordinates(drawn.body);
  drawn.graph.add<RigidBody>("next", {.position = {7, 8, 9}});  // whose coordinates come after
  for (const Modes& modes : {kAllModes, Modes{1, 3}, Modes{}, Modes{5}}) {
    drawn.body.set_fidelity({modes, Deflection::linear});
    const System system = assemble(drawn.graph);
    Snapshot now(system, system.initial_state());
    VectorX expected = VectorX::Zero(kModes);
    expected(modes) = parameters.modal_coordinates(modes);
    for (int k = 0; k < kModes; ++k) {
      EXPECT_EQ(eta.value(now, k), expected[k]);
      EXPECT_EQ(q.value(now, 7 + k), expected[k]);
      EXPECT_NEAR(rate.value(now, k), 100 * expected[k], 1e-15);
    }
    EXPECT_NEAR(q.value(now, 0), 1 + drawn.body.basis().origin.x(), 1e-15);
  }
}

TEST(Fidelity, candidate_damping_is_that_of_the_modes_in_use) {
  FlexibleDamping damping{.mass_proportional = 0.3, .stiffness_proportional = 1e-4, .modal_ratios = {0.01, 0.02, 0.05}};
  Drawn drawn({.basis = basis_of(Deflection::linear), .mode_count = 3, .damping = damping});
  const VectorX stiffness = drawn.body.candidate_stiffness(), candidates = drawn.body.candidate_damping();
  for (int k = 0; k < kModes; ++k) {
    const double zeta = damping.modal_ratios[static_cast<size_t>(std::min(k, 2))];
    EXPECT_NEAR(candidates[k], 0.3 + 1e-4 * stiffness[k] + 2 * zeta * std::sqrt(stiffness[k]), 1e-9 * candidates[k]);
    EXPECT_NEAR(stiffness[k], std::pow(2 * M_PI * drawn.body.basis().frequencies[std::min(k, 5)], 2),
                1e-9 * stiffness[k]);
  }
  drawn.body.set_fidelity({kSome, Deflection::linear});
  const VectorX rate = some_rate(3);
  const MatrixX force = look(drawn.body, {}, VectorX::Zero(3), rate)[4].second;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(force(6 + i), -candidates[kSome[static_cast<size_t>(i)]] * rate[i], 1e-9);
}

TEST(Fidelity, integrals_of_combined_fields_are_those_of_the_combined_modes) {
  const ModalBasis& whole = *basis_of(Deflection::linear);
  RandomNumbers random(13);
  for (int to : {0, 1, 4}) {
    MatrixX T(kModes, to);
    for (int k = 0; k < to; ++k) T.col(k) = random.vector(kModes);
    ModalBasis combined = whole;
    combined.modes = whole.modes * T;
    combined.stiffness = combined.modal_mass = (T.transpose() * T).sparseView();
    const InertiaIntegrals found = transformed(whole.integrals, T), expected = inertia_integrals(combined);
    const auto near = [](const MatrixX& a, const MatrixX& b, const char* what) {
      ASSERT_EQ(a.rows(), b.rows()) << what;
      ASSERT_EQ(a.cols(), b.cols()) << what;
      if (b.size() > 0) {
        EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-12 * (1 + b.cwiseAbs().maxCoeff())) << what;
      }
    };
    EXPECT_NEAR(found.mass, expected.mass, 1e-12);
    near(found.s0, expected.s0, "s0"), near(found.J0, expected.J0, "J0"), near(found.Ct, expected.Ct, "Ct");
    near(found.J1, expected.J1, "J1"), near(found.J2, expected.J2, "J2"), near(found.C0, expected.C0, "C0");
    near(found.C1, expected.C1, "C1"), near(found.Mff, expected.Mff, "Mff");
  }
}

TEST(Fidelity, a_basis_whose_second_order_moves_nothing_is_no_trouble) {
  auto still = std::make_shared<ModalBasis>(*basis_of(Deflection::linear));
  auto nothing = std::make_shared<QuadraticDeflection>();
  nothing->fields = MatrixX(still->modes.rows(), 0);
  nothing->curvature = MatrixX::Zero(kModes, kModes * (kModes + 1) / 2);
  nothing->integrals = still->integrals;
  still->deflection = nothing;
  Drawn drawn({.basis = still}), linear({.basis = basis_of(Deflection::linear)});
  for (const Modes& modes : {kAllModes, kSome}) {
    drawn.body.set_fidelity({modes, Deflection::stiffened});
    linear.body.set_fidelity({modes, Deflection::linear});
    const auto n = static_cast<int>(modes.size());
    expect_same(look(drawn.body, {}, some_eta(n), some_rate(n)), look(linear.body, {}, some_eta(n), some_rate(n)),
                1e-12);
  }
}

TEST(Fidelity, refuses_what_a_body_does_not_have_and_stays_as_it_was) {
  Drawn drawn({.basis = basis_of(Deflection::stiffened)});
  const Sight before = look(drawn.body, drawn.markers, some_eta(kModes), some_rate(kModes));
  const auto refused = [&](const Fidelity& f, const std::vector<std::string>& mentions) {
    expect_error<SceneError>([&] { drawn.body.set_fidelity(f); }, mentions);
  };
  refused({{6}, Deflection::linear}, {"mode 6", "of 6"});
  refused({{-1, 2}, Deflection::linear}, {"mode -1"});
  refused({{2, 1}, Deflection::linear}, {"mode 1", "rising"});
  refused({{2, 2}, Deflection::linear}, {"mode 2", "rising"});
  refused({{2}, Deflection::quadratic}, {"fourth order", "Deflection::quadratic"});
  EXPECT_EQ(drawn.body.fidelity(), (Fidelity{kAllModes, Deflection::stiffened}));
  expect_same(look(drawn.body, drawn.markers, some_eta(kModes), some_rate(kModes)), before, 0);

  Drawn linear({.basis = basis_of(Deflection::linear)});
  EXPECT_EQ(linear.body.finest_deflection(), Deflection::linear);
  expect_error<SceneError>([&] { linear.body.set_fidelity({{0}, Deflection::stiffened}); }, {"second order"});

  SystemGraph graph;
  auto& nodal =
      graph.add<FlexibleBody>("nodal", {.basis = make_basis(bar(), TangentFrame{bar().node_set("x_min")}, kAllNodal)});
  EXPECT_EQ(nodal.candidate_stiffness().size(), 0);
  expect_error<SceneError>([&] { nodal.set_fidelity({}); }, {"'nodal'", "one model only"});
}

}  // namespace
}  // namespace lithe::test::fidelity_test
