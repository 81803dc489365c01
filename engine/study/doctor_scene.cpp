#include <Eigen/Eigenvalues>
#include <cmath>
#include <set>

#include "engine/assembly/evaluator.h"
#include "engine/study/doctor_internal.h"

namespace lithe {
namespace doctor {
namespace {

/// The pose and velocities that the bodies were drawn with.
State as_drawn(const System& system) {
  State state = system.initial_state();
  for (const Layout::BodySlice& b : system.layout().bodies()) {
    if (b.part > 0) continue;
    const Coordinates c = b.body->coordinates();
    b.body->initial_state(state.q.segment(b.q, c.q_count()), state.v.segment(b.v, c.v_count()));
  }
  return state;
}

void look_at_start(const System& system, const State& start, double length, std::vector<Finding>& out) {
  const Layout& layout = system.layout();
  if (layout.row_count() == 0) return;
  constexpr double kOpen = 1e-3;  // of the scene's length, or rad
  int row = 0, coordinate = 0;
  // 1. As drawn, before assemble() closed the joints.
  const State drawn = as_drawn(system), &closed = system.initial_state();
  const VectorX gaps = rows_at(system, 0, drawn, Level::position);
  if (gaps.cwiseAbs().maxCoeff(&row) > kOpen * std::min(length, 1.0)) {
    VectorX moved(layout.v_count());
    layout.difference(drawn.q, closed.q, moved);
    moved.cwiseAbs().maxCoeff(&coordinate);
    out.push_back(
        {Cause::open_joint, true, 0.95,
         "joint " + layout.row_name(row) + " does not close as drawn: it is off by " + number(gaps[row]) +
             "; assemble() moved " + layout.velocity_name(coordinate) + " by " + number(moved[coordinate]),
         "place the bodies or the markers so that the joint closes; AssembleOptions::Start::refuse tells of it"});
  } else if (drawn.v.cwiseAbs().maxCoeff() > 0) {  // one drawn at rest gets the velocities that drives want
    const VectorX changed = closed.v - drawn.v;
    const double largest = changed.cwiseAbs().maxCoeff(&coordinate);
    if (largest > 1e-3 * (1e-3 + drawn.v.cwiseAbs().maxCoeff())) {
      State moving = closed;
      moving.v = drawn.v;
      rows_at(system, 0, moving, Level::velocity).cwiseAbs().maxCoeff(&row);
      out.push_back({Cause::inconsistent_start, true, 0.9,
                     "the velocities as drawn contradict the joints, most " + layout.row_name(row) + ": " +
                         layout.velocity_name(coordinate) + " was changed from " + number(drawn.v[coordinate]) +
                         " to " + number(closed.v[coordinate]),
                     "give every body the velocity of the motion, v = omega × r with omega in body axes, or all zero"});
    }
  }
  // 2. The state given.
  const VectorX g = rows_at(system, start.time, start, Level::position);
  const VectorX g_dot = rows_at(system, start.time, start, Level::velocity);
  int on_velocity = 0;
  const double gap = g.cwiseAbs().maxCoeff(&row), speed = g_dot.cwiseAbs().maxCoeff(&on_velocity);
  if (gap > 1e-6 * std::max(1.0, length))
    out.push_back(
        {Cause::inconsistent_start, true, 0.92,
         "the state to start from leaves joint " + layout.row_name(row) + " open by " + number(gap),
         "start from system.initial_state(), or move the state onto the constraints with Projector::position"});
  else if (speed > 1e-6 * (1 + start.v.cwiseAbs().maxCoeff()) &&
           !std::ranges::any_of(system.redundant_rows(), [&](const auto& r) { return r.row == on_velocity; }))
    out.push_back({Cause::inconsistent_start, true, 0.92,
                   "the velocities to start from break joint " + layout.row_name(on_velocity) + " by " + number(speed),
                   "start from system.initial_state(), or make them consistent with Projector::velocity"});
}

void look_at_units(const System& system, const State& start, double length, std::vector<Finding>& out) {
  const auto add = [&](Cause cause, double certainty, const std::string& what, const std::string& fix) {
    out.push_back({cause, true, certainty, what, fix});
  };
  if (const double g = system.gravity().norm(); g > 100)
    add(Cause::bad_unit, 0.98, "gravity is " + number(g) + " m/s²: " + number(g / 9.80665) + " times that of the earth",
        "give SI units throughout: metres, kilograms, seconds; 9.81, not 9810 mm/s²");
  const double reach = std::max(length, reach_of(system, start));
  // 1. Bodies.
  const std::vector<BodyInertia> all = inertias(system, start);
  constexpr double kTooDense = 3e8;  // kg/m³: grams for kilograms make any stuff denser; a thin rod's idle axis less
  Snapshot now(system, start);
  const auto own_reach = [&](const BodyInertia& b) {
    double farthest = 0;
    for (const auto& c : system.graph().constraints())
      for (const Marker& m : c.markers)
        if (m.body == b.slice->body) farthest = std::max(farthest, now.marker(m).r.norm());
    return farthest;
  };
  for (const BodyInertia& b : all) {
    const std::string body = "body " + quoted(b.slice->name);
    if (!(b.mass > 0)) continue;
    if (b.gyration() > 100 * reach)
      add(Cause::bad_unit, 0.95,
          body + " has a radius of gyration of " + number(b.gyration()) + " m in a scene of " + number(reach) + " m",
          "give its inertia in kg m² about its centre of mass (1 kg mm² is 1e-6 kg m²)");
    else if (b.principal == Vector3::Ones() && b.gyration() > 3 * reach)
      add(Cause::bad_unit, 0.9,
          body + " has an inertia of 1 kg m² about all axes, as if it had been left out: a radius of gyration of " +
              number(b.gyration()) + " m in a scene of " + number(reach) + " m",
          "give its mass and its inertia (kg m², about its centre of mass)");
    else if (b.gyration() < 1e-6 * reach)
      add(Cause::mass_ratio, 0.85,
          body + " turns almost without inertia: its radius of gyration is " + number(b.gyration()) +
              " m in a scene of " + number(reach) + " m",
          "give it an inertia (kg m²), or leave its rotation out: tie it to a neighbour, or make it part of one");
    else if (b.slice->linear == 0 && b.density() > 0 && b.density() < 1e-4)
      add(Cause::bad_unit, 0.93,
          body + " has mass and inertia of a box of " + number(b.density()) + " kg/m³, thinner than air by far",
          "give lengths in metres and inertia in kg m²: millimetres make densities of 1e-6");
    else if (b.slice->linear == 0 && b.density() > kTooDense && own_reach(b) > 20 * b.gyration())
      add(Cause::bad_unit, 0.92,
          body + " has mass and inertia of a box of " + number(b.density()) + " kg/m³, of " + number(b.gyration()) +
              " m, but markers " + number(own_reach(b)) + " m from its centre",
          "give its mass in kilograms beside an inertia in kg m² (1 g is 1e-3 kg)");
  }
  const auto [light, heavy] = std::minmax_element(
      all.begin(), all.end(), [](const BodyInertia& a, const BodyInertia& b) { return a.mass < b.mass; });
  if (light != all.end() && heavy->mass > 1e8 * light->mass)
    add(Cause::mass_ratio, 0.88,
        "body " + quoted(heavy->slice->name) + " weighs " + number(heavy->mass / light->mass) + " times as much as " +
            quoted(light->slice->name) + " (" + number(light->mass) + " kg)",
        "check both masses (kg); what has next to no mass is better a massless joint, a rod or a coupling");
  // 2. Springs.
  for (const Rate& rate : fastest_rates(system, start))
    if (rate.stiffness > 1e14)
      add(Cause::bad_unit, 0.94, rate.name + " has a stiffness of " + number(rate.stiffness) + " N/m (or N m/rad)",
          "steel of a square metre and a metre long has 2e11 N/m: check N/m, N/mm and GPa; or use a joint");
}

/// Bodies that no chain of connectors ties to ground.
void look_at_ties(const System& system, std::vector<Finding>& out) {
  const SystemGraph& graph = system.graph();
  std::set<const Body*> tied{graph.bodies().front().body};
  for (bool more = true; more;) {
    more = false;
    const auto spread = [&](const std::vector<Marker>& markers) {
      const bool any = std::ranges::any_of(markers, [&](const Marker& m) { return tied.contains(m.body); });
      for (const Marker& m : markers)
        if (any) more |= tied.insert(m.body).second;
    };
    for (const auto& c : graph.constraints()) spread(c.markers);
    for (const auto& f : graph.forces()) spread(f.markers);
    for (const auto& c : graph.contacts()) spread(c.markers);
  }
  std::string names;
  for (const auto& entry : graph.bodies())
    if (!tied.contains(entry.body) && entry.body->coordinates().frames > 0)
      names += (names.empty() ? "" : ", ") + quoted(entry.body->name());
  if (names.empty()) return;
  out.push_back({Cause::free_body, false, 0.5,
                 "nothing ties " + names + " to ground" + (system.gravity().norm() > 0 ? ": it falls freely" : ""),
                 "none, if it is to fly; else add the joint or the force that is missing"});
}

}  // namespace

std::string quoted(const std::string& name) { return "'" + name + "'"; }

double BodyInertia::density() const {
  const Vector3& J = principal;
  const double volume_squared = (J[1] + J[2] - J[0]) * (J[0] + J[2] - J[1]) * (J[0] + J[1] - J[2]);
  return volume_squared > 0 ? mass / std::sqrt(216 * volume_squared / (mass * mass * mass)) : 0;
}

std::vector<BodyInertia> inertias(const System& system, const State& start) {
  Evaluator equations(system);
  equations.recall(start.quarter_turns);
  equations.evaluate(start.time, start.q, start.v, Level::velocity);
  equations.factorize({0, 0, 1}, VectorX::Zero(start.v.size()), VectorX::Zero(system.layout().row_count()), nullptr);
  std::vector<BodyInertia> out;
  equations.visit_blocks([&](int row, int column, ConstMatrixRef block) {
    if (row != column || block.rows() != 6) return;
    for (const Layout::BodySlice& b : system.layout().bodies()) {
      if (!b.frame || b.v != row) continue;
      const Matrix3 J = block.bottomRightCorner<3, 3>();
      out.push_back({&b, block(0, 0), Eigen::SelfAdjointEigenSolver<Matrix3>(J, Eigen::EigenvaluesOnly).eigenvalues()});
    }
  });
  return out;
}

double reach_of(const System& system, const State& start) {
  double reach = 0;
  Vector3 low = Vector3::Constant(1e300), high = -low;
  for (const auto& b : system.layout().bodies())
    if (b.frame) {
      low = low.cwiseMin(start.q.segment<3>(b.q));
      high = high.cwiseMax(start.q.segment<3>(b.q));
    }
  if (low.x() <= high.x()) reach = (high - low).norm();
  Snapshot now(system, start);
  const auto add = [&](const std::vector<Marker>& markers) {
    for (const Marker& m : markers)
      if (m.body->coordinates().frames > 0) reach = std::max(reach, now.marker(m).r.norm());
  };
  for (const auto& c : system.graph().constraints()) add(c.markers);
  for (const auto& f : system.graph().forces()) add(f.markers);
  for (const auto& c : system.graph().contacts()) add(c.markers);
  return reach;
}

VectorX rows_at(const System& system, double time, const State& state, Level level) {
  Evaluator equations(system);
  equations.recall(state.quarter_turns);
  equations.evaluate(time, state.q, state.v, Level::velocity);
  VectorX rows(system.layout().row_count());
  equations.constraint(level, rows);
  return rows;
}

VectorX drive_rates(const System& system) {
  State still = system.initial_state();
  still.v.setZero();
  VectorX largest = VectorX::Zero(system.layout().row_count());
  for (double time : {0.0, 0.0137, 0.31, 1.0})
    largest = largest.cwiseMax(rows_at(system, time, still, Level::velocity).cwiseAbs());
  return largest;
}

/// Contacts are passive: they need no look.
bool is_conservative(const System& system, const std::vector<State>& states) {
  if (system.layout().row_count() > 0 && drive_rates(system).maxCoeff() > 0) return false;
  Snapshot now(system);
  for (const State& state : states) {
    now.evaluate(state);
    for (const auto& entry : system.graph().forces())
      if (power(*entry.force).value(now) > 1e-12 && potential_energy(*entry.force).value(now) == 0) return false;
  }
  return true;
}

Finding of_refused_scene(Drawn& drawn, const SceneError& error) {
  const std::string text = error.problem();
  const auto says = [&](const char* words) { return text.find(words) != std::string::npos; };
  Finding finding{Cause::bad_parameter, true, 0.9, text + " (" + error.where() + ")", error.fix()};
  if (says(kContradict)) {
    const System system = assemble(drawn.graph, {.start = AssembleOptions::Start::as_drawn});
    finding.cause = drive_rates(system).maxCoeff() > 0 ? Cause::incompatible_drive : Cause::open_joint;
  } else if (says("cannot be assembled")) {
    finding.cause = Cause::open_joint;
  } else if (says("not finite")) {
    finding.cause = Cause::no_number;
    const System system = assemble(drawn.graph, {.start = AssembleOptions::Start::as_drawn});
    Snapshot now(system, system.initial_state());
    for (const auto& entry : drawn.graph.forces())
      if (!force_values(now, *entry.force).allFinite())
        finding.what =
            "the force '" + entry.force->name() + "' on " + bodies_of(*entry.force) + " is not finite at t = 0",
        finding.fix = "look for a division by a zero distance or speed, a root or a logarithm of what is negative";
  }
  return finding;
}

}  // namespace doctor

std::vector<Finding> look_over(const System& system, const State& start, double characteristic_length) {
  std::vector<Finding> findings;
  doctor::look_at_start(system, start, characteristic_length, findings);
  doctor::look_at_rank(system, start, findings);
  doctor::look_for_locked_modes(system, start, findings);
  doctor::look_at_units(system, start, characteristic_length, findings);
  doctor::look_at_ties(system, findings);
  doctor::look_at_elements(system, start, characteristic_length, findings);
  return findings;
}

}  // namespace lithe
