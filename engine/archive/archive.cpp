#include "engine/archive/archive.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/base/packed_texts.h"

// No HDF5 here: plug-ins link this file.
namespace lithe {
namespace {

constexpr const char* kFix =
    "resume what this version of Lithe wrote, with the same kind of integrator, observers and events";

/// Bytes of a vector of numbers behind their count, and back.
template <class Value>
void append(std::vector<unsigned char>& bytes, const std::vector<Value>& values) {
  const std::uint64_t count = values.size();
  const auto* size = reinterpret_cast<const unsigned char*>(&count);
  bytes.insert(bytes.end(), size, size + sizeof count);
  const auto* data = reinterpret_cast<const unsigned char*>(values.data());
  bytes.insert(bytes.end(), data, data + values.size() * sizeof(Value));
}

std::vector<char> bytes_of(const std::vector<std::string>& texts) {
  const std::string bytes = packed(texts);
  return {bytes.begin(), bytes.end()};
}

struct Bytes {
  const unsigned char* at;
  std::size_t left;
  const std::string& source;

  [[noreturn]] void fail() const { throw FileError("the bytes are not an archive, or are cut short", source, kFix); }
  template <class Value>
  std::vector<Value> take() {
    std::uint64_t count = 0;
    if (left < sizeof count) fail();
    std::memcpy(&count, at, sizeof count);
    at += sizeof count, left -= sizeof count;
    if (count > left / sizeof(Value)) fail();
    std::vector<Value> values(count);
    if (count > 0) std::memcpy(values.data(), at, count * sizeof(Value));
    at += count * sizeof(Value), left -= count * sizeof(Value);
    return values;
  }
  std::vector<std::string> take_texts() {
    const std::vector<char> all = take<char>();
    auto texts = unpacked({all.begin(), all.end()});
    if (!texts) fail();
    return *std::move(texts);
  }
};

}  // namespace

Archive::Archive(std::string source, Content content)
    : source_(std::move(source)), loads_(true), content_(std::move(content)) {
  std::size_t places[3] = {0, 0, 0};
  const std::size_t sizes[3] = {content_.numbers.size(), content_.integers.size() / 2, content_.texts.size()};
  bool whole = content_.shapes.size() == 3 * content_.names.size() && content_.integers.size() % 2 == 0;
  for (std::size_t i = 0; whole && i < content_.names.size(); ++i) {
    const int kind = content_.shapes[3 * i], rows = content_.shapes[3 * i + 1], columns = content_.shapes[3 * i + 2];
    whole = kind >= 0 && kind <= 2 && rows >= 0 && columns >= 0;
    if (!whole) break;
    const auto count = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
    whole = count <= sizes[kind] - places[kind];
    entries_[content_.names[i]] = {static_cast<Kind>(kind), rows, columns, places[kind]};
    places[kind] += count;
  }
  if (!whole || !std::equal(places, places + 3, sizes))
    throw FileError("the checkpoint is not whole: what it lists is not what it holds", source_, kFix);
}

void Archive::refuse(std::string_view name, const std::string& problem) const {
  throw FileError("the checkpoint's '" + path(name) + "' " + problem, source_, kFix);
}

void Archive::add(std::string_view name, Kind kind, std::int64_t rows, std::int64_t columns) {
  constexpr std::int64_t kMost = std::numeric_limits<int>::max();
  const std::size_t places[] = {content_.numbers.size(), content_.integers.size() / 2, content_.texts.size()};
  if (rows > kMost || columns > kMost ||
      !entries_.try_emplace(path(name), Entry{kind, rows, columns, places[kind]}).second)
    throw SceneError("'" + path(name) + "' cannot be saved: it is too large, or given twice", "Archive",
                     "give each member a name of its own");
  content_.names.push_back(path(name));
  content_.shapes.insert(content_.shapes.end(), {kind, static_cast<int>(rows), static_cast<int>(columns)});
}

const Archive::Entry& Archive::find(std::string_view name, Kind kind) const {
  const auto found = entries_.find(path(name));
  if (found == entries_.end()) refuse(name, "is missing");
  if (found->second.kind != kind) refuse(name, "holds another kind of values");
  return found->second;
}

std::pair<std::int64_t, std::int64_t> Archive::extent(std::string_view name) const {
  const Entry& entry = find(name, kNumber);
  return {entry.rows, entry.columns};
}

void Archive::number(std::string_view name, double* values, std::int64_t rows, std::int64_t columns) {
  if (!loads_) {
    add(name, kNumber, rows, columns);
    content_.numbers.insert(content_.numbers.end(), values, values + rows * columns);
    return;
  }
  const Entry& entry = find(name, kNumber);
  if (entry.rows != rows || entry.columns != columns)
    refuse(name, "has " + std::to_string(entry.rows) + " x " + std::to_string(entry.columns) + " numbers instead of " +
                     std::to_string(rows) + " x " + std::to_string(columns));
  std::copy_n(content_.numbers.begin() + static_cast<std::ptrdiff_t>(entry.first), rows * columns, values);
}

void Archive::integer(std::string_view name, std::int64_t* values, std::int64_t count) {
  if (!loads_) {
    add(name, kInteger, count, 1);
    const std::size_t first = content_.integers.size();
    content_.integers.resize(first + 2 * static_cast<std::size_t>(count));
    if (count > 0)
      std::memcpy(content_.integers.data() + first, values, sizeof *values * static_cast<std::size_t>(count));
    return;
  }
  const Entry& entry = find(name, kInteger);
  if (entry.rows != count)
    refuse(name, "has " + std::to_string(entry.rows) + " integers instead of " + std::to_string(count));
  if (count > 0)
    std::memcpy(values, content_.integers.data() + 2 * entry.first, sizeof *values * static_cast<std::size_t>(count));
}

void Archive::operator()(std::string_view name, std::string& value) {
  std::vector<std::string> one{value};
  (*this)(name, one);
  if (one.size() != 1) refuse(name, "is not one text");
  value = one.front();
}

void Archive::operator()(std::string_view name, std::vector<std::string>& values) {
  if (!loads_) {
    add(name, kText, static_cast<std::int64_t>(values.size()), 1);
    content_.texts.insert(content_.texts.end(), values.begin(), values.end());
    return;
  }
  const Entry& entry = find(name, kText);
  const auto first = content_.texts.begin() + static_cast<std::ptrdiff_t>(entry.first);
  values.assign(first, first + entry.rows * entry.columns);
}

void Archive::operator()(std::string_view name, std::vector<double>& values) {
  if (loads_) values.resize(static_cast<std::size_t>(find(name, kNumber).rows));
  number(name, values.data(), static_cast<std::int64_t>(values.size()), 1);
}

void Archive::operator()(std::string_view name, std::vector<int>& values) {
  std::vector<std::int64_t> wide(values.begin(), values.end());
  if (loads_) wide.resize(static_cast<std::size_t>(find(name, kInteger).rows));
  integer(name, wide.data(), static_cast<std::int64_t>(wide.size()));
  values.assign(wide.size(), 0);
  std::transform(wide.begin(), wide.end(), values.begin(), [](std::int64_t x) { return static_cast<int>(x); });
}

void Archive::operator()(std::string_view name, State& state) {
  group(name, [&] {
    (*this)("time", state.time);
    (*this)("q", state.q);
    (*this)("v", state.v);
    (*this)("v_dot", state.v_dot);
    (*this)("lambda", state.lambda);
    (*this)("quarter_turns", state.quarter_turns);
    (*this)("left_out", state.left_out);
    (*this)("contacts", state.contacts);
  });
}

void Archive::operator()(std::string_view name, ContactMemory& memory) {
  group(name, [&] {
    int count = static_cast<int>(memory.size());
    (*this)("count", count);
    std::vector<int> integers;
    std::vector<double> numbers;
    constexpr std::size_t kIntegers = 14, kNumbers = 20, kOfCompliant = 10, kOfRigid = 5;  // of a trace
    // One walk over a trace for both ways.
    const auto walk = [](ContactTrace& t, auto&& whole, auto&& real) {
      int law = static_cast<int>(t.memory.index());
      whole(law);
      if (law != static_cast<int>(t.memory.index())) t.memory = RigidMemory{};
      whole(t.element);
      for (ContactSide* side : {&t.point.A, &t.point.B}) {
        whole(side->collider), whole(side->node_count);
        for (int& node : side->nodes) whole(node);
        for (double& weight : side->weights) real(weight);
      }
      int halves[2];
      std::memcpy(halves, &t.point.feature, sizeof halves);
      whole(halves[0]), whole(halves[1]);
      std::memcpy(&t.point.feature, halves, sizeof halves);
      real(t.point.gap), real(t.point.curvature);
      const auto vector = [&](Vector3& x) {
        for (double& value : x) real(value);
      };
      vector(t.point.position), vector(t.point.normal), vector(t.force), vector(t.moment);
      if (auto* kept = std::get_if<CompliantMemory>(&t.memory)) {
        vector(kept->on_A), vector(kept->on_B), vector(kept->bristle);
        real(kept->impact_speed);
      } else {
        auto& rigid = std::get<RigidMemory>(t.memory);
        vector(rigid.velocity);
        real(rigid.slip_at_start), real(rigid.slip_at_end);
      }
    };
    if (!loads_)
      for (ContactTrace& trace : memory)
        walk(
            trace, [&](int x) { integers.push_back(x); }, [&](double x) { numbers.push_back(x); });
    (*this)("integers", integers);
    (*this)("numbers", numbers);
    if (!loads_) return;
    bool fits = count >= 0 && integers.size() == kIntegers * static_cast<std::size_t>(count);
    std::size_t needed = 0;
    for (std::size_t i = 0; fits && i < integers.size(); i += kIntegers) {
      fits = integers[i] == 0 || integers[i] == 1;
      needed += kNumbers + (integers[i] == 0 ? kOfCompliant : kOfRigid);
    }
    if (!fits || numbers.size() != needed) refuse("count", "does not fit the contacts that it holds");
    memory.assign(static_cast<std::size_t>(count), {});
    auto whole = integers.begin();
    auto real = numbers.begin();
    for (ContactTrace& trace : memory)
      walk(
          trace, [&](int& x) { x = *whole++; }, [&](double& x) { x = *real++; });
  });
}

void Archive::same(std::string_view name, double value) {
  double saved = value;
  (*this)(name, saved);
  if (saved != value)
    throw SceneError("'" + path(name) + "' was " + number_text(saved) + " where the checkpoint was written, and is " +
                         number_text(value) + " now",
                     source_, "use the same value, or start a new run");
}

void Archive::same(std::string_view name, const std::string& value) {
  std::string saved = value;
  (*this)(name, saved);
  if (saved != value)
    throw SceneError(
        "'" + path(name) + "' was '" + saved + "' where the checkpoint was written, and is '" + value + "' now",
        source_, "use the same value, or start a new run");
}

std::vector<unsigned char> Archive::bytes() const {
  std::vector<unsigned char> all;
  append(all, bytes_of(content_.names));
  append(all, content_.shapes);
  append(all, content_.numbers);
  append(all, content_.integers);
  append(all, bytes_of(content_.texts));
  return all;
}

Archive Archive::of_bytes(std::string source, const unsigned char* bytes, std::size_t size) {
  Bytes from{bytes, size, source};
  Content content;
  content.names = from.take_texts();
  content.shapes = from.take<int>();
  content.numbers = from.take<double>();
  content.integers = from.take<int>();
  content.texts = from.take_texts();
  if (from.left > 0) from.fail();
  return {std::move(source), std::move(content)};
}

}  // namespace lithe
