#include "tools/contact/measure.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tools/bench/measure.h"

namespace lithe::contact_bench {
namespace {

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char out[256];
  std::snprintf(out, sizeof out, pattern, values...);
  return out;
}

constexpr double kLong = 60;  // s: runs of more are not repeated

/// One run; `watch` fills in what is measured of the motion, or else time alone is.
void run(const Pile& pile, double step, const Contender& contender, bool watch, Measurement& result) {
  const std::unique_ptr<Stepper> stepper = contender.make(pile, step);
  const long count = std::lround(pile.end / step);
  Motions motions;
  stepper->read(motions);
  const double start = energy(pile, motions);
  double least = start, gain = 0, seconds = 0;
  for (long k = 1; k <= count; ++k) {
    const double before = bench::cpu_seconds();
    stepper->step();
    seconds += bench::cpu_seconds() - before;
    if (!watch) continue;
    stepper->read(motions);
    const double now = energy(pile, motions);
    gain = std::max(gain, now - least);
    least = std::min(least, now);
    const double deep = overlap(pile, motions);
    result.deepest = std::max(result.deepest, deep);
    if (k > count - count / 4) result.late += deep / static_cast<double>(count / 4);
    result.tunnelled = std::max(result.tunnelled, tunnelled(pile, motions));
  }
  result.microseconds.push_back(1e6 * seconds / static_cast<double>(count));
  if (!watch) return;
  result.gain = start > least ? gain / (start - least) : 0;
  result.iterations = stepper->iterations();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    result.highest = std::max(result.highest, motions[i].position[2]);
    result.kinetic +=
        0.5 * pile.mass[i] * motions[i].velocity.squaredNorm() + 0.5 * pile.inertia(i) * motions[i].spin.squaredNorm();
  }
}

}  // namespace

double Measurement::median() const {
  if (microseconds.empty()) return NAN;
  std::vector<double> sorted = microseconds;
  std::ranges::sort(sorted);
  return 0.5 * (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]);
}

std::vector<Measurement> measure(const Pile& pile, double step, const std::vector<Contender>& contenders, int repeats) {
  std::vector<Measurement> results;
  for (const Contender& contender : contenders) {
    results.emplace_back();
    results.back().pile = pile.name;
    results.back().contender = contender.name;
    results.back().step = step;
    results.back().bodies = pile.count();
  }
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (std::size_t i = 0; i < contenders.size(); ++i) {
      if (!results[i].failure.empty()) continue;
      if (repeat > 0 && 1e-6 * results[i].microseconds[0] * pile.end / step > kLong) continue;
      try {
        run(pile, step, contenders[i], repeat == 0, results[i]);
      } catch (const std::exception& error) {
        results[i].failure = error.what();
      }
      if (repeat == 0)
        std::fprintf(stderr, "%-9s %5.2f ms  %-28s %9.1f us a step, deepest %.3g mm, late %.3g mm %s\n",
                     pile.name.c_str(), 1e3 * step, contenders[i].name.c_str(), results[i].median(),
                     1e3 * results[i].deepest, 1e3 * results[i].late, results[i].failure.c_str());
    }
  return results;
}

std::string table_of(const std::vector<Measurement>& measurements) {
  std::string out =
      "| scene | step, ms | by | us a step | of Bullet's | deepest overlap, mm | mean of the last quarter, mm | of "
      "Bullet's | energy "
      "gained of lost | lost bodies |\n|---|--:|---|--:|--:|--:|--:|--:|--:|--:|\n";
  const Measurement* first = nullptr;
  for (const Measurement& m : measurements) {
    if (!first || first->pile != m.pile || first->step != m.step) first = &m;
    out += format("| %s | %.3g | %s | ", m.pile.c_str(), 1e3 * m.step, m.contender.c_str());
    if (!m.failure.empty()) {
      out += "stops: " + m.failure + " | | | | | | |\n";
      continue;
    }
    out += format("%.4g | %.2f | %.3g | %.2g | %.2g | %.1e | %d |\n", m.median(), m.median() / first->median(),
                  1e3 * m.deepest, 1e3 * m.late, m.late / first->late, m.gain, m.tunnelled);
  }
  return out;
}

std::string json_of(const std::vector<Measurement>& measurements) {
  nlohmann::json all = nlohmann::json::array();
  for (const Measurement& m : measurements)
    all.push_back({{"scene", m.pile},
                   {"bodies", m.bodies},
                   {"step", m.step},
                   {"by", m.contender},
                   {"failure", m.failure},
                   {"microseconds_per_step", m.microseconds},
                   {"deepest_overlap", m.deepest},
                   {"overlap_of_last_quarter", m.late},
                   {"energy_gain", m.gain},
                   {"tunnelled", m.tunnelled},
                   {"kinetic_energy_at_end", m.kinetic},
                   {"highest_centre_at_end", m.highest},
                   {"solver_iterations_per_step", m.iterations}});
  return all.dump(1) + "\n";
}

}  // namespace lithe::contact_bench
