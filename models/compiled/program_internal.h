#pragma once

// The program around a compiled scene; `lithe compile` copies this text into the source it writes.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <vector>

#include "models/compiled/runtime_internal.h"

namespace lithe_compiled {

/// State and inputs of a scene in S, all lanes alike.
template <class Scene, class S>
struct SceneState {
  std::array<S, Scene::kPositions> q = {};
  std::array<S, Scene::kVelocities> v = {}, a = {};
  std::array<S, Scene::kInputs> u = {};
  SceneState() { start(); }
  void start() {
    for (int i = 0; i < Scene::kPositions; ++i) q[i] = S(Scene::kStartPositions[i]);
    for (int i = 0; i < Scene::kVelocities; ++i) v[i] = S(Scene::kStartVelocities[i]);
    for (int i = 0; i < Scene::kInputs; ++i) u[i] = S(Scene::kStartInputs[i]);
  }
};

template <class Scene, class S>
[[gnu::noinline]] void evaluate(SceneState<Scene, S>& x) {
  Scene::accelerations(x.q.data(), x.v.data(), x.u.data(), x.a.data());
}
template <class Scene, class S>
[[gnu::noinline]] void step_once(SceneState<Scene, S>& x, double step, bool euler) {
  if (euler)
    step_euler<Scene>(x.q.data(), x.v.data(), x.u.data(), step);
  else
    step_runge_kutta<Scene>(x.q.data(), x.v.data(), x.u.data(), step);
}

inline double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// CPU seconds of so many evaluations.
template <class Scene, class S>
double evaluation_seconds(long count) {
  SceneState<Scene, S> x;
  const double started = cpu_seconds();
  for (long i = 0; i < count; ++i) evaluate(x);
  return cpu_seconds() - started;
}

/// One number against lanes, by turns: the least of five each.
template <class Scene>
void print_throughput(long count) {
  double alone = 1e300, four = 1e300, eight = 1e300;
  for (int turn = 0; turn < 5; ++turn) {
    alone = std::min(alone, evaluation_seconds<Scene, double>(count));
    four = std::min(four, evaluation_seconds<Scene, Pack<4>>(count) / 4);
    eight = std::min(eight, evaluation_seconds<Scene, Pack<8>>(count) / 8);
  }
  const double us = 1e6 / static_cast<double>(count);
  std::printf(
      "{\"scene\": \"%s\", \"freedoms\": %d, \"us_per_acceleration\": %.5g, \"us_in_4_lanes\": %.5g, "
      "\"us_in_8_lanes\": %.5g, \"times_by_4_lanes\": %.3g, \"times_by_8_lanes\": %.3g}\n",
      Scene::kName, Scene::kVelocities, us * alone, us * four, us * eight, alone / four, alone / eight);
}

/// Times of single steps; every second of the scene it begins anew.
template <class Scene>
void print_histogram(long count, double step, bool euler) {
  using Clock = std::chrono::steady_clock;
  SceneState<Scene, double> x;
  std::vector<double> us(static_cast<std::size_t>(count));
  for (int i = 0; i < 1000; ++i) step_once(x, step, euler);  // caches and pages
  double now = 0;
  x.start();
  for (double& time : us) {
    if (now >= 1) x.start(), now = 0;
    const auto started = Clock::now();
    step_once(x, step, euler);
    time = std::chrono::duration<double, std::micro>(Clock::now() - started).count();
    now += step;
  }
  std::sort(us.begin(), us.end());
  const auto part = [&](double share) { return us[static_cast<std::size_t>(share * static_cast<double>(count - 1))]; };
  const double median = part(0.5);
  std::printf("%s: %ld steps of %g s by %s\n", Scene::kName, count, step,
              euler ? "semi-implicit Euler" : "Runge-Kutta 4");
  std::printf("  median %.3f us, 99.9 %% within %.3f us, longest %.3f us = %.1f medians\n", median, part(0.999),
              us.back(), us.back() / median);
  const double bounds[] = {0.9, 1.1, 1.25, 1.5, 2, 4, 16, 64, 1e300};
  auto from = us.begin();
  for (const double bound : bounds) {
    const auto to = std::lower_bound(from, us.end(), bound * median);
    if (to != from) {
      if (bound < 1e300)
        std::printf("  below %5.2f medians %9ld ", bound, static_cast<long>(to - from));
      else
        std::printf("  longer             %9ld ", static_cast<long>(to - from));
      const long stars = 50 * static_cast<long>(to - from) / count;
      for (long i = 0; i < stars; ++i) std::putchar('*');
      std::putchar('\n');
    }
    from = to;
  }
}

/// The motion for so many seconds: coordinates at every hundredth, as CSV.
template <class Scene>
void print_motion(double duration, double step, bool euler) {
  SceneState<Scene, double> x;
  std::printf("time");
  for (const char* name : Scene::kPositionNames) std::printf(",%s", name);
  const long steps = std::lround(duration / step), every = std::max(1L, steps / 100);
  for (long i = 0; i <= steps; ++i) {
    if (i % every == 0) {
      std::printf("\n%.9g", static_cast<double>(i) * step);
      for (const double q : x.q) std::printf(",%.17g", q);
    }
    step_once(x, step, euler);
  }
  std::printf("\n");
}

/// What is counted by callgrind: evaluations or steps of S, nothing else that grows with their number.
template <class Scene, class S>
void only(long count, bool steps) {
  SceneState<Scene, S> x;
  for (long i = 0; i < count; ++i) {
    if (steps)
      step_once(x, 1e-6, false);
    else
      evaluate(x);
  }
  double sum = 0;
  for (const S& a : x.a) sum += lane(a, 0);
  std::printf("{\"count\": %ld, \"sum\": %.17g}\n", count, sum);
}

template <class Scene>
int program(int argument_count, char** words) {
  const auto word = [&](int i) { return i < argument_count ? words[i] : ""; };
  const auto number = [&](int i, double fallback) { return i < argument_count ? std::atof(words[i]) : fallback; };
  const char* what = word(1);
  const auto count = static_cast<long>(number(2, 1e6));
  const bool euler = std::strcmp(word(4), "euler") == 0;
  const double step = number(3, 1e-3);
  const auto is = [&](const char* name) { return std::strcmp(what, name) == 0; };
  if (!(number(2, 1) > 0) || !(step > 0)) {
    std::fprintf(stderr, "error: numbers of steps and times are positive\n");
    return 1;
  }
  if (is("") || is("histogram")) {
    print_histogram<Scene>(count, step, euler);
    if (is("")) print_throughput<Scene>(20000);
  } else if (is("throughput")) {
    print_throughput<Scene>(count);
  } else if (is("motion")) {
    print_motion<Scene>(number(2, 1), step, euler);
  } else if (is("accelerations")) {
    only<Scene, double>(count, false);
  } else if (is("accelerations4")) {
    only<Scene, Pack<4>>(count, false);
  } else if (is("accelerations8")) {
    only<Scene, Pack<8>>(count, false);
  } else if (is("steps")) {
    only<Scene, double>(count, true);
  } else if (is("steps8")) {
    only<Scene, Pack<8>>(count, true);
  } else {
    std::fprintf(stderr,
                 "%s [histogram STEPS [STEP [euler]]]   times of single steps, of 1e-3 s by Runge-Kutta 4\n"
                 "%s throughput EVALUATIONS             one scene against 4 and 8 in lanes\n"
                 "%s motion SECONDS [STEP [euler]]      coordinates as CSV\n"
                 "%s accelerations|accelerations4|accelerations8|steps|steps8 COUNT   to be counted by callgrind\n",
                 words[0], words[0], words[0], words[0]);
    return std::strcmp(what, "--help") == 0 ? 0 : 1;
  }
  return 0;
}

}  // namespace lithe_compiled
