#pragma once

#include <string>

/// One line a milestone, through spdlog (its one home is log.cpp). Level by LITHE_LOG=debug|info|warn|error|off.
namespace lithe::log {

void info(const std::string& message);
void warn(const std::string& message);
void debug(const std::string& message);

/// The newest warning of this process; empty if there was none.
std::string last_warning();

}  // namespace lithe::log
