#include "integrators/contact_impulses.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>
#include <utility>

#include "engine/archive/archive.h"
#include "engine/base/log.h"
#include "engine/cones/gauss_seidel.h"

namespace lithe {
namespace {

constexpr int kMaxImpacts = 10000;  // of one step, one after another
constexpr int kMaxBounces = 1000;   // of one point within a step
constexpr double kWedged = 1e-3;    // of the impulses, that none are found: less is too few iterations

/// Normal velocity by a unit of the contact's own normal impulse, 1/kg.
double diagonal(const ConeProblem& problem, const ConeProblem::Contact& c) {
  double sum = 0;
  for (const ConeProblem::Side& side : c.sides)
    for (int k = 0; k < side.count; ++k)
      sum += problem.values[side.H + c.rows * k] * problem.values[side.Y + side.first + k];
  return sum;
}

}  // namespace

ContactImpulses::ContactImpulses(Parameters parameters, std::unique_ptr<ConeSolver> solver)
    : parameters_(parameters),
      solver_(std::move(solver)),
      single_(std::make_unique<GaussSeidel>(GaussSeidel::Parameters{})),
      position_(solver_->clone()) {}

/// With constant acceleration a over the step.
ContactImpulses::Closing ContactImpulses::closing(const RigidContacts::Point& point, double gap, double velocity,
                                                  double h) const {
  const double before = point.before[0] - growth_[point.first], a = (velocity - before) / h,
               time = time_to_close(gap, before, a, h);
  return {time, -(before + a * time), a};
}

/// An impact at τ leaves with e times its speed, and again where it comes back within the step; what comes to rest
/// stays.
ContactImpulses::Aim ContactImpulses::aim(const RigidContacts::Point& point, double restitution, const Closing& closing,
                                          double free_velocity, double gap, double free_gap, double h) const {
  // Others may push it there: as fast as it then closes, but not beyond rest. Were what has come back thrown out as
  // fast as it came, a body that leans on its corners would rock for ever.
  if (free_gap > 0) return {std::min(free_velocity - 2 * free_gap / h, 0.0), h / 2};
  if (closing.speed > point.law.rest_speed && restitution > 0) {
    double after = restitution * closing.speed, rest = h - closing.time;
    for (int bounces = 0; bounces < kMaxBounces; ++bounces) {
      const double away = after + 0.5 * closing.acceleration * rest;  // mean speed; rest may be zero
      if (away > 0) return {after + closing.acceleration * rest, h - closing.time, away * rest};
      if (after <= point.law.rest_speed) break;
      rest -= 2 * after / -closing.acceleration;
      after *= restitution;
    }
  }
  if (closing.speed <= point.law.rest_speed || !(free_velocity < 0)) return {0, h / 2};
  return {0, std::clamp((free_gap - std::min(gap, 0.0)) / free_velocity, 0.0, h)};
}

bool ContactImpulses::apply(EquationsOfMotion& equations, const State& start, double h, VectorX& v_end, VectorX& d) {
  const bool near = find(equations, start, h);
  if (near) act(equations, start, h, v_end, d);
  return near;
}

bool ContactImpulses::find(EquationsOfMotion& equations, const State& start, double h) {
  RigidContacts& contacts = *equations.parts().rigid_contacts;
  iterations_ = 0;
  cut_ = 0;
  contacts.find(start.v, h);
  if (contacts.fast() && would_pass(equations, start, h)) return false;
  acted_ = !contacts.empty();
  if (!acted_) {
    tell_of_partings(contacts, h, start.contacts);
    return false;
  }
  const ConeProblem& problem = contacts.form();
  as_formed_ = problem.contacts;
  last_.resize(problem.rows), growth_.resize(problem.rows);
  contacts.recall(start.contacts, h, last_, growth_);
  guess_ = last_;
  return true;
}

void ContactImpulses::act(EquationsOfMotion& equations, const State& start, double h, VectorX& v_end, VectorX& d,
                          const Others* others) {
  RigidContacts& contacts = *equations.parts().rigid_contacts;
  const ContactMemory& last = start.contacts;
  contacts.happenings().clear();
  impacts_.clear();
  ConeProblem& problem = contacts.problem();
  problem.contacts = as_formed_;
  const int n = static_cast<int>(contacts.points().size());
  u_.resize(problem.rows);
  for (VectorX* x : {&total_, &placed_, &late_}) x->setZero(problem.rows);
  dv_.resize(start.v.size());
  v_free_ = v_end, d_free_ = d;

  // 1. Gaps at both ends of the step without contact; they were found in its middle.
  gaps_.resize(n), free_gaps_.resize(n), weights_.resize(n), least_gaps_.resize(n);
  friction_.begin(contacts, last, last_, growth_, h, parameters_.position_tolerance);
  contacts.velocity(v_end, u_);
  u_ += growth_;
  brought_.setZero(problem.rows);
  if (others) contacts.velocity(others->brought, brought_);
  closings_.clear();
  for (int i = 0; i < n; ++i) {
    const RigidContacts::Point& point = contacts.points()[i];
    gaps_[i] = point.gap - h / 2 * point.before[0];
    closings_.push_back(closing(point, gaps_[i], u_[point.first] - brought_[point.first], h));
    const Closing& met = closings_.back();
    if (met.speed * (h - met.time) > parameters_.position_tolerance && contacts.is_held(i))
      contacts.refuse_held(i, start, met.speed);
  }
  held_until_.setConstant(n, -1);
  if (parameters_.impacts == Impacts::sequential)
    collide(contacts, h, v_end, d);
  else
    hold(contacts, h, v_end, d);
  contacts.velocity(v_end, u_);
  u_ += growth_;
  moved_.resize(problem.rows);
  contacts.velocity(d, moved_);
  for (int i = 0; i < n; ++i) {
    const RigidContacts::Point& point = contacts.points()[i];
    gaps_[i] = point.gap - h / 2 * point.before[0];
    free_gaps_[i] = gaps_[i] + moved_[point.first] - h / 2 * brought_[point.first];
  }

  // 2. The velocity that each point is to have, and impulses that make it.
  impacts_.resize(n);
  wedged_.assign(n, 0);
  set_aims(contacts, h);
  r_ = guess_;
  solve_bounces(contacts, h);
  if (join_impacts(contacts, h)) solve_bounces(contacts, h);
  if (cut_ > 0) {
    if (uncut_ == 0) uncut_ = h;
    return;
  }
  while (friction_.revise(contacts, r_)) solve_bounces(contacts, h);
  guess_ = r_;
  total_ += r_;
  dv_.setZero();
  contacts.add_response(r_, nullptr, dv_);
  v_end += dv_;
  place_slips(contacts, h, v_end, d);
  as_solved_ = problem.contacts;
  displace(contacts, d);
  keep_energy(equations, start, h, others, v_end, d);
  tell_of_meetings(contacts, h, last);
  tell_of_partings(contacts, h, last);
}

void ContactImpulses::set_aims(RigidContacts& contacts, double h) {
  ConeProblem& problem = contacts.problem();
  const int n = static_cast<int>(contacts.points().size());
  problem.free = u_;
  double fastest = 0;
  for (const Closing& met : closings_)
    if (met.time < h) fastest = std::max(fastest, met.speed);
  for (int i = 0; i < n; ++i) {
    const RigidContacts::Point& point = contacts.points()[i];
    const double free = u_[point.first] - brought_[point.first];
    const double restitution = wedged_[i] ? 0 : point.law.restitution;
    Aim aimed = aim(point, restitution, closings_[i], free, gaps_[i], free_gaps_[i], h);
    if (parameters_.impacts == Impacts::sequential) {
      if (free_gaps_[i] <= 0)
        aimed = {0, free < 0 && gaps_[i] >= 0 ? std::clamp(free_gaps_[i] / free, 0.0, h / 2) : h / 2};
    } else if (const Closing& met = closings_[i]; free_gaps_[i] <= 0 && met.speed > point.law.rest_speed) {
      const double held = aimed.gap > 0 ? 0 : std::max(0.0, -met.acceleration * (h - met.time));
      impacts_[i] = {met.time, met.speed, met.speed / (met.speed + held)};
    }
    if (held_until_[i] >= 0) {
      aimed.time = h - held_until_[i];
      // What rests or hops between elastic surfaces: not in reach of the impact, or touched by it.
      if (free_gaps_[i] > 0 && restitution > 0) {
        const bool in_reach = free_gaps_[i] <= 2 * fastest * aimed.time;
        aimed.velocity = in_reach ? 0 : std::min(free - free_gaps_[i] / aimed.time, 0.0);
      }
    }
    problem.free[point.first] -= aimed.velocity;
    weights_[i] = aimed.time;
    least_gaps_[i] = aimed.gap;
  }
}

/// No impulse may part surfaces as fast as their restitution wants: where friction holds them in a wedge (a body that a
/// slide guides onto the floor at less than the angle of friction), any that would is beyond Coulomb's cone the more,
/// the larger it is. Poisson's hypothesis has an answer there: the impact ends where they are at rest, and what its
/// second part would add, the wedge takes. So islands in which no impulses are found have no restitution, if that has
/// an answer; as a problem it always has one.
void ContactImpulses::solve_bounces(RigidContacts& contacts, double h) {
  ConeProblem& problem = contacts.problem();
  const int n = static_cast<int>(contacts.points().size());
  const ConeResult found = find_impulses(problem, r_);
  const double scale = scale_of(problem);
  bool wedged = false;
  if (!found.converged && found.residual > kWedged * scale) {
    problem.velocity(r_, now_);
    islands_.form(problem, [](int) { return true; });
    held_islands_.assign(problem.groups.size(), 0);
    for (int i = 0; i < n; ++i)
      if (problem.violation(problem.contacts[i], r_, now_) > kWedged * scale)
        held_islands_[islands_.of(problem, i)] = 1;
    for (int i = 0; i < n; ++i) {
      const bool bounces = !wedged_[i] && contacts.points()[i].law.restitution > 0;
      if (bounces && held_islands_[islands_.of(problem, i)]) wedged_[i] = wedged = true;
    }
  }
  if (!wedged) return judge(found, scale);
  impulse_ = r_;
  set_aims(contacts, h);
  r_ = guess_;
  const ConeResult held = find_impulses(problem, r_);
  if (held.converged) return;
  wedged_.assign(n, 0);
  set_aims(contacts, h);
  r_ = impulse_;
  judge(found, scale);
}

/// Points are found in the middle of the step: what is beyond a surface by then would be pushed out on its other side,
/// or not be found. Of a step with a body so fast, where its surfaces are as it starts tells whether it is to be
/// shorter.
bool ContactImpulses::would_pass(EquationsOfMotion& equations, const State& start, double h) {
  RigidContacts& contacts = *equations.parts().rigid_contacts;
  equations.evaluate(start.time, start.q, start.v, Level::velocity);
  const double shorter = contacts.step_without_passing(start.v, h);
  if (shorter < h) {
    cut_ = shorter;
    if (uncut_ == 0) uncut_ = h;
    return true;
  }
  dv_ = h / 2 * start.v;
  middle_.resize(start.q.size());
  equations.layout().retract(start.q, dv_, middle_);
  equations.evaluate(start.time + h / 2, middle_, start.v, Level::velocity);
  contacts.find(start.v, h);
  return false;
}

/// What holds bodies up to an impact of theirs within the step pushes no longer than that: the motion up to it is that
/// of bodies held, its impulse and what holds them afterwards are found together. Without this an impact takes place at
/// the start of its step; as it does where many meet at times of their own.
void ContactImpulses::hold(RigidContacts& contacts, double h, VectorX& v_end, VectorX& d) {
  const ConeProblem& problem = contacts.problem();
  const int n = static_cast<int>(contacts.points().size());
  const auto impacts = [&](int i) {
    return closings_[i].time < h && closings_[i].speed > contacts.points()[i].law.rest_speed;
  };
  // 1. Bodies in touch, or about to be, as islands: those with an impact and something that holds.
  holding_.assign(contacts.points().back().pair + 1, 0);  // pairs as a whole: how their points share is not unique
  for (int i = 0; i < n; ++i) {
    const RigidContacts::Point& point = contacts.points()[i];
    const bool touches = gaps_[i] <= parameters_.position_tolerance || closings_[i].time < h;  // else it hops
    if (last_[point.first] > 0 && touches) holding_[point.pair] = 1;
  }
  const auto holds = [&](int i) { return holding_[contacts.points()[i].pair] && !impacts(i); };
  islands_.form(problem, [&](int i) { return impacts(i) || holds(i); });
  const auto island_of = [&](int i) { return islands_.of(problem, i); };
  meeting_.assign(problem.groups.size(), 0);
  for (int i = 0, pair = -1; i < n; ++i)
    if (impacts(i) && std::exchange(pair, contacts.points()[i].pair) != contacts.points()[i].pair)
      ++meeting_[island_of(i)];
  some_.contacts.clear();
  some_points_.clear();
  some_.rows = 0;
  for (int i = 0; i < n; ++i) {
    if (!holds(i)) continue;
    const int pairs = meeting_[island_of(i)];
    if (pairs == 0 || pairs > kFewImpacts) continue;
    ConeProblem::Contact& c = some_.contacts.emplace_back(problem.contacts[i]);
    c.row = some_.rows;
    some_.rows += c.rows;
    some_points_.push_back(i);
  }
  if (some_points_.empty()) return;
  // 2. The step as if nothing else met.
  some_.groups = problem.groups;
  some_.values = problem.values;
  some_.velocities = problem.velocities;
  some_.free.resize(some_.rows), now_.resize(some_.rows);
  for (std::size_t k = 0; k < some_points_.size(); ++k) {
    const ConeProblem::Contact &c = some_.contacts[k], &of = problem.contacts[some_points_[k]];
    some_.free.segment(c.row, c.rows) = u_.segment(of.row, of.rows);
    now_.segment(c.row, c.rows) = last_.segment(of.row, of.rows);
  }
  solve(some_, now_);
  impulse_.setZero(problem.rows);
  for (std::size_t k = 0; k < some_points_.size(); ++k) {
    const ConeProblem::Contact &c = some_.contacts[k], &of = problem.contacts[some_points_[k]];
    impulse_.segment(of.row, of.rows) = now_.segment(c.row, c.rows);
  }
  dv_.setZero();
  contacts.add_response(impulse_, nullptr, dv_);
  moved_.resize(problem.rows);
  contacts.velocity(dv_, moved_);
  // 3. When bodies so held meet, and what has held them until then.
  first_impact_.assign(problem.groups.size(), h);
  for (int i = 0; i < n; ++i) {
    if (holds(i)) continue;
    const RigidContacts::Point& point = contacts.points()[i];
    const double a = closings_[i].acceleration;
    closings_[i] = closing(point, gaps_[i], u_[point.first] - brought_[point.first] + moved_[point.first], h);
    if (!impacts(i)) continue;
    double& first = first_impact_[island_of(i)];
    first = std::min(first, closings_[i].time);
    closings_[i].acceleration = a;
  }
  weights_.setZero();
  for (const int i : some_points_) {
    const double time = first_impact_[island_of(i)];
    const RigidContacts::Point& point = contacts.points()[i];
    impulse_.segment(point.first, point.rows) *= time < h ? time / h : 0;
    if (time < h) held_until_[i] = time, weights_[i] = h - time / 2;
  }
  total_ += impulse_;
  dv_.setZero();
  contacts.add_response(impulse_, nullptr, dv_);
  v_end += dv_;
  dv_.setZero();
  contacts.add_response(impulse_, &weights_, dv_);
  d += dv_;
  for (const int i : some_points_) {
    const RigidContacts::Point& point = contacts.points()[i];
    placed_.segment(point.first, point.rows) += weights_[i] * impulse_.segment(point.first, point.rows);
  }
}

/// The largest impulse that would stop a contact by itself.
double ContactImpulses::scale_of(const ConeProblem& problem) {
  double scale = 0;
  for (const ConeProblem::Contact& c : problem.contacts) {
    const double mobility = diagonal(problem, c);
    if (mobility > 0) scale = std::max(scale, -problem.free[c.row] / mobility);
  }
  return scale;
}

ConeResult ContactImpulses::find_impulses(const ConeProblem& problem, VectorX& r) {
  const ConeResult result = solver_->solve(problem, parameters_.tolerance * scale_of(problem), r);
  iterations_ += result.iterations;
  return result;
}

void ContactImpulses::solve(const ConeProblem& problem, VectorX& r) {
  judge(find_impulses(problem, r), scale_of(problem));
}

void ContactImpulses::judge(const ConeResult& result, double scale) {
  if (result.converged || unconverged_++ > 0) return;
  std::ostringstream message;
  message << "contact impulses by " << solver_->name() << " are left with a residual of " << result.residual
          << " N s, the tolerance is " << parameters_.tolerance * scale
          << " (later steps are not reported)\n  fix:  more sweeps, DirectConeSolver, or a looser tolerance.";
  log::warn(message.str());
}

/// Impacts one after another, each by itself, as gaps close within the step.
void ContactImpulses::collide(RigidContacts& contacts, double h, VectorX& v_end, VectorX& d) {
  const ConeProblem& problem = contacts.problem();
  const int n = static_cast<int>(contacts.points().size());
  VectorX &slope = moved_, &now = now_, &gap = gaps_, &impulse = impulse_;
  slope.resize(problem.rows), now.resize(problem.rows), impulse.resize(problem.rows);
  contacts.velocity(v_end, slope);
  for (int i = 0; i < n; ++i) {
    const RigidContacts::Point& point = contacts.points()[i];
    gap[i] = point.gap - h / 2 * point.before[0];
    now.segment(point.first, point.rows) = slope.segment(point.first, point.rows);  // tangential: as at the end
    now[point.first] = point.before[0];
    slope[point.first] = (slope[point.first] - point.before[0]) / h;
  }
  double time = 0;
  for (int impacts = 0; impacts < kMaxImpacts; ++impacts) {
    // 1. The pair that meets next, faster than it would rest.
    int next = -1;
    double first = 2 * h, speed = 0;
    for (int i = 0; i < n; ++i) {
      const RigidContacts::Point& point = contacts.points()[i];
      const double u = now[point.first], a = slope[point.first];
      const double left = h - time, after = time_to_close(std::max(gap[i], 0.0), u, a, left);
      const double closing = -(u + a * after);
      const bool meets = after < left || gap[i] + left * (u + 0.5 * a * left) <= 0;  // at the step's end too
      if (closing <= point.law.rest_speed || !meets) continue;
      if (time + after < first || (time + after == first && closing > speed))
        next = i, first = time + after, speed = closing;
    }
    if (next < 0) return;
    // 2. All move on to its time.
    const double passed = first - time;
    for (int i = 0; i < n; ++i) {
      const int row = contacts.points()[i].first;
      gap[i] += passed * (now[row] + 0.5 * slope[row] * passed);
      now[row] += passed * slope[row];
    }
    time = first;
    gap[next] = 0;
    // 3. Its impulse alone.
    const RigidContacts::Point& point = contacts.points()[next];
    alone_.contacts.assign(1, problem.contacts[next]);
    alone_.contacts[0].row = 0;
    alone_.groups = problem.groups;
    alone_.values = problem.values;
    alone_.rows = point.rows;
    alone_.velocities = problem.velocities;
    alone_.free = now.segment(point.first, point.rows);
    alone_.free[0] += point.law.restitution * alone_.free[0];  // u_n' >= -e u_n
    r_.setZero(point.rows);
    const double closes = now[point.first], tolerance = 1e-14 * std::abs(alone_.free[0]);
    const ConeResult found = single_->solve(alone_, tolerance, r_);
    if (!found.converged && found.residual * diagonal(alone_, alone_.contacts[0]) > kWedged * std::abs(closes)) {
      alone_.free[0] = closes;  // friction holds it in a wedge (solve_bounces)
      r_.setZero(point.rows);
      position_->solve(alone_, tolerance, r_);  // sticking by rows that depend on each other: too many sweeps
    }
    impulse.setZero();
    impulse.segment(point.first, point.rows) = r_;
    tell_of_impact(contacts, point, time, speed, r_[0]);
    total_ += impulse;
    dv_.setZero();
    contacts.add_response(impulse, nullptr, dv_);
    v_end += dv_;
    d += (h - time) * dv_;
    placed_ += (h - time) * impulse;
    contacts.velocity(dv_, u_);
    now += u_;
  }
}

/// The displacement that the impulses make: what acts across the normals as it is, normal parts so that the gaps come
/// out as aimed at, even where impacts share bodies and each would have a time of its own.
void ContactImpulses::displace(RigidContacts& contacts, VectorX& d) {
  ConeProblem& problem = contacts.problem();
  const int n = static_cast<int>(contacts.points().size());
  // One time for a pair of colliders: its points may push against each other, which is not to move anything.
  impulse_ = r_, times_.resize(n);
  const auto& points = contacts.points();
  for (int i = 0, end; i < n; i = end) {
    double sum = 0, normal = 0;
    for (end = i; end < n && points[end].pair == points[i].pair; ++end) {
      const double r = r_[points[end].first];
      sum += weights_[end] * r, normal += r;
    }
    for (int k = i; k < end; ++k) times_[k] = normal > 0 ? sum / normal : 0;
  }
  for (const RigidContacts::Point& point : points) impulse_[point.first] = 0;
  dv_.setZero();
  contacts.add_response(impulse_, &times_, dv_);
  d += dv_;
  for (int i = 0; i < n; ++i)
    placed_.segment(points[i].first, points[i].rows) += times_[i] * impulse_.segment(points[i].first, points[i].rows);
  contacts.velocity(d, moved_);
  problem.free.setZero();
  double stiffest = 0;
  for (int i = 0; i < n; ++i) {
    ConeProblem::Contact& c = problem.contacts[i];
    problem.free[c.row] = gaps_[i] + moved_[c.row] - least_gaps_[i];
    impulse_.segment(c.row, c.rows).setZero();
    impulse_[c.row] = weights_[i] * r_[c.row];
    c.friction = c.rolling = c.spinning = 0;
    stiffest = std::max(stiffest, diagonal(problem, c));
  }
  if (stiffest > 0) position_->solve(problem, 0.1 * parameters_.position_tolerance / stiffest, impulse_);
  dv_.setZero();
  contacts.add_response(impulse_, nullptr, dv_);
  d += dv_;
  placed_ += impulse_;
}

void ContactImpulses::leave_out_rigid(EquationsOfMotion& equations, const ContactMemory& last) {
  compliant_.clear();
  for (const ContactTrace& trace : last)
    if (std::holds_alternative<CompliantMemory>(trace.memory)) compliant_.push_back(trace);
  equations.memory().recall(compliant_);
}

/// Solvers begin with the impulses of the last step, which the state has.
void ContactImpulses::history(Archive& archive) {
  archive.group("impulses", [&] {
    archive.same("solver", solver_->name());
    archive.same("impacts", static_cast<double>(parameters_.impacts));
    archive.same("tolerance", parameters_.tolerance);
    archive.same("position_tolerance", parameters_.position_tolerance);
    archive("unconverged", unconverged_);
    archive("end", end_);
  });
}

void ContactImpulses::remember(EquationsOfMotion& equations, const VectorX& v, double h, ContactMemory& memory) {
  uncut_ = 0;
  if (acted_)
    equations.parts().rigid_contacts->remember(total_, v, h, friction_.slip_at_start(), friction_.slip_at_end(),
                                               memory);
  else
    memory.clear();
}

}  // namespace lithe
