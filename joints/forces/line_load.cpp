#include "joints/forces/line_load.h"

#include <algorithm>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/point_body.h"
#include "joints/forces/line_pieces.h"

namespace lithe {
namespace {

Wrench density_at(const std::vector<LineLoad::Station>& stations, double arc) {
  const auto next = std::find_if(stations.begin(), stations.end(), [&](const auto& s) { return s.arc > arc; });
  if (next == stations.begin()) return next->density;
  if (next == stations.end()) return stations.back().density;
  const auto last = next - 1;
  const double share = (arc - last->arc) / (next->arc - last->arc);
  return (1 - share) * last->density + share * next->density;
}

void check(const LineLoad& load) {
  if (load.density.empty() == !load.law)
    throw SceneError(load.law ? "it has a density and a law" : "it has no density", "",
                     "give .density = {{0, force({0, 0, -100})}} or a .law");
  for (std::size_t i = 0; i < load.density.size(); ++i) {
    const auto& [arc, density] = load.density[i];
    const std::string which = "station " + std::to_string(i);
    require::finite(arc, "the place of " + which);
    require::finite(density.force, "the force of " + which);
    require::finite(density.torque, "the moment of " + which);
    if (i > 0 && !(arc > load.density[i - 1].arc))
      throw SceneError(which + " does not lie behind the one before", "", "list stations from the start to the end");
  }
}

}  // namespace

void LineLoadPiece::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  const auto& [wrenches, law, axes, amplitude] = parameters_;
  const double factor = amplitude ? amplitude(time).value : 1;
  for (const MarkerView& m : markers) {
    Wrench w = law ? law(m.index, time) : wrenches[static_cast<std::size_t>(m.index)];
    if (amplitude) w = factor * w;
    if (axes == LineLoad::Axes::section) {
      rows.add_load(m, {m.R * w.force, m.R * w.torque});
    } else {
      rows.add_load(m, w);
      if (!law && !amplitude) rows.add_energy(-w.force.dot(m.p));
    }
  }
}

std::vector<LineLoadPiece*> add_line_load(SystemGraph& graph, const Located& name, const std::vector<double>& nodes,
                                          const std::function<Marker(double arc)>& marker, const LineLoad& load) {
  std::vector<LinePiece> stretches;
  try {
    check(load);
    std::vector<double> stations;
    for (const auto& station : load.density) stations.push_back(station.arc);
    stretches = line_pieces(load.from, load.to.value_or(nodes.back()), nodes, stations);
  } catch (const SceneError& error) {
    throw SceneError("'" + name.text + "': " + error.problem(), to_string(name.where), error.fix());
  }
  std::vector<LineLoadPiece*> pieces;
  for (const auto& [arcs, half] : stretches) {
    LineLoadPiece::Parameters piece{.wrenches = {}, .law = {}, .axes = load.axes, .amplitude = load.amplitude};
    if (load.law)
      piece.law = [law = load.law, arcs, half](int m, double time) {
        return half * law(arcs[static_cast<std::size_t>(m)], time);
      };
    else
      for (std::size_t m : {0, 1}) piece.wrenches[m] = half * density_at(load.density, arcs[m]);
    const std::vector<Marker> markers{marker(arcs[0]), marker(arcs[1])};
    if (load.axes == LineLoad::Axes::section && dynamic_cast<const PointBody*>(markers[0].body))
      throw SceneError("'" + name.text + "': sections of '" + markers[0].body->name() + "' do not turn",
                       to_string(name.where), "give the load in world axes");
    pieces.push_back(&graph.add<LineLoadPiece>({name.text + "." + std::to_string(pieces.size()), name.where}, markers,
                                               std::move(piece)));
  }
  return pieces;
}

template std::unique_ptr<ForceBatch> make_force_batch<LineLoadPiece>();

}  // namespace lithe
