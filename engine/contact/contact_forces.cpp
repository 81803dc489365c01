#include "engine/contact/contact_forces.h"

#include <algorithm>
#include <tuple>

namespace lithe {
namespace {

constexpr double kTouching = 1e-9;  // m: surfaces that near an accepted state have met
constexpr double kInside = 1e-12;   // m: before they are that deep in each other the speed of it is not settled

bool before(const ContactTrace& a, const ContactTrace& b) {
  return contact_key(a.element, a.point) < contact_key(b.element, b.point);
}

/// Six numbers of a load.
Vector6 flat(const ContactLoad& load) {
  Vector6 f;
  f << load.force, to_moment_rows(load.moment);
  return f;
}

}  // namespace

ContactForces::ContactForces(const std::vector<ContactRecord>& records, const Layout& layout,
                             const std::vector<MarkerKinematics>& markers, const VectorX& velocity,
                             std::vector<BodyState> bodies)
    : records_(records), bodies_(std::move(bodies)), velocity_(velocity) {
  std::size_t most = 0;
  for (const ContactRecord& record : records) {
    places_.emplace_back(record, layout, markers, bodies_);
    detectors_.push_back(record.element->make_detector());
    most = std::max(most, record.markers.size());
    const auto law = record.element->law();
    any_rigid_ |= law == ContactElement::Law::rigid;
    any_compliant_ |= law == ContactElement::Law::compliant;
    remembers_ |= law == ContactElement::Law::compliant && record.element->remembers();
  }
  no_reach_.assign(most, 0.0);
}

void ContactForces::evaluate(VectorX& load, VectorX& energies) {
  rows_.clear();
  acting_.clear();
  for (const ContactRecord& record : records_) {
    const ContactElement& element = *record.element;
    energies[record.energy] = 0;
    if (element.law() == ContactElement::Law::sensing) continue;
    const ContactPlaces& places = places_[record.number];
    if (element.law() == ContactElement::Law::rigid) {
      for (const ContactTrace& trace : memory_) {
        if (trace.element != record.number) continue;
        rows_.add(places, trace.point, 6);
        const ContactRows::Row& row = rows_.points().back();
        acting_.push_back({});
        acting_.back().load.force = row.frame.transpose() * trace.force;
        acting_.back().load.moment = row.frame.transpose() * trace.moment;
        rows_.add_force(row, flat(acting_.back().load).data(), load.data());
      }
      continue;
    }
    points_.clear();
    detectors_[record.number]->find(places, {no_reach_.data(), record.markers.size()}, points_);
    for (const ContactPoint& point : points_) {
      if (record.bodies[point.A.collider] == record.bodies[point.B.collider]) continue;  // welded together
      rows_.add(places, point, element.has_moments() ? 6 : 3);
      const ContactRows::Row& row = rows_.points().back();
      Acting& acting = acting_.emplace_back();
      acting.motion = motion_of(rows_, row);
      acting.load = element.load(acting.motion);
      rows_.add_force(row, flat(acting.load).data(), load.data());
      energies[record.energy] += acting.load.energy;
    }
  }
}

const ContactTrace* ContactForces::find_trace(int element, const ContactPoint& point) const {
  const auto wanted = contact_key(element, point);
  const auto at = std::lower_bound(memory_.begin(), memory_.end(), wanted, [](const ContactTrace& t, const auto& k) {
    return contact_key(t.element, t.point) < k;
  });
  return at != memory_.end() && contact_key(at->element, at->point) == wanted ? &*at : nullptr;
}

/// Surfaces that have met keep the speed of that while they touch, at whatever points.
double ContactForces::speed_of_meeting(int element, const ContactPoint& point, double now) const {
  const auto first =
      std::lower_bound(memory_.begin(), memory_.end(), std::tuple(element, point.A.collider, point.B.collider),
                       [](const ContactTrace& t, const auto& k) {
                         return std::tuple(t.element, t.point.A.collider, t.point.B.collider) < k;
                       });
  if (first == memory_.end() || first->element != element || first->point.A.collider != point.A.collider ||
      first->point.B.collider != point.B.collider)
    return now;
  return std::get<CompliantMemory>(first->memory).impact_speed;
}

bool ContactForces::was_inside(int element, const ContactPoint& point) const {
  return std::ranges::any_of(memory_, [&](const ContactTrace& t) {
    return t.element == element && t.point.A.collider == point.A.collider && t.point.B.collider == point.B.collider &&
           t.point.gap < -kInside;
  });
}

Vector3 ContactForces::place_of(int element, const ContactSide& side, const Vector3& on) const {
  const ContactPlaces& places = places_[element];
  const MarkerKinematics& base = places.collider(side.collider);
  if (side.node_count == 0) return base.p + base.R * on;
  Vector3 p = base.R * on;  // turns with the collider, moves with the nodes
  for (int i = 0; i < side.node_count; ++i) {
    MarkerKinematics node;
    places.node(side.collider, side.nodes[i], node);
    p += side.weights[i] * node.p;
  }
  return p;
}

Vector3 ContactForces::on_side(int element, const ContactSide& side, const Vector3& p) const {
  const Vector3 origin = place_of(element, side, Vector3::Zero());
  return places_[element].collider(side.collider).R.transpose() * (p - origin);
}

ContactMotion ContactForces::motion_of(const ContactRows& rows, const ContactRows::Row& row) const {
  ContactMotion motion;
  double u[6] = {};
  rows.velocity(row, velocity_.data(), u);
  motion.gap = row.point.gap;
  motion.curvature = row.point.curvature;
  motion.velocity = {u[0], u[1], u[2]};
  motion.spin = from_moment_rows({u[3], u[4], u[5]});
  motion.slip.setZero();
  motion.bristle.setZero();
  if (!records_[row.element].element->remembers()) return motion;
  motion.impact_speed = speed_of_meeting(row.element, row.point, 0);
  if (const ContactTrace* trace = find_trace(row.element, row.point)) {
    const auto& kept = std::get<CompliantMemory>(trace->memory);
    const Vector3 slip =
        place_of(row.element, trace->point.B, kept.on_B) - place_of(row.element, trace->point.A, kept.on_A);
    motion.slip = row.frame.transpose() * slip;
    motion.bristle = row.frame.transpose() * kept.bristle;
    motion.slip[0] = motion.bristle[0] = 0;
  }
  return motion;
}

void ContactForces::track(ContactMemory& memory) {
  // 1. Rigid contacts' traces stay; compliant ones are made anew.
  ContactMemory& now = next_;
  now.clear();
  for (const ContactTrace& trace : memory)
    if (records_[trace.element].element->law() == ContactElement::Law::rigid) now.push_back(trace);
  for (const ContactRecord& record : records_) {
    const ContactElement& element = *record.element;
    if (element.law() != ContactElement::Law::compliant || !element.remembers()) continue;
    points_.clear();
    std::fill(no_reach_.begin(), no_reach_.end(), kTouching / 2);
    detectors_[record.number]->find(places_[record.number], {no_reach_.data(), record.markers.size()}, points_);
    std::fill(no_reach_.begin(), no_reach_.end(), 0.0);
    ContactRows& rows = tracked_;
    rows.clear();
    for (const ContactPoint& point : points_) {
      rows.add(places_[record.number], point, element.has_moments() ? 6 : 3);
      const ContactRows::Row& row = rows.points().back();
      double u[6] = {};
      rows.velocity(row, velocity_.data(), u);
      // Surfaces that part here meet anew, though the next state may be the one in which they do.
      if (point.gap > -kInside && u[0] > 0 && was_inside(record.number, point)) continue;
      ContactTrace trace;
      trace.element = record.number;
      trace.point = row.point;
      auto& kept = trace.memory.emplace<CompliantMemory>();
      const double closing = std::max(0.0, -u[0]);
      kept.impact_speed = speed_of_meeting(record.number, point, closing);
      if (point.gap > -kInside && !was_inside(record.number, point))
        kept.impact_speed = std::max(kept.impact_speed, closing);
      const ContactLoad load = element.load(motion_of(rows, row));
      trace.force = row.frame * load.force;
      trace.moment = row.frame * load.moment;
      kept.bristle = row.frame * load.bristle;
      kept.on_A = on_side(record.number, point.A, row.point.position);
      kept.on_B = on_side(record.number, point.B, row.point.position);
      now.push_back(trace);
    }
  }
  // 2. Sorted, to be found again.
  std::sort(now.begin(), now.end(), before);
  memory.swap(now);
}

ContactMemory ContactForces::report() const {
  ContactMemory all;
  for (std::size_t i = 0; i < acting_.size(); ++i) {
    const ContactRows::Row& row = rows_.points()[i];
    ContactTrace& trace = all.emplace_back();
    trace.element = row.element;
    trace.point = row.point;
    trace.force = row.frame * acting_[i].load.force;
    trace.moment = row.frame * acting_[i].load.moment;
    if (records_[row.element].element->law() == ContactElement::Law::rigid) trace.memory = RigidMemory{};
  }
  return all;
}

double ContactForces::power(int element) const {
  double sum = 0;
  for (std::size_t i = 0; i < acting_.size(); ++i) {
    const ContactRows::Row& row = rows_.points()[i];
    if (row.element != element) continue;
    double u[6] = {};
    rows_.velocity(row, velocity_.data(), u);
    sum += flat(acting_[i].load).dot(Eigen::Map<const Vector6>(u));
  }
  return sum;
}

void ContactForces::form(const TangentWeights& weights, const VectorX* increment) {
  by_position_.clear(), by_velocity_.clear();
  // 1. Derivatives of the laws.
  for (std::size_t i = 0; i < acting_.size(); ++i) {
    const ContactRows::Row& row = rows_.points()[i];
    const ContactElement& element = *records_[row.element].element;
    const int n = row.rows;
    for (auto* blocks : {&by_position_, &by_velocity_}) blocks->resize(blocks->size() + n * n, 0.0);
    if (element.law() == ContactElement::Law::rigid) continue;  // its load is given
    double* by_x = by_position_.data() + by_position_.size() - n * n;
    double* by_u = by_velocity_.data() + by_velocity_.size() - n * n;
    const auto difference = [&](double step, auto&& displace, double* column) {
      ContactMotion plus = acting_[i].motion, minus = plus;
      displace(plus, step), displace(minus, -step);
      const Vector6 change = flat(element.load(plus)) - flat(element.load(minus));
      for (int k = 0; k < n; ++k) column[k] = change[k] / (2 * step);
    };
    const double depth = std::max(-acting_[i].motion.gap, 1e-12);
    if (weights.position != 0)
      for (int axis = 0; axis < 3; ++axis)
        difference(
            1e-4 * depth, [axis](ContactMotion& m, double d) { (axis == 0 ? m.gap : m.slip[axis]) += d; },
            by_x + n * axis);
    if (weights.velocity != 0)
      for (int axis = 0; axis < n; ++axis)
        difference(
            1e-7, [axis](ContactMotion& m, double d) { (axis < 3 ? m.velocity[axis] : m.spin[(axis - 2) % 3]) += d; },
            by_u + n * axis);
  }
  // 2. H', where corrections are those of the chart of the increment: d' = Jr⁻¹ ω.
  right_.clear();
  for (const ContactRows::Row& row : rows_.points())
    for (const ContactRows::Side& side : row.sides)
      right_.insert(right_.end(), rows_.values(side), rows_.values(side) + row.rows * side.count);
  if (!increment) return;
  for (const ContactRows::Row& row : rows_.points())
    for (const ContactRows::Side& side : row.sides) {
      for (int f = 0; f < side.frames; ++f) {
        Eigen::Map<MatrixX> columns(right_.data() + side.H + (6 * f + 3) * row.rows, row.rows, 3);
        columns = (columns * right_jacobian_inverse(increment->segment<3>(side.velocity + 6 * f + 3))).eval();
      }
    }
}

}  // namespace lithe
