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

/// From one event to the next: states first … last.
struct Smooth {
  long first, last;
};
std::vector<Smooth> smooth_parts(const std::vector<double>& times) {
  std::vector<Smooth> parts{{0, 0}};
  for (long i = 1; i < static_cast<long>(times.size()); ++i)
    if (times[i] > times[i - 1])
      parts.back().last = i;
    else
      parts.push_back({i, i});
  return parts;
}

/// Of the part with the extreme state; at an event it has no weights that hold.
const Smooth& part_of_extremum(const Quantity& quantity, const std::vector<Smooth>& parts,
                               const std::vector<double>& times, const std::vector<double>& samples) {
  if (parts.size() == 1) return parts.front();
  const auto top = quantity.kind == Quantity::Kind::largest ? std::max_element(samples.begin(), samples.end())
                                                            : std::min_element(samples.begin(), samples.end());
  const long at = top - samples.begin();
  const auto part = std::find_if(parts.begin(), parts.end(), [&](const Smooth& p) { return at <= p.last; });
  if ((at == part->first && at != 0) || (at == part->last && at != parts.back().last))
    refuse(quantity, "'" + quantity.name() + "' is reached at an event, at t = " + std::to_string(times[at]) + " s",
           "ask for the value at a time");
  return *part;
}

}  // namespace

std::vector<SampleWeight> sample_weights(const Quantity& quantity, const std::vector<double>& times,
                                         const std::vector<double>& samples) {
  std::map<long, double> weights;
  const std::vector<Smooth> parts = smooth_parts(times);
  const double end = times.back(), slack = 1e-9 * (times[1] - times[0]);
  const auto within = [&](const Smooth& part, const std::vector<double>& of) {
    return std::vector<double>(of.begin() + part.first, of.begin() + part.last + 1);
  };
  const auto add_shifted = [&](const Smooth& part, const std::map<long, double>& found) {
    for (const auto& [step, weight] : found) weights[part.first + step] += weight;
  };
  switch (quantity.kind) {
    case Quantity::Kind::at_time:
    case Quantity::Kind::integral:
      if (!(quantity.from >= times.front() - slack && quantity.to <= end + slack && quantity.from <= quantity.to))
        refuse(quantity,
               "'" + quantity.name() + "' asks for times outside the run, which ends at " + std::to_string(end) + " s",
               "give times between its begin and its end");
      for (const Smooth& part : parts) {
        if (part.first == part.last) continue;
        std::map<long, double> found;
        const std::vector<double> inside = within(part, times);
        if (quantity.kind == Quantity::Kind::integral)
          add_integral(inside, quantity.from, quantity.to, found);
        else if (quantity.to <= inside.back() || part.last == parts.back().last)
          add_value(inside, quantity.to, found);
        add_shifted(part, found);
        if (quantity.kind == Quantity::Kind::at_time && !found.empty()) break;
      }
      break;
    default: {
      const Smooth& part = part_of_extremum(quantity, parts, times, samples);
      std::map<long, double> found;
      add_extremum(quantity, within(part, times), within(part, samples), found);
      add_shifted(part, found);
    }
  }
  std::vector<SampleWeight> result;
  for (const auto& [step, weight] : weights)
    if (weight != 0) result.push_back({step, weight});
  return result;
}

}  // namespace lithe
