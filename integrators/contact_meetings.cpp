// How ContactImpulses has impacts that several pairs of bodies take part in.
#include <algorithm>
#include <cmath>
#include <utility>

#include "integrators/contact_impulses.h"

namespace lithe {
namespace {

constexpr double kEnd = 1e-6;     // of a step: impacts nearer to its ends are at them
constexpr double kCounts = 3e-4;  // speed of an impact, of that before it: 1e-7 of its energy
constexpr double kSliver = 1e-5;  // of a step: what is left of it after an impact at its end
constexpr double kMajor = 0.1;    // speed of impacts that a step ends at, of the fastest
constexpr double kFlight = 0.02;  // of a step: shorter ones between impacts are too many to be told apart

}  // namespace

double ContactImpulses::time_to_close(double g, double u, double a, double h) {
  if (g <= 0) {
    if (u < 0 || (u == 0 && a < 0)) return 0;
    return a < 0 ? std::min(h, -2 * u / a) : h;  // up and back
  }
  // g + u t + ½ a t² = 0, the smaller positive root, without cancellation
  const double root = u * u - 2 * a * g;
  if (root < 0) return h;
  const double q = -u + std::sqrt(root);
  if (u < 0 && q > 0) return std::min(h, 2 * g / q);
  return a < 0 ? std::min(h, (u + std::sqrt(root)) / -a) : h;
}

/// When a step is to end for the impact of an island: h where it is not.
///
/// An impact within a step acts from its time on, but what its bodies do besides in that step is known as a mean over
/// it alone: what a body rebounds from seems to fall freely where something holds it, or hops, or is met by a third
/// afterwards. An elastic ball that hits one at rest on the floor would gain m v g h. In a step that ends with it an
/// impact is exact: velocities are those at its time, and nothing follows. Such a step has two parts where bodies are
/// pushed before the impact: its time is known only as well as their motion without contact tells, so that the first
/// part ends safely before it.
double ContactImpulses::end_before(RigidContacts& contacts, int island, double h) {
  const ConeProblem& problem = contacts.problem();
  const auto& points = contacts.points();
  const int n = static_cast<int>(points.size());
  const double sliver = kSliver * (uncut_ > 0 ? uncut_ : h);
  for (int g = 0; g < static_cast<int>(problem.groups.size()); ++g)
    if (islands_.of_group(g) == island && contacts.deforms(g)) return h;  // what it does in a step is not so simple
  // 1. The first impact that counts, in time for a flight of some length.
  double time = h, speed = 0, acceleration = 0;
  bool rebounds = false;
  const auto pushes = [&](int i) { return r_[points[i].first] > 0 && islands_.of(problem, i) == island; };
  for (int i = 0; i < n; ++i) {
    if (!pushes(i)) continue;
    acceleration = std::max(acceleration, std::abs(closings_[i].acceleration));
    rebounds = rebounds || points[i].law.restitution > 0;
    if (impacts_[i] && impacts_[i]->speed >= kMajor * fastest_[island].speed && impacts_[i]->time < time)
      time = impacts_[i]->time, speed = impacts_[i]->speed;
  }
  if (!rebounds || h - time <= sliver || 2 * speed < kFlight * acceleration * h) return h;
  // 2. How much earlier or later it may be, by what is pushed before it.
  double unsure = 0;
  for (int i = 0; i < n; ++i) {
    if (!pushes(i) || held_until_[i] >= 0 || closings_[i].time >= time) continue;
    const double before = points[i].before[0] - growth_[points[i].first];
    unsure = std::max(unsure, -(gaps_[i] + time * (before + 0.5 * closings_[i].acceleration * time)) / speed);
  }
  return unsure > sliver && time - 2 * unsure > sliver ? time - 2 * unsure : time + sliver / 2;
}

/// Of all islands with an impact: sets cut().
void ContactImpulses::end_before_impacts(RigidContacts& contacts, double h) {
  const ConeProblem& problem = contacts.problem();
  const auto& points = contacts.points();
  const int n = static_cast<int>(points.size()), groups = static_cast<int>(problem.groups.size());
  // 1. Bodies that are thrown against what did not touch.
  now_.resize(problem.rows);
  problem.velocity(r_, now_, of_groups_);
  goes_on_.assign(groups, 0);
  for (int i = 0; i < n; ++i) {
    if (r_[points[i].first] > 0) continue;
    const double change = now_[points[i].first] - problem.free[points[i].first];
    for (const ConeProblem::Side& side : problem.contacts[i].sides) {
      if (side.group < 0) continue;
      const int island = islands_.of_group(side.group);
      if (free_gaps_[i] + (h - fastest_[island].time) * change < 0) goes_on_[island] = 1;
    }
  }
  const auto alone = [&](int island) {  // one body, or what joints make one, that meets ground and nothing else
    int bodies = 0;
    for (int g = 0; g < groups; ++g) bodies += islands_.of_group(g) == island;
    return bodies == 1 && meeting_[island] == 1 && !goes_on_[island];
  };
  // 2. The first of their times.
  for (int g = 0; g < groups; ++g) {
    if (islands_.of_group(g) != g || !(fastest_[g].speed > 0) || meeting_[g] > kFewImpacts || alone(g)) continue;
    const double end = end_before(contacts, g, h);
    if (end < h) cut_ = cut_ > 0 ? std::min(cut_, end) : end;
  }
}

/// Impacts of several pairs that push each other are one impact, at the time of the fastest: Newton's restitution of
/// the velocities then keeps the energy of elastic bodies, of velocities each at a time of its own it would not. A gap
/// that such an impact closes takes part: were its surfaces only kept from passing each other, the speed with which
/// they meet would be lost.
bool ContactImpulses::join_impacts(RigidContacts& contacts, double h) {
  ConeProblem& problem = contacts.problem();
  const auto& points = contacts.points();
  const int n = static_cast<int>(points.size());
  const auto pushes = [&](int i) { return r_[points[i].first] > 0; };
  const auto joins = [&](int i) {
    return pushes(i) && points[i].law.restitution > 0 && held_until_[i] < 0 && (impacts_[i] || free_gaps_[i] > 0);
  };
  // 1. Bodies that push each other, by how many pairs, and the fastest impact among them.
  islands_.form(problem, pushes);
  const auto island_of = [&](int i) { return islands_.of(problem, i); };
  meeting_.assign(problem.groups.size(), 0);
  fastest_.assign(problem.groups.size(), Impact{});
  for (int i = 0, pair = -1; i < n; ++i) {
    if (!pushes(i)) continue;
    if (std::exchange(pair, points[i].pair) != points[i].pair) ++meeting_[island_of(i)];
    Impact& fastest = fastest_[island_of(i)];
    if (impacts_[i] && impacts_[i]->speed > fastest.speed) fastest = *impacts_[i];
  }
  // 2. Of few rigid bodies, a step up to it.
  const int groups = static_cast<int>(problem.groups.size());
  const auto meets = [&](int g) { return islands_.of_group(g) == g && fastest_[g].speed > 0; };
  int impacts = 0;
  for (int g = 0; g < groups; ++g) impacts += meets(g);
  if (impacts == 0) return false;
  if (impacts <= kFewImpacts) end_before_impacts(contacts, h);
  if (cut_ > 0) return false;
  // 3. Their aims, from their motion at its time.
  bool any = false;
  for (int i = 0; i < n; ++i) {
    if (!joins(i) || meeting_[island_of(i)] < 2 || !(fastest_[island_of(i)].speed > 0)) continue;
    const RigidContacts::Point& point = points[i];
    const double time = fastest_[island_of(i)].time, rest = h - time, a = closings_[i].acceleration;
    const double before = point.before[0] - growth_[point.first];
    const double after = -point.law.restitution * (before + a * time);
    const double met = gaps_[i] + time * (before + 0.5 * a * time), gap = met + rest * (after + 0.5 * a * rest);
    if (gap < 0 && met >= 0 && meeting_[island_of(i)] <= kFewImpacts) {
      // It closes again, by an impact of its own: the step is to end there.
      const double again = time_to_close(met, after, a, rest), back = -(after + a * again);
      const double least = std::max(point.law.rest_speed, kCounts * fastest_[island_of(i)].speed);
      if (back > least && time + again > kEnd * h && time + again < (1 - kEnd) * h)
        cut_ = cut_ > 0 ? std::min(cut_, time + again) : time + again;
    }
    problem.free[point.first] = u_[point.first] - (after + a * rest);
    weights_[i] = rest;
    least_gaps_[i] = std::max(0.0, gap);
    if (!impacts_[i]) closings_[i].time = time;
    any = true;
  }
  return any;
}

}  // namespace lithe
