// What ContactImpulses tells of a step: impacts, meeting and parting, by pair of colliders.
#include <algorithm>
#include <limits>

#include "integrators/contact_impulses.h"

namespace lithe {

/// Several points of a pair at one time are one impact.
void ContactImpulses::tell_of_impact(RigidContacts& contacts, const RigidContacts::Point& point, double time,
                                     double speed, double impulse) {
  const RigidContacts::Pair& pair = contacts.pairs()[point.pair];
  if (!contacts.located(pair.element)) return;
  auto& all = contacts.happenings();
  const auto same = std::find_if(all.begin(), all.end(), [&](const RigidContacts::Happening& other) {
    return other.element == pair.element && other.event.a == pair.a && other.event.b == pair.b && other.time == time;
  });
  if (same == all.end()) {
    all.push_back({time, pair.element, {ContactChange::impact, pair.a, pair.b, speed, impulse}});
    return;
  }
  same->event.speed = std::max(same->event.speed, speed);
  same->event.impulse += impulse;
}

/// An impact is that of the pair's first point to meet, with the impulse of all. What acts without one, and neither
/// touched as the step began nor acted in the last one, meets.
void ContactImpulses::tell_of_meetings(RigidContacts& contacts, double h, const ContactMemory& last) const {
  const auto& points = contacts.points();
  const int n = static_cast<int>(points.size());
  for (int i = 0, end; i < n; i = end) {
    const RigidContacts::Pair& pair = contacts.pairs()[points[i].pair];
    RigidContacts::Happening impact{h, pair.element, {ContactChange::impact, pair.a, pair.b}}, meeting = impact;
    bool acts = false, meets = false;
    double nearest = std::numeric_limits<double>::infinity();
    for (end = i; end < n && points[end].pair == points[i].pair; ++end) {
      nearest = std::min(nearest, gaps_[end]);
      const double r = r_[points[end].first];
      if (!(r > 0)) continue;
      acts = true;
      meeting.time = std::min(meeting.time, closings_[end].time);
      if (!impacts_[end]) continue;
      meets = true;
      impact.time = std::min(impact.time, impacts_[end]->time);
      impact.event.speed = std::max(impact.event.speed, impacts_[end]->speed);
      impact.event.impulse += impacts_[end]->share * r;
    }
    if (!contacts.located(pair.element) || !acts) continue;
    if (meets) {
      contacts.happenings().push_back(impact);
      continue;
    }
    const bool acted = std::any_of(last.begin(), last.end(), [&](const ContactTrace& t) {
      return t.element == pair.element && t.point.A.collider == pair.a && t.point.B.collider == pair.b;
    });
    if (acted || nearest <= parameters_.position_tolerance) continue;
    meeting.event.change = ContactChange::meeting;
    contacts.happenings().push_back(meeting);
  }
}

/// What acted in the last step, did not leave in it and acts no more.
void ContactImpulses::tell_of_partings(RigidContacts& contacts, double h, const ContactMemory& last) const {
  const auto& points = contacts.points();
  for (auto t = last.begin(), end = t; t != last.end(); t = end) {
    const RigidContacts::Pair pair{t->element, t->point.A.collider, t->point.B.collider};
    bool left = false;
    for (; end != last.end() && pair == RigidContacts::Pair{end->element, end->point.A.collider, end->point.B.collider};
         ++end)
      if (const auto* kept = std::get_if<RigidMemory>(&end->memory))
        left |= kept->velocity.dot(end->point.normal) * h > parameters_.position_tolerance;
    if (left || !contacts.located(pair.element)) continue;
    bool acts = false;
    for (const RigidContacts::Point& point : points)
      acts |= contacts.pairs()[point.pair] == pair && total_[point.first] > 0;
    if (!acts) contacts.happenings().push_back({0, pair.element, {ContactChange::parting, pair.a, pair.b}});
  }
}

}  // namespace lithe
