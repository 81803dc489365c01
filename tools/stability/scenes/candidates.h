#pragma once

#include <functional>
#include <string>
#include <type_traits>
#include <vector>

#include "integrators/adams.h"
#include "integrators/automatic.h"
#include "integrators/hht.h"
#include "integrators/lie_bdf.h"
#include "integrators/linearly_implicit.h"
#include "integrators/radau.h"
#include "integrators/rattle.h"
#include "tools/stability/lab.h"
#include "tools/stability/scenes/ours.h"

/// The library's methods as cells of a scene: the default must pass wherever any method passes, the others are shown.
namespace lithe::lab {

struct Candidate {
  std::string name;
  std::function<Method()> make;
  Role role = Role::also;
};

inline std::string figure_text(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

inline Candidate automatic(double tolerance) {
  return {"default (automatic, tolerance " + figure_text(tolerance) + ")",
          [tolerance] {
            Automatic::Parameters parameters;
            parameters.tolerance = {.relative = tolerance, .absolute = tolerance};
            return std::make_unique<Automatic>(parameters);
          },
          Role::ours};
}
inline Candidate runge_kutta8(double tolerance) {
  return {"explicit Runge-Kutta 8(5,3), tolerance " + figure_text(tolerance), [tolerance] {
            return std::make_unique<ExplicitRungeKutta>(
                ExplicitRungeKutta::Parameters{.method = ExplicitRungeKutta::Method::dormand_prince8,
                                               .tolerance = {.relative = tolerance, .absolute = tolerance}});
          }};
}
inline Candidate runge_kutta5(double tolerance) {
  return {"explicit Runge-Kutta 5(4), tolerance " + figure_text(tolerance),
          [tolerance] { return runge_kutta(tolerance); }};
}
template <class Type>
Candidate of_tolerance(const std::string& name, double tolerance) {
  return {name + ", tolerance " + figure_text(tolerance), [tolerance] {
            typename Type::Parameters parameters;
            parameters.tolerance = {.relative = tolerance, .absolute = tolerance};
            return std::make_unique<Type>(parameters);
          }};
}
inline Candidate radau(double tolerance) { return of_tolerance<Radau>("Radau IIA, order 5", tolerance); }
inline Candidate lie_bdf(double tolerance) { return of_tolerance<LieBdf>("BDF, stabilized index 2", tolerance); }
inline Candidate adams(double tolerance) { return of_tolerance<Adams>("Adams", tolerance); }

template <class Type>
Candidate of_step(const std::string& name, double step) {
  return {name + ", h = " + figure_text(step), [step] {
            typename Type::Parameters parameters;
            parameters.step = step;
            return std::make_unique<Type>(parameters);
          }};
}
inline Candidate alpha(double step, double spectral_radius = 0.8,
                       GeneralizedAlpha::Form form = GeneralizedAlpha::Form::index3) {
  const bool index3 = form == GeneralizedAlpha::Form::index3;
  return {std::string("generalized-alpha, ") + (index3 ? "index 3" : "index 2") +
              ", rho = " + figure_text(spectral_radius) + ", h = " + figure_text(step),
          [step, spectral_radius, form] {
            return std::make_unique<GeneralizedAlpha>(
                GeneralizedAlpha::Parameters{.step = step, .spectral_radius = spectral_radius, .form = form});
          }};
}
inline Candidate hht(double step) { return of_step<Hht>("HHT, alpha = -0.05", step); }
inline Candidate rattle(double step) { return of_step<Rattle>("RATTLE", step); }
inline Candidate linearly_implicit(double step) {
  return of_step<LinearlyImplicit>("linearly implicit Euler (real time)", step);
}

/// A cell for each, judged by `judge(integrator)`.
template <class Judge>
void add_candidates(Scene& scene, const std::vector<Candidate>& candidates, Judge judge) {
  for (const Candidate& c : candidates)
    scene.cells.push_back({c.name,
                           [make = c.make, judge] {
                             const Method method = make();
                             return judge(*method);
                           },
                           c.role});
}

/// A scene on which every method of the engine is tried too; the judge is given one, or what makes as many as it needs.
template <class Judge>
Scene under_every_method(Scene scene, const Settings& settings, Judge judge) {
  if constexpr (std::is_invocable_v<Judge, Integrator&>)
    scene.judge = [judge](const std::function<Method()>& make) { return judge(*make()); };
  else
    scene.judge = judge;
  scene.settings = settings;
  return scene;
}

/// A scene of published cells and the library's methods on it, those chosen and all with the same settings.
template <class Judge>
Scene with_candidates(Scene scene, const std::vector<Candidate>& candidates, const Settings& settings, Judge judge) {
  add_candidates(scene, candidates, judge);
  return under_every_method(std::move(scene), settings, judge);
}

}  // namespace lithe::lab
