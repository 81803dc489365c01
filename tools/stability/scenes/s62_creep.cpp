// S62: a block on a slope of 10 degrees that friction of 0.3 holds (C02): regularised friction lets it creep.
#include "engine/base/number_text.h"
#include "engine/study/study_run.h"
#include "tools/stability/methods/ordinary.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/contacts.h"

namespace lithe::lab {
namespace {

constexpr double kSlope = 10 * M_PI / 180, kFriction = 0.3, kEnd = 10, kLimit = 1e-9;  // rad, -, s, m

/// (x, v) of 1 kg on the slope, friction μ N tanh(v / v_d) by the library's law.
struct Creeping {
  double v_d;  // m/s
  VectorX operator()(double, const VectorX& y) const {
    const ContactFriction law{.coefficient = kFriction, .creep_speed = 3 * v_d};
    const double force = regularised_friction(law, kGravity * std::cos(kSlope), y[1]);
    return Eigen::Vector2d(y[1], kGravity * std::sin(kSlope) + force);
  }
  double steady_speed() const { return v_d * std::atanh(std::tan(kSlope) / kFriction); }
  /// Where a thousandth of that speed more or less grows in RK4.
  double critical_step() const {
    const auto holds = [&](double h) {
      VectorX y = Eigen::Vector2d(0, 1.001 * steady_speed());
      for (int i = 0; i < 3000; ++i) y = rk4_step(*this, 0, y, h);
      return std::abs(y[1] - steady_speed()) < 0.001 * steady_speed();
    };
    return largest_stable_step(holds, v_d, 2 * v_d, 1e-3);
  }
  double displacement(double h) const {
    const int count = static_cast<int>(std::ceil(kEnd / h));
    VectorX y = Eigen::Vector2d::Zero();
    for (int i = 0; i < count; ++i) y = rk4_step(*this, 0, y, kEnd / count);
    return y[0];
  }
};

Finding regularised() {
  const double speeds[] = {1e-1, 1e-2, 1e-3, 1e-4}, moved[] = {0.671, 6.74e-2, 6.74e-3, 6.74e-4},
               steps[] = {0.146, 1.46e-2, 1.46e-3, 1.46e-4};
  std::vector<Figure> figures;
  double step = NAN, least = INFINITY;
  for (int i = 0; i < 4; ++i) {
    const Creeping law{speeds[i]};
    step = law.critical_step();
    figures.push_back(
        {"displacement in 10 s, m, v_d = " + short_number(speeds[i]), law.displacement(0.5 * step), moved[i], 3});
    figures.push_back({"largest stable step of RK4, s", step, steps[i], 3});
    least = std::min(least, figures[2 * i].value);
  }
  return {judged(least, kLimit), figures, "creeps at v_d atanh(tan / μ); its explicit step falls with v_d", step};
}

/// A box on the plane z = 0, gravity leaning by the slope.
class Block : public Bench {
 public:
  explicit Block(const Contact::Parameters& contact, double depth = 0)
      : Bench(kGravity * Vector3(std::sin(kSlope), 0, -std::cos(kSlope)), [&](SystemGraph& graph) {
          const Vector3 edges(0.2, 0.2, 0.1);
          auto& block = graph.add<RigidBody>(
              "block", {.mass = 1, .inertia = box_inertia(edges, 1), .position = {0, 0, 0.5 * edges[2] - depth}});
          graph.add<Contact>(
              "slope", {{graph.ground().marker(), shape::half_space()}, {block.marker(), shape::box(edges)}}, contact);
        }) {}
  double displacement() const { return (state.q.head<3>() - system.initial_state().q.head<3>()).norm(); }
};

Finding set_valued(Integrator& method) {
  Block block({.law = RigidSurfaces{}, .friction = {.coefficient = kFriction}});
  double most = 0;
  const auto course = block.run(method, kEnd, [&] { most = std::max(most, block.displacement()); });
  return {course.reached ? judged(most, kLimit) : Outcome::unstable,
          {{"displacement in 10 s, m", most}, {"steps", static_cast<double>(course.steps)}},
          course.why};
}

/// Bristles give way first, then hold.
Finding bristles() {
  constexpr double kStiffness = 1e5;  // N/m a corner
  Block block(
      {.law = Compliance{.stiffness = kStiffness, .exponent = 1, .dissipation = Dissipation::fixed, .damping = 10},
       .friction = {.coefficient = kFriction, .bristle_stiffness = 1e4, .bristle_damping = 100}},
      kGravity * std::cos(kSlope) / 4 / kStiffness);
  const Method method = runge_kutta(1e-8);
  const auto settling = block.run(*method, 2);
  const double settled = block.displacement();
  const auto course = block.go_on(*method, 2 + kEnd);
  const double moved = std::abs(block.displacement() - settled);
  return {settling.reached && course.reached ? judged(moved, kLimit) : Outcome::unstable,
          {{"displacement in 10 s, m, after 2 s", moved},
           {"in these 2 s", settled},
           {"steps", static_cast<double>(settling.steps + course.steps)}},
          course.why};
}

const Registered scene{under_every_method(
    {"S62",
     "false sticking (creep)",
     {{"regularised Coulomb tanh(v/vd)", regularised},
      {"set-valued friction (complementarity)", [] { return set_valued(*moreau(1e-3)); }},
      {"Moreau-Jean, h = 0.01", [] { return set_valued(*moreau(0.01)); }, Role::ours},
      {"nonsmooth generalized-alpha, h = 0.01", [] { return set_valued(*nonsmooth_alpha(0.01)); }, Role::ours},
      {"compliant contact with bristles (LuGre)", bristles, Role::also, Cost::slow}}},
    {1e-6, 1e-3}, set_valued)};

}  // namespace
}  // namespace lithe::lab
