#include "engine/study/sweep_parameters.h"

#include <algorithm>
#include <random>

#include "engine/base/checks.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

/// Uniform in [0, 1). The standard's distributions differ between libraries; its engines do not.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

std::vector<int> permutation(int count, std::mt19937_64& random) {
  std::vector<int> order(count);
  for (int i = 0; i < count; ++i) order[i] = i;
  for (int i = count - 1; i > 0; --i) std::swap(order[i], order[static_cast<int>(uniform(random) * (i + 1))]);
  return order;
}

template <class Parameter>
std::vector<std::string> names_of(const std::vector<Parameter>& parameters, const std::string& where) {
  if (parameters.empty())
    throw SceneError("a sweep without parameters has no points", where, "give at least one parameter");
  std::vector<std::string> names;
  for (const Parameter& parameter : parameters) {
    if (parameter.name.empty()) throw SceneError("a parameter has no name", where, "name it");
    if (std::find(names.begin(), names.end(), parameter.name) != names.end())
      throw SceneError("the parameter '" + parameter.name + "' appears twice", where, "give each a name of its own");
    names.push_back(parameter.name);
  }
  return names;
}

}  // namespace

Table grid(const std::vector<SweepAxis>& axes) {
  Table points{.columns = names_of(axes, "grid")};
  std::size_t count = 1;
  for (const SweepAxis& axis : axes) {
    if (axis.values.empty())
      throw SceneError("the parameter '" + axis.name + "' takes no value", "grid", "give at least one");
    count *= axis.values.size();
  }
  points.values.reserve(count * axes.size());
  for (std::size_t point = 0; point < count; ++point) {
    std::size_t block = count;  // points over which this axis and those after it run through their values
    for (const SweepAxis& axis : axes) {
      const std::size_t within = point % block;
      block /= axis.values.size();
      points.values.push_back(axis.values[within / block]);
    }
  }
  return points;
}

Table latin_hypercube(const std::vector<SweepRange>& ranges, int count, std::uint64_t seed) {
  Table points{.columns = names_of(ranges, "latin_hypercube")};
  if (count < 1) throw SceneError("a sample has no points", "latin_hypercube", "ask for at least one");
  for (const SweepRange& range : ranges) {
    require::at("latin_hypercube", [&] {
      require::finite(range.lower, range.name + ".lower");
      require::finite(range.upper, range.name + ".upper");
    });
    if (!(range.lower < range.upper))
      throw SceneError("the bounds of '" + range.name + "' do not rise", "latin_hypercube", "set lower < upper");
  }
  std::mt19937_64 random(seed);
  points.values.resize(static_cast<std::size_t>(count) * ranges.size());
  for (std::size_t column = 0; column < ranges.size(); ++column) {
    const SweepRange& range = ranges[column];
    const std::vector<int> part = permutation(count, random);
    for (int row = 0; row < count; ++row)
      points.values[row * ranges.size() + column] =
          range.lower + (range.upper - range.lower) * ((part[row] + uniform(random)) / count);
  }
  return points;
}

std::vector<double> evenly_spaced(double first, double last, int count) {
  if (count < 2) throw SceneError("from one value to another takes two", "evenly_spaced", "ask for two or more");
  std::vector<double> values(count);
  for (int i = 0; i < count; ++i) values[i] = ((count - 1 - i) * first + i * last) / (count - 1);
  values.back() = last;
  return values;
}

}  // namespace lithe
