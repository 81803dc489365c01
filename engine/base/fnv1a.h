#pragma once

#include <cstdint>
#include <string_view>

namespace lithe {

inline constexpr std::uint64_t kFnvStart = 14695981039346656037ull, kFnvPrime = 1099511628211ull;

/// A digest of bytes against damage, not against malice (Fowler, Noll, Vo: FNV-1a, 64 bits); goes on from `hash`.
inline std::uint64_t fnv1a(std::string_view bytes, std::uint64_t hash = kFnvStart) {
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * kFnvPrime;
  return hash;
}

}  // namespace lithe
