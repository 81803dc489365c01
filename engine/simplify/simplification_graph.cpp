#include <algorithm>

#include "engine/base/log.h"
#include "engine/model/rigid_frame_body.h"
#include "engine/simplify/simplification_internal.h"
#include "engine/simplify/stand_in.h"

namespace lithe {

Simplifier::Simplifier(SystemGraph& whole, const SimplificationOptions& options, Simplification& made)
    : whole_(whole), options_(options), made_(made), system_(made.whole_), start_(system_), drawn_(system_) {
  drawn_q_ = initial().q;
  VectorX v = initial().v;
  for (const auto& s : system_.layout().bodies()) {
    if (s.part > 0) continue;
    const Coordinates c = s.body->coordinates();
    number_.emplace(s.body, static_cast<int>(number_.size()));
    slices_.push_back(static_cast<int>(&s - system_.layout().bodies().data()));
    s.body->initial_state(drawn_q_.segment(s.q, c.q_count()), v.segment(s.v, c.v_count()));
    rigid_.push_back(rigid_inertia_of(*s.body) && c.frames == 1 && c.linear == 0);
  }
  for (const auto& entry : whole.bodies())
    if (entry.body != &whole.ground()) entries_.push_back(&entry);
  start_.evaluate(0, initial().q, initial().v, Level::velocity);
  drawn_.evaluate(0, drawn_q_, v, Level::velocity);
  for (const auto& f : whole.forces())
    if (f.force->reaction_of()) consumers_.emplace(f.force->reaction_of(), f.force->name());
}

void Simplifier::run() {
  find_welds();
  make_items();
  if (options_.planar) find_planes();
  draw_bodies();
  draw_connectors();
  note_slices();
  for (const RedundantRow& r : system_.redundant_rows())
    say(r.name + " is left out: it " + (r.repeats.empty() ? "restrains nothing." : "repeats " + r.repeats + "."));
}

FramePose Simplifier::pose(const Marker& m) {
  const MarkerKinematics k = marker_kinematics(start_, m, Level::position);
  return {k.p, k.R};
}

std::string Simplifier::name(const Item& item) const {
  std::string text;
  for (int b : item.bodies) text += (text.empty() ? "" : " + ") + entries_[b]->body->name();
  return text;
}

void Simplifier::say(const std::string& line) {
  made_.report_.push_back(line);
  log::info("simplified: " + line);
}

std::string quoted(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "'" : i + 1 < names.size() ? ", '" : " and '") + names[i] + "'";
  return text;
}

void Simplifier::draw_bodies() {
  made_.graph_ = SystemGraph::part_of(whole_);
  for (Item& item : items_) {
    const int first = item.bodies[0];
    if (!stands_in(static_cast<int>(&item - items_.data()))) {
      made_.graph_->share(*entries_[first]);
      item.body = entries_[first]->body;
      continue;
    }
    const auto& s = slice(first);
    const Vector3 w = initial().v.segment<3>(s.v + 3), w_world = frame(first, initial().q).axes * w;
    const Vector3 v =
        Vector3(initial().v.segment<3>(s.v)) + w_world.cross(item.start.position - frame(first, initial().q).position);
    if (item.plane < 0) {
      item.body = &made_.graph_->add<RigidStandIn>(
          name(item), {.inertia = item.inertia, .start = {.pose = item.drawn, .velocity = v, .angular_velocity = w}});
      continue;
    }
    const Matrix3& axes = planes_[item.plane];
    const Vector3 n = axes.col(2), normal = item.start.axes.transpose() * n, e1 = axes.col(0);
    const Vector3 turned = item.drawn.axes * (item.start.axes.transpose() * e1);
    item.body = &made_.graph_->add<PlanarStandIn>(
        name(item), {.plane = {.mass = item.inertia.mass,
                               .inertia = normal.dot(item.inertia.inertia * normal),
                               .axes = axes,
                               .height = n * n.dot(item.start.position)},
                     .reference = item.start,
                     .start = {e1.dot(item.drawn.position), axes.col(1).dot(item.drawn.position),
                               std::atan2(turned.dot(axes.col(1)), turned.dot(e1))},
                     .rates = {e1.dot(v), axes.col(1).dot(v), n.dot(w_world)}});
  }
}

/// Where a marker of the whole is in the smaller scene.
Marker Simplifier::moved(const Marker& m) {
  if (body_of(m) == kGround) return m;
  const int i = item_of(m);
  if (i != kGround && !stands_in(i)) return m;
  const auto [at, fresh] = markers_.try_emplace({m.body, m.index});
  if (!fresh) return at->second;
  const FramePose here = pose(m);
  if (i == kGround)
    at->second = whole_.ground().marker(here.position, here.axes);
  else if (auto* planar = items_[i].plane >= 0 ? static_cast<PlanarStandIn*>(items_[i].body) : nullptr)
    at->second = planar->marker(here);
  else {
    const FramePose& frame = items_[i].start;
    at->second =
        static_cast<RigidStandIn*>(items_[i].body)
            ->marker({frame.axes.transpose() * (here.position - frame.position), frame.axes.transpose() * here.axes});
  }
  return at->second;
}

std::vector<Marker> Simplifier::moved(const std::vector<Marker>& markers) {
  std::vector<Marker> all;
  for (const Marker& m : markers) all.push_back(moved(m));
  return all;
}

void Simplifier::draw_connectors() {
  std::vector<std::string> idle;
  for (int i = 0; i < static_cast<int>(whole_.constraints().size()); ++i) draw_constraint(i, idle);
  for (const auto& [joint, first] : only_counts_) {
    const int count = static_cast<int>(joint->constraint->angles().size());
    made_.graph_->add<TurnCount>(joint->constraint->name(), moved(joint->markers), {.of = joint->constraint});
    keep_angles(first, count);
  }
  whole_.for_each_load([&](const auto& force) { draw_force(force); },
                       [&](const auto& contact) { draw_contact(contact); });
  if (!idle.empty()) say(quoted(idle) + (idle.size() > 1 ? " hold" : " holds") + " what is welded already.");
  if (left_out_ > 0) say(std::to_string(left_out_) + " rows that say nothing in these planes are left out.");
}

void Simplifier::draw_constraint(int number, std::vector<std::string>& idle) {
  const Tie& c = whole_.constraints()[number];
  const int angles = static_cast<int>(c.constraint->angles().size()), first_angle = angle_;
  angle_ += angles;
  if (is_within(c.markers)) {
    if (!std::count(welded_.begin(), welded_.end(), &c)) idle.push_back(c.constraint->name());
    return;
  }
  const std::vector<int> rows = rows_that_act(c);
  left_out_ += c.constraint->row_count() - static_cast<int>(rows.size());
  if (rows.empty()) {
    if (angles > 0) only_counts_.emplace_back(&c, first_angle);
    return;
  }
  keep_angles(first_angle, angles);
  for (int r : rows) made_.rows_.push_back(system_.layout().rows()[number].first + r);
  if (static_cast<int>(rows.size()) == c.constraint->row_count())
    made_.graph_->share(c, moved(c.markers));
  else
    made_.graph_->add<RowsInPlane>(c.constraint->name(), moved(c.markers), {.whole = c.constraint, .rows = rows});
}

void Simplifier::draw_force(const SystemGraph::ForceEntry& f) {
  const int angles = static_cast<int>(f.force->angles().size()), first_angle = angle_;
  angle_ += angles;
  if (is_on_ground(f.markers)) return;
  keep_angles(first_angle, angles);
  const std::vector<Marker> markers = moved(f.markers);
  std::vector<CoordinateSwitch> switches = f.force->switches();
  if (switches.empty() || markers == f.markers) return made_.graph_->share(f, markers);
  for (CoordinateSwitch& s : switches) s.coordinate.A = moved(s.coordinate.A), s.coordinate.B = moved(s.coordinate.B);
  made_.graph_->add<MovedForce>(f.force->name(), markers, {.whole = f.force, .switches = switches});
}

void Simplifier::draw_contact(const SystemGraph::ContactEntry& contact) {
  if (!is_on_ground(contact.markers)) made_.graph_->share(contact, moved(contact.markers));
}

/// What acts on ground alone moves nothing.
bool Simplifier::is_on_ground(const std::vector<Marker>& markers) const {
  return std::all_of(markers.begin(), markers.end(), [&](const Marker& m) { return item_of(m) == kGround; });
}

/// Of the connector drawn next.
void Simplifier::keep_angles(int first, int count) {
  if (count > 0) made_.angles_.push_back({first, made_.angle_count_, count});
  made_.angle_count_ += count;
}

// ---- what expand() and reduce() follow ----

void Simplifier::note_slices() {
  made_.still_ = initial().q;
  for (const Item& item : items_) {
    const Coordinates c = item.body->coordinates();
    if (!stands_in(static_cast<int>(&item - items_.data()))) {
      const auto& s = slice(item.bodies[0]);
      made_.q_.push_back({s.q, made_.q_count_, c.q_count()});
      made_.v_.push_back({s.v, made_.v_count_, c.v_count()});
    } else {
      const Vector4 e = initial().q.segment<4>(slice(item.bodies[0]).q + 3);
      const auto* planar = item.plane >= 0 ? static_cast<const PlanarStandIn*>(item.body) : nullptr;
      made_.moved_.push_back({made_.q_count_, made_.v_count_, planar, e, {}});
      for (int b : item.bodies) {
        const Vector4 turned =
            quaternion_product(Vector4(e[0], -e[1], -e[2], -e[3]), initial().q.segment<4>(slice(b).q + 3));
        const Vector3 at = item.start.axes.transpose() * (frame(b, initial().q).position - item.start.position);
        made_.moved_.back().pieces.push_back({slice(b).q, slice(b).v, at, turned});
      }
    }
    made_.q_count_ += c.q_count();
    made_.v_count_ += c.v_count();
  }
}

}  // namespace lithe
