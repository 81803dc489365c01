#include "engine/study/solve_internal.h"

#include <algorithm>
#include <numeric>
#include <sstream>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/model/contact_element.h"
#include "engine/model/islands.h"
#include "engine/simplify/simplification.h"
#include "engine/study/study_run.h"

namespace lithe {

Solver::Solver(SystemGraph& graph, double duration, const std::vector<Want>& wants, const SolveMethods& methods,
               const SolveOptions& options)
    : graph_(graph), duration_(duration), wants_(wants), methods_(methods), options_(options), bodies_(graph) {
  if (wants.empty()) throw SceneError("nothing is wanted", "solve", "say what: want(position(tip), percent(1))");
  if (!(duration > 0) || !std::isfinite(duration))
    throw SceneError("the duration is " + short_number(duration) + " s", "solve", "give a positive time");
  if (options.samples < 4 || options.most_runs < 1)
    throw SceneError("solve needs at least 4 samples and one run", "solve", "give more");
  for (const Want& w : wants) sensors_.push_back(w.sensor);
  for (DeformableBody* body : bodies_.bodies()) body->body_frame();
  look_at_contacts();
  finer_ = std::max(1, (kFewestSamples + options.samples - 1) / options.samples);
  for (int stride = 2; samples() / stride >= kLooks; ++stride)
    if (samples() % stride == 0) stride_ = stride;
}

/// Impulses are not for the methods that a certificate rests on; what a force does to modes is looked at by samples.
void Solver::look_at_contacts() {
  for (const auto& entry : graph_.forces()) {
    const auto* contact = dynamic_cast<const ContactElement*>(entry.force);
    if (!contact || contact->law() == ContactElement::Law::sensing) continue;
    if (contact->law() == ContactElement::Law::rigid)
      throw SceneError("solve() certifies smooth motion, and '" + contact->name() + "' has rigid surfaces",
                       contact->where(),
                       "give it a Compliance law, or run the scene with MoreauJean or NonsmoothGeneralizedAlpha");
    const auto touches = [&](const DeformableBody* body) {
      return std::any_of(entry.markers.begin(), entry.markers.end(), [&](const Marker& m) { return m.body == body; });
    };
    for (const DeformableBody* body : bodies_.bodies())
      if (touches(body))
        remarks_.push_back("'" + contact->name() + "' touches '" + body->name() +
                           "': what impacts between two samples do to its modes is not in the statement");
  }
}

Solution Solver::solve() {
  begun_ = thread_seconds();
  if (options_.simplify) simplify();
  look_at_rigid();
  std::vector<Fidelity> models = first_choice();
  if (is_rigid(models) && rigid_.reached()) {
    accept_rigid();
  } else {
    refine(std::move(models));
  }
  return finish();
}

RunRequest Solver::request(double tolerance, bool dynamics) const {
  return {duration_, samples(), {tolerance, std::min(1e-2, 0.1 * elastic_scale_) * tolerance}, simplify_, dynamics};
}

/// Whether the graph can be simplified, and how: runs do it then.
void Solver::simplify() {
  Simplification simple(graph_);
  const std::size_t islands = split(simple.graph()).size();
  simplify_ = simple.smaller() || islands > 1;
  std::istringstream lines(simple.report());
  for (std::string line; std::getline(lines, line);) simplification_.push_back(line);
  if (islands > 1) simplification_.push_back(std::to_string(islands) + " islands have steps of their own");
}

// ---- 1. rigid bodies, and what deformation would do ----

void Solver::look_at_rigid() {
  tolerance_ = kFirstTolerance;
  rigid_ = run(bodies_.rigid(), tolerance_, true);
  if (!rigid_.reached()) return;
  if (bodies_.count() > 0) {
    linear_ = model_error(graph_, bodies_, rigid_, bodies_.all(), Missing::modes, sensors_);
    const ModelRun corrected = run_model(graph_, bodies_, bodies_.rigid(), sensors_, methods_.by_tolerance,
                                         request(tolerance_, true), linear_.feedback);
    predicted_ = corrected.reached()
                     ? with_response(graph_, bodies_, corrected, bodies_.all(), linear_.response, sensors_)
                     : rigid_;
    if (corrected.reached()) corrected_ = corrected;
  } else {
    predicted_ = rigid_;
  }
  change_ = sample_changes(sensors_, predicted_.samples);
  double amplitude = 0;
  for (const auto& c : linear_.coordinates) amplitude = std::max(amplitude, c.amplitude);
  if (amplitude > 0) elastic_scale_ = amplitude;
  deformation_ = sample_differences(sensors_, predicted_.samples, rigid_.samples);
  set_bounds();
  amplification_.assign(count(), 1);
  for (std::size_t w = 0; w < count(); ++w)
    if (bodies_.count() > 0 && linear_.effect[w] > 0)
      amplification_[w] = std::max(1.0, deformation_[w] / linear_.effect[w]);
  find_tolerance();
}

void Solver::set_bounds() {
  bounds_.resize(count());
  for (std::size_t w = 0; w < count(); ++w) {
    const Precision& p = wants_[w].precision;
    bounds_[w] = p.relative ? p.value * std::max(change_[w], round_off(w)) : p.value;
  }
}

/// Of a quantity, far above what it changes by when it does not change.
double Solver::round_off(std::size_t w) const {
  const Table& samples = answer_.samples.values.empty() ? rigid_.samples : answer_.samples;
  int column = 1;
  for (std::size_t s = 0; s < w; ++s) column += static_cast<int>(sensors_[s].columns().size());
  double size = 1;
  for (std::size_t i = 0; i < sensors_[w].columns().size(); ++i)
    size = std::max(size, std::abs(samples.at(0, column + static_cast<int>(i))));
  return 1e-9 * size;
}

/// Two rigid runs tell what a tolerance is worth here.
void Solver::find_tolerance() {
  const double scale = std::exchange(elastic_scale_, 1);
  const ModelRun tighter = run(bodies_.rigid(), tolerance_ / 10, false);
  elastic_scale_ = scale;
  time_worth_.assign(count(), 0);
  if (!tighter.reached()) {
    time_worth_ = change_;  // what a tolerance is worth is not known
    return;
  }
  const auto difference = sample_differences(sensors_, tighter.samples, rigid_.samples);
  for (std::size_t w = 0; w < count(); ++w) time_worth_[w] = difference[w] / tolerance_;
  tighter_ = tighter;
  double tolerance = kLoosest;
  for (std::size_t w = 0; w < count(); ++w) {
    const double worth = time_worth_[w] + deformation_[w];
    if (worth > 0) tolerance = std::min(tolerance, kTimeShare * bounds_[w] / worth);
  }
  if (is_rough()) tolerance = std::min(tolerance, kTimeShare * kLoosest);
  tolerance_ = std::max(tolerance, kTightest);
}

double Solver::time_worth(std::size_t w) const {
  const bool implicit = 10 * answer_.statistics.newton_iterations > answer_.statistics.steps;
  return (time_worth_.empty() ? change_[w] : time_worth_[w]) +
         (implicit ? kImplicitTime : kExplicitTime) * deformation(w);
}

// ---- 2. which modes, which order ----

double Solver::severity(const ModelError::Coordinate& c) const {
  double most = 0;
  for (std::size_t w = 0; w < count(); ++w) most = std::max(most, amplification_[w] * c.effect[w] / bounds_[w]);
  return most;
}

std::vector<Fidelity> Solver::first_choice() {
  if (!rigid_.reached()) return fallback();
  if (bodies_.count() == 0) return {};
  effects_ = linear_.coordinates;
  const bool rigid_does = [&] {
    for (std::size_t w = 0; w < count(); ++w)
      if (!(kPredicted * deformation_[w] < kRigidShare * bounds_[w])) return false;
    return true;
  }();
  if (rigid_does) return bodies_.rigid();
  linear_ = model_error(graph_, bodies_, rigid_, bodies_.all(), Missing::modes, sensors_, stride_, Detail::each);
  effects_ = linear_.coordinates;
  double share = kModesShare;
  std::vector<Fidelity> models = with_modes(share);
  first_ = model_error(graph_, bodies_, rigid_, models, Missing::modes, sensors_, stride_);
  // Modes that are left out make the body stiffer: the rest of them together may do less than their sum.
  for (int round = 0; round < kMostChoices && !close_to_all(); ++round) {
    const auto before = models;
    while (models == before && share > kNoShare) models = with_modes(share /= 4);
    if (models == before) break;
    first_ = model_error(graph_, bodies_, rigid_, models, Missing::modes, sensors_, stride_);
  }
  add_second_order(models);
  return models;
}

bool Solver::close_to_all() const {
  const auto difference = sample_differences(sensors_, first_.samples, linear_.samples);
  for (std::size_t w = 0; w < count(); ++w)
    if (!(amplification_[w] * difference[w] < kModesShare * bounds_[w])) return false;
  return true;
}

/// The smallest effects stay out while they sum to less than the share.
std::vector<Fidelity> Solver::with_modes(double share) const {
  std::vector<std::size_t> order(effects_.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return severity(effects_[a]) < severity(effects_[b]); });
  std::vector<Fidelity> models = bodies_.rigid();
  double sum = 0;
  for (std::size_t i : order) {
    const auto& c = effects_[i];
    sum += severity(c);
    if (sum > share) models[static_cast<std::size_t>(c.body)].modes.push_back(c.mode);
  }
  for (Fidelity& m : models) std::sort(m.modes.begin(), m.modes.end());
  return models;
}

/// From the motion predicted with the first-order modes: what the second order makes of it.
void Solver::add_second_order(std::vector<Fidelity>& models) {
  second_order_.assign(count(), 0), fourth_order_.assign(count(), 0);
  if (is_rigid(models) || !corrected_ || finest() == Deflection::linear) return;
  const ModelRun bent = with_response(graph_, bodies_, *corrected_, models, first_.response, sensors_);
  const auto own = own_remainders(graph_, bodies_, bent);
  const ModelError stiffened = model_error(graph_, bodies_, bent, deflected(models, Deflection::stiffened),
                                           Missing::all, sensors_, stride_, Detail::whole, own);
  second_order_ = stiffened.effect;
  if (finest() == Deflection::quadratic) {
    const ModelError quadratic = model_error(graph_, bodies_, bent, deflected(models, Deflection::quadratic),
                                             Missing::all, sensors_, stride_, Detail::whole, own);
    fourth_order_ = sample_differences(sensors_, quadratic.samples, stiffened.samples);
  }
  if (counts(second_order_)) {
    double error = 0;
    for (std::size_t w = 0; w < count(); ++w) error = std::max(error, kCaution * second_order_[w] / bounds_[w]);
    trials_.push_back({model_text(bodies_, models), 0, false, error, 0});
    models = deflected(models, Deflection::stiffened);
  }
  if (counts(fourth_order_)) models = deflected(models, Deflection::quadratic);
}

bool Solver::counts(const std::vector<double>& effect) const {
  for (std::size_t w = 0; w < count(); ++w)
    if (!(kCaution * effect[w] < kSecondOrder * bounds_[w])) return true;
  return false;
}

Deflection Solver::finest() const {
  Deflection finest = Deflection::linear;
  for (const DeformableBody* body : bodies_.bodies()) finest = std::max(finest, body->finest_deflection());
  return finest;
}

std::vector<Fidelity> Solver::deflected(std::vector<Fidelity> models, Deflection deflection) const {
  for (std::size_t b = 0; b < models.size(); ++b)
    if (!models[b].modes.empty()) models[b].deflection = std::min(deflection, bodies_.bodies()[b]->finest_deflection());
  return models;
}

Deflection Solver::order_of(const std::vector<Fidelity>& models) {
  Deflection order = Deflection::linear;
  for (const Fidelity& m : models) order = std::max(order, m.deflection);
  return order;
}

/// Rigid bodies could not move as the scene asks: all modes.
std::vector<Fidelity> Solver::fallback() {
  remarks_.push_back("with rigid bodies the run fails: " + rigid_.why);
  amplification_.assign(count(), 1);
  second_order_.assign(count(), 0), fourth_order_.assign(count(), 0);
  return bodies_.all();
}

// ---- the sheet ----

ModelRun Solver::run(const std::vector<Fidelity>& models, double tolerance, bool dynamics) {
  ModelRun r = run_model(graph_, bodies_, models, sensors_, methods_.by_tolerance, request(tolerance, dynamics));
  log::debug("solve: " + model_text(bodies_, models) + ", tolerance " + short_number(tolerance) + ": " +
             duration_text(r.cost) + (r.reached() ? "" : ", " + r.why));
  return r;
}

namespace {

Precision checked(Precision precision, std::source_location where) {
  if (!(precision.value > 0) || !std::isfinite(precision.value))
    throw SceneError("a precision is " + short_number(precision.value), to_string(where),
                     "give a positive number: percent(1), within(1e-3)");
  return precision;
}

}  // namespace

Precision percent(double value, std::source_location where) { return checked({value / 100, true}, where); }
Precision within(double bound, std::source_location where) { return checked({bound, false}, where); }

Solution solve(SystemGraph& graph, double duration, const std::vector<Want>& wants, const SolveMethods& methods,
               const SolveOptions& options) {
  return Solver(graph, duration, wants, methods, options).solve();
}

}  // namespace lithe
