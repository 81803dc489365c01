#include "engine/gradient/gradient.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>

#include "engine/base/number_text.h"
#include "engine/gradient/recorded_run.h"
#include "engine/gradient/repeated_steps.h"
#include "engine/gradient/sample_weights.h"
#include "engine/gradient/sensor_derivative.h"
#include "engine/gradient/static_derivative.h"
#include "engine/gradient/tangent_equations.h"
#include "engine/study/study_run.h"

namespace lithe {
namespace {

using Mode = GradientOptions::Mode;

constexpr int kForwards = 8;      // parameters that go forwards in any case: a step costs little more for each
constexpr double kWholeRun = -1;  // as the end of an integral

bool is_static(const Quantity& q) { return q.kind == Quantity::Kind::at_rest || q.kind == Quantity::Kind::frequency; }
bool is_extremum(const Quantity& q) { return q.kind == Quantity::Kind::largest || q.kind == Quantity::Kind::smallest; }

/// The columns that quantities ask for, each once.
struct Columns {
  std::vector<std::string> names;
  std::vector<Drawing::Place> places;
  int add(const Located& name, const Drawing& drawing) {
    const auto found = std::find(names.begin(), names.end(), name.text);
    if (found != names.end()) return static_cast<int>(found - names.begin());
    places.push_back(drawing.find(name));
    names.push_back(name.text);
    return static_cast<int>(names.size()) - 1;
  }
};

/// Derivatives of quantities of one run.
class RunGradient {
 public:
  RunGradient(const ParametricScene& scene, const std::vector<DesignParameter>& parameters, const Drawing& drawing,
              std::vector<Quantity> quantities, const GradientOptions& options)
      : scene_(scene), drawing_(drawing), events_(scene, parameters, drawing), quantities_(std::move(quantities)) {
    for (const Quantity& q : quantities_) column_of_.push_back(columns_.add(q.column, drawing));
    run(options.memory);
    const auto count = static_cast<int>(parameters.size());
    touches_ = !drawing.system().contacts().empty();
    repeats_backwards_ = !run_->derivative() && (touches_ || run_->passes_kinks() || !run_->method().step_adjoint());
    const std::string no_adjoint = why_no_adjoint();
    mode_ = options.mode;
    if (mode_ == Mode::automatic)
      mode_ = count <= std::max<int>(kForwards, static_cast<int>(quantities_.size())) || !no_adjoint.empty() ||
                      repeats_backwards_
                  ? Mode::tangent
                  : Mode::adjoint;
    if (mode_ == Mode::adjoint && !no_adjoint.empty())
      throw SceneError(no_adjoint, "the gradient of scene '" + scene.name + "'", "take GradientOptions::Mode::tangent");
    find_parameters(parameters);
    equations_ = std::make_unique<TangentEquations>(drawing.system(), parameters_.get(), terms_.get());
    for (const Drawing::Place& place : columns_.places) sensors_.emplace_back(drawing, place, run_->probes());
    refuse_contact_loads();
  }

  void find(VectorX& values, MatrixX& derivatives) {
    values.setZero(static_cast<Eigen::Index>(quantities_.size()));
    derivatives.setZero(values.size(), parameter_count());
    mode_ == Mode::tangent ? forwards(values, derivatives) : backwards(values, derivatives);
  }
  void report(Gradient& result) const {
    result.mode = mode_;
    result.steps = run_->steps();
    result.run_seconds = run_->seconds();
    result.tape_bytes = run_->bytes();
    result.stretches = run_->stretch_count();
    result.groups = terms_ ? terms_->group_count() : parameters_->group_count();
    result.differenced = equations_->tangents() == TangentEquations::Tangents::differenced;
  }

 private:
  std::string why_no_adjoint() const {
    if (repeats_backwards_) return "";
    Evaluator equations(drawing_.system());
    if (!equations.velocity_rows().empty() || equations.reacts())
      return "rows on velocities alone (rolling) and friction by reactions have no adjoint yet";
    return run_->method().step_adjoint()->refuse(equations);
  }

  /// Whether the derivative of a step is found by taking it again.
  bool repeats(const TakenStep& step) const {
    if (step.kinks && !step.kinks->empty()) return true;
    return run_->derivative() ? run_->derivative()->by_repetition(step) : mode_ == Mode::tangent || repeats_backwards_;
  }

  /// The loads of rigid contacts are those of a step, and no function of the state.
  void refuse_contact_loads() {
    if (run_->derivative() || !Evaluator(drawing_.system()).parts().rigid_contacts) return;
    for (std::size_t c = 0; c < sensors_.size(); ++c)
      for (State state : run_->touching()) {
        const double value = sensors_[c].value(state);
        for (ContactTrace& trace : state.contacts) trace.force *= 1.5, trace.moment *= 1.5;
        if (sensors_[c].value(state) != value)
          throw SceneError(
              "'" + columns_.names[c] + "' reads what contacts between rigid surfaces do, which has no derivative",
              "the gradient of scene '" + scene_.name + "'", "ask for positions and velocities");
      }
  }

  /// Very many parameters by the terms that they act on, where these can be told apart.
  void find_parameters(const std::vector<DesignParameter>& parameters) {
    const auto& places = columns_.places;
    const bool many = parameters.size() > kFewParameters;
    const bool apart = run_->derivative() ? run_->repeats() || touches_ : mode_ == Mode::tangent || repeats_backwards_;
    const bool weighed = !apart && mode_ == Mode::adjoint && run_->method().step_adjoint()->weighs_parameters();
    std::string why;
    if (!apart && mode_ == Mode::adjoint && (many || weighed))
      terms_ = ParameterTerms::find(scene_, parameters, drawing_, run_->probes(), places, many, why);
    if (weighed && !terms_)
      throw SceneError(why, "the gradient of scene '" + scene_.name + "'",
                       "take GradientOptions::Mode::tangent, or GeneralizedAlpha");
    if (terms_ && many) return;
    parameters_ = std::make_unique<ParameterDerivative>(
        scene_, parameters, drawing_, run_->probes(), places,
        apart ? ParameterDerivative::Grouping::apart : ParameterDerivative::Grouping::by_rows);
    if (apart) repeated_ = std::make_unique<RepeatedSteps>(run_->method(), drawing_, *parameters_);
  }
  int parameter_count() const { return terms_ ? terms_->count() : parameters_->count(); }

  /// Extremes need their column at every step.
  void run(std::size_t memory) {
    std::map<int, std::vector<double>> samples;
    for (std::size_t i = 0; i < quantities_.size(); ++i)
      if (is_extremum(quantities_[i])) samples[column_of_[i]];
    Snapshot now(drawing_.system());
    run_ = std::make_unique<RecordedRun>(scene_, drawing_, memory, [&](const State& state) {
      if (samples.empty()) return;
      now.evaluate(state, Accelerations::solved);
      for (auto& [column, values] : samples) {
        const Drawing::Place& place = columns_.places[static_cast<std::size_t>(column)];
        values.push_back(drawing_.sensor(place.sensor).value(now, place.column));
      }
    });
    for (std::size_t i = 0; i < quantities_.size(); ++i) {
      if (quantities_[i].to == kWholeRun) quantities_[i].to = run_->times().back();
      const std::vector<double> none;
      const auto found = samples.find(column_of_[i]);
      for (const SampleWeight& w :
           sample_weights(quantities_[i], run_->times(), found == samples.end() ? none : found->second))
        weights_[w.step].push_back({static_cast<int>(i), w.weight});
    }
  }

  /// What quantities read at a state: calls read(column, sums of weights by quantity).
  template <class Read>
  void at_step(long step, const State& state, VectorX& values, MatrixX& derivatives, const Read& read) {
    const auto found = weights_.find(step);
    if (found == weights_.end()) return;
    VectorX turn(state.v.size()), velocity(state.v.size()), direct;
    for (int column = 0; column < static_cast<int>(sensors_.size()); ++column) {
      if (std::none_of(found->second.begin(), found->second.end(),
                       [&](const Share& s) { return column_of_[s.quantity] == column; }))
        continue;
      const double value = sensors_[column].value(state);
      turn.setZero(), velocity.setZero();
      sensors_[column].add(state, 1, turn, velocity);
      parameters_ ? parameters_->sensor(column, state, direct) : terms_->sensor(column, state, direct);
      for (const Share& s : found->second) {
        if (column_of_[s.quantity] != column) continue;
        values[s.quantity] += s.weight * value;
        derivatives.row(s.quantity) += s.weight * direct;
        read(s.quantity, s.weight, turn, velocity);
      }
    }
  }

  /// An integral over an event changes with the event's time by what the column jumps: calls add(quantity, jump).
  template <class Add>
  void at_jump(const State& before, const State& after, const Add& add) {
    for (std::size_t i = 0; i < quantities_.size(); ++i) {
      const Quantity& q = quantities_[i];
      if (q.kind != Quantity::Kind::integral || !(q.from < before.time && before.time < q.to)) continue;
      SensorDerivative& sensor = sensors_[static_cast<std::size_t>(column_of_[i])];
      add(static_cast<int>(i), sensor.value(before) - sensor.value(after));
    }
  }

  static TakenStep step(const std::vector<RecordedRun::Taken>& states, std::size_t i) {
    return {states[i - 1].state, states[i].state, states[i].record.get(), &states[i].kinks};
  }

  void forwards(VectorX& values, MatrixX& derivatives) {
    Variation x = parameters_->start();
    const Eigen::Index n = x.turn.rows();
    const auto read = [&](int quantity, double weight, const VectorX& turn, const VectorX& velocity) {
      derivatives.row(quantity) += weight * (turn.transpose() * x.turn + velocity.transpose() * x.velocity);
    };
    for (int s = 0; s < run_->stretch_count(); ++s) {
      const auto& states = run_->stretch(s);
      const long first = run_->first(s);
      if (s == 0) at_step(0, states[0].state, values, derivatives, read);
      for (std::size_t i = 1; i < states.size(); ++i) {
        if (const int event = run_->event_before(first + static_cast<long>(i)); event >= 0) {
          const EventDerivative::Jump jump = events_.at(event, states[i - 1].state, states[i].state);
          MatrixX change = stacked(x).topRows(2 * n);
          const Eigen::RowVectorXd time = jump.time_by_state.transpose() * change + jump.time_by_parameters.transpose();
          at_jump(states[i - 1].state, states[i].state,
                  [&](int quantity, double weight) { derivatives.row(quantity) += weight * time; });
          MatrixX behind(jump.by_state.rows() + x.memory.rows(), change.cols());
          behind << jump.by_state * change + jump.by_parameters, x.memory;
          unstack(behind, n, x.history.size(), x);
        } else if (const TakenStep taken = step(states, i); repeats(taken))
          repeated_->tangent(taken, x);
        else
          run_->derivative()->tangent(*equations_, taken, x);
        at_step(first + static_cast<long>(i), states[i].state, values, derivatives, read);
      }
    }
  }

  void backwards(VectorX& values, MatrixX& derivatives) {
    const Eigen::Index velocities = drawing_.system().layout().v_count(), count = values.size();
    // The method as it starts: what its start() does goes backwards too.
    State start = drawing_.system().initial_state();
    Evaluator evaluator(drawing_.system());
    const auto integrator = scene_.integrator();
    integrator->start(evaluator, start);
    const auto& method = dynamic_cast<const DifferentiableSteps&>(*integrator);
    const auto adjoint = method.step_adjoint();
    const auto derivative = method.step_derivative();
    const MatrixX none = MatrixX::Zero(velocities, count);
    Variation x{none, none, {}, MatrixX::Zero(run_->memory_at_end(), count)};
    if (parameters_)
      x.history.assign(parameters_->start().history.size(), none);
    else if (derivative)
      x.history.assign(static_cast<std::size_t>(derivative->history(start).cols()), none);
    MatrixX within = MatrixX::Zero(parameter_count(), count);
    const auto read = [&](int quantity, double weight, const VectorX& turn, const VectorX& velocity) {
      x.turn.col(quantity) += weight * turn;
      x.velocity.col(quantity) += weight * velocity;
    };
    for (int s = run_->stretch_count() - 1; s >= 0; --s) {
      const auto& states = run_->stretch(s);
      const long first = run_->first(s);
      for (std::size_t i = states.size() - 1; i >= 1; --i) {
        at_step(first + static_cast<long>(i), states[i].state, values, derivatives, read);
        if (const int event = run_->event_before(first + static_cast<long>(i)); event >= 0) {
          if (repeated_) repeated_->leave();
          const EventDerivative::Jump jump = events_.at(event, states[i - 1].state, states[i].state);
          MatrixX wanted = stacked(x).topRows(jump.by_state.rows());
          within += jump.by_parameters.transpose() * wanted;
          wanted = (jump.by_state.transpose() * wanted).eval();
          at_jump(states[i - 1].state, states[i].state, [&](int quantity, double weight) {
            within.col(quantity) += weight * jump.time_by_parameters;
            wanted.col(quantity) += weight * jump.time_by_state;
          });
          x.turn = wanted.topRows(velocities), x.velocity = wanted.bottomRows(velocities);
          for (MatrixX& carried : x.history) carried.setZero();  // the method starts anew
        } else if (const TakenStep taken = step(states, i); repeats(taken))
          repeated_->adjoint(taken, x, within);
        else {
          if (repeated_) repeated_->leave();
          adjoint->adjoint(*equations_, taken, x, within);
        }
      }
      if (s == 0) at_step(0, states[0].state, values, derivatives, read);
    }
    if (!parameters_) {
      adjoint->adjoint_start(*equations_, drawing_.system().initial_state(), x, within);
      assembled(x, within);
      derivatives += within.transpose();
      return;
    }
    const Variation& start_by = parameters_->start();
    if (repeated_) repeated_->begin_at(start_by);
    derivatives += within.transpose() + x.turn.transpose() * start_by.turn +
                   x.velocity.transpose() * start_by.velocity + x.memory.transpose() * start_by.memory;
    for (std::size_t i = 0; i < x.history.size(); ++i) derivatives += x.history[i].transpose() * start_by.history[i];
  }

  /// From what is wanted of the assembled start to the parameters: v, then q were moved onto the joints along M⁻¹Gᵀ,
  /// by nothing, but not with their derivatives nothing.
  void assembled(Variation& x, MatrixX& within) {
    const State& start = drawing_.system().initial_state();
    const Eigen::Index rows = drawing_.system().layout().row_count(), none = 0;
    MatrixX unused = MatrixX::Zero(x.turn.rows(), x.turn.cols());
    equations_->at(start);
    for (const auto level : {WeightedSum::Rows::velocity, WeightedSum::Rows::position}) {
      const WeightedSum sum{.rows = level, .forces = false, .a = {}, .l = {}, .u = {}};
      MatrixX wanted = level == WeightedSum::Rows::velocity ? x.velocity : x.turn;
      MatrixX nu = MatrixX::Zero(rows, wanted.cols());
      equations_->solve_mass(wanted, nu);
      equations_->add_weighted(sum, MatrixX(wanted.rows(), none), nu, -1, x.turn,
                               level == WeightedSum::Rows::velocity ? x.velocity : unused, within);
    }
    terms_->add_drawn(x.turn, x.velocity, within);
  }

  struct Share {
    int quantity;
    double weight;
  };
  const ParametricScene& scene_;
  const Drawing& drawing_;
  EventDerivative events_;
  std::vector<Quantity> quantities_;
  Columns columns_;
  std::vector<int> column_of_;  // of each quantity
  std::unique_ptr<RecordedRun> run_;
  std::map<long, std::vector<Share>> weights_;       // by step
  std::unique_ptr<ParameterDerivative> parameters_;  // null: terms_ has all
  std::unique_ptr<ParameterTerms> terms_;
  std::unique_ptr<RepeatedSteps> repeated_;  // null: no step is taken again
  std::unique_ptr<TangentEquations> equations_;
  std::deque<SensorDerivative> sensors_;
  Mode mode_{};
  bool touches_ = false;            // there are contacts
  bool repeats_backwards_ = false;  // all steps, whose own adjoint has no contacts and no kinks
};

/// Derivatives of quantities at rest.
void static_gradient(const ParametricScene& scene, const std::vector<DesignParameter>& parameters,
                     const Drawing& drawing, const std::vector<Quantity>& quantities, VectorX& values,
                     MatrixX& derivatives) {
  Columns columns;
  std::vector<int> column_of;
  for (const Quantity& q : quantities)
    column_of.push_back(q.kind == Quantity::Kind::at_rest ? columns.add(q.column, drawing) : -1);
  StaticDerivative rest(scene, parameters, drawing, columns.places);
  values.setZero(static_cast<Eigen::Index>(quantities.size()));
  derivatives.setZero(values.size(), rest.parameters().count());
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    VectorX of_parameters;
    if (quantities[i].kind == Quantity::Kind::frequency) {
      values[i] = rest.frequency(quantities[i].number, of_parameters);
    } else {
      SensorDerivative sensor(drawing, columns.places[static_cast<std::size_t>(column_of[i])], {rest.state()});
      values[i] = sensor.value(rest.state());
      VectorX turn = VectorX::Zero(rest.turns().rows()), velocity = turn;
      sensor.add(rest.state(), 1, turn, velocity);
      rest.parameters().sensor(column_of[i], rest.state(), of_parameters);
      of_parameters += rest.turns().transpose() * turn;
    }
    derivatives.row(static_cast<Eigen::Index>(i)) = of_parameters;
  }
}

}  // namespace

std::string Quantity::name() const {
  switch (kind) {
    case Kind::at_time:
      return column.text + " at " + short_number(to) + " s";
    case Kind::integral:
      return "integral of " + column.text;
    case Kind::largest:
      return "largest " + column.text;
    case Kind::smallest:
      return "smallest " + column.text;
    case Kind::at_rest:
      return column.text + " at rest";
    case Kind::frequency:
      return "frequency " + std::to_string(number);
  }
  return "";
}

Quantity value_at(Located column, double time) { return {Quantity::Kind::at_time, std::move(column), time, time}; }
Quantity integral(Located column) { return {Quantity::Kind::integral, std::move(column), 0, kWholeRun}; }
Quantity integral(Located column, double from, double to) {
  return {Quantity::Kind::integral, std::move(column), from, to};
}
Quantity largest(Located column) { return {Quantity::Kind::largest, std::move(column)}; }
Quantity smallest(Located column) { return {Quantity::Kind::smallest, std::move(column)}; }
Quantity at_rest(Located column) { return {Quantity::Kind::at_rest, std::move(column)}; }
Quantity frequency(int number) { return {Quantity::Kind::frequency, "", 0, 0, number}; }

double Gradient::operator()(const Located& quantity, const Located& parameter) const {
  const auto place = [](const std::vector<std::string>& names, const Located& name) {
    const auto found = std::find(names.begin(), names.end(), name.text);
    if (found != names.end()) return static_cast<Eigen::Index>(found - names.begin());
    std::string known;
    for (const std::string& each : names) known += (known.empty() ? "" : ", ") + each;
    throw SceneError("the gradient has no '" + name.text + "'", to_string(name.where), "known are " + known);
  };
  return derivatives(place(quantities, quantity), place(parameters, parameter));
}

Table Gradient::table() const {
  Table table{.columns = {"quantity", "value"}};
  for (const std::string& name : parameters) table.columns.push_back("by " + name);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    std::vector<double> row{static_cast<double>(i), values[i]};
    for (Eigen::Index k = 0; k < derivatives.cols(); ++k) row.push_back(derivatives(i, k));
    table.add_row(row);
  }
  return table;
}

Gradient gradient(const ParametricScene& scene, const std::vector<Quantity>& quantities,
                  std::vector<DesignParameter> parameters, const GradientOptions& options) {
  if (quantities.empty())
    throw SceneError("nothing is to be differentiated", "gradient", "give quantities, such as value_at(\"tip_z\", 1)");
  parameters = checked_parameters(std::move(parameters));
  const double begun = thread_seconds();
  Gradient result;
  for (const Quantity& q : quantities) result.quantities.push_back(q.name());
  for (const DesignParameter& p : parameters) result.parameters.push_back(p.name);
  result.values.setZero(static_cast<Eigen::Index>(quantities.size()));
  result.derivatives.setZero(result.values.size(), static_cast<Eigen::Index>(parameters.size()));
  const Drawing drawing(scene, parameters);
  for (const bool at_rest : {false, true}) {
    std::vector<Quantity> these;
    std::vector<Eigen::Index> places;
    for (std::size_t i = 0; i < quantities.size(); ++i)
      if (is_static(quantities[i]) == at_rest)
        these.push_back(quantities[i]), places.push_back(static_cast<Eigen::Index>(i));
    if (these.empty()) continue;
    VectorX values;
    MatrixX derivatives;
    if (at_rest) {
      static_gradient(scene, parameters, drawing, these, values, derivatives);
    } else {
      RunGradient run(scene, parameters, drawing, these, options);
      run.find(values, derivatives);
      run.report(result);
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      result.values[places[i]] = values[static_cast<Eigen::Index>(i)];
      result.derivatives.row(places[i]) = derivatives.row(static_cast<Eigen::Index>(i));
    }
  }
  result.seconds = thread_seconds() - begun;
  return result;
}

}  // namespace lithe
