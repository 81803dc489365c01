#include <zlib.h>

#include "engine/base/error.h"
#include "engine/page/run_record_internal.h"

namespace lithe {

std::string packed_text(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                bytes.size(), Z_BEST_COMPRESSION) != Z_OK)
    throw SceneError("the data of the page cannot be compressed", "write_page", "free some memory");
  packed.resize(size);

  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((packed.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < packed.size(); i += 3) {
    const auto byte = [&](std::size_t k) -> unsigned {
      return i + k < packed.size() ? static_cast<unsigned char>(packed[i + k]) : 0;
    };
    const unsigned triple = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (const int shift : {18, 12, 6, 0}) text += kDigits[triple >> shift & 63];
  }
  for (std::size_t k = 0; k < (3 - packed.size() % 3) % 3; ++k) text[text.size() - 1 - k] = '=';
  return text;
}

}  // namespace lithe
