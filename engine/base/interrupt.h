#pragma once

#include <csignal>

namespace lithe {

/// While one lives, SIGINT and SIGTERM do not kill the program: runs of Simulation end after their present step with
/// SimulationError "interrupted", their state kept and observers told of it. A second signal kills as usual. A signal
/// that no run has seen takes effect when the last guard is gone. Signals that the program ignores stay ignored.
///   const InterruptGuard guard;
///   try { simulation.run(state, 10); } catch (const SimulationError&) { recorder.write_csv("so_far.csv"); throw; }
/// The one global of the engine: signals come to a process, not to an object.
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
