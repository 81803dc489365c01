#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/page/run.h"

namespace lithe {

struct PageOptions {
  std::string title{};  // empty: the names of the runs
};

/// Writes a recorded run as one HTML file that opens in any browser, without a server or a network: bodies in 3D,
/// charts, the system graph, mode shapes. See docs/page.md. The file appears under its name only when
/// complete. Throws SceneError for a run without states, FileError if it cannot be written.
void write_page(const Run& run, const std::string& path, const PageOptions& options = {});
/// Variants of one scene, overlaid, with charts of their differences: write_page({rigid, flexible}, …).
/// Throws SceneError likewise, and for two runs of one name.
void write_page(const std::vector<std::reference_wrapper<const Run>>& runs, const std::string& path,
                const PageOptions& options = {});

}  // namespace lithe
