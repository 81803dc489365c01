#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "engine/study/sweep_internal.h"

namespace lithe {

int free_processors(int ranks_on_this_machine) {
  const int all = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
  cpu_set_t allowed;
  if (pthread_getaffinity_np(pthread_self(), sizeof allowed, &allowed) == 0 && CPU_COUNT(&allowed) < all)
    return CPU_COUNT(&allowed);
  return std::max(1, all / ranks_on_this_machine);
}

SweepThreads::SweepThreads(int threads, Compute compute) : compute_(std::move(compute)) {
  try {
    for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
  } catch (const std::system_error&) {  // the system gives no more: fewer do the same work
    if (threads_.empty()) throw;
  } catch (...) {
    close();
    throw;
  }
}

SweepThreads::~SweepThreads() { close(); }

void SweepThreads::close() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  given_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void SweepThreads::add(int row) {
  {
    const std::lock_guard lock(mutex_);
    rows_.push_back(row);
  }
  given_.notify_one();
}

std::vector<SweepOutcome> SweepThreads::take(std::chrono::microseconds patience) {
  std::unique_lock lock(mutex_);
  finished_.wait_for(lock, patience, [this] { return !outcomes_.empty(); });
  return std::exchange(outcomes_, {});
}

void SweepThreads::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    given_.wait(lock, [this] { return closing_ || !rows_.empty(); });
    if (closing_) return;
    const int row = rows_.front();
    rows_.pop_front();
    lock.unlock();
    SweepOutcome outcome = compute_(row);
    lock.lock();
    outcomes_.push_back(std::move(outcome));
    finished_.notify_one();
  }
}

}  // namespace lithe
