#pragma once

#include <cstdint>
#include <string_view>

namespace lithe {

/// A digest of bytes against damage, not against malice (Fowler, Noll, Vo: FNV-1a, 64 bits).
inline std::uint64_t fnv1a(std::string_view bytes) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  return hash;
}

}  // namespace lithe
