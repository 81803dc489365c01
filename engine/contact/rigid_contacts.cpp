#include "engine/contact/rigid_contacts.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "engine/factor/graph_topology.h"
#include "engine/motion/equations_of_motion.h"

namespace lithe {
namespace {

constexpr double kNear = 1e-6;  // m: looked at whatever the speed

}  // namespace

RigidContacts::RigidContacts(Scene scene) : scene_(std::move(scene)) {
  for (const ContactRecord& record : scene_.records) {
    reach_.emplace_back(record.markers.size(), 0.0);
    auto& half = half_thickness_.emplace_back();
    for (std::size_t i = 0; i < record.markers.size(); ++i)
      half.push_back(scene_.contacts.half_thickness(record.number, static_cast<int>(i)));
    located_.push_back(record.element->law() == ContactElement::Law::rigid && !record.element->located_pairs().empty());
  }
  group_bodies();
  for (const ContactRecord& record : scene_.records) {
    auto& frames = frames_.emplace_back();
    for (std::size_t i = 0; i < record.markers.size(); ++i) frames.push_back(frames_under(record, static_cast<int>(i)));
  }
}

/// How many frames carry a collider: all of its body's, if by its size as drawn it reaches another than its marker's.
int RigidContacts::frames_under(const ContactRecord& record, int collider) const {
  if (record.bodies[collider] < 0) return 0;
  const ContactPlaces& places = scene_.contacts.places()[record.number];
  const Coordinates c = record.markers[collider].body->coordinates();
  const int frames = c.frames, own = places.slice(collider)->part;
  if (frames <= 1) return 0;
  VectorX q(c.q_count()), v(c.v_count());
  record.markers[collider].body->initial_state(q, v);
  const double extent = scene_.contacts.extent(record.number, collider);
  for (int f = 0; f < frames; ++f)
    if (f != own && (q.segment<3>(7 * f) - q.segment<3>(7 * own)).norm() <= extent) return frames;
  return 0;
}

void RigidContacts::group_bodies() {
  const BlockStructure& blocks = scene_.blocks;
  for (const BlockStructure::Linear& linear : blocks.linears) {
    std::vector<int>& diagonal = diagonals_.emplace_back();
    if (!linear.pattern) continue;
    diagonal.resize(static_cast<std::size_t>(linear.size));
    for (int entry = 0; entry < static_cast<int>(linear.pattern->rows.size()); ++entry)
      if (const int row = linear.pattern->rows[entry]; row == linear.pattern->columns[entry])
        diagonal[static_cast<std::size_t>(row)] = linear.values + entry;
  }
  const auto& bodies = scene_.equations.layout().bodies();
  const int n = static_cast<int>(bodies.size());
  std::vector<int> body_of(scene_.equations.layout().v_count());
  for (int b = 0; b < n; ++b)
    for (int i = 0; i < (bodies[b].frame ? 6 : 0) + bodies[b].linear; ++i) body_of[bodies[b].v + i] = b;
  // 1. Who shares rows or couplings.
  Topology topology{n, std::vector<std::vector<int>>(blocks.rows.size())};
  std::vector<char> tied(n, 0);
  for (const auto& G : blocks.jacobians) {
    const int b = body_of[G.velocity];
    tied[b] = 1;
    auto& tie = topology.ties[G.rows];
    if (std::find(tie.begin(), tie.end(), b) == tie.end()) tie.push_back(b);
  }
  const auto tie = [&](int a, int b) {
    if (a != b) topology.ties.push_back({a, b});
  };
  for (const auto& c : blocks.row_couplings)
    if (!topology.ties[c.rows].empty() && !topology.ties[c.on].empty())
      tie(topology.ties[c.rows].front(), topology.ties[c.on].front());
  for (const auto& c : blocks.couplings) {
    const int a = body_of[blocks.frames[c.a].v], b = body_of[blocks.frames[c.b].v];
    tied[a] = tied[b] = 1;
    tie(a, b);
  }
  for (int b = 0; b + 1 < n; ++b)  // frames of one body
    if (bodies[b].body == bodies[b + 1].body) tied[b] = tied[b + 1] = 1, tie(b, b + 1);
  for (const int b : scene_.loaded) tied[b] = 1;  // its load has a tangent
  // 2. Components, by their first body.
  const std::vector<int> island = islands(topology);
  std::vector<int> component(n, -1);
  component_.assign(n, -1);
  place_.assign(scene_.equations.layout().v_count(), 0);
  for (int b = 0; b < n; ++b) {
    int& c = component[island[b]];
    if (c < 0) c = static_cast<int>(components_.size()), components_.emplace_back();
    component_[b] = c;
    Component& of = components_[c];
    of.bodies.push_back(b);
    of.deforms = of.deforms || (bodies[b].frame ? 6 : 0) + bodies[b].linear > 6 ||
                 (b > 0 && bodies[b].body == bodies[b - 1].body);  // a frame each
    for (int i = 0; i < (bodies[b].frame ? 6 : 0) + bodies[b].linear; ++i) {
      place_[bodies[b].v + i] = static_cast<int>(of.velocities.size());
      of.velocities.push_back(bodies[b].v + i);
    }
  }
  for (Component& c : components_) {
    const auto& body = bodies[c.bodies.front()];
    const auto* inertia = rigid_inertia_of(*body.body);
    c.alone = c.bodies.size() == 1 && !tied[c.bodies.front()] && body.frame && body.linear == 0 && inertia;
    if (!c.alone) continue;
    const auto frame =
        std::find_if(blocks.frames.begin(), blocks.frames.end(), [&](const auto& f) { return f.v == body.v; });
    c.values = frame->values;
    c.inertia.mass = 1 / inertia->mass;
  }
}

const std::vector<int>& RigidContacts::tied_velocities(const Marker& marker) const {
  static const std::vector<int> none;
  const Layout& layout = scene_.equations.layout();
  if (marker.body->coordinates().v_count() == 0) return none;
  return components_[component_[&layout.slice(*marker.body) - layout.bodies().data()]].velocities;
}

/// How far the surfaces of a contact can move within the horizon.
void RigidContacts::find_reach(const ContactRecord& record, ConstVectorRef v, double horizon) {
  const ContactPlaces& places = scene_.contacts.places()[record.number];
  auto& reach = reach_[record.number];
  for (std::size_t i = 0; i < reach.size(); ++i) {
    reach[i] = kNear;
    if (record.bodies[i] < 0) continue;
    const MarkerKinematics& k = places.collider(static_cast<int>(i));
    const double extent = scene_.contacts.extent(record.number, static_cast<int>(i));
    double speed = k.v.norm() + k.w.norm() * extent;
    for (int f = 0; f < frames_[record.number][i]; ++f) {
      const auto twist = v.segment<6>(frame_slice(places, static_cast<int>(i), f).v);
      speed = std::max(speed, twist.head<3>().norm() + twist.tail<3>().norm() * extent);
    }
    reach[i] += horizon * speed + horizon * horizon * scene_.gravity;
  }
}

double RigidContacts::step_without_passing(ConstVectorRef v, double step) {
  constexpr double kDepth = 0.5;   // in the middle of the step, of the depth that is still pushed out
  constexpr double kLeast = 1e-3;  // of the step: a body that grazes a thin edge is not to stop the run
  double shortest = step;
  for (const ContactRecord& record : scene_.records) {
    if (record.element->law() != ContactElement::Law::rigid) continue;
    find_reach(record, v, step);
    found_.clear();
    scene_.contacts.find(record.number, reach_[record.number], found_);
    const auto& half = half_thickness_[record.number];
    rows_.clear();
    for (const ContactPoint& point : found_) {
      const double deepest = half[point.A.collider] + half[point.B.collider];
      if (!(point.gap > -kDepth * deepest) || record.bodies[point.A.collider] == record.bodies[point.B.collider])
        continue;
      rows_.add(scene_.contacts.places()[record.number], point, 3);
      double u[6] = {};
      rows_.velocity(rows_.points().back(), v.data(), u);
      const double closing = -u[0];
      if (!(step / 2 * closing - point.gap > deepest)) continue;
      shortest = std::min(shortest, 2 * (point.gap + kDepth * deepest) / closing);
    }
  }
  return std::max(shortest, kLeast * step);
}

void RigidContacts::find(ConstVectorRef v, double horizon) {
  rows_.clear();
  points_.clear();
  pairs_.clear();
  happenings_.clear();
  fast_ = false;
  ContactForces& contacts = scene_.contacts;
  for (const ContactRecord& record : scene_.records) {
    if (record.element->law() != ContactElement::Law::rigid) continue;
    const ContactPlaces& places = contacts.places()[record.number];
    find_reach(record, v, horizon);
    const auto& reach = reach_[record.number];
    double beyond[2] = {-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};  // largest
    for (std::size_t i = 0; i < reach.size(); ++i) {
      const double by = (reach[i] - kNear) / 2 - half_thickness_[record.number][i];
      if (by > beyond[0])
        beyond[1] = beyond[0], beyond[0] = by;
      else
        beyond[1] = std::max(beyond[1], by);
    }
    fast_ |= beyond[0] + beyond[1] > 0;
    found_.clear();
    contacts.find(record.number, reach, found_);
    const RigidContact law = record.element->rigid();
    for (const ContactPoint& point : found_) {
      if (record.bodies[point.A.collider] == record.bodies[point.B.collider]) continue;  // welded together
      rows_.add(places, point, record.element->has_moments() ? 6 : 3);
      const ContactRows::Row& row = rows_.points().back();
      double u[6] = {};
      rows_.velocity(row, v.data(), u);
      const Pair pair{record.number, point.A.collider, point.B.collider};
      if (pairs_.empty() || pairs_.back() != pair) pairs_.push_back(pair);
      points_.push_back(
          {law, point.gap, {u[0], u[1], u[2]}, row.first, row.rows, static_cast<int>(pairs_.size()) - 1, 0});
      RigidContacts::Point& now = points_.back();
      now.turning = now.before.tail<2>().squaredNorm() * point.curvature;
      for (const ContactRows::Side& side : row.sides) {
        if (side.body < 0) continue;
        const MarkerKinematics& k = places.collider(side.collider);
        const double w = k.w.norm(), arm = k.r.norm() + (row.point.position - k.p).norm();
        now.turning += w * (w * arm + now.before.norm());
      }
    }
  }
}

/// S⁻¹ Hᵀ of a rigid body.
void RigidContacts::respond_alone(const ContactRows::Row& row, const ContactRows::Side& side, ConeProblem::Side& to) {
  const RigidInertia& inverse = components_[component_[side.body]].inertia;
  const double* H = rows_.values(side);
  double* Y = problem_.values.data() + to.Y;
  for (int i = 0; i < row.rows; ++i, Y += 6) {
    const Vector3 turn(H[i + 3 * row.rows], H[i + 4 * row.rows], H[i + 5 * row.rows]);
    for (int k = 0; k < 3; ++k) Y[k] = inverse.mass * H[i + k * row.rows];
    Eigen::Map<Vector3>(Y + 3).noalias() = inverse.inertia * turn;
  }
}

/// S⁻¹ Hᵀ of all others: a column of each component goes into one solution.
void RigidContacts::respond_together() {
  if (columns_.size() < problem_.groups.size()) columns_.resize(problem_.groups.size());
  for (auto& of : columns_) of.clear();
  for (std::size_t i = 0; i < points_.size(); ++i)
    for (int s = 0; s < 2; ++s) {
      const ContactRows::Side& side = rows_.points()[i].sides[s];
      if (side.count == 0 || components_[component_[side.body]].alone) continue;
      for (int row = 0; row < points_[i].rows; ++row)
        columns_[problem_.contacts[i].sides[s].group].push_back({static_cast<int>(i), s, row});
    }
  std::size_t most = 0;
  for (const auto& of : columns_) most = std::max(most, of.size());
  rv_.resize(scene_.equations.layout().v_count()), rl_.resize(scene_.equations.layout().row_count());
  for (std::size_t k = 0; k < most; ++k) {
    rv_.setZero(), rl_.setZero();
    for (const auto& of : columns_) {
      if (k >= of.size()) continue;
      const ContactRows::Row& row = rows_.points()[of[k].point];
      const ContactRows::Side& side = row.sides[of[k].side];
      for (int c = 0; c < side.count; ++c) rv_[side.velocity + c] = rows_.values(side)[of[k].row + row.rows * c];
    }
    scene_.equations.solve(rv_, rl_);
    for (std::size_t g = 0; g < columns_.size(); ++g) {
      if (k >= columns_[g].size()) continue;
      const Column& column = columns_[g][k];
      const auto& velocities = components_[used_[g]].velocities;
      double* Y = problem_.values.data() + problem_.contacts[column.point].sides[column.side].Y +
                  column.row * static_cast<int>(velocities.size());
      for (int velocity : velocities) *Y++ = rv_[velocity];
    }
  }
}

ConeProblem& RigidContacts::form() {
  // 1. Groups: the components in touch.
  for (int c : used_) components_[c].group = -1;
  used_.clear();
  problem_.contacts.clear(), problem_.groups.clear(), problem_.values.clear();
  problem_.rows = rows_.row_count();
  problem_.velocities = 0;
  problem_.free.setZero(problem_.rows);
  bool tied = false;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ContactRows::Row& row = rows_.points()[i];
    ConeProblem::Contact& contact = problem_.contacts.emplace_back();
    contact.row = row.first;
    contact.rows = row.rows;
    contact.friction = points_[i].law.friction;
    contact.rolling = points_[i].law.rolling;
    contact.spinning = points_[i].law.spinning;
    for (int s = 0; s < 2; ++s) {
      const ContactRows::Side& side = row.sides[s];
      if (side.count == 0) continue;
      Component& component = components_[component_[side.body]];
      const int size = static_cast<int>(component.velocities.size());
      if (component.group < 0) {
        component.group = static_cast<int>(used_.size());
        used_.push_back(component_[side.body]);
        problem_.groups.push_back({problem_.velocities, size});
        problem_.velocities += size;
        if (component.alone) {
          const Eigen::Map<const Matrix6> S(scene_.values.data() + component.values);
          component.inertia.inertia = S.bottomRightCorner<3, 3>().inverse();
        }
      }
      // 2. H as it is, Y where it is to be.
      ConeProblem::Side& to = contact.sides[s];
      to.group = component.group;
      to.first = place_[side.velocity];
      to.count = side.count;
      to.H = static_cast<int>(problem_.values.size());
      problem_.values.insert(problem_.values.end(), rows_.values(side), rows_.values(side) + row.rows * side.count);
      to.Y = static_cast<int>(problem_.values.size());
      problem_.values.resize(problem_.values.size() + static_cast<std::size_t>(size * row.rows), 0.0);
      if (component.alone)
        respond_alone(row, side, to);
      else
        tied = true;
    }
  }
  if (tied) respond_together();
  return problem_;
}

void RigidContacts::velocity(ConstVectorRef v, VectorRef u) const {
  for (const ContactRows::Row& row : rows_.points()) rows_.velocity(row, v.data(), u.data() + row.first);
}

void RigidContacts::add_impulses(ConstVectorRef r, VectorRef f) const {
  for (const ConeProblem::Contact& c : problem_.contacts)
    for (const ConeProblem::Side& side : c.sides) {
      if (side.group < 0) continue;
      const auto& velocities = components_[used_[side.group]].velocities;
      const double* H = problem_.values.data() + side.H;
      for (int k = 0; k < side.count; ++k)
        for (int row = 0; row < c.rows; ++row) f[velocities[side.first + k]] += r[c.row + row] * *H++;
    }
}

void RigidContacts::add_response(ConstVectorRef r, const VectorX* weights, VectorRef dv) const {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const double weight = weights ? (*weights)[static_cast<int>(i)] : 1;
    for (const ConeProblem::Side& side : problem_.contacts[i].sides) {
      if (side.group < 0) continue;
      const auto& velocities = components_[used_[side.group]].velocities;
      const double* Y = problem_.values.data() + side.Y;
      for (int row = 0; row < points_[i].rows; ++row) {
        const double impulse = weight * r[points_[i].first + row];
        for (int velocity : velocities) dv[velocity] += impulse * *Y++;
      }
    }
  }
}

double RigidContacts::dot(int group, ConstVectorRef a, ConstVectorRef b) const {
  double sum = 0;
  for (int velocity : components_[used_[group]].velocities) sum += a[velocity] * b[velocity];
  return sum;
}

const ContactTrace* RigidContacts::find_trace(const ContactMemory& memory, const ContactRows::Row& row) const {
  const auto wanted = contact_key(row.element, row.point);
  const auto at = std::lower_bound(memory.begin(), memory.end(), wanted, [](const ContactTrace& t, const auto& k) {
    return contact_key(t.element, t.point) < k;
  });
  return at != memory.end() && contact_key(at->element, at->point) == wanted ? &*at : nullptr;
}

void RigidContacts::recall(const ContactMemory& memory, double h, VectorRef r, VectorRef growth) const {
  r.setZero(), growth.setZero();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ContactRows::Row& row = rows_.points()[i];
    const ContactTrace* at = find_trace(memory, row);
    if (!at) continue;
    r.segment<3>(row.first) = h * (row.frame.transpose() * at->force);
    if (row.rows > 3) r.segment<3>(row.first + 3) = h * to_moment_rows(row.frame.transpose() * at->moment);
    // The step before left this velocity along its own H: what it is along this one differs by h Ḣ v.
    const Vector3 change = (points_[i].before - row.frame.transpose() * std::get<RigidMemory>(at->memory).velocity) / 2;
    if (change.norm() <= h * points_[i].turning) growth.segment<3>(row.first) = change;  // else v has been set anew
  }
}

void RigidContacts::recall_slip(const ContactMemory& memory, VectorRef at_start, VectorRef at_end) const {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ContactTrace* at = find_trace(memory, rows_.points()[i]);
    const auto k = static_cast<Eigen::Index>(i);
    const RigidMemory kept = at ? std::get<RigidMemory>(at->memory) : RigidMemory{};
    at_start[k] = kept.slip_at_start;
    at_end[k] = kept.slip_at_end;
  }
}

void RigidContacts::remember(ConstVectorRef r, ConstVectorRef v, double h, ConstVectorRef slip_at_start,
                             ConstVectorRef slip_at_end, ContactMemory& memory) const {
  const auto& contacts = scene_.records;
  std::erase_if(
      memory, [&](const ContactTrace& t) { return contacts[t.element].element->law() == ContactElement::Law::rigid; });
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ContactRows::Row& row = rows_.points()[i];
    if (r.segment(row.first, row.rows).isZero(0)) continue;
    ContactTrace& trace = memory.emplace_back();
    trace.element = row.element;
    trace.point = row.point;
    trace.force = row.frame * r.segment<3>(row.first) / h;
    trace.moment.setZero();
    if (row.rows > 3) trace.moment = row.frame * from_moment_rows(r.segment<3>(row.first + 3)) / h;
    const auto k = static_cast<Eigen::Index>(i);
    double u[6] = {};
    rows_.velocity(row, v.data(), u);
    trace.memory = RigidMemory{row.frame * Vector3(u[0], u[1], u[2]), slip_at_start[k], slip_at_end[k]};
  }
  std::sort(memory.begin(), memory.end(), [](const ContactTrace& a, const ContactTrace& b) {
    return contact_key(a.element, a.point) < contact_key(b.element, b.point);
  });
}

}  // namespace lithe
