#include "models/adams/adams_scene.h"

#include <algorithm>

#include "engine/base/error.h"
#include "joints/coordinate_drive.h"
#include "models/adams/adams_elements_internal.h"

namespace lithe {
namespace {

using adams::FieldForce, adams::FunctionConstraint, adams::FunctionForce, adams::in_time, adams::PlacedFunction,
    adams::RateDrive;

/// Places of the markers that a function reads in an element's list, which grows; at most `most`.
PlacedFunction place(const AdamsFunction& f, std::vector<int>& ids, std::vector<MeasuredAngle>& angles,
                     const std::string& name, int most) {
  PlacedFunction placed{f};
  const auto find = [&](int id) {
    const auto found = std::find(ids.begin(), ids.end(), id);
    if (found != ids.end()) return static_cast<int>(found - ids.begin());
    ids.push_back(id);
    if (static_cast<int>(ids.size()) > most)
      throw SceneError(name + " acts on and reads more than " + std::to_string(most) + " markers.", "",
                       "split it into several.");
    return static_cast<int>(ids.size()) - 1;
  };
  for (const AdamsMeasure& m : f.measures) {
    PlacedFunction::Places at{find(m.i), find(m.j), 0, 0, -1};
    using enum AdamsMeasure::Kind;
    const bool along =
        (m.kind >= DX && m.kind <= DZ) || (m.kind >= VX && m.kind <= VZ) || (m.kind >= WX && m.kind <= WZ);
    at.k = along ? find(m.k) : at.j;
    at.l = m.of_velocity() && m.kind <= VZ ? find(m.l) : at.j;
    if (m.is_angle()) {
      at.angle = static_cast<int>(angles.size());
      angles.push_back({at.j, at.i, static_cast<int>(m.kind) - static_cast<int>(AX)});
    }
    placed.places.push_back(at);
  }
  return placed;
}

}  // namespace

AdamsScene::AdamsScene(SystemGraph& graph, AdamsUnits units, std::map<int, Marker> markers)
    : graph_(graph), units_(units), markers_(std::move(markers)) {
  markers_.try_emplace(0, graph_.ground().marker());
}

AdamsFunction AdamsScene::function(const std::string& text) const {
  const auto fail = [](const std::string& problem, const std::string& fix) {
    throw SceneError(problem, "AdamsScene::function", fix);
  };
  return read_adams_function(text, 0,
                             {.variable = [&](int id) -> std::string {
                                fail("VARIABLE/" + std::to_string(id) + " is not known here", "write it out");
                                return "";
                              },
                              .curve = [&](int id, AdamsCurve::Kind) -> AdamsCurve {
                                fail("SPLINE/" + std::to_string(id) + " is not known here", "read the data set");
                                return {{}, {}, false, {}};
                              },
                              .fail = fail});
}

Marker AdamsScene::marker(int id) const {
  const auto found = markers_.find(id);
  if (found == markers_.end())
    throw SceneError("MARKER/" + std::to_string(id) + " is not among those that were given", "AdamsScene",
                     "give it a marker by that number");
  return found->second;
}

std::vector<Marker> AdamsScene::markers_of(const std::vector<int>& ids) const {
  std::vector<Marker> all;
  for (const int id : ids) all.push_back(marker(id));
  return all;
}

const ForceElement& AdamsScene::add(Located name, const AdamsModel::Load& load) {
  FunctionForce::Parameters p{.kind = load.kind, .functions = {}, .units = units_};
  std::vector<int> ids = {load.i, load.j};
  const auto found = std::find(ids.begin(), ids.end(), load.axes);
  p.axes = static_cast<int>(found - ids.begin());
  if (found == ids.end()) ids.push_back(load.axes);
  p.timed = false;
  for (std::size_t c = 0; c < 6; ++c)
    if (load.functions[c]) {
      p.functions[c] = place(*load.functions[c], ids, p.angles, name.text, kMaxMarkers);
      for (const AdamsFunction::Node& node : load.functions[c]->nodes)
        p.timed |= node.operation == AdamsFunction::Operation::time;
    }
  p.markers = static_cast<int>(ids.size());
  return graph_.add<FunctionForce>(std::move(name), markers_of(ids), std::move(p));
}

const ForceElement& AdamsScene::add(Located name, const AdamsModel::Field& field) {
  return graph_.add<FieldForce>(std::move(name), {marker(field.j), marker(field.i)}, field);
}

const Constraint& AdamsScene::add(Located name, const AdamsModel::Motion& motion) {
  const JointCoordinate x = motion.rotation ? angle_between(marker(motion.j), marker(motion.i))
                                            : displacement_between(marker(motion.j), marker(motion.i), motion.axis);
  const double T = units_.time, unit = motion.rotation ? 1 : units_.length;
  if (motion.rate) return graph_.add<RateDrive>(std::move(name), {x}, {motion.function, T, unit / T});
  return graph_.add<CoordinateDrive>(std::move(name), {x}, {.motion = [f = motion.function, T, unit](double t) {
                                       const InTime y = in_time(f, {t / T, 1 / T, 0});
                                       return Motion{unit * y.value, unit * y.rate, unit * y.acceleration};
                                     }});
}

const Constraint& AdamsScene::add(Located name, const AdamsModel::Constraint& constraint, std::vector<int>* read) {
  FunctionConstraint::Parameters p{.units = units_};
  std::vector<int> ids;
  p.function = place(constraint.function, ids, p.angles, name.text, 4);
  std::vector<Marker> markers = markers_of(ids);
  while (markers.size() != 2 && markers.size() != 4) markers.push_back(graph_.ground().marker());
  p.markers = static_cast<int>(markers.size());
  if (read) *read = ids;
  return graph_.add<FunctionConstraint>(std::move(name), markers, std::move(p));
}

}  // namespace lithe
