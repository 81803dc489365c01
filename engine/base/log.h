#pragma once

#include <string>

/// One line a milestone, through spdlog (its one home is log.cpp). Level by LITHE_LOG=debug|info|warn|error|off.
namespace lithe::log {

void info(const std::string& message);
void warn(const std::string& message);
void debug(const std::string& message);

/// The newest warning of this process; empty if there was none.
std::string last_warning();

/// While it lives, warnings and milestones of this thread are dropped: drawings that only repeat another one.
class Quiet {
 public:
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;
};

}  // namespace lithe::log
