#include "engine/run/checkpoint.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "engine/base/error.h"
#include "engine/base/version.h"
#include "engine/observe/observer_schedules.h"
#include "engine/output/hdf5_file.h"

namespace lithe {
namespace {

constexpr std::int64_t kFormat = 4;
constexpr const char* kKind = "lithe checkpoint";
constexpr const char* kByteOrder = std::endian::native == std::endian::little ? "little" : "big";

/// FNV-1a, eight bytes at a time.
class Digest {
 public:
  template <class Value>
  void add(const std::vector<Value>& values) {
    add(reinterpret_cast<const unsigned char*>(values.data()), values.size() * sizeof(Value));
  }
  void add(const std::vector<std::string>& texts) {
    for (const std::string& text : texts) add(reinterpret_cast<const unsigned char*>(text.data()), text.size());
    add(nullptr, texts.size());
  }
  std::int64_t value() const { return std::bit_cast<std::int64_t>(sum_); }

 private:
  void add(const unsigned char* bytes, std::size_t size) {
    mix(size);
    for (; bytes && size > 0; bytes += std::min<std::size_t>(size, 8), size -= std::min<std::size_t>(size, 8)) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes, std::min<std::size_t>(size, 8));
      mix(word);
    }
  }
  void mix(std::uint64_t word) {
    sum_ = (sum_ ^ word) * 1099511628211ull;
    sum_ ^= sum_ >> 29;
  }
  std::uint64_t sum_ = 14695981039346656037ull;
};

std::int64_t digest(const Archive::Content& content) {
  Digest all;
  all.add(content.names), all.add(content.texts);
  all.add(content.shapes), all.add(content.numbers), all.add(content.integers);
  return all.value();
}

}  // namespace

void write_checkpoint(const Archive& archive, const std::string& path) {
  const Archive::Content& content = archive.content();
  Hdf5Writer file(path);
  file.attribute("/", "kind", kKind);
  file.attribute("/", "format", kFormat);
  file.attribute("/", "lithe", kVersion);
  file.attribute("/", "bytes of a number", static_cast<std::int64_t>(sizeof(double)));
  file.attribute("/", "byte order", kByteOrder);
  file.attribute("/", "digest", digest(content));
  file.write("/names", content.names);
  file.write("/shapes", content.shapes);
  file.write("/numbers", content.numbers);
  file.write("/integers", content.integers);
  file.write("/texts", content.texts);
  file.commit();
}

Archive read_checkpoint(const std::string& path) {
  const Hdf5Reader file(path);
  const auto refuse = [&](const std::string& problem, const std::string& fix) { throw FileError(problem, path, fix); };
  if (file.text_attribute("/", "kind") != kKind)
    refuse("the file is not a checkpoint but a '" + file.text_attribute("/", "kind") + "'",
           "give a file that Simulation::checkpoint() or save() wrote");
  if (const auto format = file.number_attribute("/", "format"); format != kFormat)
    refuse("the checkpoint has format " + std::to_string(format) + ", known is " + std::to_string(kFormat),
           "resume with the Lithe that wrote it");
  if (const std::string version = file.text_attribute("/", "lithe"); version != kVersion)
    refuse("the checkpoint is of Lithe " + version + ", this is " + kVersion,
           "resume with the Lithe that wrote it: another one would not go on with the same bits");
  const auto bytes = file.number_attribute("/", "bytes of a number");
  const std::string order = file.text_attribute("/", "byte order");
  if (bytes != sizeof(double) || order != kByteOrder)
    refuse("the checkpoint's numbers have " + std::to_string(bytes) + " bytes, " + order +
               " end first; here they have " + std::to_string(sizeof(double)) + ", " + kByteOrder + " end first",
           "resume on a machine, and with a precision, as it was written with");
  Archive::Content content;
  content.names = file.texts("/names");
  content.shapes = file.integers("/shapes");
  content.numbers = file.numbers("/numbers");
  content.integers = file.integers("/integers");
  content.texts = file.texts("/texts");
  if (digest(content) != file.number_attribute("/", "digest"))
    refuse("the checkpoint is damaged: it does not hold what was written", "resume from an older one, or start anew");
  return {path, std::move(content)};
}

void CheckpointSchedule::begin(double time, bool anew) {
  if (path_.empty() || (begun_ && !anew)) return;
  begun_ = true;
  origin_ = time;
  next_ = 0;
}

bool CheckpointSchedule::pass(double time) {
  if (path_.empty() || (next_ > 0 && last_ == time)) return false;
  const double interval = schedule_.interval;
  if (interval > 0) {
    const double slack = 1e-9 * interval + time_round_off(time);
    if (origin_ + static_cast<double>(next_) * interval > time + slack) return false;
    next_ = static_cast<long>(std::floor((time + slack - origin_) / interval)) + 1;
  } else {
    ++next_;
  }
  last_ = time;
  return true;
}

void CheckpointSchedule::history(Archive& archive) {
  bool begun = begun_ && !path_.empty();
  double interval = schedule_.interval, origin = origin_, last = last_;
  long next = next_;
  archive("begun", begun);
  archive("interval", interval);
  archive("origin", origin);
  archive("last", last);
  archive("next", next);
  // Of another interval, or none: it begins anew, or stays away.
  if (archive.loads() && begun && interval == schedule_.interval)
    begun_ = true, origin_ = origin, last_ = last, next_ = next;
}

}  // namespace lithe
