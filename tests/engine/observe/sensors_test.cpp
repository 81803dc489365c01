#include "engine/observe/sensors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/model/system_graph.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::sensors_test {

using lithe::test::message_of;
using testing::ElementsAre;
using testing::HasSubstr;

namespace {

constexpr double kMass = 2, kLength = 1, kWeight = kMass * 9.81;

/// A slender rod pinned at one end, at `angle` from hanging (towards +x), turning at `rate`; free to swing about y.
struct Pendulum {
  explicit Pendulum(double angle, double rate = 0) {
    const Matrix3 hinge = rotation_about({1, 0, 0}, -M_PI / 2);  // marker z along world y
    const Matrix3 A = rotation_about({0, 1, 0}, M_PI / 2 - angle);
    const double J = kMass * kLength * kLength / 12;
    rod = &graph.add<RigidBody>("rod", {.mass = kMass,
                                        .inertia = {1e-4, J, J},
                                        .position = A * Vector3(kLength / 2, 0, 0),
                                        .orientation = A,
                                        .velocity = A * Vector3(0, rate, 0).cross(Vector3(kLength / 2, 0, 0)),
                                        .angular_velocity = Vector3(0, rate, 0)});
    end = rod->marker({-kLength / 2, 0, 0}, hinge);
    tip = rod->marker({kLength / 2, 0, 0});
    pin = &graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, hinge), end});
  }
  SystemGraph graph;
  RigidBody* rod;
  RevoluteJoint* pin;
  Marker end, tip;
};

Vector3 vector_of(const Sensor& sensor, Snapshot& now, int first = 0) {
  return {sensor.value(now, first), sensor.value(now, first + 1), sensor.value(now, first + 2)};
}

/// Pulls B to A like a spring of 100 N/m, as a compliant row, and lifts B with a plain load of 3 N.
class Tether final : public Force</*markers=*/2, /*rows=*/1> {
 public:
  void evaluate(double, std::span<const MarkerView> m, ForceRows& rows) const override {
    const Vector3 d = m[1].p - m[0].p, along = d.normalized();
    rows.add({force(-along), force(along)}, 100 * d.norm(), 100, 0, 50 * d.squaredNorm());
    rows.add_load(m[1], force({0, 0, 3}));
  }
};

/// A bead of 1 kg on a rail fixed in a floating frame: p + A (r + b η); its axes turn by τ η in the frame.
class Slider final : public Body {
 public:
  struct Parameters {};
  struct Cache : BodyCache {
    Matrix6X elastic;
    explicit Cache(const Slider&) : elastic(6, 1) { elastic << b(), turn(); }
  };
  explicit Slider(Parameters) { set_marker_count(1); }
  static Vector3 b() { return {0.3, -0.2, 0.9}; }
  static Vector3 turn() { return {0.5, 1.5, -1}; }
  Marker bead() const { return {this, 0}; }

  Coordinates coordinates() const override { return {.frames = 1, .linear = 1}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override {
    q << 0, 0, 0, 1, 0, 0, 0, 0;
    v.setZero();
  }
  void evaluate(const BodyState& s, Level) const override {
    s.cache->A = rotation_matrix(Eigen::Map<const Vector4>(s.q + 3));
  }
  void add_residual(const BodyState&, const double*, const Vector3&, double*) const override {}
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights&,
                   BodyTangent& S) const override {
    S.frame += Matrix6::Identity();
    S.linear[0] += 1;
  }
  void marker_kinematics(const BodyState& s, int, Level, MarkerKinematics& k) const override {
    const Matrix3& A = s.cache->A;
    const Eigen::Map<const Vector3> p(s.q), p_dot(s.v), w(s.v + 3);
    const double eta = s.q[7], eta_dot = s.v[6];
    k.A = &A;
    k.elastic = static_cast<const Cache&>(*s.cache).elastic.data();
    k.r = Vector3(1, 2, 3) + eta * b();
    k.R = A * rotation_exp(eta * turn());
    k.p = p + A * k.r;
    k.v = p_dot + A * (w.cross(k.r) + eta_dot * b());
    k.w = A * (w + eta_dot * turn());
    k.bias_v = A * (w.cross(w.cross(k.r)) + 2 * eta_dot * w.cross(b()));
    k.bias_w = A * (eta_dot * w.cross(turn()));
  }
  BodyEnergy energy(const BodyState&, const Vector3&) const override { return {}; }
};

}  // namespace

TEST(sensors, the_pin_of_a_hanging_spinning_rod_bears_weight_and_centripetal_force) {
  const double rate = 3;
  Pendulum p(0, rate);
  const System system = assemble(p.graph);
  Snapshot now{system, system.initial_state()};
  const double expected = kWeight + kMass * rate * rate * kLength / 2;  // m g + m v²/r at the centre of mass

  const Sensor on_rod = reaction(*p.pin, 1), on_ground = reaction(*p.pin, 0), along_rod = reaction(*p.pin, 1, p.tip);
  EXPECT_THAT((vector_of(on_rod, now) - Vector3(0, 0, expected)).norm(), testing::Le(1e-11));
  EXPECT_THAT((vector_of(on_ground, now) + Vector3(0, 0, expected)).norm(), testing::Le(1e-11));
  EXPECT_THAT((vector_of(along_rod, now) - Vector3(-expected, 0, 0)).norm(), testing::Le(1e-11));
  EXPECT_THAT(vector_of(on_rod, now, 3).norm(), testing::Le(1e-11));  // the plane motion needs no moment
  EXPECT_NEAR(multipliers(*p.pin).value(now, 2), -expected, 1e-11);   // F_B = -λ
}

TEST(sensors, the_pin_of_a_rod_released_from_horizontal_bears_a_quarter_of_its_weight) {
  Pendulum p(M_PI / 2);
  const System system = assemble(p.graph);
  Snapshot now{system, system.initial_state()};
  EXPECT_LT((vector_of(reaction(*p.pin, 1), now) - Vector3(0, 0, kWeight / 4)).norm(), 1e-11);
  EXPECT_NEAR(acceleration(p.tip).value(now, 2), -1.5 * 9.81, 1e-11);
  EXPECT_NEAR(angular_acceleration(p.tip).value(now, 1), 1.5 * 9.81 / kLength, 1e-11);
}

TEST(sensors, a_pin_off_centre_bears_a_moment_about_its_own_point) {
  // Two rods in one: the mass lies 0.3 m beside the pin, along the hinge axis.
  SystemGraph graph;
  const Matrix3 hinge = rotation_about({1, 0, 0}, -M_PI / 2);
  auto& block = graph.add<RigidBody>("block", {.mass = kMass, .position = Vector3(0, 0.3, -1)});
  auto& pin =
      graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, hinge), block.marker({0, -0.3, 1}, hinge)});
  const System system = assemble(graph);
  Snapshot now{system, system.initial_state()};
  const Sensor on_block = reaction(pin, 1);
  EXPECT_LT((vector_of(on_block, now) - Vector3(0, 0, kWeight)).norm(), 1e-11);
  // Moment balance about the pin: M + (0, 0.3, -1) × (0, 0, -m g) = 0.
  EXPECT_LT((vector_of(on_block, now, 3) - Vector3(0.3 * kWeight, 0, 0)).norm(), 1e-11);
}

TEST(sensors, along_a_swing_reactions_and_energies_are_those_of_the_books) {
  Pendulum p(M_PI / 2);
  const System system = assemble(p.graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator{{.step = 5e-4, .spectral_radius = 0.9}};
  Simulation simulation{system, integrator};
  Recorder swing{{position(p.tip, "tip"), reaction(*p.pin, 1, kWorldAxes, "pin"), kinetic_energy(),
                  kinetic_energy(*p.rod), potential_energy(*p.rod), total_energy(), elastic_energy(),
                  constraint_residual(), velocity_residual()}};
  simulation.observe(swing, every(0.01));
  simulation.run(state, 1.0);
  const Table& t = swing.table();
  const auto at = [&](const char* name, int row) { return t.column(name)[row]; };
  for (int row = 0; row < t.row_count(); ++row) {
    // θ from hanging: radial N = m g cos θ + 3/2 m g cos θ, tangential m g sin θ / 4.
    const double c = -at("tip_z", row) / kLength, s = at("tip_x", row) / kLength;
    const double radial = 2.5 * kWeight * c, tangential = kWeight * s / 4;
    EXPECT_NEAR(at("pin_force_x", row), -radial * s + tangential * c, 2e-4 * kWeight) << row;
    EXPECT_NEAR(at("pin_force_z", row), radial * c + tangential * s, 2e-4 * kWeight) << row;
    EXPECT_NEAR(at("total_energy", row), 0, 1e-4);
    EXPECT_EQ(at("kinetic_energy", row), at("rod_kinetic_energy", row));
    EXPECT_NEAR(at("rod_potential_energy", row), -kWeight * c / 2, 1e-9);
    EXPECT_EQ(at("elastic_energy", row), 0);
    EXPECT_LT(at("constraint_residual", row), 1e-9);
    EXPECT_LT(at("velocity_residual", row), 1e-4);
  }
}

TEST(sensors, accelerations_are_the_slope_of_velocities) {
  SystemGraph graph;
  auto& top = graph.add<RigidBody>("top", {.mass = 1, .inertia = {0.02, 0.03, 0.04}, .position = Vector3(0.1, 0, 0.2)});
  const Marker edge = top.marker({0.2, -0.1, 0.3}, rotation_about({1, 2, 3}, 0.7));
  graph.add<SphericalJoint>("foot", {graph.ground().marker(), top.marker({-0.1, 0, -0.2})});
  const System system = assemble(graph);
  State state = system.initial_state();
  const Vector3 omega(3, -2, 8);
  state.v << omega.cross(Vector3(0.1, 0, 0.2)), omega;
  GeneralizedAlpha integrator{{.step = 1e-4, .form = GeneralizedAlpha::Form::stabilized_index2}};
  Simulation simulation{system, integrator};
  Recorder motion{{position(edge), velocity(edge), acceleration(edge), angular_velocity(edge),
                   angular_acceleration(edge), orientation(edge)}};
  simulation.observe(motion, every_step());
  simulation.run(state, 0.05);
  const Table& t = motion.table();
  const double h = 1e-4;
  for (int row = 1; row + 1 < t.row_count(); row += 20) {
    const auto slope = [&](int column) { return (t.at(row + 1, column) - t.at(row - 1, column)) / (2 * h); };
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(t.at(row, 4 + i), slope(1 + i), 1e-4);    // v, p
      EXPECT_NEAR(t.at(row, 7 + i), slope(4 + i), 1e-2);    // v_dot, v (some 100 m/s²)
      EXPECT_NEAR(t.at(row, 13 + i), slope(10 + i), 1e-2);  // w_dot, w
    }
    double norm = 0;
    for (int i = 16; i < 20; ++i) norm += t.at(row, i) * t.at(row, i);
    EXPECT_NEAR(norm, 1, 1e-12);
  }
}

TEST(sensors, accelerations_of_markers_that_move_in_their_body_are_the_slope_of_velocities) {
  SystemGraph graph;
  auto& slider = graph.add<Slider>("slider");
  const System system = assemble(graph);
  State state = system.initial_state();
  state.q << 1, -2, 0.5, Vector4(0.5, -0.5, 0.1, 0.7).normalized(), 0.4;
  state.v << 0.3, 0.2, -1, 2, -1, 0.7, 1.3;
  state.v_dot << 1, -2, 3, 4, 5, -6, 7;

  // Along q ⊕ (h v + ½ h² v_dot), v + h v_dot.
  const auto moved = [&](double h) {
    State s = state;
    s.v += h * state.v_dot;
    const VectorX d = h * state.v + h * h / 2 * state.v_dot;
    system.layout().retract(state.q, d, s.q);
    return s;
  };
  const double h = 1e-5;
  Snapshot before{system, moved(-h)}, now{system, state}, after{system, moved(h)};
  const auto slope = [&](const Sensor& s) -> Vector3 { return (vector_of(s, after) - vector_of(s, before)) / (2 * h); };
  const Marker bead = slider.bead();
  EXPECT_LT((vector_of(velocity(bead), now) - slope(position(bead))).norm(), 1e-8);
  EXPECT_LT((vector_of(acceleration(bead), now) - slope(velocity(bead))).norm(), 1e-7);
  EXPECT_LT((vector_of(angular_acceleration(bead), now) - slope(angular_velocity(bead))).norm(), 1e-7);

  EXPECT_EQ(modal_coordinates(slider).value(now), 0.4);
  EXPECT_EQ(modal_rates(slider).value(now), 1.3);
  EXPECT_EQ(coordinates(slider).value(now, 2), 0.5);
  EXPECT_EQ(generalized_velocities(slider).value(now, 5), 0.7);
}

TEST(sensors, columns_bear_the_names_of_what_is_measured) {
  SystemGraph graph;
  auto& slider = graph.add<Slider>("slider");
  EXPECT_THAT(position(slider.bead(), "tip").columns(), ElementsAre("tip_x", "tip_y", "tip_z"));
  EXPECT_THAT(height(slider.bead(), "tip").columns(), ElementsAre("tip"));
  EXPECT_THAT(height(slider.bead()).columns(), ElementsAre("slider_m0_height"));
  EXPECT_THAT(acceleration(slider.bead()).columns(),
              ElementsAre("slider_m0_v_dot_x", "slider_m0_v_dot_y", "slider_m0_v_dot_z"));
  EXPECT_THAT(coordinates(slider).columns(), ElementsAre("slider_p_x", "slider_p_y", "slider_p_z", "slider_e_w",
                                                         "slider_e_x", "slider_e_y", "slider_e_z", "slider_eta_1"));
  EXPECT_THAT(modal_rates(slider, "s").columns(), ElementsAre("s_eta_dot_1"));
  EXPECT_THAT(total_energy(slider).columns(), ElementsAre("slider_total_energy"));
  EXPECT_THAT(total_energy("E").columns(), ElementsAre("E"));
  // A scene's own has its columns as written.
  EXPECT_THAT((Sensor{"pair", {"first", "second"}, [](Snapshot&, std::span<double>) {}}.columns()),
              ElementsAre("first", "second"));
}

TEST(sensors, two_hinges_of_a_door_share_its_weight) {
  SystemGraph graph;
  auto& door = graph.add<RigidBody>("door", {.mass = kMass, .position = Vector3(0.5, 0, 0)});
  auto& upper = graph.add<RevoluteJoint>("upper", {graph.ground().marker({0, 0, 1}), door.marker({-0.5, 0, 1})});
  auto& lower = graph.add<RevoluteJoint>("lower", {graph.ground().marker({0, 0, -1}), door.marker({-0.5, 0, -1})});
  const System system = assemble(graph);
  ASSERT_EQ(system.redundant_rows().size(), 5u);
  State state = system.initial_state();
  GeneralizedAlpha integrator{{.step = 1e-3}};
  Simulation simulation{system, integrator};
  simulation.run(state, 0.01);  // leaves multipliers of one choice of rows

  Snapshot now{system, state};
  const Sensor above = reaction(upper, 1), below = reaction(lower, 1);
  EXPECT_NEAR(above.value(now, 2), kWeight / 2, 1e-9);
  EXPECT_NEAR(below.value(now, 2), kWeight / 2, 1e-9);
  // Equilibrium about the middle of the hinge line.
  const Vector3 moment = vector_of(above, now, 3) + vector_of(below, now, 3) +
                         Vector3(0, 0, 1).cross(vector_of(above, now) - vector_of(below, now));
  EXPECT_NEAR(moment.y(), -0.5 * kWeight, 1e-9);
  EXPECT_NEAR(moment.x(), 0, 1e-9);
}

TEST(sensors, a_force_element_tells_what_it_does_to_each_body) {
  SystemGraph graph;
  auto& ball = graph.add<RigidBody>("ball", {.position = Vector3(0.3, 0, -0.4)});
  const Marker centre = ball.marker({0, 0, 0}, rotation_about({0, 0, 1}, M_PI / 2));
  auto& tether = graph.add<Tether>("tether", {graph.ground().marker(), centre});
  const System system = assemble(graph);
  Snapshot now{system, system.initial_state()};
  EXPECT_LT((vector_of(applied_force(tether, 1), now) - Vector3(-30, 0, 43)).norm(), 1e-12);
  EXPECT_LT((vector_of(applied_force(tether, 0), now) - Vector3(30, 0, -40)).norm(), 1e-12);
  EXPECT_LT((vector_of(applied_force(tether, 1, centre), now) - Vector3(0, 30, 43)).norm(), 1e-12);
  EXPECT_NEAR(elastic_energy().value(now), 12.5, 1e-12);
  EXPECT_NEAR(potential_energy().value(now), 12.5 - 9.81 * 0.4, 1e-12);
  EXPECT_EQ(constraint_residual().value(now), 0);  // no row at all
}

TEST(sensors, residuals_show_a_state_off_its_constraints) {
  Pendulum p(0);
  const System system = assemble(p.graph);
  State state = system.initial_state();
  state.q[2] += 0.25;
  state.v[1] += 0.5;
  Snapshot now{system, state};
  EXPECT_NEAR(constraint_residual().value(now), 0.25, 1e-12);
  EXPECT_NEAR(velocity_residual().value(now), 0.5, 1e-12);
}

TEST(sensors, mistakes_are_named_with_their_line) {
  Pendulum p(0), other(1);
  const System system = assemble(p.graph);
  EXPECT_THAT(message_of<SceneError>([&] { position(Marker{}); }), HasSubstr("sensors_test.cpp:"));
  EXPECT_THAT(message_of<SceneError>([&] { position(Marker{p.rod, 9}); }), HasSubstr("marker 9 does not exist"));
  EXPECT_THAT(message_of<SceneError>([&] { reaction(*p.pin, 2); }), HasSubstr("'pin' has no marker number 2"));
  EXPECT_THAT(message_of<SceneError>([&] { modal_coordinates(*p.rod); }), HasSubstr("body 'rod' has no such"));
  Snapshot now{system, system.initial_state()};
  for (const Sensor& sensor : {position(other.tip), acceleration(other.tip), reaction(*other.pin, 0),
                               multipliers(*other.pin), coordinates(*other.rod), kinetic_energy(*other.rod)})
    EXPECT_THAT(message_of<SceneError>([&] { sensor.value(now); }), HasSubstr("in this system")) << sensor.name();
  EXPECT_THROW(Snapshot(system, State{}), SceneError);
}

}  // namespace lithe::test::sensors_test
