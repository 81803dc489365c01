#include "bodies/beam/beam.h"

#include <algorithm>

#include "bodies/beam/beam_cache_internal.h"
#include "bodies/beam/se3_internal.h"
#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/base/rotations.h"
#include "engine/observe/snapshot.h"

namespace lithe {

namespace {

BeamSection section_at(const std::vector<Beam::Station>& stations, double arc) {
  const auto next = std::find_if(stations.begin(), stations.end(), [&](const auto& s) { return s.arc > arc; });
  if (next == stations.begin()) return next->section;
  if (next == stations.end()) return stations.back().section;
  const auto last = next - 1;
  return between(last->section, next->section, (arc - last->arc) / (next->arc - last->arc));
}

/// Adds the stretch from `from` to `to` to a mass matrix about `node`, in its axes, as drawn: Gauss's four points.
void add_stretch(const Beam::Parameters& p, const FramePose& node, double from, double to, Matrix6& mass) {
  constexpr double kPlace[] = {0.33998104358485626, 0.86113631159405258};
  constexpr double kWeight[] = {0.65214515486254614, 0.34785484513745386};
  for (int i = 0; i < 4; ++i) {
    const double side = i < 2 ? 1 : -1, arc = 0.5 * (from + to) + 0.5 * (to - from) * side * kPlace[i % 2];
    const double ds = 0.5 * (to - from) * kWeight[i % 2];
    const FramePose pose = p.axis.pose(arc);
    const BeamSection section = section_at(p.sections, arc);
    // The section's axes, seen from the node: [R, 0; r~ R, R] carries its momenta there.
    const Matrix3 R = node.axes.transpose() * pose.axes;
    const Vector3 r = node.axes.transpose() * (pose.position - node.position);
    Matrix6 carry = Matrix6::Zero();
    carry.topLeftCorner<3, 3>() = carry.bottomRightCorner<3, 3>() = R;
    carry.bottomLeftCorner<3, 3>() = skew(r) * R;
    mass += ds * carry * section.mass * carry.transpose();
  }
}

void check(const Beam::Parameters& p) {
  require::positive(p.axis.length, "the axis' length");
  if (!p.axis.pose) throw SceneError("its axis has no curve", "", "give .axis = BeamAxis::straight(from, to)");
  require::finite(p.velocity, "velocity");
  require::finite(p.angular_velocity, "angular_velocity");
  if (p.elements < 1)
    throw SceneError("it has " + std::to_string(p.elements) + " elements", "", "give one element or more");
  if (p.sections.empty())
    throw SceneError("it has no section", "", "give .sections = {{0, BeamSection::circle(radius, material)}}");
  for (std::size_t i = 0; i < p.sections.size(); ++i) {
    const std::string which = "section " + std::to_string(i) + " (at " + std::to_string(p.sections[i].arc) + " m)";
    require::finite(p.sections[i].arc, "the place of section " + std::to_string(i));
    if (i > 0 && !(p.sections[i].arc > p.sections[i - 1].arc))
      throw SceneError(which + " does not lie behind the one before", "", "list sections from the start to the end");
    p.sections[i].section.check(which);
  }
}

/// Ends and stations, rising, each once; and equal stretches between them.
std::vector<double> place_nodes(const Beam::Parameters& p) {
  const double length = p.axis.length;
  std::vector<double> fixed{0, length};
  for (const double arc : p.stations) {
    if (!(arc >= 0 && arc <= length * (1 + 1e-12)))
      throw SceneError("the station at " + std::to_string(arc) + " m is beyond its ends", "",
                       "give arc lengths from 0 to " + std::to_string(length));
    if (std::none_of(fixed.begin(), fixed.end(), [&](double s) { return std::abs(s - arc) < 1e-9 * length; }))
      fixed.push_back(arc);
  }
  std::sort(fixed.begin(), fixed.end());
  std::vector<double> arcs{0};
  for (std::size_t i = 1; i < fixed.size(); ++i) {
    const double stretch = fixed[i] - fixed[i - 1];
    const int count = std::max(1, static_cast<int>(std::lround(p.elements * stretch / length)));
    for (int k = 1; k < count; ++k) arcs.push_back(fixed[i - 1] + stretch * k / count);
    arcs.push_back(fixed[i]);
  }
  return arcs;
}

/// Whether the axis' frames turn at once between two arc lengths, and where: half after half that turns all but alone.
void refuse_kink(const BeamAxis& axis, double from, double to) {
  constexpr double kTurn = 0.01;  // rad
  const double length = to - from;
  const auto turn = [](const FramePose& a, const FramePose& b) {
    return rotation_log(a.axes.transpose() * b.axes).norm();
  };
  FramePose a = axis.pose(from), b = axis.pose(to);
  double whole = turn(a, b);
  while (whole > kTurn && to - from > 1e-6 * length) {
    const double middle = 0.5 * (from + to);
    const FramePose m = axis.pose(middle);
    const double first = turn(a, m), second = turn(m, b);
    if (std::max(first, second) < 0.9 * whole) return;
    if (first > second)
      to = middle, b = m, whole = first;
    else
      from = middle, a = m, whole = second;
  }
  if (whole > kTurn)
    throw SceneError(
        "its axis has a kink of " + std::to_string(whole * 180 / M_PI) + " degrees at " + std::to_string(from) + " m",
        "",
        "draw two beams and join them there by a FixedJoint: of a bent tube or an elbow the shear centre "
        "and the stiffness at the kink are then yours to give, as an offset of the sections or a bushing");
}

double clamped(double arc, double length) { return std::min(std::max(arc, 0.0), length); }

}  // namespace

BeamAxis BeamAxis::straight(const Vector3& from, const Vector3& to, const Vector3& axis_2) {
  const Matrix3 turned = axes_along(to - from, axis_2);  // its z along the line
  Matrix3 axes;
  axes << turned.col(2), turned.col(0), turned.col(1);
  const Vector3 direction = axes.col(0);
  return {(to - from).norm(), [=](double arc) { return FramePose{from + arc * direction, axes}; }};
}

BeamAxis BeamAxis::curved(const FramePose& start, const Vector3& curvature, double length) {
  require::rotation(start.axes, "axes at the start of the curve");
  require::finite(curvature, "curvature");
  return {length, [=](double arc) {
            const Vector3 turn = arc * curvature;
            return FramePose{start.position + start.axes * left_jacobian(turn).col(0) * arc,
                             start.axes * rotation_exp(turn)};
          }};
}

Beam::Beam(Parameters parameters) : parameters_(std::move(parameters)) {
  const Parameters& p = parameters_;
  check(p);
  arcs_ = place_nodes(p);
  for (const double arc : arcs_) poses_.push_back(p.axis.pose(arc));
  for (int i = 0; i + 1 < node_count(); ++i) {
    const FramePose &a = poses_[i], &b = poses_[i + 1];
    require::rotation(a.axes, "axes at " + std::to_string(arcs_[i]) + " m");
    try {
      refuse_kink(p.axis, arcs_[i], arcs_[i + 1]);
      spans_.emplace_back(section_at(p.sections, 0.5 * (arcs_[i] + arcs_[i + 1])), arcs_[i + 1] - arcs_[i],
                          se3::log_between(a.position, a.axes, b.position, b.axes));
    } catch (const SceneError& error) {
      throw SceneError("element " + std::to_string(i) + ", from " + std::to_string(arcs_[i]) + " m to " +
                           std::to_string(arcs_[i + 1]) + " m: " + error.problem(),
                       "", error.fix());
    }
    pairs_.push_back({i, i + 1});
  }
  if (p.mass == Mass::lumped)
    for (int i = 0; i < node_count(); ++i) node_masses_.push_back(lumped_mass(i));
}

Matrix6 Beam::lumped_mass(int node) const {
  const FramePose& about = pose(node);
  const double here = arc(node);
  Matrix6 mass = Matrix6::Zero();
  for (const int beside : {node - 1, node + 1}) {
    if (beside < 0 || beside >= node_count()) continue;
    const double middle = 0.5 * (here + arcs_[static_cast<std::size_t>(beside)]);
    add_stretch(parameters_, about, std::min(here, middle), std::max(here, middle), mass);
  }
  return 0.5 * (mass + mass.transpose());
}

Marker Beam::marker(double arc, const Point& offset, const Matrix3& orientation) {
  const double slack = 1e-9 * length();
  if (!(arc >= -slack && arc <= length() + slack))
    throw SceneError("beam '" + name() + "' has no section at " + std::to_string(arc) + " m", where(),
                     "give an arc length from 0 to " + std::to_string(length()));
  require::at("'" + name() + "' of " + where(), [&] {
    require::finite(offset.at, "offset");
    require::rotation(orientation, "orientation");
  });
  const int e = element_at(clamped(arc, length()));
  const double from = arcs_[e], to = arcs_[e + 1];
  double share = (clamped(arc, length()) - from) / (to - from);
  if (share < 1e-9) share = 0;
  if (share > 1 - 1e-9) share = 1;
  places_.push_back({e, share, offset.at, orientation});
  return new_marker();
}

Marker Beam::marker_at_world(const Point& point, const Matrix3& orientation) {
  const auto nearest = std::min_element(poses_.begin(), poses_.end(), [&](const FramePose& a, const FramePose& b) {
    return (a.position - point.at).squaredNorm() < (b.position - point.at).squaredNorm();
  });
  return marker(arcs_[nearest - poses_.begin()], nearest->axes.transpose() * (point.at - nearest->position),
                nearest->axes.transpose() * orientation);
}

double Beam::mass() const {
  double sum = 0;
  for (const Matrix6& mass : node_masses_) sum += mass(0, 0);
  if (node_masses_.empty())
    for (const BeamSpan& span : spans_) sum += span.length() * span.section().mass_per_length();
  return sum;
}

int Beam::element_at(double arc) const {
  const auto behind = std::upper_bound(arcs_.begin(), arcs_.end(), arc);
  return std::clamp(static_cast<int>(behind - arcs_.begin()) - 1, 0, element_count() - 1);
}

std::size_t Beam::checked_node(int i) const {
  if (i >= 0 && i < node_count()) return static_cast<std::size_t>(i);
  throw SceneError("beam '" + name() + "' has no node " + std::to_string(i), where(),
                   "give 0 to " + std::to_string(node_count() - 1));
}

std::size_t Beam::checked_element(int i) const {
  if (i >= 0 && i < element_count()) return static_cast<std::size_t>(i);
  throw SceneError("beam '" + name() + "' has no element " + std::to_string(i), where(),
                   "give 0 to " + std::to_string(element_count() - 1) + "; element_at(arc) finds one");
}

int Beam::node_of(const Place& place) const {
  if (place.share == 0) return place.element;
  return place.share == 1 ? place.element + 1 : -1;
}

void Beam::initial_state(VectorRef q, VectorRef v) const {
  const Vector3 start = poses_.front().position, spin = parameters_.angular_velocity;
  for (int i = 0; i < node_count(); ++i) {
    const FramePose& pose = poses_[i];
    q.segment<7>(7 * i) << pose.position, quaternion_of(pose.axes);
    v.segment<6>(6 * i) << parameters_.velocity + spin.cross(pose.position - start), pose.axes.transpose() * spin;
  }
}

Sensor Beam::strain(int element, Located name) const { return make_sensor(element, std::move(name), false); }
Sensor Beam::resultants(int element, Located name) const { return make_sensor(element, std::move(name), true); }

Sensor Beam::make_sensor(int element, Located name, bool resultants) const {
  static const std::vector<std::string> kStrains = {"_Gamma_1", "_Gamma_2", "_Gamma_3", "_K_1", "_K_2", "_K_3"};
  static const std::vector<std::string> kResultants = {"_n_1", "_n_2", "_n_3", "_m_1", "_m_2", "_m_3"};
  checked_element(element);
  if (name.text.empty()) name.text = this->name() + ".element" + std::to_string(element);
  std::vector<std::string> columns;
  for (const std::string& ending : resultants ? kResultants : kStrains) columns.push_back(name.text + ending);
  const auto read = [this, element, resultants](Snapshot& now, std::span<double> values) {
    const BodyState state = now.body_state(*this);
    Eigen::Map<Vector6>(values.data()) = resultants ? this->resultants(state, element) : strain(state, element);
  };
  if (resultants) return {std::move(name), std::move(columns), read, {"N", "N", "N", "N m", "N m", "N m"}};
  return {std::move(name), std::move(columns), read, {"", "", "", "1/m", "1/m", "1/m"}};
}

template std::unique_ptr<BodyBatch> make_body_batch<Beam>();

}  // namespace lithe
