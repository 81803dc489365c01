// The fuzzer's side of the targets: one program, the target named by LITHE_FUZZ_TARGET; tools/fuzz.sh builds and runs
// it. A reader returns what is sound, or throws lithe::Error; anything else is a crash.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/temporary_folder.h"
#include "tools/fuzz/targets.h"

namespace {

using lithe::fuzz::Target;

Target chosen() {
  const char* name = std::getenv("LITHE_FUZZ_TARGET");
  for (const Target& target : lithe::fuzz::all_targets())
    if (name && target.name == std::string(name)) return target;
  std::fprintf(stderr, "LITHE_FUZZ_TARGET names no target: '%s'\n", name ? name : "");
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const lithe::log::Quiet quiet;
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
