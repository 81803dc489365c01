#include "bodies/beam/beam.h"

#include <algorithm>

#include "engine/base/checks.h"
#include "engine/base/rotations.h"

namespace lithe {

namespace {

/// What a piece of the beam weighs, about a place.
struct Piece {
  double length = 0, mass = 0;
  Vector3 first_length = Vector3::Zero(), first_mass = Vector3::Zero();  // ∫ r ds, ∫ r dm
  Matrix3 inertia = Matrix3::Zero();                                     // about the place
};

BeamSection section_at(const std::vector<Beam::Station>& stations, double arc) {
  const auto next = std::find_if(stations.begin(), stations.end(), [&](const auto& s) { return s.arc > arc; });
  if (next == stations.begin()) return next->section;
  if (next == stations.end()) return stations.back().section;
  const auto last = next - 1;
  return between(last->section, next->section, (arc - last->arc) / (next->arc - last->arc));
}

/// Adds the stretch from `from` to `to`, in the axes and from the point of `node`, as drawn: Gauss's four points.
void add_stretch(const Beam::Parameters& p, const FramePose& node, double from, double to, Piece& piece) {
  constexpr double kPlace[] = {0.33998104358485626, 0.86113631159405258};
  constexpr double kWeight[] = {0.65214515486254614, 0.34785484513745386};
  for (int i = 0; i < 4; ++i) {
    const double side = i < 2 ? 1 : -1, arc = 0.5 * (from + to) + 0.5 * (to - from) * side * kPlace[i % 2];
    const double ds = 0.5 * (to - from) * kWeight[i % 2];
    const FramePose pose = p.axis.pose(arc);
    const BeamSection section = section_at(p.sections, arc);
    const Matrix3 turn = node.axes.transpose() * pose.axes;
    const Vector3 r = node.axes.transpose() * (pose.position - node.position), c = section.mass_center();
    const double mass = section.mass_per_length() * ds;
    const Matrix3 about_center = section.mass.bottomRightCorner<3, 3>() + section.mass_per_length() * skew(c) * skew(c);
    const Vector3 center = r + turn * c;
    piece.length += ds, piece.mass += mass;
    piece.first_length += ds * r, piece.first_mass += mass * center;
    piece.inertia += ds * turn * about_center * turn.transpose() - mass * skew(center) * skew(center);
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

const std::vector<std::string> kStrains = {"_Gamma_1", "_Gamma_2", "_Gamma_3", "_K_1", "_K_2", "_K_3"};
const std::vector<std::string> kResultants = {"_n_1", "_n_2", "_n_3", "_m_1", "_m_2", "_m_3"};

Sensor make_sensor(Located name, const BeamElement& element, const std::vector<std::string>& endings,
                   std::vector<std::string> units, bool resultants) {
  if (name.text.empty()) name.text = element.name();
  std::vector<std::string> columns;
  for (const std::string& ending : endings) columns.push_back(name.text + ending);
  const auto read = [&element, resultants](Snapshot& now, std::span<double> values) {
    const MarkerKinematics a = now.marker(element.markers()[0]), b = now.marker(element.markers()[1]);
    const MarkerView A(a, 0), B(b, 1);
    Eigen::Map<Vector6>(values.data()) = resultants ? element.resultants(A, B) : element.strain(A, B);
  };
  return {std::move(name), std::move(columns), read, std::move(units)};
}

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

Beam::Beam(SystemGraph& graph, Located name, const Parameters& p) : name_(name.text), where_(to_string(name.where)) {
  require::at("'" + name_ + "' of " + where_, [&] {
    check(p);
    arcs_ = place_nodes(p);
  });
  const int count = static_cast<int>(arcs_.size());
  const Vector3 start = p.axis.pose(0).position;
  for (int i = 0; i < count; ++i) {
    const FramePose node = p.axis.pose(arcs_[i]);
    Piece piece;
    if (i > 0) add_stretch(p, node, 0.5 * (arcs_[i - 1] + arcs_[i]), arcs_[i], piece);
    if (i + 1 < count) add_stretch(p, node, arcs_[i], 0.5 * (arcs_[i] + arcs_[i + 1]), piece);
    const Vector3 center = piece.first_mass / piece.mass;
    const Vector3 position = node.position + node.axes * center;
    const Matrix3 inertia = piece.inertia + piece.mass * skew(center) * skew(center);
    auto& body = graph.add<RigidBody>({name_ + ".node" + std::to_string(i), name.where},
                                      {.mass = piece.mass,
                                       .inertia = Matrix3(0.5 * (inertia + inertia.transpose())),
                                       .position = position,
                                       .orientation = node.axes,
                                       .velocity = p.velocity + p.angular_velocity.cross(position - start),
                                       .angular_velocity = node.axes.transpose() * p.angular_velocity});
    poses_.push_back(node);
    nodes_.push_back(&body);
    centers_.push_back(center);
    axis_markers_.push_back(body.marker(-center));
    middles_.push_back(body.marker(piece.first_length / piece.length - center));
  }
  for (int i = 0; i + 1 < count; ++i)
    elements_.push_back(&graph.add<BeamElement>(
        {name_ + ".element" + std::to_string(i), name.where}, {axis_markers_[i], axis_markers_[i + 1]},
        {.section = section_at(p.sections, 0.5 * (arcs_[i] + arcs_[i + 1])), .length = arcs_[i + 1] - arcs_[i]}));
}

int Beam::node_at(double arc) const {
  const auto near = std::min_element(arcs_.begin(), arcs_.end(),
                                     [&](double a, double b) { return std::abs(a - arc) < std::abs(b - arc); });
  if (!(std::abs(*near - arc) <= 1e-9 * arcs_.back()))
    throw SceneError("beam '" + name_ + "' has no node at " + std::to_string(arc) + " m", where_,
                     "list that place in .stations of the beam");
  return static_cast<int>(near - arcs_.begin());
}

Marker Beam::marker(double arc, const Point& offset, const Matrix3& orientation) const {
  const int i = node_at(arc);
  return nodes_[i]->marker(offset.at - centers_[i], orientation);
}

double Beam::piece_length(int node) const {
  const double before = node > 0 ? arcs_[node] - arcs_[node - 1] : 0;
  const double behind = node + 1 < node_count() ? arcs_[node + 1] - arcs_[node] : 0;
  return 0.5 * (before + behind);
}

Vector6 Beam::strain(Snapshot& at, int element) const {
  Vector6 values;
  strain(element).evaluate(at, {values.data(), 6});
  return values;
}

Vector6 Beam::resultants(Snapshot& at, int element) const {
  Vector6 values;
  resultants(element).evaluate(at, {values.data(), 6});
  return values;
}

Sensor Beam::strain(int element, Located name) const {
  return make_sensor(std::move(name), *elements_[element], kStrains, {"", "", "", "1/m", "1/m", "1/m"}, false);
}

Sensor Beam::resultants(int element, Located name) const {
  return make_sensor(std::move(name), *elements_[element], kResultants, {"N", "N", "N", "N m", "N m", "N m"}, true);
}

}  // namespace lithe
