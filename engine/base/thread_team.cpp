#include "engine/base/thread_team.h"

#include <system_error>
#include <utility>

namespace lithe {
namespace {

constexpr int kAwake = 2000;  // looks before a thread sleeps or lets others have its processor: some 50 microseconds

/// Between looks: leaves the core to what shares it.
inline void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

ThreadTeam::ThreadTeam(int threads) {
  try {
    for (int i = 1; i < threads; ++i) threads_.emplace_back([this] { wait_for_work(); });
  } catch (const std::system_error&) {  // the system gives no more: fewer do the same work
  } catch (...) {
    close();
    throw;
  }
}

ThreadTeam::~ThreadTeam() { close(); }

void ThreadTeam::close() {
  over_ = true;
  ++round_;
  round_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void ThreadTeam::run(int count, Call call, const void* data) {
  if (threads_.empty() || count < 2) {
    for (int i = 0; i < count; ++i) call(data, i);
    return;
  }
  call_ = call, data_ = data, count_ = count;
  next_ = 0;
  at_work_ = static_cast<int>(threads_.size());
  ++round_;
  round_.notify_all();
  work();
  for (int looks = 0; at_work_.load(std::memory_order_acquire) > 0; ++looks)
    looks < kAwake ? pause() : std::this_thread::yield();
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void ThreadTeam::work() {
  for (int i = next_++; i < count_; i = next_++) try {
      call_(data_, i);
    } catch (...) {
      keep_error(i);
    }
}

void ThreadTeam::keep_error(int i) {
  const std::lock_guard lock(mutex_);
  if (!error_ || i < failed_) error_ = std::current_exception(), failed_ = i;
}

void ThreadTeam::wait_for_work() {
  for (unsigned seen = 0;; ++seen) {
    for (int looks = 0; round_.load(std::memory_order_acquire) == seen && looks < kAwake; ++looks) pause();
    round_.wait(seen);
    if (over_) return;
    work();
    at_work_.fetch_sub(1, std::memory_order_release);
  }
}

}  // namespace lithe
