#pragma once

#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string_view>

namespace lithe::fuzz {

/// The input as choices: what is sane where a byte is below 192 or the input has ended, else what is not.
class FuzzScript {
 public:
  explicit FuzzScript(std::string_view bytes = {}) : rest_(bytes) {}

  bool ended() const { return rest_.empty(); }
  std::uint8_t byte() {
    if (rest_.empty()) return 0;
    const auto first = static_cast<std::uint8_t>(rest_.front());
    rest_.remove_prefix(1);
    return first;
  }
  /// Whether something is to be odd.
  bool odd() { return byte() >= kOdd; }
  /// Bytes of the input as they are, zeros beyond its end.
  template <class Value>
  Value raw() {
    unsigned char bytes[sizeof(Value)];
    for (unsigned char& one : bytes) one = byte();
    Value value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
  }
  template <class Value>
  Value one_of(Value sane, std::span<const Value> odd_ones) {
    const std::uint8_t choice = byte();
    return choice < kOdd ? sane : odd_ones[(choice - kOdd) % odd_ones.size()];
  }
  double number(double sane) {
    using Limits = std::numeric_limits<double>;
    static constexpr double kOddOnes[] = {
        Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(), 1e308, -1e308, 5e-324, 0, -1, 1, 1e9, 0};
    const std::uint8_t choice = byte();
    if (choice < kOdd) return sane;
    const std::size_t which = (choice - kOdd) % std::size(kOddOnes);
    return which + 1 < std::size(kOddOnes) ? kOddOnes[which] : raw<double>();
  }
  /// A number, index or code: small ones on both sides of zero, and the ends.
  std::int32_t integer(std::int32_t sane) {
    using Limits = std::numeric_limits<std::int32_t>;
    static constexpr std::int32_t kOddOnes[] = {-1, 0, 1, 2, 3, 9, 13, 65, Limits::max(), Limits::min(), -7, 77};
    return one_of<std::int32_t>(sane, kOddOnes);
  }

 private:
  static constexpr std::uint8_t kOdd = 192;
  std::string_view rest_;
};

}  // namespace lithe::fuzz
