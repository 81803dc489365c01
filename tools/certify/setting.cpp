#include "tools/certify/setting.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "engine/base/error.h"
#include "engine/study/certificate.h"
#include "integrators/automatic.h"
#include "integrators/generalized_alpha.h"

namespace lithe::certify {

std::string text(const Setting& setting) {
  const Model& m = setting.model;
  const std::string count = m.modes == FlexibleBody::kAll ? "all" : std::to_string(m.modes);
  const std::string model = m.deflection == Deflection::exact ? std::to_string(m.elements) + " exact elements"
                            : m.modes == 0                    ? "rigid"
                                           : count + (m.modes == 1 ? " mode, " : " modes, ") + to_string(m.deflection);
  char value[64];
  std::snprintf(value, sizeof value,
                setting.fixed_step ? "generalized-alpha, step %.3g s" : "automatic, tolerance %.3g", setting.value);
  return model + "; " + value;
}

nlohmann::json described(const Setting& setting) {
  nlohmann::json j = {{"deflection", to_string(setting.model.deflection)}};
  j["modes"] = setting.model.modes == FlexibleBody::kAll ? nlohmann::json("all") : nlohmann::json(setting.model.modes);
  if (setting.model.elements > 0) j["elements"] = setting.model.elements;
  j[setting.fixed_step ? "step" : "tolerance"] = setting.value;
  return j;
}

Setting read_setting(const nlohmann::json& json) {
  Setting setting{.model = {.elements = json.value("elements", 0)}, .fixed_step = json.contains("step")};
  const nlohmann::json& modes = json.at("modes");
  setting.model.modes = modes.is_string() ? FlexibleBody::kAll : modes.get<int>();
  for (Deflection d : {Deflection::linear, Deflection::stiffened, Deflection::quadratic, Deflection::exact})
    if (to_string(d) == json.at("deflection").get<std::string>()) setting.model.deflection = d;
  setting.value = json.at(setting.fixed_step ? "step" : "tolerance");
  return setting;
}

Outcome run_setting(const Scene& scene, ElasticParts& parts, const Setting& setting, const Table& reference) {
  parts.mode_count = setting.model.modes;
  parts.deflection = setting.model.deflection;
  parts.elements = setting.model.elements;
  Outcome outcome;
  try {
    std::unique_ptr<Integrator> integrator;
    if (setting.fixed_step)
      integrator = std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = setting.value});
    else
      integrator =
          std::make_unique<Automatic>(Automatic::Parameters{.tolerance = {setting.value, 0.01 * setting.value}});
    const Sampled sampled = run(scene, parts, *integrator);
    outcome.cpu = sampled.cpu;
    outcome.errors = deviations(sampled.watched, sampled.table, reference);
    outcome.error = *std::max_element(outcome.errors.begin(), outcome.errors.end());
  } catch (const Error&) {  // a model that breaks down, a step too long: not what one would choose
  }
  return outcome;
}

}  // namespace lithe::certify
