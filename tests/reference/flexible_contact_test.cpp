// Flexible bodies in contact: momentum and energy balances, the nodal solution beside the modal one, rigid surfaces,
// and what every kind of body owes a contact.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/surface_mesh.h"
#include "engine/assembly/batch_of.h"
#include "engine/model/system_graph.h"
#include "engine/observe/contact_sensors.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/contact/contact.h"
#include "joints/revolute_joint.h"
#include "plugins/inertial_body/inertial_body.h"
#include "tests/support/methods.h"

namespace lithe::test::flexible_contact_test {
namespace {

const Vector3 kSize(0.4, 0.02, 0.02);  // m
constexpr double kYoung = 2e9, kPoisson = 0.3, kDensity = 1200;
constexpr double kMass = 0.4 * 0.02 * 0.02 * kDensity;

FiniteElementModel rod_model(int along = 8) {
  return brick_mesh({.size = kSize,
                     .divisions = {along, 1, 1},
                     .type = "C3D8I",
                     .material = {kYoung, kPoisson, kDensity},
                     .name = "rod"});
}
std::shared_ptr<const ModalBasis> free_modes(int modes, int along = 8) {
  return make_basis(rod_model(along), MeanAxisFrame{}, modes);
}

/// Boundary of a nodal rod, as SurfaceMesh has that of a modal one: all its nodes are looked at.
Collider skin_of(InertialBody& body) {
  const BrickMesh& mesh = body.mesh();
  ElementBlock block{.type = "C3D8"};
  for (const auto& element : mesh.elements) block.nodes.emplace_back(element.begin(), element.end());
  const auto triangles = boundary_triangles({block}, mesh.nodes);
  std::vector<Marker> nodes;
  std::vector<Vector3> points;
  for (int i = 0; i < mesh.node_count(); ++i) {
    nodes.push_back(body.node(mesh.node_ids[i]));
    points.push_back(mesh.nodes.col(i) - mesh.nodes.col(0));
  }
  return {nodes[0], shape::surface(nodes, points, triangles)};
}

/// Where the rod starts: its far end down by `tilt`, the lowest corner `gap` above z = 0.
struct Start {
  double tilt = 0.1, gap = 1e-4;
  Vector3 velocity{0, 0, -1};
  std::string name = "rod";
  Matrix3 orientation() const { return rotation_about({0, 1, 0}, tilt); }
  Vector3 position() const { return {0, 0, gap + std::max(0.0, kSize[0] * std::sin(tilt))}; }
};

FlexibleBody& add_modal(SystemGraph& graph, const Start& start, int modes, int along = 8) {
  return graph.add<FlexibleBody>(start.name, {.basis = free_modes(modes, along),
                                              .position = start.position(),
                                              .orientation = start.orientation(),
                                              .velocity = start.velocity});
}
InertialBody& add_nodal(SystemGraph& graph, const Start& start) {
  return graph.add<InertialBody>(
      "rod", {.mesh = std::make_shared<const BrickMesh>(brick_block(kSize, {8, 1, 1}, {kYoung, kPoisson, kDensity})),
              .position = start.position(),
              .orientation = start.orientation(),
              .velocity = start.velocity});
}

const Contact::Parameters kElastic{.law = Compliance{.stiffness = 1e7}};
const Contact::Parameters kLossy{.law = Compliance{.stiffness = 1e7, .restitution = 0.6},
                                 .friction = {.coefficient = 0.3, .creep_speed = 0.05}};

/// What the world does to a body over a run, summed by the trapezoidal rule over all steps, against what it has.
class Balance final : public Observer {
 public:
  using Momentum = std::function<Vector3(const BodyState&)>;
  Balance(const Body& body, Momentum momentum, std::vector<Sensor> forces, const Contact& contact)
      : body_(body),
        momentum_(std::move(momentum)),
        forces_(std::move(forces)),
        power_(contact_power(contact)),
        stored_(contact_energy(contact)),
        energy_(total_energy()),
        kinetic_(kinetic_energy()) {}

  void observe(Snapshot& now) override {
    Vector3 force = Vector3::Zero();
    for (const Sensor& sensor : forces_) {
      double values[6];
      sensor.evaluate(now, values);
      force += Vector3(values[0], values[1], values[2]);
    }
    const double power = power_.value(now);
    const Vector3 p = momentum_(now.body_state(body_));
    const double energy = energy_.value(now), stored = stored_.value(now);
    if (steps_++ == 0) {
      p0_ = p, energy0_ = energy, start_ = now.time(), motion_ = kinetic_.value(now);
    } else {
      const double h = now.time() - time_;
      impulse_ += h / 2 * (force + force_);
      work_ += h / 2 * (power + power_last_);
    }
    time_ = now.time(), force_ = force, power_last_ = power, p_ = p, energy_now_ = energy, stored_now_ = stored;
  }
  /// Change of momentum less weight and forces, of the impulse of the forces.
  double momentum_error() const {
    return (p_ - p0_ - impulse_ - kMass * (time_ - start_) * Vector3(0, 0, -9.81)).norm() / impulse_.norm();
  }
  /// Change of all but the contact's energy less the contact's work, of the first kinetic energy.
  double energy_error() const { return std::abs(energy_now_ - stored_now_ - energy0_ - work_) / motion_; }
  double total_change() const { return (energy_now_ - energy0_) / motion_; }

 private:
  const Body& body_;
  Momentum momentum_;
  std::vector<Sensor> forces_;
  Sensor power_, stored_, energy_, kinetic_;
  int steps_ = 0;
  Vector3 p0_, p_, impulse_ = Vector3::Zero(), force_;
  double energy0_ = 0, energy_now_ = 0, stored_now_ = 0, work_ = 0, power_last_ = 0, time_ = 0, start_ = 0;
  double motion_ = 0;
};

constexpr double kBound = 1e-6;  // of momentum and energy, relative

/// Methods of fixed steps, so fine that sums over them are exact enough: those of second order need shorter ones (at 2
/// us generalized-alpha's energy is off by 1.4e-6, a quarter of that at 1 us).
std::vector<Method> fine_methods(bool elastic) {
  std::vector<Method> methods;
  methods.push_back(runge_kutta_fixed(2e-6));
  methods.push_back(radau_fixed(2e-6));
  methods.push_back(index2(1e-6));
  if (elastic) methods.push_back(rattle(1e-6));
  return methods;
}

/// A run, watched at every step.
template <class AnyBody>
std::unique_ptr<Balance> watch_run(SystemGraph& graph, const AnyBody& body, const Contact& contact,
                                   std::vector<Sensor> more, Integrator& method, double end) {
  const System system = assemble(graph);
  State state = system.initial_state();
  Simulation simulation(system, method);
  more.push_back(contact_force(contact, 1));
  auto balance = std::make_unique<Balance>(
      body, [&](const BodyState& b) { return body.linear_momentum(b); }, std::move(more), contact);
  simulation.observe(*balance, every_step());
  simulation.run(state, end);
  return balance;
}

void expect_balanced(const Integrator& method, bool elastic, const Balance& balance) {
  const std::string name = method.name() + (elastic ? ", elastic" : ", lossy");
  expect_below(name + ": momentum", balance.momentum_error(), kBound);
  expect_below(name + ": energy", balance.energy_error(), kBound);
  if (elastic)
    expect_below(name + ": all energy", std::abs(balance.total_change()), kBound);
  else
    expect_below(name + ": energy falls", balance.total_change(), -0.1);
}

Contact& add_table(SystemGraph& graph, const Collider& collider, const Contact::Parameters& law) {
  return graph.add<Contact>("table", {{graph.ground().marker(), shape::half_space()}, collider}, law);
}
Collider skin(FlexibleBody& body) {
  const SurfaceMesh mesh = surface(body);
  return {mesh.frame, shape::surface(mesh.nodes, mesh.points, mesh.triangles, mesh.reach)};
}

TEST(FlexibleContact, ARodDroppedOnATableExchangesMomentumAndEnergyWithIt) {
  for (const bool elastic : {true, false}) {
    for (const Method& method : fine_methods(elastic)) {
      SystemGraph graph;
      FlexibleBody& rod = add_modal(graph, {.velocity = {0.2, 0, -1}}, 6);
      const Contact& contact = add_table(graph, skin(rod), elastic ? kElastic : kLossy);
      const auto balance = watch_run(graph, rod, contact, {}, *method, 6e-3);
      expect_balanced(*method, elastic, *balance);
    }
  }
}

const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);
const Vector3 kPin(0, 0.5 * kSize[1], 0);

/// A rod on a pin along y through its edge, horizontal, turning downwards; a ball below it to be hit.
FlexibleBody& add_modal_pendulum(SystemGraph& graph, int modes) {
  auto& rod = graph.add<FlexibleBody>(
      "rod", {.basis = make_basis(rod_model(), HingeFrame{{1, 3}}, modes), .angular_velocity = {0, 5, 0}});
  graph.add<RevoluteJoint>("pin", {graph.ground().marker(Point(kPin), kAlongY), rod.average({1, 3}, kAlongY)});
  return rod;
}
InertialBody& add_nodal_pendulum(SystemGraph& graph) {
  auto& rod = graph.add<InertialBody>(
      "rod", {.mesh = std::make_shared<const BrickMesh>(brick_block(kSize, {8, 1, 1}, {kYoung, kPoisson, kDensity})),
              .angular_velocity = {0, 5, 0}});
  graph.add<RevoluteJoint>("pin", {graph.ground().marker(Point(kPin), kAlongY), rod.average({1, 10}, kAlongY)});
  return rod;
}
Contact& add_stop(SystemGraph& graph, const Collider& collider, const Contact::Parameters& law) {
  const Vector3 at(0.32, 0.5 * kSize[1], -0.0301);
  return graph.add<Contact>("stop", {{graph.ground().marker(Point(at)), shape::sphere(0.03)}, collider}, law);
}

TEST(FlexibleContact, APendulumHittingAStopLoadsItsPinAsWell) {
  for (const bool elastic : {true, false}) {
    for (const Method& method : fine_methods(elastic)) {
      SystemGraph graph;
      FlexibleBody& rod = add_modal_pendulum(graph, 6);
      const Contact& contact = add_stop(graph, skin(rod), elastic ? kElastic : kLossy);
      const auto balance = watch_run(graph, rod, contact,
                                     {reaction(*dynamic_cast<const Constraint*>(graph.find("pin")), 1)}, *method, 6e-3);
      expect_balanced(*method, elastic, *balance);
    }
  }
}

/// Tip height and vertical contact force over a run.
struct History {
  std::vector<double> tip, force;
};
History history(SystemGraph& graph, const Contact& contact, Marker tip, double end) {
  const System system = assemble(graph);
  State state = system.initial_state();
  const Method method = index2(1e-5);
  Simulation simulation(system, *method);
  Recorder recorder({height(tip, "tip"), contact_force(contact, 1, "contact")});
  simulation.observe(recorder, every(2e-5));
  simulation.run(state, end);
  return {recorder.table().column("tip"), recorder.table().column("contact_force_z")};
}
double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0, size = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]), size += b[i] * b[i];
  return std::sqrt(sum / size);
}
double farthest(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

TEST(FlexibleContact, MoreModesComeNearerToTheNodalRod) {
  const Contact::Parameters law{.law = Compliance{.stiffness = 1e6, .restitution = 0.6},
                                .friction = {.coefficient = 0.3, .creep_speed = 0.05}};
  for (const bool pendulum : {false, true}) {
    const double end = 6e-3;
    History nodal;
    {
      SystemGraph graph;
      InertialBody& rod = pendulum ? add_nodal_pendulum(graph) : add_nodal(graph, {.velocity = {0.2, 0, -1}});
      const Contact& contact = pendulum ? add_stop(graph, skin_of(rod), law) : add_table(graph, skin_of(rod), law);
      nodal = history(graph, contact, rod.node(9), end);
    }
    std::vector<double> tips, forces;
    for (const int modes : {0, 3, 8, 24}) {
      SystemGraph graph;
      FlexibleBody& rod =
          pendulum ? add_modal_pendulum(graph, modes) : add_modal(graph, {.velocity = {0.2, 0, -1}}, modes);
      const Contact& contact = pendulum ? add_stop(graph, skin(rod), law) : add_table(graph, skin(rod), law);
      const History modal = history(graph, contact, rod.node(33), end);
      tips.push_back(farthest(modal.tip, nodal.tip));
      forces.push_back(distance(modal.force, nodal.force));
    }
    // 0, 3, 8 and 24 modes; measured: the rod's tip 1.5 mm, 120, 6 and 2 um off, its force 75, 21, 0.9 and 0.24 %; the
    // pendulum's 780, 290, 24 and 8 um, 7.7, 5.9, 0.6 and 0.15 %.
    const std::string name = pendulum ? "pendulum" : "rod";
    for (std::size_t i = 1; i < tips.size(); ++i) {
      expect_below(name + ": tip, of fewer modes'", tips[i] / tips[i - 1], 0.5);
      expect_below(name + ": force, of fewer modes'", forces[i] / forces[i - 1], 0.9);
    }
    expect_below(name + ": tip with 24 modes (m)", tips.back(), pendulum ? 1.5e-5 : 4e-6);
    expect_below(name + ": force with 24 modes", forces.back(), 5e-3);
  }
}

/// Rigid surfaces: what each step did, and what the rod has.
class Impulses final : public Observer {
 public:
  Impulses(std::function<Vector3(const BodyState&)> momentum, const Body& body, const Contact& contact)
      : momentum_(std::move(momentum)), body_(body), force_(contact_force(contact, 1)), energy_(total_energy()) {}
  void observe(Snapshot& now) override {
    double f[6];
    force_.evaluate(now, f);
    const Vector3 p = momentum_(now.body_state(body_));
    const double energy = energy_.value(now);
    if (steps_++ > 0) {
      const Vector3 impulse = (now.time() - time_) * Vector3(f[0], f[1], f[2]);
      worst_ = std::max(worst_, (p - p_ - impulse - kMass * (now.time() - time_) * Vector3(0, 0, -9.81)).norm());
      sum_ += impulse;
      rise_ = std::max(rise_, energy - lowest_);
    }
    time_ = now.time(), p_ = p, lowest_ = std::min(lowest_, energy);
    if (steps_ == 1) first_ = energy;
  }
  double worst() const { return worst_ / sum_.norm(); }  // of the sum
  double lost() const { return first_ - lowest_; }
  double rise() const { return rise_; }
  Vector3 sum() const { return sum_; }

 private:
  const std::function<Vector3(const BodyState&)> momentum_;
  const Body& body_;
  Sensor force_, energy_;
  double time_ = 0, worst_ = 0, lowest_ = 1e300, rise_ = 0, first_ = 0;
  int steps_ = 0;
  Vector3 p_ = Vector3::Zero(), sum_ = Vector3::Zero();
};

Method stepping(bool alpha, double step) {
  if (alpha) return std::make_unique<NonsmoothGeneralizedAlpha>(NonsmoothGeneralizedAlpha::Parameters{.step = step});
  return std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = step});
}

TEST(FlexibleContact, ImpulsesOfRigidSurfacesChangeTheRodsMomentumExactlyAndTakeEnergy) {
  for (const bool alpha : {false, true})
    for (const double friction : {0.0, 0.4})
      for (const bool nodal : {false, true}) {
        const Contact::Parameters law{.law = RigidSurfaces{}, .friction = {.coefficient = friction}};
        SystemGraph graph;
        const Start start{.velocity = {friction > 0 ? 1.0 : 0.0, 0, -1}};
        const Body* body;
        std::function<Vector3(const BodyState&)> momentum;
        const Contact* contact;
        if (nodal) {
          InertialBody& rod = add_nodal(graph, start);
          contact = &add_table(graph, skin_of(rod), law);
          body = &rod, momentum = [&rod](const BodyState& b) { return rod.linear_momentum(b); };
        } else {
          FlexibleBody& rod = add_modal(graph, start, 6);
          contact = &add_table(graph, skin(rod), law);
          body = &rod, momentum = [&rod](const BodyState& b) { return rod.linear_momentum(b); };
        }
        const System system = assemble(graph);
        State state = system.initial_state();
        // At 0.1 ms the energy of the modal rod rises by 1.6e-5 J where it rubs, with shorter steps by less.
        const Method method = stepping(alpha, nodal ? 1e-4 : 5e-5);
        Simulation simulation(system, *method);
        Impulses impulses(momentum, *body, *contact);
        simulation.observe(impulses, every_step());
        simulation.run(state, 0.03);
        const std::string name = method->name() + (nodal ? ", nodal" : ", modal") + (friction > 0 ? ", rubbing" : "");
        expect_below(name + ": momentum by impulses", impulses.worst(), 1e-10);
        expect_below(name + ": energy lost (J)", -impulses.lost(), -0.04);
        expect_below(name + ": upwards (N s)", -impulses.sum()[2], -0.2);
        // Friction takes at most what Coulomb lets it; all points slide here but those of the nodal rod at the end.
        expect_below(name + ": in the cone", std::abs(impulses.sum()[0]) - friction * impulses.sum()[2], 1e-9);
        if (friction > 0) expect_below(name + ": braked (N s)", impulses.sum()[0], -0.05);
        // The modes are resolved by this step. The elements' own frequencies are not: what leaves the table at a step's
        // start they bring back within it, and the impulse that stops it works upon a mean speed upwards.
        expect_below(name + ": energy rises (J)", impulses.rise(), nodal ? 1e-2 : 1e-5);
      }
}

TEST(FlexibleContact, ARodAtRestOnRigidSurfacesWeighsWhatItWeighsAndStays) {
  for (const bool alpha : {false, true}) {
    SystemGraph graph;
    FlexibleBody& rod = graph.add<FlexibleBody>("rod", {.basis = free_modes(6), .damping = {.modal_ratios = {0.05}}});
    const Contact& contact = add_table(graph, skin(rod), {.law = RigidSurfaces{}, .friction = {.coefficient = 0.4}});
    const System system = assemble(graph);
    State state = system.initial_state();
    const Method method = stepping(alpha, 1e-3);
    Simulation simulation(system, *method);
    Recorder recorder({position(rod.node(1), "a"), position(rod.node(33), "b"), contact_force(contact, 1, "contact")});
    simulation.observe(recorder, every(0.1));
    simulation.run(state, 1);
    const Table& t = recorder.table();
    double weight = 0, drift = 0;
    for (int row = 2; row < t.row_count(); ++row)
      weight = std::max(weight, std::abs(t.column("contact_force_z")[row] / (kMass * 9.81) - 1));
    const int last = t.row_count() - 1;
    for (const char* c : {"a_x", "a_y", "a_z", "b_x", "b_y", "b_z"})
      drift = std::max(drift, std::abs(t.column(c)[last] - t.column(c)[1]));
    expect_below(method->name() + ": weight", weight, 1e-8);
    expect_below(method->name() + ": drift (m)", drift, 1e-9);
  }
}

/// Two rods across each other in free space, that meet and rub; momentum and angular momentum of both.
TEST(FlexibleContact, APairOfBodiesKeepsItsMomentumAndAngularMomentum) {
  for (const bool nodal : {false, true}) {
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    FlexibleBody& lower = add_modal(graph, {.tilt = 0, .gap = 0, .velocity = {0.5, 0, 0}, .name = "lower"}, 6);
    const Start above{.tilt = 0.1, .gap = 0.0201, .velocity = {-0.5, 0.7, -1}};
    const Contact::Parameters law{.law = Compliance{.stiffness = 1e6},
                                  .friction = {.coefficient = 0.5, .creep_speed = 0.05}};
    std::function<Vector3(const BodyState&)> linear, angular;
    const Body* upper;
    const auto meet = [&](const Body& body, const Collider& collider) {
      graph.add<Contact>("rods", {skin(lower), collider}, law);
      upper = &body;
    };
    if (nodal) {
      InertialBody& rod = add_nodal(graph, above);
      meet(rod, skin_of(rod));
      linear = [&rod](const BodyState& b) { return rod.linear_momentum(b); };
      angular = [&rod](const BodyState& b) { return rod.angular_momentum(b); };
    } else {
      FlexibleBody& rod = add_modal(graph, above, 6);
      meet(rod, skin(rod));
      linear = [&rod](const BodyState& b) { return rod.linear_momentum(b); };
      angular = [&rod](const BodyState& b) { return rod.angular_momentum(b); };
    }
    const System system = assemble(graph);
    State state = system.initial_state();
    Snapshot now(system, state);
    const auto sums = [&] {
      const BodyState a = now.body_state(lower), b = now.body_state(*upper);
      Vector6 sum;
      sum << lower.linear_momentum(a) + linear(b), lower.angular_momentum(a) + angular(b);
      return sum;
    };
    const Vector6 start = sums();
    const Vector3 before = linear(now.body_state(*upper));
    const Method method = runge_kutta_fixed(1e-6);
    Simulation simulation(system, *method);
    simulation.run(state, 1e-3);
    now.evaluate(state);
    const std::string name = nodal ? "modal and nodal" : "modal";
    const Vector3 changed = linear(now.body_state(*upper)) - before;
    expect_below(name + ": met, and braked (N s)", -changed.head<2>().norm(), -1e-3);
    expect_below(name + ": momentum (N s)", (sums() - start).head<3>().norm(), 1e-12);
    // A method's own error, where points come and go: it falls with the third power of the step.
    expect_below(name + ": angular momentum (N m s)", (sums() - start).tail<3>().norm(), 2e-11);
  }
}

TEST(FlexibleContact, AShapeOnTheMeanOfNodesPushesThem) {
  SystemGraph graph;
  FlexibleBody& rod = add_modal(graph, {.tilt = 0.1, .gap = 0.02, .velocity = {0.2, 0, -1}}, 6);
  const Contact& contact = add_table(graph, {rod.average({33, 35}), shape::sphere(0.0199)}, kElastic);
  const Method method = runge_kutta_fixed(2e-6);
  expect_balanced(*method, true, *watch_run(graph, rod, contact, {}, *method, 3e-3));
}

TEST(FlexibleContact, BristlesHoldARodOnASlope) {
  const double slope = 0.2, stiffness = 1e7;
  SystemGraph graph{{.gravity = {9.81 * std::sin(slope), 0, -9.81 * std::cos(slope)}}};
  FlexibleBody& rod = graph.add<FlexibleBody>("rod", {.basis = free_modes(6), .damping = {.modal_ratios = {0.05}}});
  const Contact& contact =
      add_table(graph, skin(rod),
                {.law = Compliance{.stiffness = stiffness, .exponent = 1, .restitution = 0.2},
                 .friction = {.coefficient = 0.4, .bristle_stiffness = 1e5, .bristle_damping = 300}});
  const System system = assemble(graph);
  State state = system.initial_state();
  const Method method = index2(1e-4, 0.5);
  Simulation simulation(system, *method);
  simulation.run(state, 0.3);
  Snapshot now(system, state);
  const Sensor place = position(rod.node(1)), force = contact_force(contact, 1);
  const double there = place.value(now, 0);
  expect_below("friction bears the weight", std::abs(force.value(now, 0) / (kMass * 9.81 * std::sin(slope)) + 1), 1e-4);
  simulation.run(state, 0.5);
  now.evaluate(state);
  expect_below("creeps (m)", std::abs(place.value(now, 0) - there), 1e-9);
}

}  // namespace
}  // namespace lithe::test::flexible_contact_test
