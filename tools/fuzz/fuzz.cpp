// The fuzzer's side of the targets: one program, the target named by LITHE_FUZZ_TARGET; tools/fuzz.sh builds and runs
// it. A reader returns what is sound, or throws lithe::Error; anything else is a crash.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "engine/base/error.h"
#include "engine/base/temporary_folder.h"
#include "tools/fuzz/targets.h"

// Messages are of no interest here, and spdlog is not linked.
namespace lithe::log {
void info(const std::string&) {}
void warn(const std::string&) {}
}  // namespace lithe::log

namespace {

using lithe::fuzz::Target;

std::vector<Target> all_targets() {
  std::vector<Target> all = lithe::fuzz::body_targets();
  const auto add = [&](const std::vector<Target>& more) { all.insert(all.end(), more.begin(), more.end()); };
  add(lithe::fuzz::table_targets());
  add(lithe::fuzz::model_targets());
  return all;
}

Target chosen() {
  const char* name = std::getenv("LITHE_FUZZ_TARGET");
  for (const Target& target : all_targets())
    if (name && target.name == std::string(name)) return target;
  std::fprintf(stderr, "LITHE_FUZZ_TARGET names no target: '%s'\n", name ? name : "");
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Target target = chosen();
  static const lithe::TemporaryFolder folder("lithe_fuzz");
  for (const auto& old : std::filesystem::directory_iterator(folder.path())) std::filesystem::remove_all(old.path());
  try {
    target.run({reinterpret_cast<const char*>(data), size}, folder.path());
  } catch (const lithe::Error&) {  // refused, as it should be
  } catch (const lithe::fuzz::SilentAcceptance& wrong) {
    std::fprintf(stderr, "taken as good: %s\n", wrong.what());
    std::abort();
  }
  return 0;
}
