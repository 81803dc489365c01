#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace lithe {

/// Threads that share many short pieces of work: between them they spin for a moment, then sleep. A call waits for its
/// jobs, not for its threads: one that gets no processor in time costs nothing, the others have done its share.
class ThreadTeam {
 public:
  /// So many threads in all, the caller's among them.
  explicit ThreadTeam(int threads);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;

  int size() const { return 1 + static_cast<int>(threads_.size()); }

  /// Calls job(i) for 0 <= i < count, in no order, and returns when all are done. Rethrows what the job of the lowest i
  /// threw, as one thread would that takes them in turn.
  template <class Job>
  void run(int count, const Job& job) {
    const Call call = [](const void* data, int i) { (*static_cast<const Job*>(data))(i); };
    run(count, call, &job);
  }

 private:
  using Call = void (*)(const void*, int);
  void run(int count, Call call, const void* data);
  void work();
  void keep_error(int i);
  void wait_for_work();
  void close();

  Call call_ = nullptr;
  const void* data_ = nullptr;
  int count_ = 0;
  std::atomic<std::uint64_t> left_{0};  // the round, and in the lower half how many of its jobs nobody has taken
  std::atomic<int> done_{0};
  std::atomic<unsigned> round_{0};  // what threads sleep on
  std::atomic<bool> over_{false};
  std::mutex mutex_;  // of what failed
  std::exception_ptr error_;
  int failed_ = 0;
  std::vector<std::thread> threads_;
};

}  // namespace lithe
