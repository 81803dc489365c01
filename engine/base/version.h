#pragma once

namespace lithe {

/// Of this engine; CMakeLists.txt reads it here.
inline constexpr const char* kVersion = "0.1.0";

}  // namespace lithe
