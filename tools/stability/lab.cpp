#include "tools/stability/lab.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/study/study_run.h"

namespace lithe::lab {
namespace {

std::vector<Scene>& registered() {
  static std::vector<Scene> all;
  return all;
}

}  // namespace

Registered::Registered(Scene scene) { registered().push_back(std::move(scene)); }

std::vector<Scene> scenes() {
  std::vector<Scene> all = registered();
  std::ranges::sort(all, {}, &Scene::id);
  return all;
}

bool agrees(const Figure& figure) {
  const double published = std::abs(figure.published), value = std::abs(figure.value);
  if (std::isnan(published)) return true;
  if (figure.digits == 0) return value > 0.1 * published && value < 10 * published;
  if (figure.value * figure.published < 0) return false;
  const double unit = std::pow(10, std::floor(std::log10(published)) - (figure.digits - 1));
  return std::abs(value - published) <= 0.5 * unit + 0.01 * published;
}

Finding run(const Cell& cell) {
  try {
    return cell.run();
  } catch (const Error& error) {
    return {Outcome::refused, {}, error.what()};
  }
}

StabilityCell run(const Scene& scene, const Cell& cell) {
  const Finding finding = run(cell);
  StabilityCell out{.scene = scene.id,
                    .title = scene.title,
                    .method = cell.role == Role::ours ? "ours: " + cell.method : cell.method,
                    .outcome = finding.outcome,
                    .largest_stable_step = finding.largest_stable_step,
                    .why = finding.why};
  for (std::size_t i = 0; i < finding.figures.size(); ++i) {
    const Figure& f = finding.figures[i];
    if (i == 0) {
      out.measure = f.what, out.value = f.value;
    } else {
      out.more += (out.more.empty() ? "" : "; ") + f.what + ": " + short_number(f.value);
    }
  }
  return out;
}

Outcome judged(double detector, double limit, double unbounded) {
  if (!std::isfinite(detector) || std::abs(detector) > unbounded) return Outcome::unstable;
  return std::abs(detector) <= limit ? Outcome::converged : Outcome::inaccurate;
}

}  // namespace lithe::lab
