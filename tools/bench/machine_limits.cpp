// machine_limits: what one core of this machine can do at most, for the roofline note of docs/benchmarks.md.
//
//   --repeat 5  runs, the best counts
//
// Multiply-adds on registers alone, two flops a number, in vectors as wide as this build has (GFLOP/s); then the stream
// triad a = b + s c over arrays that fit the second cache, and over arrays that fit no cache (GB/s, three numbers
// each).
#include <vector>

#include "tools/bench/measure.h"

namespace {

using lithe::bench::cpu_seconds;

#ifdef __AVX512F__
constexpr int kWidth = 8;
#else
constexpr int kWidth = 4;
#endif
typedef double Wide __attribute__((vector_size(8 * kWidth)));

double flops_a_second() {
  constexpr int kChains = 12;  // enough to hide the latency of two units
  constexpr long kSteps = 20'000'000;
  Wide sum[kChains] = {}, factor = {}, shift = {};
  for (int i = 0; i < kWidth; ++i) factor[i] = 0.999999, shift[i] = 1e-6;
  const double started = cpu_seconds();
  for (long step = 0; step < kSteps; ++step)
#pragma GCC unroll 12
    for (int i = 0; i < kChains; ++i) sum[i] = sum[i] * factor + shift;
  const double seconds = cpu_seconds() - started;
  double total = 0;
  for (const Wide& one : sum) total += one[0];
  if (total == 0) return 0;  // so that the sums are not left out
  return 2.0 * kWidth * kChains * kSteps / seconds;
}

double triad_bytes_a_second(size_t count) {
  std::vector<double> a(count, 0.0), b(count, 1.0), c(count, 2.0);
  const long passes = std::max<long>(3, static_cast<long>(200'000'000 / count));
  const double started = cpu_seconds();
  for (long pass = 0; pass < passes; ++pass) {
    const double s = 1e-9 * static_cast<double>(pass);
    for (size_t i = 0; i < count; ++i) a[i] = b[i] + s * c[i];
    asm volatile("" : : "r"(a.data()) : "memory");  // every pass is made
  }
  return 24.0 * static_cast<double>(count) * static_cast<double>(passes) / (cpu_seconds() - started);
}

}  // namespace

int main(int argument_count, char** words) {
  return lithe::bench::run_program(argument_count, words, [](lithe::bench::Arguments& arguments) {
    const int repeats = arguments.integer("repeat", 5);
    arguments.finish();
    double flops = 0, cached = 0, memory = 0;
    for (int i = 0; i < repeats; ++i) {
      flops = std::max(flops, flops_a_second());
      cached = std::max(cached, triad_bytes_a_second(30'000));      // 0.7 MB
      memory = std::max(memory, triad_bytes_a_second(40'000'000));  // 1 GB
    }
    lithe::bench::JsonLine line;
    line.add("program", "machine_limits").add("gflops", 1e-9 * flops, 4);
    line.add("gb_per_s_cached", 1e-9 * cached, 4).add("gb_per_s_memory", 1e-9 * memory, 4).print();
  });
}
