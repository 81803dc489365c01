#include "engine/study/solve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <sstream>
#include <utility>

#include "engine/error.h"
#include "engine/islands.h"
#include "engine/log.h"
#include "engine/simplification.h"
#include "engine/study/model_error.h"
#include "engine/study/study_run.h"

namespace lithe {
namespace {

// Shares of what is allowed, in the choice: what is stated in the end is estimated along the answer itself.
constexpr double kModesShare = 0.25;  // of all modes that are left out, together
constexpr double kSecondOrder = 0.6;  // of the second order, if it is left out
constexpr double kTimeShare = 0.1;
constexpr double kRigidShare = 0.95;  // of all deformation, for rigid bodies to do

// Estimates are of the first order: what is stated is so much more.
constexpr double kCaution = 2.5;
constexpr double kPredicted = 2;  // of the change by all deformation, feedback included
constexpr double kFirstTolerance = 1e-3, kLoosest = 1e-2, kTightest = 1e-9;
// Error of elastic motion over tolerance times motion, of explicit methods and of implicit ones.
constexpr double kExplicitTime = 0.5, kImplicitTime = 1.5;
constexpr double kRoundOff = 1e-3;  // of what round_off() takes for a change
constexpr double kNoShare = 1e-9;   // modes below this part of what is allowed are idle
constexpr int kMostChoices = 6, kLooks = 25, kFewestSamples = 100;
// Error of the finer of two runs of a method of second order over their difference, a third, with caution; and what may
// be of it.
constexpr double kStepsLeft = 0.6, kStepsShare = 0.4;
constexpr double kCoarse = 3e-3;  // of a change: what is wanted better is not tried so
constexpr double kRoughTime =
    0.3;  // error of reactions and accelerations over their change by a tolerance ten times looser
constexpr double kCandidates = 5e-4;      // of what deformation does, beyond the candidate modes
constexpr double kFieldsLeftOut = 0.004;  // of the second order, by make_basis() (Reduction::deflection_tolerance)

double infinity() { return std::numeric_limits<double>::infinity(); }

class Solver {
 public:
  Solver(SystemGraph& graph, double duration, const std::vector<Want>& wants, const SolveMethods& methods,
         const SolveOptions& options)
      : graph_(graph), duration_(duration), wants_(wants), methods_(methods), options_(options), bodies_(graph) {
    if (wants.empty()) throw SceneError("nothing is wanted", "solve", "say what: want(position(tip), percent(1))");
    if (!(duration > 0) || !std::isfinite(duration))
      throw SceneError("the duration is " + short_number(duration) + " s", "solve", "give a positive time");
    if (options.samples < 4 || options.most_runs < 1)
      throw SceneError("solve needs at least 4 samples and one run", "solve", "give more");
    for (const Want& w : wants) sensors_.push_back(w.sensor);
    for (DeformableBody* body : bodies_.bodies()) body->body_frame();
    finer_ = std::max(1, (kFewestSamples + options.samples - 1) / options.samples);
    for (int stride = 2; samples() / stride >= kLooks; ++stride)
      if (samples() % stride == 0) stride_ = stride;
  }

  Solution solve() {
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

 private:
  static bool is_rigid(const std::vector<Fidelity>& models) {
    return std::all_of(models.begin(), models.end(), [](const Fidelity& m) { return m.modes.empty(); });
  }
  RunRequest request(double tolerance, bool dynamics) const {
    return {duration_, samples(), {tolerance, std::min(1e-2, 0.1 * elastic_scale_) * tolerance}, simplify_, dynamics};
  }
  RunRequest rigid_request(bool dynamics) const {
    return {duration_, samples(), {kFirstTolerance, 1e-2 * kFirstTolerance}, simplify_, dynamics};
  }
  std::size_t count() const { return wants_.size(); }
  /// That errors are looked for at: those of the answer, or more.
  int samples() const { return finer_ * options_.samples; }
  double deformation(std::size_t w) const { return deformation_.empty() ? 0 : deformation_[w]; }

  /// Whether the graph can be simplified, and how: runs do it then.
  void simplify() {
    Simplification simple(graph_);
    const std::size_t islands = split(simple.graph()).size();
    simplify_ = simple.smaller() || islands > 1;
    std::istringstream lines(simple.report());
    for (std::string line; std::getline(lines, line);) simplification_.push_back(line);
    if (islands > 1) simplification_.push_back(std::to_string(islands) + " islands have steps of their own");
  }

  // ---- 1. rigid bodies, and what deformation would do ----

  void look_at_rigid() {
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

  void set_bounds() {
    bounds_.resize(count());
    for (std::size_t w = 0; w < count(); ++w) {
      const Precision& p = wants_[w].precision;
      bounds_[w] = p.relative ? p.value * std::max(change_[w], round_off(w)) : p.value;
    }
  }

  /// Of a quantity, far above what it changes by when it does not change.
  double round_off(std::size_t w) const {
    const Table& samples = answer_.samples.values.empty() ? rigid_.samples : answer_.samples;
    int column = 1;
    for (std::size_t s = 0; s < w; ++s) column += static_cast<int>(sensors_[s].columns().size());
    double size = 1;
    for (std::size_t i = 0; i < sensors_[w].columns().size(); ++i)
      size = std::max(size, std::abs(samples.at(0, column + static_cast<int>(i))));
    return 1e-9 * size;
  }

  /// Two rigid runs tell what a tolerance is worth here.
  void find_tolerance() {
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
  bool is_rough() const {
    return !rigid_.reached() || std::find(rigid_.rough.begin(), rigid_.rough.end(), true) != rigid_.rough.end();
  }
  double time_worth(std::size_t w) const {
    const bool implicit = 10 * answer_.statistics.newton_iterations > answer_.statistics.steps;
    return (time_worth_.empty() ? change_[w] : time_worth_[w]) +
           (implicit ? kImplicitTime : kExplicitTime) * deformation(w);
  }

  // ---- 2. which modes, which order ----

  double severity(const ModelError::Coordinate& c) const {
    double most = 0;
    for (std::size_t w = 0; w < count(); ++w) most = std::max(most, amplification_[w] * c.effect[w] / bounds_[w]);
    return most;
  }

  std::vector<Fidelity> first_choice() {
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

  bool close_to_all() const {
    const auto difference = sample_differences(sensors_, first_.samples, linear_.samples);
    for (std::size_t w = 0; w < count(); ++w)
      if (!(amplification_[w] * difference[w] < kModesShare * bounds_[w])) return false;
    return true;
  }

  /// The smallest effects stay out while they sum to less than the share.
  std::vector<Fidelity> with_modes(double share) const {
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
  void add_second_order(std::vector<Fidelity>& models) {
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

  bool counts(const std::vector<double>& effect) const {
    for (std::size_t w = 0; w < count(); ++w)
      if (!(kCaution * effect[w] < kSecondOrder * bounds_[w])) return true;
    return false;
  }
  Deflection finest() const {
    Deflection finest = Deflection::linear;
    for (const DeformableBody* body : bodies_.bodies()) finest = std::max(finest, body->finest_deflection());
    return finest;
  }
  std::vector<Fidelity> deflected(std::vector<Fidelity> models, Deflection deflection) const {
    for (std::size_t b = 0; b < models.size(); ++b)
      if (!models[b].modes.empty())
        models[b].deflection = std::min(deflection, bodies_.bodies()[b]->finest_deflection());
    return models;
  }
  static Deflection order_of(const std::vector<Fidelity>& models) {
    Deflection order = Deflection::linear;
    for (const Fidelity& m : models) order = std::max(order, m.deflection);
    return order;
  }

  /// Rigid bodies could not move as the scene asks: all modes.
  std::vector<Fidelity> fallback() {
    remarks_.push_back("with rigid bodies the run fails: " + rigid_.why);
    amplification_.assign(count(), 1);
    second_order_.assign(count(), 0), fourth_order_.assign(count(), 0);
    return bodies_.all();
  }

  // ---- 3. the answer ----

  void accept_rigid() {
    answer_ = tolerance_ < kFirstTolerance / 10                    ? run(bodies_.rigid(), tolerance_, false)
              : tolerance_ < kFirstTolerance && tighter_.reached() ? tighter_
                                                                   : rigid_;
    if (!answer_.reached()) {
      remarks_.push_back("rigid, tolerance " + short_number(tolerance_) + ": " + answer_.why);
      answer_ = rigid_;
    }
    errors_.assign(count(), {});
    for (std::size_t w = 0; w < count(); ++w) {
      errors_[w].truncation = kPredicted * deformation_[w];
      errors_[w].time = time_worth_[w] * answer_.tolerance.relative;
      errors_[w].solver = answer_.residual + kRoundOff * round_off(w);
    }
    note_trial(answer_, largest_part());
    chosen_ = static_cast<int>(trials_.size()) - 1;
  }

  void refine(std::vector<Fidelity> models) {
    double share = kModesShare;
    std::optional<ModelRun> good;  // the last that reached the end
    std::vector<StatedError> good_errors;
    for (int round = 0; round < options_.most_runs; ++round) {
      const bool stepped = (step_ > 0 || round == 0) && try_steps(models);
      if (!stepped) answer_ = run(models, tolerance_, true);
      if (!answer_.reached()) {
        note_trial(answer_, infinity());
        remarks_.push_back(model_text(bodies_, models) + ": " + answer_.why);
        if (!complete(models) && !raise_order(models)) tolerance_ /= 10;
        continue;
      }
      change_ = sample_changes(sensors_, answer_.samples);
      set_bounds();
      judge();
      if (stepped)
        for (std::size_t w = 0; w < count(); ++w) errors_[w].time = step_error_[w];
      else if (is_rough())
        judge_rough();
      note_trial(answer_, largest_part());
      chosen_ = static_cast<int>(trials_.size()) - 1;
      if (largest_part() <= 1) return;
      good = answer_, good_errors = errors_;
      if (!improve(models, share)) return;
    }
    if (answer_.reached()) return;
    if (good) {
      answer_ = std::move(*good), errors_ = good_errors;
      return;
    }
    throw SimulationError("no model of the scene reached the end: " + answer_.why, "solve",
                          "run the scene by itself first: diagnose() tells why it fails");
  }

  /// Steps as long as the samples are apart, and half of that; true if the difference, a third of which is left in the
  /// finer, is a small part of what is allowed.
  bool try_steps(const std::vector<Fidelity>& models) {
    step_ = 0;
    if (!methods_.by_step || change_.empty()) return false;
    for (std::size_t w = 0; w < count(); ++w)
      if (bounds_[w] < kCoarse * change_[w]) return false;
    const double interval = duration_ / samples();
    const auto stepped = [&](double step, bool dynamics) {
      return run_model(graph_, bodies_, models, sensors_, [&](const Tolerance&) { return methods_.by_step(step); },
                       {duration_, samples(), {}, simplify_, dynamics});
    };
    const ModelRun coarse = stepped(interval, false);
    if (!coarse.reached()) return false;
    ModelRun fine = stepped(interval / 2, true);
    if (!fine.reached()) return false;
    step_error_ = sample_differences(sensors_, coarse.samples, fine.samples);
    for (std::size_t w = 0; w < count(); ++w) {
      step_error_[w] *= kStepsLeft;
      if (!(step_error_[w] < kStepsShare * bounds_[w])) return false;
    }
    fine.tolerance = {0, 0};
    answer_ = std::move(fine);
    step_ = interval / 2;
    return true;
  }

  /// Modes that no load drives keep joints from being redundant: all up to the highest chosen, then all.
  bool complete(std::vector<Fidelity>& models) const {
    bool more = false;
    for (std::size_t b = 0; b < models.size(); ++b) {
      auto& modes = models[b].modes;
      if (modes.empty()) continue;
      const auto known = modes.size();
      const int last = modes.back() + 1;
      const bool leading = static_cast<int>(known) == last;
      const int end = leading ? static_cast<int>(bodies_.bodies()[b]->candidate_stiffness().size()) : last;
      modes.resize(static_cast<std::size_t>(end));
      std::iota(modes.begin(), modes.end(), 0);
      more |= modes.size() > known;
    }
    return more;
  }

  /// States the errors of the answer along its own motion.
  void judge() {
    errors_.assign(count(), {});
    const ModelError rest =
        model_error(graph_, bodies_, answer_, bodies_.all(), Missing::modes, sensors_, 1, Detail::each);
    for (const auto& c : rest.coordinates)
      for (auto& known : effects_)
        if (known.body == c.body && known.mode == c.mode) known = c;
    if (effects_.empty()) effects_ = rest.coordinates;
    // How far the first order carries here: the change by deformation as it came, over that predicted.
    std::vector<double> carried(count(), 1);
    if (rigid_.reached()) {
      const auto came = sample_differences(sensors_, answer_.samples, rigid_.samples);
      for (std::size_t w = 0; w < count(); ++w)
        if (deformation(w) > 0) carried[w] = std::clamp(came[w] / deformation_[w], 1.0, 10.0);
    }
    // What the modes left out do to the motion at large.
    std::vector<double> at_large(count(), 0);
    if (rigid_.reached() && !rest.coordinates.empty()) {
      const ModelRun moved = run_model(graph_, bodies_, bodies_.rigid(), sensors_, methods_.by_tolerance,
                                       rigid_request(false), rest.feedback);
      if (moved.reached()) at_large = sample_differences(sensors_, moved.samples, rigid_.samples);
    }
    std::vector<double> next(count(), 0);  // of the order beyond
    const Deflection order = order_of(answer_.models);
    if (order < finest()) {
      const Deflection above = order == Deflection::linear ? Deflection::stiffened : Deflection::quadratic;
      next = model_error(graph_, bodies_, answer_, deflected(answer_.models, above), Missing::all, sensors_, stride_)
                 .effect;
      auto& known = order == Deflection::linear ? second_order_ : fourth_order_;
      for (std::size_t w = 0; w < count(); ++w) known[w] = next[w] = std::max(known[w], next[w]);
    } else if (order != Deflection::linear) {  // orders fall as the second fell from the first
      const auto& last = order == Deflection::quadratic ? fourth_order_ : second_order_;
      for (std::size_t w = 0; w < count() && !deformation_.empty(); ++w)
        if (deformation_[w] > 0) next[w] = last[w] * std::min(1.0, second_order_[w] / deformation_[w]);
    }
    if (order != Deflection::linear)
      for (std::size_t w = 0; w < count(); ++w) next[w] += kFieldsLeftOut * second_order_[w];
    for (std::size_t w = 0; w < count(); ++w) {
      errors_[w].truncation = kCaution * carried[w] * (rest.effect[w] + at_large[w]) + kCandidates * deformation(w);
      errors_[w].deflection = kCaution * next[w];
      if (!options_.small_deflection && finest() == Deflection::linear)
        errors_[w].deflection = std::numeric_limits<double>::quiet_NaN();
      errors_[w].time = answer_.tolerance.relative * time_worth(w);
      errors_[w].solver = answer_.residual + kRoundOff * round_off(w);
    }
  }

  /// Where reactions or accelerations are wanted, modes that hardly move show: a second run at a looser tolerance
  /// tells.
  void judge_rough() {
    const ModelRun looser = run(answer_.models, 10 * answer_.tolerance.relative, false);
    const auto difference = sample_differences(sensors_, answer_.samples, looser.samples);
    for (std::size_t w = 0; w < count(); ++w)
      if (rigid_.rough.empty() || rigid_.rough[w])
        errors_[w].time = looser.reached() ? kRoughTime * difference[w] : infinity();
  }

  double largest_part() const {
    double most = 0;
    for (std::size_t w = 0; w < count(); ++w) {
      StatedError known = errors_[w];
      if (std::isnan(known.deflection)) known.deflection = 0;
      most = std::max(most, known.total() / bounds_[w]);
    }
    return most;
  }

  /// Refines what counts most; false if nothing is left to refine.
  bool improve(std::vector<Fidelity>& models, double& share) {
    double truncation = 0, deflection = 0, time = 0;
    for (std::size_t w = 0; w < count(); ++w) {
      truncation = std::max(truncation, errors_[w].truncation / bounds_[w]);
      deflection = std::max(deflection, errors_[w].deflection / bounds_[w]);
      time = std::max(time, errors_[w].time / bounds_[w]);
    }
    bool better = false;
    if (deflection > 0.3) better = raise_order(models);
    if (truncation > 0.3 && !effects_.empty()) {
      share *= 0.3 / truncation;
      for (bool more = false; !more && share > kNoShare; share /= 4) more = add_modes(models, with_modes(share));
      better |= share > kNoShare;
      models = deflected(models, order_of(models));
    }
    if (step_ > 0 && time > 0.3) {
      step_ = 0;
      return true;
    }
    if (time > 0.3 && tolerance_ > kTightest) {
      tolerance_ = std::max(kTightest, tolerance_ * 0.1 / time);
      better = true;
    }
    return better;
  }

  static bool add_modes(std::vector<Fidelity>& models, const std::vector<Fidelity>& more) {
    bool added = false;
    for (std::size_t b = 0; b < models.size(); ++b) {
      std::vector<int> both;
      std::set_union(models[b].modes.begin(), models[b].modes.end(), more[b].modes.begin(), more[b].modes.end(),
                     std::back_inserter(both));
      added |= both != models[b].modes;
      models[b].modes = both;
    }
    return added;
  }

  bool raise_order(std::vector<Fidelity>& models) const {
    const Deflection order = order_of(models);
    if (order >= finest()) return false;
    models = deflected(models, order == Deflection::linear ? Deflection::stiffened : Deflection::quadratic);
    return true;
  }

  // ---- the sheet ----

  ModelRun run(const std::vector<Fidelity>& models, double tolerance, bool dynamics) {
    ModelRun r = run_model(graph_, bodies_, models, sensors_, methods_.by_tolerance, request(tolerance, dynamics));
    log::debug("solve: " + model_text(bodies_, models) + ", tolerance " + short_number(tolerance) + ": " +
               duration_text(r.cost) + (r.reached() ? "" : ", " + r.why));
    return r;
  }
  void note_trial(const ModelRun& r, double error) {
    trials_.push_back({model_text(bodies_, r.models), r.tolerance.relative, true, error, r.cost});
  }

  Solution finish() {
    bodies_.set(answer_.models);
    Solution solution{{answer_.samples.columns, {}}, {}};
    const std::size_t width = answer_.samples.columns.size();
    for (int row = 0; row < answer_.samples.row_count(); row += finer_)
      solution.samples.add_row(std::span(answer_.samples.values).subspan(static_cast<std::size_t>(row) * width, width));
    Certificate& c = solution.certificate;
    c.scene = options_.scene;
    c.duration = duration_;
    c.simplification = simplification_;
    c.integrator = answer_.integrator;
    c.tolerance = answer_.tolerance.relative;
    c.steps = answer_.statistics.steps;
    c.mean_step = c.steps > 0 ? duration_ / static_cast<double>(c.steps) : 0;
    c.answer_cost = answer_.cost;
    for (std::size_t w = 0; w < count(); ++w)
      c.quantities.push_back({wants_[w].sensor.name(), change_[w], bounds_[w], errors_[w]});
    for (std::size_t b = 0; b < answer_.models.size(); ++b) c.bodies.push_back(describe(b));
    if (rigid_.reached() && !is_rigid(answer_.models)) {
      double error = 0;
      for (std::size_t w = 0; w < count(); ++w) error = std::max(error, kPredicted * deformation_[w] / bounds_[w]);
      ++chosen_;
      trials_.insert(trials_.begin(), {"rigid", rigid_.tolerance.relative, true, error, rigid_.cost});
    }
    c.trials = trials_;
    c.chosen = chosen_;
    remark();
    c.remarks = remarks_;
    c.cost = thread_seconds() - begun_;
    return solution;
  }

  ChosenBody describe(std::size_t b) const {
    const DeformableBody& body = *bodies_.bodies()[b];
    ChosenBody out{body.name(), answer_.models[b], body.finest_deflection(), {}, {}, ""};
    for (const auto& e : effects_) {
      if (e.body != static_cast<int>(b)) continue;
      const auto& modes = out.fidelity.modes;
      std::vector<double> effect = e.effect;
      for (std::size_t w = 0; w < count(); ++w) effect[w] *= amplification_[w];
      out.modes.push_back({e.mode, e.frequency, std::find(modes.begin(), modes.end(), e.mode) != modes.end(), effect});
    }
    if (body.finest_deflection() != Deflection::linear && !is_rigid(answer_.models))
      out.deflection_effect = second_order_;
    double share = 0, second = 0;
    for (std::size_t w = 0; w < count(); ++w) {
      share = std::max(share, deformation_.empty() ? infinity() : deformation_[w] / bounds_[w]);
      second = std::max(second, second_order_.empty() ? 0 : second_order_[w] / bounds_[w]);
    }
    if (out.fidelity.modes.empty())
      out.why = is_rigid(answer_.models)
                    ? "all deformation changes what is wanted by " + short_number(100 * share) + " % of what is allowed"
                    : "its deformation changes what is wanted by little beside that of others";
    else
      out.why = "a rigid body would be off by " + short_number(share) + " times what is allowed" +
                (share < 1 ? ", too much for an estimate to vouch for" : "") +
                (out.fidelity.deflection == Deflection::linear
                     ? ""
                     : "; any number of linear modes by " + short_number(second) + " times");
    return out;
  }

  void remark() {
    if (std::any_of(errors_.begin(), errors_.end(), [](const StatedError& e) { return std::isnan(e.deflection); }))
      remarks_.push_back(
          "what the second order of deflection does cannot be told, so that nothing is certified: the basis has no "
          "data "
          "for it; make_basis(model, frame, modes, {.deflection = Deflection::quadratic}) gives it, or "
          "SolveOptions::small_deflection leaves it out of the statement");
    if (largest_part() <= 1) return;
    double truncation = 0, deflection = 0, time = 0;
    for (std::size_t w = 0; w < count(); ++w) {
      truncation = std::max(truncation, errors_[w].truncation / bounds_[w]);
      deflection = std::max(deflection, errors_[w].deflection / bounds_[w]);
      time = std::max(time, errors_[w].time / bounds_[w]);
    }
    if (deflection >= std::max(truncation, time))
      remarks_.push_back(
          order_of(answer_.models) == finest() && finest() < Deflection::quadratic
              ? "no number of modes brings the error down: it is of the second order of deflection, for which the "
                "basis "
                "has no data; make_basis(model, frame, modes, {.deflection = Deflection::quadratic}) gives it"
              : "no number of modes brings the error down: the deflection is too large for reduced bodies; model the "
                "body "
                "by its nodes (plugins/inertial_body)");
    else if (truncation >= time)
      remarks_.push_back(
          "the candidate modes do not suffice: make_basis() with more of them, and with the interfaces "
          "that are loaded");
    else
      remarks_.push_back("the motion amplifies errors of the integrator: no tolerance tried is tight enough");
  }

  SystemGraph& graph_;
  double duration_;
  const std::vector<Want>& wants_;
  const SolveMethods& methods_;
  const SolveOptions& options_;
  BodyModels bodies_;
  std::vector<Sensor> sensors_;
  double begun_ = 0, tolerance_ = kFirstTolerance;
  int finer_ = 1;    // of the samples to those asked for
  int stride_ = 1;   // of the samples that estimates look at
  double step_ = 0;  // s, of the answer; 0: steps by tolerance
  std::vector<double> step_error_;
  double elastic_scale_ = 1;  // largest modal coordinate

  ModelRun rigid_, tighter_, predicted_, answer_;
  std::optional<ModelRun> corrected_;  // the rigid run under the feedback of deformation
  ModelError linear_, first_;          // from the rigid run to all candidates, and to those first chosen
  std::vector<ModelError::Coordinate> effects_;
  // A number a wanted quantity: largest change, allowed error, change by deformation, by its second and fourth order,
  // what the motion at large makes of a deformation, error over tolerance.
  std::vector<double> change_, bounds_, deformation_, second_order_, fourth_order_, amplification_, time_worth_;
  int chosen_ = -1;  // of the trials
  bool simplify_ = false;
  std::vector<std::string> simplification_;
  std::vector<StatedError> errors_;
  std::vector<CertificateTrial> trials_;
  std::vector<std::string> remarks_;
};

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
