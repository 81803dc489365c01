#pragma once

#include <csignal>

namespace lithe {

/// While a guard exists, SIGINT and SIGTERM do not kill the program: runs of Simulation end after the current step with
/// SimulationError "interrupted"; the state is kept and observers receive it. A second signal kills as usual. A signal
/// that no run has seen takes effect when the last guard is destroyed. Signals that the program ignores stay ignored.
///   const InterruptGuard guard;
///   try { simulation.run(state, 10); } catch (const SimulationError&) { recorder.write_csv("so_far.csv"); throw; }
/// The only global of the engine: signals are sent to a process, not to an object.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// The signal that asks runs to end; 0: none.
  static int asked();

 private:
  struct sigaction old_interrupt_, old_terminate_;
};

}  // namespace lithe
