#include "engine/gradient/minimize.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <nlopt.hpp>

#include "engine/base/log.h"

namespace lithe {
namespace {

constexpr double kNone = 1e299;

double size_of(double value) { return value == 0 || std::abs(value) > kNone ? 1 : std::abs(value); }

/// Values and derivatives at the point asked for last: objective and limits ask for the same one by turns.
class Evaluations {
 public:
  Evaluations(const ParametricScene& scene, const Quantity& objective, const std::vector<FreeParameter>& parameters,
              const std::vector<Limit>& limits, const MinimizeOptions& options)
      : scene_(scene), parameters_(parameters), options_(options), quantities_{objective} {
    for (const Limit& limit : limits) quantities_.push_back(limit.quantity);
  }

  const Gradient& at(const std::vector<double>& scaled) {
    if (scaled == scaled_) return found_;
    std::vector<DesignParameter> values;
    VectorX told(static_cast<Eigen::Index>(scaled.size()));
    for (std::size_t k = 0; k < scaled.size(); ++k) {
      const FreeParameter& p = parameters_[k];
      told[static_cast<Eigen::Index>(k)] = scaled[k] * size_of(p.value);
      values.push_back({p.name, scaled[k] * size_of(p.value), p.step});
    }
    const log::Quiet quiet;
    found_ = gradient(scene_, quantities_, values);
    for (std::size_t k = 0; k < scaled.size(); ++k)
      found_.derivatives.col(static_cast<Eigen::Index>(k)) *= size_of(parameters_[k].value);
    scaled_ = scaled;
    ++count_;
    if (options_.progress) options_.progress({count_, found_.values[0], told});
    return found_;
  }
  int count() const { return count_; }
  /// What ended the search from within: NLopt's C core knows no exceptions but its own.
  std::exception_ptr trouble;

 private:
  const ParametricScene& scene_;
  const std::vector<FreeParameter>& parameters_;
  const MinimizeOptions& options_;
  std::vector<Quantity> quantities_;
  std::vector<double> scaled_;
  Gradient found_;
  int count_ = 0;
};

/// sign (quantity - bound)/scale, as NLopt asks for it.
struct Term {
  Evaluations* evaluations;
  int quantity;
  double sign, bound, scale;
};

double evaluate(const std::vector<double>& x, std::vector<double>& derivatives, void* data) {
  const Term& term = *static_cast<const Term*>(data);
  try {
    const Gradient& found = term.evaluations->at(x);
    for (std::size_t k = 0; k < derivatives.size(); ++k)
      derivatives[k] = term.sign * found.derivatives(term.quantity, static_cast<Eigen::Index>(k)) / term.scale;
    return term.sign * (found.values[term.quantity] - term.bound) / term.scale;
  } catch (...) {
    term.evaluations->trouble = std::current_exception();
    throw nlopt::forced_stop();
  }
}

}  // namespace

Optimum minimize(const ParametricScene& scene, const Quantity& objective, const std::vector<FreeParameter>& parameters,
                 const std::vector<Limit>& limits, const MinimizeOptions& options) {
  if (parameters.empty()) throw SceneError("there are no parameters", "minimize", "name one");
  std::vector<double> x, lower, upper;
  for (const FreeParameter& p : parameters) {
    if (!(p.lower < p.upper && p.value >= p.lower && p.value <= p.upper))
      throw SceneError("the parameter '" + p.name + "' does not begin between its bounds", "minimize",
                       "give lower < value < upper");
    x.push_back(p.value / size_of(p.value));
    lower.push_back(p.lower < -kNone ? -HUGE_VAL : p.lower / size_of(p.value));
    upper.push_back(p.upper > kNone ? HUGE_VAL : p.upper / size_of(p.value));
  }
  Evaluations evaluations(scene, objective, parameters, limits, options);
  std::vector<Term> terms;
  terms.push_back({&evaluations, 0, 1, 0, size_of(evaluations.at(x).values[0])});
  for (std::size_t i = 0; i < limits.size(); ++i) {
    const int quantity = static_cast<int>(i) + 1;
    if (limits[i].upper < kNone)
      terms.push_back({&evaluations, quantity, 1, limits[i].upper, size_of(limits[i].upper)});
    if (limits[i].lower > -kNone)
      terms.push_back({&evaluations, quantity, -1, limits[i].lower, size_of(limits[i].lower)});
  }
  nlopt::opt search(nlopt::LD_SLSQP, static_cast<unsigned>(parameters.size()));
  search.set_lower_bounds(lower);
  search.set_upper_bounds(upper);
  search.set_min_objective(evaluate, &terms[0]);
  for (std::size_t i = 1; i < terms.size(); ++i) search.add_inequality_constraint(evaluate, &terms[i], options.slack);
  search.set_ftol_rel(options.tolerance);
  search.set_xtol_rel(options.tolerance);
  search.set_maxeval(options.max_evaluations);

  Optimum result;
  try {
    double value = 0;
    const nlopt::result ended = search.optimize(x, value);
    result.converged = ended > 0 && ended != nlopt::MAXEVAL_REACHED && ended != nlopt::MAXTIME_REACHED;
    result.message = ended == nlopt::MAXEVAL_REACHED ? "the most evaluations were reached"
                                                     : "objective and parameters no longer change";
  } catch (const nlopt::roundoff_limited&) {
    result.converged = true;
    result.message = "round-off limits the search";
  } catch (const nlopt::forced_stop&) {
    if (evaluations.trouble) std::rethrow_exception(evaluations.trouble);
    throw;
  } catch (const std::runtime_error& error) {
    throw SimulationError(std::string("the search failed: ") + error.what(), "minimize, scene '" + scene.name + "'",
                          "start from other values, or relax the limits");
  }
  const Gradient& found = evaluations.at(x);
  result.objective = found.values[0];
  result.limited = found.values.tail(found.values.size() - 1);
  result.evaluations = evaluations.count();
  for (std::size_t i = 1; i < terms.size(); ++i) {
    const Term& term = terms[i];
    const double excess = term.sign * (found.values[term.quantity] - term.bound) / term.scale;
    result.largest_excess = std::max(result.largest_excess, excess);
  }
  result.values.resize(static_cast<Eigen::Index>(x.size()));
  for (std::size_t k = 0; k < x.size(); ++k) {
    result.parameters.push_back(parameters[k].name);
    result.values[static_cast<Eigen::Index>(k)] = x[k] * size_of(parameters[k].value);
    if (x[k] - lower[k] < 1e-10 || upper[k] - x[k] < 1e-10) result.at_bound.push_back(parameters[k].name);
  }
  if (result.largest_excess > 10 * options.slack) {
    result.converged = false;
    result.message += "; a limit is exceeded";
  }
  return result;
}

double Optimum::operator()(const Located& parameter) const {
  const auto found = std::find(parameters.begin(), parameters.end(), parameter.text);
  if (found != parameters.end()) return values[found - parameters.begin()];
  throw SceneError("the optimum has no parameter '" + parameter.text + "'", to_string(parameter.where),
                   "use a name that was given to minimize()");
}

}  // namespace lithe
