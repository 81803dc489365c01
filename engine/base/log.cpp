#include "engine/base/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdlib>
#include <mutex>

namespace lithe::log {
namespace {

std::mutex warning_mutex;
std::string newest_warning;
thread_local int quiet = 0;

spdlog::logger& logger() {
  static const auto instance = [] {
    auto made = spdlog::stderr_color_mt("lithe");
    made->set_pattern("%^%l%$: %v");
    const char* level = std::getenv("LITHE_LOG");
    made->set_level(level ? spdlog::level::from_str(level) : spdlog::level::warn);
    return made;
  }();
  return *instance;
}

}  // namespace

Quiet::Quiet() { ++quiet; }
Quiet::~Quiet() { --quiet; }

void info(const std::string& message) {
  if (quiet == 0) logger().info(message);
}
void debug(const std::string& message) {
  if (quiet == 0) logger().debug(message);
}
void warn(const std::string& message) {
  if (quiet > 0) return;
  {
    const std::lock_guard lock(warning_mutex);
    newest_warning = message;
  }
  logger().warn(message);
}
std::string last_warning() {
  const std::lock_guard lock(warning_mutex);
  return newest_warning;
}

}  // namespace lithe::log
