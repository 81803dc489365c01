#include "models/fmu/exchange_equations_internal.h"

#include <cmath>

#include "engine/archive/archive.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/observe/observer_schedules.h"

namespace lithe {
namespace {

constexpr int kMostEvents = 1000;  // at one time
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// But for round-off of times: an FMU compares its own time with that of the event.
bool is_due(double event, double time) { return event <= time + time_round_off(time); }

std::span<double> span_of(VectorX& x) { return {x.data(), static_cast<std::size_t>(x.size())}; }

}  // namespace

/// What the FMU fails at names the FMU and the time; then it is not called again.
template <class Work>
decltype(auto) ExchangeEquations::guarded(double time, Work&& work) {
  const auto refuse = [&](const std::string& problem, const std::string& fix) {
    throw SimulationError(problem, "FMU '" + file_->name() + "', " + time_text(time), fix);
  };
  if (run_.begun && !run_.library)
    refuse("the FMU failed before and cannot go on.",
           "call its reset() and run again from the start, or resume a checkpoint.");
  if (run_.begun && time < run_.since)
    refuse("the FMU has passed an event at " + time_text(run_.since) + ", and what held before is gone.",
           "call its reset() before a run that starts anew; look at states before the event as the run comes by.");
  if (!joined_ && time > run_.since)
    refuse("nobody looks for the FMU's events.", "call its join(simulation) before the run.");
  try {
    return work();
  } catch (const SimulationError& error) {
    run_.model.reset();
    run_.library.reset();
    at_time_ = kNone;
    throw SimulationError(error.problem(), "FMU '" + file_->name() + "', " + time_text(time), error.fix());
  }
}

ExchangeEquations::ExchangeEquations(std::unique_ptr<const FmuFile> file, Parameters parameters)
    : file_(std::move(file)), p_(std::move(parameters)) {
  const int n = state_count(), rates = n + p_.output_count, known = n + input_count();
  z = initial_states_ = VectorX::Zero(n);
  u = p_.inputs;
  rates_.setZero(rates), plus_.setZero(rates), seed_.setZero(known), jacobian_.setZero(rates, known);
  indicators_.setZero(file_->contents().indicator_count);
  guarded(0, [&] { initialize(0); });
  if (n > 0) run_.model->get_states(span_of(initial_states_));
  z = initial_states_;
}

void ExchangeEquations::initialize(double time) {
  run_.model.reset();
  run_.library.reset();  // some binaries allow one instance at a time
  run_.library = file_->make_instance();
  run_.model = std::make_unique<ExchangeModel>(*run_.library, file_->contents(), p_.connected);
  for (const auto& [name, value] : p_.values) run_.library->set(file_->find_parameter(name, value), value);
  run_.library->enter_initialization(time);
  if (!run_.model->set_inputs(span_of(u)))
    throw SimulationError("the FMU discards its first inputs.", "", "look at the scene's first state.");
  run_.library->exit_initialization();
  settle(run_.model->begin(), time);
  run_.first_u = u;
}

/// What an event, or the first, leaves; an FMU that wants another at once has it.
bool ExchangeEquations::settle(ExchangeModel::Event event, double time) {
  bool changed = event.states_changed;
  for (int more = 0; event.next && is_due(*event.next, time); ++more) {
    if (more == kMostEvents)
      throw SimulationError("the FMU names time events that have passed.", "", "look at its inputs and parameters.");
    run_.model->set_time(std::max(time, *event.next));
    event = run_.model->handle_event();
    changed |= event.states_changed;
  }
  run_.next = event.next;
  run_.since = time;
  at_time_ = kNone;
  return changed;
}

/// Makes the instance fit for being evaluated at this time.
void ExchangeEquations::prepare(double time) {
  if (!run_.library || (!run_.begun && (time < run_.since || (time == run_.since && u != run_.first_u))))
    initialize(time);
}

/// Brings the FMU to (t, z, u), unless it stands there; false: it discards them.
bool ExchangeEquations::move_to(double time) {
  if (time == at_time_ && z == at_z_ && u == at_u_) return accepted_;
  at_time_ = kNone, has_rates_ = has_indicators_ = false;
  accepted_ = run_.model->move_to(time, span_of(z), span_of(u));
  at_time_ = time, at_z_ = z, at_u_ = u;
  return accepted_;
}

const VectorX& ExchangeEquations::rates_at(double time) {
  const bool accepted = move_to(time);
  if (has_rates_) return rates_;
  const auto n = static_cast<std::size_t>(state_count());
  const std::span<double> all = span_of(rates_);
  if (!accepted || (n > 0 && !run_.model->get_derivatives(all.first(n))) ||
      (all.size() > n && !run_.model->get_outputs(all.subspan(n))))
    rates_.setConstant(kNone);
  has_rates_ = true;
  return rates_;
}

const VectorX& ExchangeEquations::rates(double time) {
  return guarded(time, [&]() -> const VectorX& {
    prepare(time);
    return rates_at(time);
  });
}

const VectorX& ExchangeEquations::indicators(double time) {
  return guarded(time, [&]() -> const VectorX& {
    prepare(time);
    const bool accepted = move_to(time);
    if (!has_indicators_ && (!accepted || !run_.model->get_indicators(span_of(indicators_))))
      indicators_.setConstant(kNone);
    has_indicators_ = true;
    return indicators_;
  });
}

double ExchangeEquations::value(double time, const std::string& name, const FmuNumber& number) {
  return guarded(time, [&] {
    prepare(time);
    move_to(time);
    return file_->checked(name, run_.library->get(number));
  });
}

const MatrixX& ExchangeEquations::jacobian(double time) {
  return guarded(time, [&]() -> const MatrixX& {
    prepare(time);
    const int n = state_count();
    for (int k = 0; k < jacobian_.cols(); ++k) {
      if (p_.differentiable && file_->contents().differentiates) {
        move_to(time);
        seed_.setZero();
        seed_[k] = 1;
        run_.model->differentiate(span_of(seed_), span_of(plus_));
        jacobian_.col(k) = plus_;
        continue;
      }
      double& x = k < n ? z[k] : u[k - n];
      const double kept = x, h = std::cbrt(std::numeric_limits<double>::epsilon()) * std::max(1.0, std::abs(kept));
      x = kept + h;
      plus_ = rates_at(time);
      x = kept - h;
      jacobian_.col(k) = (plus_ - rates_at(time)) / (2 * h);
      x = kept;
    }
    return jacobian_;
  });
}

void ExchangeEquations::reset() {
  run_ = {};
  at_time_ = kNone;
}

void ExchangeEquations::set_as_drawn(bool drawn) {
  if (drawn) kept_ = std::move(run_);
  run_ = drawn ? Run{} : std::move(*kept_);
  at_time_ = kNone;
}

void ExchangeEquations::see(double time) {
  if (run_.begun && time == run_.seen) return;
  guarded(time, [&] {
    if (run_.begun && time < run_.seen) reset();  // the run starts anew, before any event
    const bool first = !run_.begun;
    prepare(time);
    if (!first && run_.next && !is_due(time, *run_.next))
      throw SimulationError("a time event of the FMU has been passed by: " + time_text(*run_.next) + ".", "",
                            "take shorter steps.");
    run_.begun = true;
    run_.seen = time;
    if (first || time == run_.since || !file_->contents().completes_steps) return;
    move_to(time);
    if (run_.model->complete_step()) run_.next = time;
    at_time_ = kNone;
  });
}

void ExchangeEquations::handle_event(double time) {
  guarded(time, [&] {
    if (time == run_.since) return;
    move_to(run_.next && is_due(*run_.next, time) ? std::max(time, *run_.next) : time);
    if (file_->contents().completes_steps) run_.model->complete_step();
    if (settle(run_.model->handle_event(), time)) run_.model->get_states(span_of(z));
    for (int i = 0; i < z.size(); ++i) file_->checked("state " + std::to_string(i + 1), z[i]);
  });
}

double ExchangeEquations::until_time_event(double time) const {
  // Zero at the last event too, and positive after it: the next may come at any time.
  return run_.next ? (time - run_.since) * (*run_.next - time) / (*run_.next - run_.since) : 1;
}

void ExchangeEquations::history(Archive& archive) {
  bool has_next = run_.next.has_value();
  double next = run_.next.value_or(0);
  archive("begun", run_.begun);
  archive("since", run_.since);
  archive("seen", run_.seen);
  archive("has_next", has_next);
  archive("next", next);
  if (archive.loads()) run_.model.reset();
  file_->history(archive, run_.library, run_.begun);
  if (!archive.loads()) return;
  run_.next = has_next ? std::optional(next) : std::nullopt;
  at_time_ = kNone;
  if (run_.begun)
    run_.model = std::make_unique<ExchangeModel>(*run_.library, file_->contents(), p_.connected);
  else
    run_.library.reset();  // initialized with the first state
}

}  // namespace lithe
