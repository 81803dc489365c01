#pragma once

#include <functional>
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

enum class Level { debug, info, warn };

/// While it lives, messages of this thread go to `sink` instead: to whoever called the engine as a component. The sink
/// must not throw, and may be called at any time.
class Redirect {
 public:
  explicit Redirect(std::function<void(Level level, const std::string& message)> sink);
  ~Redirect();
  Redirect(const Redirect&) = delete;
  Redirect& operator=(const Redirect&) = delete;

 private:
  std::function<void(Level, const std::string&)> sink_;
  const std::function<void(Level, const std::string&)>* outer_;
};

}  // namespace lithe::log
