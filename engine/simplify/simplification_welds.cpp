#include <algorithm>

#include "engine/model/rigid_frame_body.h"
#include "engine/simplify/simplification_internal.h"

namespace lithe {
namespace {

constexpr double kClosed = 1e-9;  // m and rad: how well a fixed joint is drawn

bool is_weld(const Constraint& constraint) {
  const auto f = constraint.freedom();
  return f && f->rotation == JointFreedom::Rotation::none && !f->x && !f->y && !f->z;
}

}  // namespace

/// Fixed joints between rigid bodies and ground that may go.
bool Simplifier::may_go(const Tie& c) {
  if (!is_weld(*c.constraint) || c.markers.size() != 2) return false;
  for (const Marker& m : c.markers) {
    const int body = body_of(m);
    if (body == kGround ? !options_.hold : !rigid_[body]) return false;
  }
  const std::string stays = "'" + c.constraint->name() + "' stays a joint: ";
  if (const auto user = consumers_.find(c.constraint); user != consumers_.end()) {
    say(stays + "'" + user->second + "' asks for its reaction.");
    return false;
  }
  const MarkerKinematics A = marker_kinematics(drawn_, c.markers[0], Level::position),
                         B = marker_kinematics(drawn_, c.markers[1], Level::position);
  if ((A.p - B.p).norm() < kClosed && (A.R - B.R).norm() < kClosed) return true;
  say(stays + "it does not close as drawn.");
  return false;
}

void Simplifier::find_welds() {
  const int n = static_cast<int>(number_.size());
  Topology welds{n, {}};
  for (const Tie& c : whole_.constraints())
    if ((options_.weld || options_.hold) && may_go(c)) {
      welds.ties.push_back({body_of(c.markers[0]), body_of(c.markers[1])});
      welded_.push_back(&c);
    }
  while (true) {
    group_ = islands(welds);
    held_.assign(n, 0);
    size_.assign(n, 0);
    for (const auto& tie : welds.ties)
      for (int body : tie)
        if (body != kGround && std::count(tie.begin(), tie.end(), kGround)) held_[group_[body]] = 1;
    for (int g : group_) ++size_[g];
    const int refused = find_refused();
    if (refused < 0) return;
    for (std::size_t i = welds.ties.size(); i-- > 0;) {
      const auto& tie = welds.ties[i];
      if (std::none_of(tie.begin(), tie.end(), [&](int b) { return b != kGround && group_[b] == refused; })) continue;
      welds.ties.erase(welds.ties.begin() + static_cast<long>(i));
      welded_.erase(welded_.begin() + static_cast<long>(i));
    }
  }
}

/// A group that cannot be one body; -1: none.
int Simplifier::find_refused() {
  const int n = static_cast<int>(number_.size());
  for (int b = 0; b < n; ++b)
    if (!options_.weld && size_[group_[b]] > 1 && !held_[group_[b]]) return group_[b];
  // Something has to move.
  if (n > 0 && std::all_of(group_.begin(), group_.end(), [&](int g) { return held_[g]; })) return group_[0];
  for (const Tie& c : whole_.constraints()) {
    if (!is_within(c.markers)) continue;
    if (c.constraint->freedom() && !consumers_.contains(c.constraint)) continue;
    for (const Marker& m : c.markers)
      if (const int body = body_of(m); body != kGround) {
        say("bodies welded to '" + entries_[body]->body->name() + "' stay apart: '" + c.constraint->name() +
            "' acts between them.");
        return group_[body];
      }
  }
  return -1;
}

/// Whether all markers are on bodies welded into one, or to ground.
bool Simplifier::is_within(const std::vector<Marker>& markers) const {
  const auto target = [&](const Marker& m) {
    const int body = body_of(m);
    return body == kGround || held_[group_[body]] ? kGround : group_[body];
  };
  const int first = target(markers[0]);
  if (first != kGround && size_[first] == 1) return false;
  return std::all_of(markers.begin(), markers.end(), [&](const Marker& m) { return target(m) == first; });
}

void Simplifier::make_items() {
  const int n = static_cast<int>(number_.size());
  item_.assign(n, kGround);
  std::map<int, int> of_group;
  for (int b = 0; b < n; ++b) {
    if (held_[group_[b]]) continue;
    const auto [at, fresh] = of_group.try_emplace(group_[b], static_cast<int>(items_.size()));
    if (fresh) items_.emplace_back();
    item_[b] = at->second;
    items_[at->second].bodies.push_back(b);
  }
  for (Item& item : items_) {
    item.rigid = rigid_[item.bodies[0]];
    if (item.rigid) compose(item);
  }
  report_welds();
}

/// Mass, centre of mass, inertia of rigid bodies taken together; axes are those of the first.
void Simplifier::compose(Item& item) const {
  const FramePose first = frame(item.bodies[0], initial().q), first_drawn = frame(item.bodies[0], drawn_q_);
  item.inertia = *rigid_inertia_of(*slice(item.bodies[0]).body);
  item.start = first, item.drawn = first_drawn;
  if (item.bodies.size() == 1) return;
  double mass = 0;
  Vector3 center = Vector3::Zero();  // from the first body's, in its axes
  Matrix3 J = Matrix3::Zero();
  const auto place = [&](int b) -> FramePose {
    const FramePose here = frame(b, initial().q);
    return {first.axes.transpose() * (here.position - first.position), first.axes.transpose() * here.axes};
  };
  for (int b : item.bodies) {
    const double m = rigid_inertia_of(*slice(b).body)->mass;
    mass += m;
    center += m * place(b).position;
  }
  center /= mass;
  for (int b : item.bodies) {
    const RigidInertia part = *rigid_inertia_of(*slice(b).body);
    const FramePose at = place(b);
    const Matrix3 arm = skew(at.position - center);
    J += at.axes * part.inertia * at.axes.transpose() - part.mass * arm * arm;
  }
  item.inertia = {mass, J};
  item.start.position += first.axes * center;
  item.drawn.position += first_drawn.axes * center;
}

void Simplifier::report_welds() {
  const auto by = [&](auto&& belongs) {
    std::vector<std::string> names;
    for (const Tie* c : welded_)
      if (belongs(body_of(c->markers[0])) || belongs(body_of(c->markers[1]))) names.push_back(c->constraint->name());
    return quoted(names);
  };
  const auto in_ground = [&](int b) { return b != kGround && item_[b] == kGround; };
  std::vector<std::string> held;
  for (std::size_t b = 0; b < item_.size(); ++b)
    if (in_ground(static_cast<int>(b))) held.push_back(entries_[b]->body->name());
  if (!held.empty()) {
    say(quoted(held) + (held.size() > 1 ? " are" : " is") + " part of the ground: welded by " + by(in_ground) + ".");
    made_.smaller_ = true;
  }
  for (std::size_t i = 0; i < items_.size(); ++i) {
    if (items_[i].bodies.size() < 2) continue;
    std::vector<std::string> others;
    for (std::size_t k = 1; k < items_[i].bodies.size(); ++k)
      others.push_back(entries_[items_[i].bodies[k]]->body->name());
    say(quoted(others) + (others.size() > 1 ? " are" : " is") + " one body with '" +
        entries_[items_[i].bodies[0]]->body->name() + "': welded by " +
        by([&](int b) { return b != kGround && item_[b] == static_cast<int>(i); }) + ".");
    made_.smaller_ = true;
  }
}

}  // namespace lithe
