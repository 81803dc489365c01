#include <typeindex>

#include "engine/model/marker_motions.h"
#include "engine/observe/contact_sensors.h"
#include "engine/study/doctor_internal.h"

namespace lithe::doctor {
namespace {

/// The state moved a little, in every way, and set in motion: what two laws do there differs if they do.
State shaken(const System& system, const State& start, double length) {
  State state = start;
  VectorX d(state.v.size());
  for (int i = 0; i < d.size(); ++i) d[i] = std::sin(1 + 2.4 * i);
  system.layout().retract(start.q, 1e-3 * length * d, state.q);
  state.v += d;
  return state;
}

/// Two force elements of one type between the same points that do the same to their bodies: a copy that was kept.
void look_for_copies(const System& system, const State& start, double length, std::vector<Finding>& out) {
  // 1. Those that could be alike, by type and bodies.
  using Entry = SystemGraph::ForceEntry;
  const auto key = [](const Entry& entry) {
    std::vector<const Body*> bodies;
    for (const Marker& m : entry.markers) bodies.push_back(m.body);
    return std::pair(entry.type, bodies);
  };
  std::map<std::pair<std::type_index, std::vector<const Body*>>, std::vector<const Entry*>> alike;
  for (const Entry& entry : system.graph().forces()) alike[key(entry)].push_back(&entry);
  if (std::ranges::all_of(alike, [](const auto& group) { return group.second.size() < 2; })) return;
  // 2. Those that are, here and where all has moved.
  Snapshot now(system, start), moved(system, shaken(system, start, length));
  const auto at_one_place = [&](const Marker& a, const Marker& b) {
    const MarkerKinematics A = now.marker(a), B = now.marker(b);
    return (A.p - B.p).norm() < 1e-9 * length && (A.R - B.R).norm() < 1e-9;
  };
  const auto do_the_same = [&](const Entry& a, const Entry& b) {
    if (!std::ranges::equal(a.markers, b.markers, at_one_place)) return false;
    const VectorX here = force_values(now, *a.force), there = force_values(moved, *a.force);
    return there.norm() > 0 && (force_values(now, *b.force) - here).norm() <= 1e-12 * here.norm() &&
           (force_values(moved, *b.force) - there).norm() <= 1e-9 * there.norm();
  };
  for (const Entry& a : system.graph().forces())
    for (const Entry* b : alike[key(a)]) {
      if (b->place <= a.place || !do_the_same(a, *b)) continue;
      out.push_back({Cause::drawn_twice, true, 0.8,
                     quoted(a.force->name()) + " and " + quoted(b->force->name()) +
                         " do the same at the same points of " + bodies_of(*a.force) + ": the force acts twice",
                     "leave one of them out; if two are meant, give one twice the stiffness"});
      return;
    }
}

/// Surfaces that overlap far as drawn: their energy throws the bodies apart.
void look_for_overlaps(const System& system, const State& start, double length, std::vector<Finding>& out) {
  if (system.graph().contacts().empty()) return;
  double weight = 0;
  for (const BodyInertia& b : inertias(system, start)) weight += b.mass * system.gravity().norm();
  const double least = 1e-3 * std::max(length, reach_of(system, start));
  Snapshot now(system, start);
  for (const auto& entry : system.graph().contacts()) {
    const ContactElement& contact = *entry.contact;
    if (contact.law() == ContactElement::Law::sensing) continue;
    const double depth = penetration(contact).value(now);
    if (!(depth > least)) continue;
    const bool compliant = contact.law() == ContactElement::Law::compliant;
    const double energy = compliant ? contact_energy(contact).value(now) : 0;
    if (compliant && !(energy > 100 * weight * depth)) continue;  // a soft one carries weight so
    out.push_back({Cause::overlap, true, 0.9,
                   "surfaces of the contact " + quoted(contact.name()) +
                       (contact.markers().size() <= 4 ? " of " + bodies_of(contact) : "") + " overlap by " +
                       number(depth) + " m as drawn" +
                       (compliant ? ": they store " + number(energy) + " J, which throws the bodies apart" : ""),
                   "draw the bodies apart, or touching; look at the sizes of the shapes and where their markers are"});
    return;
  }
}

/// Friction of a pin whose radius is larger than the scene.
void look_at_friction(const System& system, const State& start, std::vector<Finding>& out) {
  Snapshot now(system, start);
  double size = reach_of(system, start);
  for (const BodyInertia& b : inertias(system, start)) size = std::max(size, b.gyration());
  for (const auto& entry : system.graph().forces()) {
    if (!entry.force->reaction_of()) continue;
    const MarkerMotions views(entry.markers, [&](const Marker& m) { return now.marker(m); });
    ForceRows rows(entry.force->marker_count());
    rows.recall(now.quarter_turns_of(*entry.force));
    rows.set_reaction({Vector3::Zero(), Vector3::Zero()});
    entry.force->evaluate(start.time, views, rows);
    for (int r = 0; r < rows.count(); ++r) {
      // A row of sliding speed: where it is a turn alone, its torque is the radius.
      const Wrench& w = rows.wrench(r, 1);
      if (w.force.norm() > 0 || !(w.torque.norm() > 2 * size)) continue;
      out.push_back({Cause::bad_unit, true, 0.9,
                     "the friction " + quoted(entry.force->name()) + " between " + bodies_of(*entry.force) +
                         " acts at a radius of " + number(w.torque.norm()) + " m in a scene of " + number(size) + " m",
                     "give the radius of the bearing in metres (1 mm is 1e-3 m)"});
      return;
    }
  }
}

}  // namespace

void look_at_elements(const System& system, const State& start, double length, std::vector<Finding>& out) {
  try {
    look_for_copies(system, start, length, out);
  } catch (const Error&) {  // NOLINT: a law that refuses the moved state cannot be compared
  }
  look_for_overlaps(system, start, length, out);
  look_at_friction(system, start, out);
}

}  // namespace lithe::doctor
