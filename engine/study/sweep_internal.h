#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "engine/study/sweep.h"

namespace lithe {

/// What a point came to: its values, or why there are none.
struct SweepOutcome {
  int row = 0;
  double seconds = 0;  // wall time
  SweepValues values{};
  std::optional<SweepFailure> failure{};
};

/// Threads that compute the points they are given.
class SweepThreads {
 public:
  using Compute = std::function<SweepOutcome(int row)>;  // throws nothing
  SweepThreads(int threads, Compute compute);
  ~SweepThreads();  // waits for points under way; those not begun are dropped
  SweepThreads(const SweepThreads&) = delete;
  SweepThreads& operator=(const SweepThreads&) = delete;

  int size() const { return static_cast<int>(threads_.size()); }
  void add(int row);
  /// The points that have been finished since the last call; waits for one, but no longer than `patience`.
  std::vector<SweepOutcome> take(std::chrono::microseconds patience);

 private:
  void work();
  void close();

  Compute compute_;
  std::mutex mutex_;
  std::condition_variable given_, finished_;
  std::deque<int> rows_;
  std::vector<SweepOutcome> outcomes_;
  bool closing_ = false;
  std::vector<std::thread> threads_;
};

/// Processors for this process: those it is bound to; else its share of the machine's.
int free_processors(int ranks_on_this_machine);

/// Told of each outcome, in any order, and of how many threads take part.
using SweepListener = std::function<void(SweepOutcome outcome, int threads)>;

/// The processes that mpirun started; one, where it did not. Its home is sweep_mpi.cpp; built without MPI, there is
/// always one. Once a process.
class SweepRanks {
 public:
  /// Null where this process runs alone.
  static SweepRanks* find();
  virtual ~SweepRanks() = default;

  virtual int rank() const = 0;
  virtual int ranks_on_this_machine() const = 0;
  /// Computes the points 0 … count - 1 together. On every rank `listener` receives all points, on rank 0 as they are
  /// finished. `fingerprint`: of the parameters; ranks that sweep different ones end the program. `meanwhile` is called
  /// again and again on rank 0 while it waits.
  virtual void share(SweepThreads& team, int count, std::uint64_t fingerprint, const SweepListener& listener,
                     const std::function<void()>& meanwhile) = 0;
};

}  // namespace lithe
