#include "engine/gradient/sample_weights.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace lithe {
namespace {

/// Adds scale L_j(t) of the Lagrange polynomials through `count` steps from `first` on.
void add_interpolation(const std::vector<double>& times, long first, long count, double t, double scale,
                       std::map<long, double>& weights) {
  for (long j = first; j < first + count; ++j) {
    double value = scale;
    for (long k = first; k < first + count; ++k)
      if (k != j) value *= (t - times[k]) / (times[j] - times[k]);
    weights[j] += value;
  }
}

/// The first of the four steps around an interval, and how many there are.
std::pair<long, long> around(long interval, long steps) {
  const long count = std::min(4L, steps + 1);
  return {std::clamp(interval - 1, 0L, steps + 1 - count), count};
}

[[noreturn]] void refuse(const Quantity& quantity, const std::string& what, const std::string& fix) {
  throw SceneError(what, to_string(quantity.column.where), fix);
}

void add_value(const std::vector<double>& times, double t, std::map<long, double>& weights) {
  const auto after = std::lower_bound(times.begin(), times.end(), t);
  const long next = std::min<long>(after - times.begin(), static_cast<long>(times.size()) - 1);
  for (long near : {next, std::max(0L, next - 1)})
    if (std::abs(times[near] - t) <= 1e-9 * (times[1] - times[0])) return void(weights[near] += 1);
  const auto [first, count] = around(next - 1, static_cast<long>(times.size()) - 1);
  add_interpolation(times, first, count, t, 1, weights);
}

void add_integral(const std::vector<double>& times, double from, double to, std::map<long, double>& weights) {
  const long steps = static_cast<long>(times.size()) - 1;
  for (long i = 0; i < steps; ++i) {
    const double a = std::max(from, times[i]), b = std::min(to, times[i + 1]);
    if (!(b > a)) continue;
    const auto [first, count] = around(i, steps);
    for (const double x : {-std::sqrt(1.0 / 3), std::sqrt(1.0 / 3)})  // exact for cubics
      add_interpolation(times, first, count, (a + b + (b - a) * x) / 2, (b - a) / 2, weights);
  }
}

void add_extremum(const Quantity& quantity, const std::vector<double>& times, std::vector<double> samples,
                  std::map<long, double>& weights) {
  if (quantity.kind == Quantity::Kind::smallest)
    for (double& x : samples) x = -x;
  const long last = static_cast<long>(samples.size()) - 1;
  const long top = std::max_element(samples.begin(), samples.end()) - samples.begin();
  const double span = samples[top] - *std::min_element(samples.begin(), samples.end());
  for (long i = 0; i <= last; ++i) {
    const bool peak = (i == 0 || samples[i] >= samples[i - 1]) && (i == last || samples[i] >= samples[i + 1]);
    if (std::abs(i - top) > 1 && peak && samples[top] - samples[i] <= 1e-10 * span)
      refuse(quantity,
             "'" + quantity.name() + "' is reached twice, at t = " + std::to_string(times[std::min(i, top)]) + " and " +
                 std::to_string(times[std::max(i, top)]) + " s: it has no derivative",
             "ask for the value at one of these times");
  }
  if (top == 0 || top == last) return void(weights[top] += 1);
  // Of the parabola through three: Newton's form f = f₀ + (t - t₀) (s₀ + (t - t₁) c).
  const double t0 = times[top - 1], t1 = times[top], t2 = times[top + 1];
  const double s0 = (samples[top] - samples[top - 1]) / (t1 - t0), s1 = (samples[top + 1] - samples[top]) / (t2 - t1);
  const double c = (s1 - s0) / (t2 - t0);
  if (!(c < 0)) return void(weights[top] += 1);
  double t = (t0 + t1) / 2 - s0 / (2 * c);
  // Of the quartic through five: Newton's method from there on, slopes and curvatures by differences of the weights.
  const long count = std::min(5L, last + 1), first = std::clamp(top - 2, 0L, last + 1 - count);
  const double h = 1e-3 * (t2 - t0);
  const auto value = [&](double at) {
    std::map<long, double> L;
    add_interpolation(times, first, count, at, 1, L);
    double sum = 0;
    for (const auto& [step, weight] : L) sum += weight * (samples[step] - samples[top]);
    return sum;
  };
  for (int i = 0; i < 6; ++i) {
    const double before = value(t - h), here = value(t), after = value(t + h);
    const double curvature = (after - 2 * here + before) / (h * h);
    if (curvature < 0) t -= (after - before) / (2 * h) / curvature;
  }
  add_interpolation(times, first, count, std::clamp(t, t0, t2), 1, weights);
}

}  // namespace

std::vector<SampleWeight> sample_weights(const Quantity& quantity, const std::vector<double>& times,
                                         const std::vector<double>& samples) {
  std::map<long, double> weights;
  const double end = times.back(), slack = 1e-9 * (times[1] - times[0]);
  switch (quantity.kind) {
    case Quantity::Kind::at_time:
    case Quantity::Kind::integral:
      if (!(quantity.from >= times.front() - slack && quantity.to <= end + slack && quantity.from <= quantity.to))
        refuse(quantity,
               "'" + quantity.name() + "' asks for times outside the run, which ends at " + std::to_string(end) + " s",
               "give times between its begin and its end");
      if (quantity.kind == Quantity::Kind::at_time)
        add_value(times, quantity.to, weights);
      else
        add_integral(times, quantity.from, quantity.to, weights);
      break;
    default:
      add_extremum(quantity, times, samples, weights);
  }
  std::vector<SampleWeight> result;
  for (const auto& [step, weight] : weights)
    if (weight != 0) result.push_back({step, weight});
  return result;
}

}  // namespace lithe
