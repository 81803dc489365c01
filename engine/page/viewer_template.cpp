// The viewer as bytes of this object: read by the assembler, so that a megabyte costs no compile time.
#include <string_view>

#include "engine/page/run_record_internal.h"

// clang-format off
__asm__(
    ".pushsection .rodata\n"
    ".hidden lithe_viewer_html\n"
    ".globl lithe_viewer_html\n"
    "lithe_viewer_html:\n"
    ".incbin \"" LITHE_VIEWER_HTML "\"\n"
    ".hidden lithe_viewer_html_end\n"
    ".globl lithe_viewer_html_end\n"
    "lithe_viewer_html_end:\n"
    ".byte 0\n"
    ".popsection\n");
// clang-format on

extern "C" {
__attribute__((visibility("hidden"))) extern const char lithe_viewer_html[], lithe_viewer_html_end[];
}

namespace lithe {

std::string_view viewer_template() {
  return {lithe_viewer_html, static_cast<std::size_t>(lithe_viewer_html_end - lithe_viewer_html)};
}

}  // namespace lithe
