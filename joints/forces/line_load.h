#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"
#include "engine/model/motion_law.h"
#include "engine/model/system_graph.h"

namespace lithe {

/// A load spread along a stretch of a Beam or a Cable: wind, pressure, thrust, cargo. Forces (N/m) and moments (N m/m)
/// per length as drawn (of a cable: unstretched), in axes that stay with the world (a dead load) or turn with the
/// sections (a follower: 1 along the beam).
///   add_line_load(graph, "wind", blade, {.from = 2, .density = {{2, force({0, 0, 0})}, {8, force({0, -40, 0})}}});
struct LineLoad {
  enum class Axes { world, section };
  struct Station {
    double arc;      // m
    Wrench density;  // N/m, N m/m
  };
  double from = 0;                                       // m
  std::optional<double> to{};                            // m; none: to its end
  std::vector<Station> density{};                        // rising; linear between, constant beyond
  std::function<Wrench(double arc, double time)> law{};  // N/m, N m/m, instead of them
  Axes axes = Axes::world;
  MotionLaw amplitude{};  // factor over time, a function or an Input; none: 1
};

/// The part of a line load on one element of its body: two wrenches at Gauss's two points, which is exact for what is
/// linear along a straight element. Forces that are dead and constant in time have a potential, V = -Σ F · p.
class LineLoadPiece final : public Force</*markers=*/2, /*rows=*/0> {
 public:
  struct Parameters {
    std::array<Wrench, 2> wrenches;                      // N, N m, one a marker
    std::function<Wrench(int marker, double time)> law;  // instead of them
    LineLoad::Axes axes;
    MotionLaw amplitude{};
  };
  explicit LineLoadPiece(Parameters parameters) : parameters_(std::move(parameters)) {}

  bool depends_on_time() const override { return parameters_.law || parameters_.amplitude; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

 private:
  const Parameters parameters_;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<LineLoadPiece>();

/// On a body whose nodes are at the arc lengths `nodes`: a piece for each element that the stretch covers, cut at the
/// load's stations, named "<name>.0" and so on.
std::vector<LineLoadPiece*> add_line_load(SystemGraph& graph, const Located& name, const std::vector<double>& nodes,
                                          const std::function<Marker(double arc)>& marker, const LineLoad& load);

/// Throws SceneError for a stretch that is empty or leaves the body, stations that do not rise, densities that are not
/// finite, no density, axes of sections on a body that has none (a Cable); assemble() for a moment on such a body.
template <class Line>
std::vector<LineLoadPiece*> add_line_load(SystemGraph& graph, const Located& name, Line& line, const LineLoad& load) {
  std::vector<double> nodes;
  for (int i = 0; i < line.node_count(); ++i) nodes.push_back(line.arc(i));
  return add_line_load(
      graph, name, nodes, [&](double arc) { return line.marker(arc); }, load);
}

}  // namespace lithe
