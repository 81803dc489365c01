#include "engine/base/interrupt.h"

#include <atomic>

namespace lithe {
namespace {

std::atomic<int> signal_asked{0}, guards{0};
std::atomic<bool> signal_seen{false};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may touch nothing else");

void ask(int signal) {
  signal_asked = signal;
  std::signal(SIGINT, SIG_DFL);  // the next one kills
  std::signal(SIGTERM, SIG_DFL);
}

void install(int signal, struct sigaction& old) {
  struct sigaction wanted {};
  wanted.sa_handler = ask;
  wanted.sa_flags = SA_RESTART;  // a write that is under way goes on
  sigemptyset(&wanted.sa_mask);
  sigaction(signal, nullptr, &old);
  if (old.sa_handler != SIG_IGN) sigaction(signal, &wanted, nullptr);
}

}  // namespace

InterruptGuard::InterruptGuard() {
  ++guards;
  install(SIGINT, old_interrupt_);
  install(SIGTERM, old_terminate_);
}

InterruptGuard::~InterruptGuard() {
  sigaction(SIGINT, &old_interrupt_, nullptr);
  sigaction(SIGTERM, &old_terminate_, nullptr);
  if (--guards > 0) return;
  const int signal = signal_asked.exchange(0);
  if (!signal_seen.exchange(false) && signal != 0) std::raise(signal);
}

int InterruptGuard::asked() {
  const int signal = signal_asked.load(std::memory_order_relaxed);
  if (signal != 0) signal_seen = true;
  return signal;
}

}  // namespace lithe
