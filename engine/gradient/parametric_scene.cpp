#include "engine/gradient/parametric_scene.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"

namespace lithe {

namespace {

constexpr double kStep = 1e-3;  // of a parameter's size: differences of fourth order then err by 1e-12

Table as_table(const std::vector<DesignParameter>& parameters) {
  Table table;
  for (const DesignParameter& p : parameters) {
    table.columns.push_back(p.name);
    table.values.push_back(p.value);
  }
  return table;
}

}  // namespace

std::vector<DesignParameter> checked_parameters(std::vector<DesignParameter> parameters) {
  const auto refuse = [](const std::string& what, const std::string& fix) {
    throw SceneError(what, "parameters", fix);
  };
  if (parameters.empty()) refuse("there are no parameters", "name one");
  std::vector<std::string> names;
  for (DesignParameter& p : parameters) {
    if (p.name.empty()) refuse("a parameter has no name", "name it");
    if (!std::isfinite(p.value) || !std::isfinite(p.step) || p.step < 0)
      refuse("the parameter '" + p.name + "' has a value or a step that is not finite, or a negative step",
             "give finite numbers");
    if (p.step == 0) p.step = p.value == 0 ? kStep : kStep * std::abs(p.value);
    names.push_back(p.name);
  }
  std::sort(names.begin(), names.end());
  if (const auto twice = std::adjacent_find(names.begin(), names.end()); twice != names.end())
    refuse("the parameter '" + *twice + "' appears twice", "give each a name of its own");
  return parameters;
}

std::vector<DesignParameter> moved_parameter(std::vector<DesignParameter> parameters, int k, double steps) {
  DesignParameter& p = parameters[static_cast<std::size_t>(k)];
  p.value += steps * p.step;
  return parameters;
}

void draw_only(const ParametricScene& scene, const std::vector<DesignParameter>& parameters,
               const std::function<void(const SystemGraph&)>& look) {
  SystemGraph graph{{.gravity = scene.gravity}};
  const Table table = as_table(parameters);
  scene.draw(graph, SweepPoint(table, 0));
  look(graph);
}

Drawing::Drawing(const ParametricScene& scene, const std::vector<DesignParameter>& parameters)
    : values_(as_table(parameters)), graph_({.gravity = scene.gravity}) {
  if (!scene.draw) throw SceneError("the scene has nothing to draw", "ParametricScene", "give a function draw");
  sensors_ = scene.draw(graph_, point());
  system_ = std::make_unique<const System>(assemble(graph_, {.forward_dynamics = scene.forward_dynamics}));
}

Drawing::Place Drawing::find(const Located& column) const {
  std::string known;
  for (std::size_t s = 0; s < sensors_.size(); ++s) {
    const auto& columns = sensors_[s].columns();
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (columns[c] == column.text) return {static_cast<int>(s), static_cast<int>(c)};
      known += (known.empty() ? "" : ", ") + columns[c];
    }
  }
  throw SceneError("no sensor of the scene has a column '" + column.text + "'", to_string(column.where),
                   known.empty() ? "let the scene return sensors" : "known are " + known);
}

}  // namespace lithe
