#include "integrators/contact_impulses.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "engine/checkpoint/archive.h"
#include "engine/contact/gauss_seidel.h"
#include "engine/log.h"

namespace lithe {
namespace {

constexpr int kMaxImpacts = 10000;  // of one step, one after another

/// Time at which a gap closes that starts at g with rate u and acceleration a; h if it does not.
double closing_time(double g, double u, double a, double h) {
  if (g <= 0) return u < 0 || (u == 0 && a < 0) ? 0 : h;
  // g + u t + ½ a t² = 0, the smaller positive root, without cancellation
  const double root = u * u - 2 * a * g;
  if (root < 0) return h;
  const double q = -u + std::sqrt(root);
  if (u < 0 && q > 0) return std::min(h, 2 * g / q);
  return a < 0 ? std::min(h, (u + std::sqrt(root)) / -a) : h;
}

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

/// With constant acceleration a over the step: an impact at τ leaves with e times its speed; what comes to rest, or
/// would come back within the step, stays.
ContactImpulses::Aim ContactImpulses::aim(const RigidContacts::Point& point, double free_velocity, double gap,
                                          double free_gap, double h) const {
  const double before = point.before[0], a = (free_velocity - before) / h;
  if (free_gap > 0) return {free_velocity - 2 * free_gap / h, h / 2};  // others may push it there
  const double time = closing_time(gap, before, a, h), speed = -(before + a * time);
  if (speed > point.law.rest_speed && point.law.restitution > 0) {
    const double after = point.law.restitution * speed, rest = h - time;
    const double away = after * rest + 0.5 * a * rest * rest;
    if (away > 0) return {after + a * rest, rest, away};
  }
  if (speed <= point.law.rest_speed || !(free_velocity < 0)) return {0, h / 2};
  return {0, std::clamp((free_gap - std::min(gap, 0.0)) / free_velocity, 0.0, h)};
}

bool ContactImpulses::apply(EquationsOfMotion& equations, const VectorX& v, double h, const ContactMemory& last,
                            VectorX& v_end, VectorX& d) {
  RigidContacts& contacts = *equations.rigid_contacts();
  contacts.find(v, h);
  acted_ = !contacts.empty();
  iterations_ = 0;
  if (!acted_) return false;
  ConeProblem& problem = contacts.form();
  const int n = static_cast<int>(contacts.points().size());
  u_.resize(problem.rows);
  total_.setZero(problem.rows);
  dv_.resize(v.size());

  // 1. Gaps at both ends of the step without contact; they were found in its middle.
  gaps_.resize(n), free_gaps_.resize(n), weights_.resize(n), least_gaps_.resize(n);
  if (parameters_.impacts == Impacts::sequential) collide(contacts, h, v_end, d);
  contacts.velocity(v_end, u_);
  moved_.resize(problem.rows);
  contacts.velocity(d, moved_);
  for (int i = 0; i < n; ++i) {
    const RigidContacts::Point& point = contacts.points()[i];
    gaps_[i] = point.gap - h / 2 * point.before[0];
    free_gaps_[i] = gaps_[i] + moved_[point.first];
  }

  // 2. The velocity that each point is to have, and impulses that make it.
  problem.free = u_;
  for (int i = 0; i < n; ++i) {
    const RigidContacts::Point& point = contacts.points()[i];
    const Aim aimed =
        parameters_.impacts == Impacts::sequential && free_gaps_[i] <= 0
            ? Aim{0, u_[point.first] < 0 && gaps_[i] >= 0 ? std::clamp(free_gaps_[i] / u_[point.first], 0.0, h / 2)
                                                          : h / 2}
            : aim(point, u_[point.first], gaps_[i], free_gaps_[i], h);
    problem.free[point.first] -= aimed.velocity;
    weights_[i] = aimed.time;
    least_gaps_[i] = aimed.gap;
  }
  r_.resize(problem.rows);
  contacts.recall(last, h, r_);
  double scale = 0;
  for (const ConeProblem::Contact& c : problem.contacts) {
    const double mobility = diagonal(problem, c);
    if (mobility > 0) scale = std::max(scale, std::abs(problem.free[c.row]) / mobility);
  }
  const ConeResult result = solver_->solve(problem, parameters_.tolerance * scale, r_);
  iterations_ = result.iterations;
  if (!result.converged && unconverged_++ == 0) {
    std::ostringstream message;
    message << "contact impulses by " << solver_->name() << " are left with a residual of " << result.residual
            << " N s, the tolerance is " << parameters_.tolerance * scale
            << " (later steps are not told of)\n  mend: more sweeps, DirectConeSolver, or a looser tolerance.";
    log::warn(message.str());
  }
  total_ += r_;
  dv_.setZero();
  contacts.add_response(r_, nullptr, dv_);
  v_end += dv_;
  displace(contacts, d);
  return true;
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
    double first = h, speed = 0;
    for (int i = 0; i < n; ++i) {
      const RigidContacts::Point& point = contacts.points()[i];
      const double u = now[point.first], a = slope[point.first];
      const double after = closing_time(std::max(gap[i], 0.0), u, a, h - time);
      const double closing = -(u + a * after);
      if (closing <= point.law.rest_speed || time + after >= h) continue;
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
    single_->solve(alone_, 1e-14 * std::abs(alone_.free[0]), r_);
    impulse.setZero();
    impulse.segment(point.first, point.rows) = r_;
    total_ += impulse;
    dv_.setZero();
    contacts.add_response(impulse, nullptr, dv_);
    v_end += dv_;
    d += (h - time) * dv_;
    contacts.velocity(dv_, u_);
    now += u_;
  }
}

/// The displacement that the impulses make: what acts across the normals as it is, normal parts so that the gaps come
/// out as aimed at, even where impacts share bodies and each would have a time of its own.
void ContactImpulses::displace(RigidContacts& contacts, VectorX& d) {
  ConeProblem& problem = contacts.problem();
  const int n = static_cast<int>(contacts.points().size());
  impulse_ = r_;
  for (const RigidContacts::Point& point : contacts.points()) impulse_[point.first] = 0;
  dv_.setZero();
  contacts.add_response(impulse_, &weights_, dv_);
  d += dv_;
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
}

/// Solvers begin with the impulses of the last step, which the state has.
void ContactImpulses::history(Archive& archive) {
  archive.group("impulses", [&] {
    archive.same("solver", solver_->name());
    archive.same("impacts", static_cast<double>(parameters_.impacts));
    archive.same("tolerance", parameters_.tolerance);
    archive.same("position_tolerance", parameters_.position_tolerance);
    archive("unconverged", unconverged_);
  });
}

void ContactImpulses::remember(EquationsOfMotion& equations, double h, ContactMemory& memory) const {
  if (acted_)
    equations.rigid_contacts()->remember(total_, h, memory);
  else
    memory.clear();
}

}  // namespace lithe
