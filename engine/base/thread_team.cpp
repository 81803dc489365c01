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
  done_.store(0, std::memory_order_relaxed);
  const unsigned round = round_.load(std::memory_order_relaxed) + 1;
  left_.store(std::uint64_t{round} << 32 | static_cast<unsigned>(count), std::memory_order_release);
  round_.store(round, std::memory_order_release);
  round_.notify_all();
  work();
  for (int looks = 0; done_.load(std::memory_order_acquire) < count; ++looks)
    looks < kAwake ? pause() : std::this_thread::yield();
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

/// Who takes a job holds its round open: until the job is done, run() returns to nobody and what it shared stays.
void ThreadTeam::work() {
  std::uint64_t left = left_.load(std::memory_order_acquire);
  while (static_cast<std::uint32_t>(left) > 0) {
    if (!left_.compare_exchange_weak(left, left - 1, std::memory_order_acquire)) continue;
    const int i = count_ - static_cast<int>(static_cast<std::uint32_t>(left));
    try {
      call_(data_, i);
    } catch (...) {
      keep_error(i);
    }
    done_.fetch_add(1, std::memory_order_release);
    left = left_.load(std::memory_order_acquire);
  }
}

void ThreadTeam::keep_error(int i) {
  const std::lock_guard lock(mutex_);
  if (!error_ || i < failed_) error_ = std::current_exception(), failed_ = i;
}

void ThreadTeam::wait_for_work() {
  for (unsigned seen = 0;;) {
    for (int looks = 0; round_.load(std::memory_order_acquire) == seen && looks < kAwake; ++looks) pause();
    round_.wait(seen);
    if (over_) return;
    seen = round_.load(std::memory_order_acquire);
    work();
  }
}

}  // namespace lithe
