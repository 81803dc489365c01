#include "engine/gradient/fit.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstdio>

#include "engine/base/dense.h"
#include "engine/base/log.h"

namespace lithe {
namespace {

constexpr double kFree = 1e299;     // bounds beyond are none
constexpr double kAtBound = 1e-10;  // of the parameter's size

double size_of(const FreeParameter& p) { return p.value == 0 ? 1 : std::abs(p.value); }

/// Measurements as quantities, and their values in units of σ.
class Misfit final : public ceres::CostFunction {
 public:
  Misfit(const ParametricScene& scene, const Table& measured, const std::vector<FreeParameter>& parameters,
         const FitOptions& options)
      : scene_(scene), parameters_(parameters) {
    const auto refuse = [](const std::string& what, const std::string& fix) { throw SceneError(what, "fit", fix); };
    const auto time = std::find(measured.columns.begin(), measured.columns.end(), "t");
    if (time == measured.columns.end()) refuse("the measurements have no column 't'", "name the column of times 't'");
    const int t = static_cast<int>(time - measured.columns.begin());
    const auto columns = static_cast<Eigen::Index>(measured.columns.size()) - 1;
    if (options.deviations.size() > 0 && options.deviations.size() != columns)
      refuse("there are " + std::to_string(options.deviations.size()) + " deviations for " + std::to_string(columns) +
                 " measured columns",
             "give one a column beside 't'");
    Eigen::Index number = 0;
    for (int c = 0; c < static_cast<int>(measured.columns.size()); ++c) {
      if (c == t) continue;
      const double sigma = options.deviations.size() > 0 ? options.deviations[number]
                           : options.deviation > 0       ? options.deviation
                                                         : 1;
      ++number;
      if (!(sigma > 0)) refuse("a deviation is not positive", "give those of the measurements");
      for (int row = 0; row < measured.row_count(); ++row) {
        if (!std::isfinite(measured.at(row, c))) continue;
        quantities_.push_back(value_at(measured.columns[static_cast<std::size_t>(c)], measured.at(row, t)));
        measured_.push_back(measured.at(row, c));
        weights_.push_back(1 / sigma);
      }
    }
    if (quantities_.size() < parameters.size())
      refuse("there are " + std::to_string(quantities_.size()) + " measurements for " +
                 std::to_string(parameters.size()) + " parameters",
             "measure more, or fit fewer");
    set_num_residuals(static_cast<int>(quantities_.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(parameters.size()));
  }

  /// Residuals and their derivatives by the scaled parameters.
  void evaluate(const double* scaled, VectorX& residuals, MatrixX& jacobian) const {
    std::vector<DesignParameter> at;
    for (std::size_t k = 0; k < parameters_.size(); ++k)
      at.push_back({parameters_[k].name, scaled[k] * size_of(parameters_[k]), parameters_[k].step});
    const log::Quiet quiet;
    const Gradient found = gradient(scene_, quantities_, at, {.mode = GradientOptions::Mode::tangent});
    ++evaluations_;
    residuals.resize(found.values.size());
    jacobian = found.derivatives;
    for (Eigen::Index i = 0; i < residuals.size(); ++i) {
      const auto n = static_cast<std::size_t>(i);
      residuals[i] = (found.values[i] - measured_[n]) * weights_[n];
      for (Eigen::Index k = 0; k < jacobian.cols(); ++k)
        jacobian(i, k) *= weights_[n] * size_of(parameters_[static_cast<std::size_t>(k)]);
    }
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    // A trial that the run does not survive is a step that is too long.
    try {
      VectorX r;
      MatrixX J;
      evaluate(parameters[0], r, J);
      std::copy(r.data(), r.data() + r.size(), residuals);
      if (jacobians && jacobians[0])
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(jacobians[0], J.rows(),
                                                                                           J.cols()) = J;
      return true;
    } catch (const SimulationError& error) {
      why_ = error.what();
      return false;
    }
  }
  int evaluations() const { return evaluations_; }
  const std::string& why() const { return why_; }

 private:
  const ParametricScene& scene_;
  const std::vector<FreeParameter>& parameters_;
  std::vector<Quantity> quantities_;
  std::vector<double> measured_, weights_;
  mutable int evaluations_ = 0;
  mutable std::string why_;
};

class Listener final : public ceres::IterationCallback {
 public:
  Listener(const std::vector<FreeParameter>& parameters, const VectorX& scaled, const FitOptions& options)
      : parameters_(parameters), scaled_(scaled), options_(options) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    SearchStep step{summary.iteration, summary.cost, scaled_};
    for (Eigen::Index k = 0; k < scaled_.size(); ++k)
      step.parameters[k] *= size_of(parameters_[static_cast<std::size_t>(k)]);
    options_.progress(step);
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const std::vector<FreeParameter>& parameters_;
  const VectorX& scaled_;
  const FitOptions& options_;
};

/// How many deviations the interval reaches to each side: of the normal distribution, or Student's t.
double quantile(double confidence, bool given, int freedom) {
  const double side = (1 + confidence) / 2;
  if (given || freedom < 1) return boost::math::quantile(boost::math::normal(), side);
  return boost::math::quantile(boost::math::students_t(freedom), side);
}

void check(const std::vector<FreeParameter>& parameters, const FitOptions& options) {
  const auto refuse = [](const std::string& what, const std::string& fix) { throw SceneError(what, "fit", fix); };
  if (parameters.empty()) refuse("there are no parameters", "name one");
  for (const FreeParameter& p : parameters)
    if (!(p.lower < p.upper && p.value >= p.lower && p.value <= p.upper))
      refuse("the parameter '" + p.name + "' does not begin between its bounds", "give lower < value < upper");
  if (!(options.confidence > 0 && options.confidence < 1))
    refuse("the confidence is not between 0 and 1", "0.95 is usual");
}

}  // namespace

Fit fit(const ParametricScene& scene, const Table& measured, const std::vector<FreeParameter>& parameters,
        const FitOptions& options) {
  check(parameters, options);
  Misfit misfit(scene, measured, parameters, options);
  const auto count = static_cast<Eigen::Index>(parameters.size());
  VectorX scaled(count);
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (Eigen::Index k = 0; k < count; ++k) {
    const FreeParameter& p = parameters[static_cast<std::size_t>(k)];
    scaled[k] = p.value / size_of(p);
  }
  problem.AddResidualBlock(&misfit, nullptr, scaled.data());
  for (int k = 0; k < count; ++k) {
    const FreeParameter& p = parameters[static_cast<std::size_t>(k)];
    if (p.lower > -kFree) problem.SetParameterLowerBound(scaled.data(), k, p.lower / size_of(p));
    if (p.upper < kFree) problem.SetParameterUpperBound(scaled.data(), k, p.upper / size_of(p));
  }
  ceres::Solver::Options search;
  search.linear_solver_type = ceres::DENSE_QR;
  search.max_num_iterations = options.max_iterations;
  search.function_tolerance = search.parameter_tolerance = options.tolerance;
  search.gradient_tolerance = 1e-300;  // has units
  search.logging_type = ceres::SILENT;
  search.num_threads = 1;
  search.update_state_every_iteration = true;
  Listener listener(parameters, scaled, options);
  if (options.progress) search.callbacks.push_back(&listener);
  ceres::Solver::Summary summary;
  ceres::Solve(search, &problem, &summary);
  if (summary.termination_type == ceres::FAILURE)
    throw SimulationError("the search failed: " + summary.message + (misfit.why().empty() ? "" : "; " + misfit.why()),
                          "fit of scene '" + scene.name + "'", "start from other values, or give bounds");

  Fit result;
  VectorX r;
  MatrixX J;
  misfit.evaluate(scaled.data(), r, J);
  result.measurements = static_cast<int>(r.size());
  result.iterations = static_cast<int>(summary.iterations.size());
  result.evaluations = misfit.evaluations();
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.message = summary.message;
  const bool given = options.deviation > 0 || options.deviations.size() > 0;
  const int freedom = result.measurements - static_cast<int>(count);
  result.deviation = given ? 1 : freedom > 0 ? std::sqrt(r.squaredNorm() / freedom) : 0;
  const MatrixX normal = J.transpose() * J;
  const Eigen::FullPivLU<MatrixX> factor(normal);
  const MatrixX inverse = factor.isInvertible()
                              ? MatrixX(factor.inverse())
                              : MatrixX::Constant(count, count, std::numeric_limits<double>::infinity());
  result.covariance = result.deviation * result.deviation * inverse;
  result.values.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const FreeParameter& p = parameters[static_cast<std::size_t>(k)];
    result.parameters.push_back(p.name);
    result.values[k] = scaled[k] * size_of(p);
    result.covariance.row(k) *= size_of(p);
    result.covariance.col(k) *= size_of(p);
    const double near = kAtBound * size_of(p);
    if (result.values[k] - p.lower < near || p.upper - result.values[k] < near) result.at_bound.push_back(p.name);
  }
  result.deviations = result.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const double width = quantile(options.confidence, given, freedom);
  result.lower = result.values - width * result.deviations;
  result.upper = result.values + width * result.deviations;
  if (given && options.deviations.size() == 0) result.deviation = options.deviation;
  return result;
}

double Fit::operator()(const Located& parameter) const {
  const auto found = std::find(parameters.begin(), parameters.end(), parameter.text);
  if (found != parameters.end()) return values[found - parameters.begin()];
  std::string known;
  for (const std::string& name : parameters) known += (known.empty() ? "" : ", ") + name;
  throw SceneError("the fit has no parameter '" + parameter.text + "'", to_string(parameter.where),
                   "known are " + known);
}

std::string Fit::text() const {
  std::string lines;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    char line[200];
    std::snprintf(line, sizeof line, "%s %.6g +- %.2g (%.6g ... %.6g)%s\n", parameters[k].c_str(), values[i],
                  deviations[i], lower[i], upper[i],
                  std::find(at_bound.begin(), at_bound.end(), parameters[k]) == at_bound.end() ? "" : ", at its bound");
    lines += line;
  }
  return lines;
}

}  // namespace lithe
