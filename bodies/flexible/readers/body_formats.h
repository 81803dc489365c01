#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "bodies/flexible/readers/read_flexible_body.h"

namespace lithe {

/// What the first look at a path shows.
struct BodyOpening {
  std::filesystem::path path;
  std::string text;                  // its first 4096 characters, lower case
  std::vector<std::string> words{};  // of these
  bool begins_with(std::string_view start) const { return text.rfind(start, 0) == 0; }
  /// The same name with another ending: "job.inp" to "job.dof".
  std::filesystem::path beside(const char* extension) const {
    return std::filesystem::path(path).replace_extension(extension);
  }
};

/// What a format's reader fills, in the units of the file.
struct FoundBody {
  FlexibleBodyFile body;
  FiniteElementModel model;
  std::shared_ptr<const ModalBasis> basis;
  MatrixX modes;
};

struct BodyFormat {
  const char* name;
  bool (*recognised)(const BodyOpening&);
  FoundBody (*read)(const BodyOpening&, const ImportOptions&);
};

/// All formats, in the order in which they are tried.
const std::vector<BodyFormat>& body_formats();
/// The first look. A folder stands for its K.mtx, "job" for job.inp. FileError if there is no such file.
BodyOpening open_body(const std::string& given);

}  // namespace lithe
