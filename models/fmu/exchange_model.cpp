#include "models/fmu/exchange_model_internal.h"

#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr int kMostUpdates = 1000;  // of the discrete states at one event

std::vector<unsigned> joined(std::vector<unsigned> a, const std::vector<unsigned>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

ExchangeModel::ExchangeModel(FmuLibrary& library, const FmuContents& contents, Connected connected)
    : library_(library),
      two_(contents.version == 2),
      connected_(std::move(connected)),
      knowns_(joined(contents.states, connected_.inputs)),
      unknowns_(joined(contents.derivatives, connected_.outputs)) {
  const std::string prefix = two_ ? "fmi2" : "fmi3";
  enter_event_mode_.name = prefix + "EnterEventMode";
  enter_continuous_time_.name = prefix + "EnterContinuousTimeMode";
  set_time_.name = prefix + "SetTime";
  set_states_.name = prefix + "SetContinuousStates";
  states_.name = prefix + "GetContinuousStates";
  derivatives_.name = prefix + (two_ ? "GetDerivatives" : "GetContinuousStateDerivatives");
  indicators_.name = prefix + "GetEventIndicators";
}

ExchangeModel::Event ExchangeModel::begin() {
  Event out;
  for (int update = 0;; ++update) {
    if (update == kMostUpdates)
      throw SimulationError("the FMU's discrete states do not settle.", "", "look at its inputs and parameters.");
    bool again = false, terminate = false, nominals = false, changed = false, has_next = false;
    double next = 0;
    if (two_) {
      EventInfo2 info{};
      library_.call(update2_, &info);
      again = info.again, terminate = info.terminate, changed = info.states_changed;
      has_next = info.has_next, next = info.next;
    } else {
      library_.call(update3_, &again, &terminate, &nominals, &changed, &has_next, &next);
    }
    if (terminate) library_.messages().ends_simulation();
    out.states_changed |= changed;
    out.next = has_next ? std::optional(next) : std::nullopt;
    if (!again) break;
  }
  library_.call(enter_continuous_time_);
  return out;
}

ExchangeModel::Event ExchangeModel::handle_event() {
  library_.call(enter_event_mode_);
  return begin();
}

bool ExchangeModel::complete_step() {
  bool event = false, terminate = false;
  if (two_) {
    int event2 = 0, terminate2 = 0;
    library_.call(complete2_, 1, &event2, &terminate2);
    event = event2 != 0, terminate = terminate2 != 0;
  } else {
    library_.call(complete3_, true, &event, &terminate);
  }
  if (terminate) library_.messages().ends_simulation();
  return event;
}

bool ExchangeModel::move_to(double time, std::span<const double> states, std::span<const double> inputs) {
  if (!library_.try_call(set_time_, time)) return false;
  if (!states.empty() && !library_.try_call(set_states_, states.data(), states.size())) return false;
  return set_inputs(inputs);
}

bool ExchangeModel::set_inputs(std::span<const double> inputs) {
  const std::vector<unsigned>& to = connected_.inputs;
  if (to.empty()) return true;
  return two_ ? library_.try_call(set2_, to.data(), to.size(), inputs.data())
              : library_.try_call(set3_, to.data(), to.size(), inputs.data(), inputs.size());
}

bool ExchangeModel::get_outputs(std::span<double> out) {
  const std::vector<unsigned>& from = connected_.outputs;
  return two_ ? library_.try_call(get2_, from.data(), from.size(), out.data())
              : library_.try_call(get3_, from.data(), from.size(), out.data(), out.size());
}

void ExchangeModel::differentiate(std::span<const double> seed, std::span<double> out) {
  if (two_)
    library_.call(differentiate2_, unknowns_.data(), unknowns_.size(), knowns_.data(), knowns_.size(), seed.data(),
                  out.data());
  else
    library_.call(differentiate3_, unknowns_.data(), unknowns_.size(), knowns_.data(), knowns_.size(), seed.data(),
                  seed.size(), out.data(), out.size());
}

}  // namespace lithe
