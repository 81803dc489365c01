#include "tools/stability/lab.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/study/study_run.h"
#include "integrators/catalogue.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "tools/stability/methods/limited.h"

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

namespace {

StabilityCell described(const Scene& scene, const std::string& method, const Finding& finding) {
  StabilityCell out{.scene = scene.id,
                    .title = scene.title,
                    .method = method,
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

constexpr double kTimeLimit = 10;  // s of CPU

}  // namespace

StabilityCell run(const Scene& scene, const Cell& cell) {
  return described(scene, cell.role == Role::ours ? "ours: " + cell.method : cell.method, run(cell));
}

std::vector<StudyMethod> methods_of_the_engine() {
  std::vector<StudyMethod> all = standard_methods();
  const auto by_step = [&]<class Method>(const std::string& name, std::type_identity<Method>) {
    all.push_back({name, StudyMethod::Setting::step, [](double step) -> std::unique_ptr<Integrator> {
                     return std::make_unique<Method>(typename Method::Parameters{.step = step});
                   }});
  };
  by_step("Moreau-Jean", std::type_identity<MoreauJean>());
  by_step("nonsmooth generalized-alpha", std::type_identity<NonsmoothGeneralizedAlpha>());
  return all;
}

StabilityCell run(const Scene& scene, const StudyMethod& method) {
  const double setting = method.setting == StudyMethod::Setting::step ? scene.settings.step : scene.settings.tolerance;
  bool expired = false;
  const double end = thread_seconds() + kTimeLimit;
  Finding finding =
      run({method.name,
           [&] { return scene.judge([&] { return std::make_unique<Limited>(method.make(setting), end, expired); }); }});
  if (expired)
    finding.outcome = Outcome::unstable, finding.why = "it takes more than ten seconds of CPU: its step collapses";
  StabilityCell out = described(scene, method.name + ", " + setting_text(method.setting, setting), finding);
  out.column = method.name;
  return out;
}

Outcome judged(double detector, double limit, double unbounded) {
  if (!std::isfinite(detector) || std::abs(detector) > unbounded) return Outcome::unstable;
  return std::abs(detector) <= limit ? Outcome::converged : Outcome::inaccurate;
}

}  // namespace lithe::lab
