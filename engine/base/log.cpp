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
thread_local const std::function<void(Level, const std::string&)>* sink = nullptr;

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

Redirect::Redirect(std::function<void(Level, const std::string&)> to) : sink_(std::move(to)), outer_(sink) {
  sink = &sink_;
}
Redirect::~Redirect() { sink = outer_; }

void info(const std::string& message) {
  if (quiet > 0) return;
  if (sink) return (*sink)(Level::info, message);
  logger().info(message);
}
void debug(const std::string& message) {
  if (quiet > 0) return;
  if (sink) return (*sink)(Level::debug, message);
  logger().debug(message);
}
void warn(const std::string& message) {
  if (quiet > 0) return;
  {
    const std::lock_guard lock(warning_mutex);
    newest_warning = message;
  }
  if (sink) return (*sink)(Level::warn, message);
  logger().warn(message);
}
std::string last_warning() {
  const std::lock_guard lock(warning_mutex);
  return newest_warning;
}

}  // namespace lithe::log
