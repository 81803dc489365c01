#pragma once

#include <optional>
#include <string>
#include <vector>

namespace lithe {

/// Texts one after the other, each closed by a zero: short, and no pointers in a file.
inline std::string packed(const std::vector<std::string>& texts) {
  std::string bytes;
  for (const std::string& text : texts) bytes += text + '\0';
  return bytes;
}

/// The texts that were packed; none where the last one is not closed.
inline std::optional<std::vector<std::string>> unpacked(const std::string& bytes) {
  std::vector<std::string> texts;
  for (std::size_t from = 0; from < bytes.size();) {
    const std::size_t end = bytes.find('\0', from);
    if (end == std::string::npos) return {};
    texts.push_back(bytes.substr(from, end - from));
    from = end + 1;
  }
  return texts;
}

}  // namespace lithe
