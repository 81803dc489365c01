#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/page/run.h"

namespace lithe {

/// What a look at the scene has found, for a list on the page: page_findings() of a diagnosis (engine/study/doctor.h).
/// Names of bodies and connectors that stand in 'quotes' select these by a click.
struct PageFinding {
  std::string kind{};  // "open joint"
  std::string text{};
  std::string fix{};  // empty: none
  bool alarm = true;  // false: worth knowing
};

struct PageOptions {
  std::string title{};                  // empty: the names of the runs
  std::vector<PageFinding> findings{};  // most important first
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
