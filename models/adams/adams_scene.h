#pragma once

#include <map>
#include <string>
#include <vector>

#include "engine/model/constraint.h"
#include "engine/model/force_element.h"
#include "engine/model/marker.h"
#include "engine/model/system_graph.h"
#include "models/adams/adams_model.h"

namespace lithe {

/// Motions, loads and constraints by functions in the language of Adams data sets, in a scene of one's own; what
/// `lithe model inspect --write` writes of a data set. Markers have numbers, by which functions name them:
///   AdamsScene adams(graph, {.length = 1e-3}, {{204, bob.marker()}, {205, graph.ground().marker()}});
///   adams.add("SFORCE/1", AdamsModel::Load{.kind = AdamsModel::Load::Kind::along_line, .i = 204, .j = 205,
///                                          .functions = {{adams.function("-10*(DM(204,205)-2)")}}});
class AdamsScene {
 public:
  /// Number 0 is the frame of the ground, unless it is given. Units: of functions, in SI.
  AdamsScene(SystemGraph& graph, AdamsUnits units, std::map<int, Marker> markers);

  /// Throws SceneError for what read_adams_function() refuses, and for VARIABLEs and SPLINEs, which are a data set's.
  AdamsFunction function(const std::string& text) const;

  /// All throw SceneError for a marker that has not been given, and for more of them than an element may read: eight of
  /// a load, four of a constraint.
  const ForceElement& add(Located name, const AdamsModel::Load& load);
  const ForceElement& add(Located name, const AdamsModel::Field& field);
  const Constraint& add(Located name, const AdamsModel::Motion& motion);
  /// `read`: the markers in the order of its list.
  const Constraint& add(Located name, const AdamsModel::Constraint& constraint, std::vector<int>* read = nullptr);

 private:
  Marker marker(int id) const;
  std::vector<Marker> markers_of(const std::vector<int>& ids) const;

  SystemGraph& graph_;
  const AdamsUnits units_;
  std::map<int, Marker> markers_;
};

}  // namespace lithe
