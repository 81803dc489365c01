#include "bodies/beam/beam_table.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <memory>

#include "bodies/flexible/readers/text_file.h"
#include "engine/base/checks.h"

namespace lithe {
namespace {

/// A point of the axis that a file gives, in the blade frame.
struct KeyPoint {
  Vector3 position = Vector3::Zero();
  double twist = 0;  // degrees
};

/// x, y and twist over z: natural cubic splines through the key points.
class SplineLine {
 public:
  explicit SplineLine(const std::vector<KeyPoint>& points) {
    const int n = static_cast<int>(points.size());
    values_.resize(n, 3);
    for (int i = 0; i < n; ++i) {
      z_.push_back(points[i].position.z());
      values_.row(i) << points[i].position.x(), points[i].position.y(), points[i].twist * M_PI / 180;
    }
    MatrixX A = MatrixX::Identity(n, n), b = MatrixX::Zero(n, 3);
    for (int i = 1; i + 1 < n; ++i) {
      const double before = z_[i] - z_[i - 1], after = z_[i + 1] - z_[i];
      A(i, i - 1) = before / 6, A(i, i) = (before + after) / 3, A(i, i + 1) = after / 6;
      b.row(i) = (values_.row(i + 1) - values_.row(i)) / after - (values_.row(i) - values_.row(i - 1)) / before;
    }
    seconds_ = A.partialPivLu().solve(b);
    for (int i = 0; i + 1 < n; ++i)
      for (int k = 0; k < kPieces; ++k) {
        const double from = z_[i] + (z_[i + 1] - z_[i]) * k / kPieces;
        const double to = k + 1 < kPieces ? z_[i] + (z_[i + 1] - z_[i]) * (k + 1) / kPieces : z_[i + 1];
        if (knots_.empty()) knots_.push_back(from), arcs_.push_back(0);
        arcs_.push_back(arcs_.back() + stretch(from, to));
        knots_.push_back(to);
      }
  }

  double length() const { return arcs_.back(); }
  double arc_at(double z) const {
    const std::size_t i = piece(knots_, z);
    return arcs_[i] + stretch(knots_[i], z);
  }
  FramePose pose(double arc) const {
    const std::size_t i = piece(arcs_, arc);
    double z = knots_[i] + (knots_[i + 1] - knots_[i]) * (arc - arcs_[i]) / (arcs_[i + 1] - arcs_[i]);
    for (int newton = 0; newton < 4; ++newton) z += (arc - arcs_[i] - stretch(knots_[i], z)) / slope(z).norm();
    const Vector3 at = value(z), along = slope(z).normalized();
    // Seen along z, axis x of the section has the angle of the twist.
    Vector3 x(std::cos(at[2]), -std::sin(at[2]), 0);
    x[2] = -(along[0] * x[0] + along[1] * x[1]) / along[2];
    x.normalize();
    FramePose pose;
    pose.position = Vector3(at[0], at[1], z);
    pose.axes << along, x, along.cross(x);
    return pose;
  }

 private:
  static constexpr int kPieces = 16;  // between two key points: Newton's iterations and Gauss's points stay within one

  static std::size_t piece(const std::vector<double>& knots, double at) {
    const auto next = std::upper_bound(knots.begin(), knots.end(), at) - knots.begin();
    return std::clamp<std::ptrdiff_t>(next - 1, 0, static_cast<std::ptrdiff_t>(knots.size()) - 2);
  }
  Vector3 value(double z) const {  // x, y, twist
    const std::size_t i = piece(z_, z);
    const double h = z_[i + 1] - z_[i], b = (z - z_[i]) / h, a = 1 - b;
    return a * values_.row(i) + b * values_.row(i + 1) +
           h * h / 6 * ((a * a * a - a) * seconds_.row(i) + (b * b * b - b) * seconds_.row(i + 1));
  }
  Vector3 slope(double z) const {  // x', y', 1
    const std::size_t i = piece(z_, z);
    const double h = z_[i + 1] - z_[i], b = (z - z_[i]) / h, a = 1 - b;
    Vector3 s = (values_.row(i + 1) - values_.row(i)) / h +
                h / 6 * ((1 - 3 * a * a) * seconds_.row(i) + (3 * b * b - 1) * seconds_.row(i + 1));
    s[2] = 1;
    return s;
  }
  double stretch(double from, double to) const {  // arc length, Gauss's four points
    constexpr double kPlace[] = {0.33998104358485626, 0.86113631159405258};
    constexpr double kWeight[] = {0.65214515486254614, 0.34785484513745386};
    double sum = 0;
    for (int i = 0; i < 2; ++i)
      for (const double side : {-1.0, 1.0})
        sum += kWeight[i] * slope(0.5 * (from + to) + 0.5 * (to - from) * side * kPlace[i]).norm();
    return 0.5 * (to - from) * sum;
  }

  std::vector<double> z_, knots_, arcs_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> values_, seconds_;
};

void require_rising(double before, double at, const TextFile& file, const std::string& which, const std::string& what) {
  if (!(at > before))
    throw SceneError(which + " has " + what + " " + std::to_string(at) + " and does not lie behind the one before",
                     file.where(), "list them from the root to the tip, each once");
}

Beam::Parameters on_line(const std::vector<KeyPoint>& points, const FramePose& root) {
  const auto line = std::make_shared<const SplineLine>(points);
  Beam::Parameters p;
  p.axis.length = line->length();
  p.axis.pose = [line, root](double arc) {
    const FramePose pose = line->pose(arc);
    FramePose placed;
    placed.position = root.position + root.axes * pose.position;
    placed.axes = root.axes * pose.axes;
    return placed;
  };
  return p;
}

// ---- BeamDyn ----

/// BeamDyn's order is force x, y, z, moment x, y, z; that of sections 1 = z, 2 = x, 3 = y.
constexpr std::array<int, 6> kFromBeamDyn = {2, 0, 1, 5, 3, 4};

double fortran_number(const TextFile& file, std::string_view word, std::string_view what) {
  std::string text(word);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == 'd' || c == 'D'; }, 'e');
  return file.number(text, what);
}

void next_line(TextFile& file, const std::string& what) {
  if (!file.next()) file.fail("the file ends before " + what + ".", "give a complete BeamDyn file.");
}

template <int N>
Eigen::Matrix<double, 1, N> read_numbers(TextFile& file, const std::string& what) {
  do next_line(file, what);
  while (file.blank());
  const auto& words = file.words();
  if (words.size() < N)
    file.fail(what + " has " + std::to_string(words.size()) + " numbers.", "give " + std::to_string(N) + ".");
  Eigen::Matrix<double, 1, N> row;
  for (int i = 0; i < N; ++i) row[i] = fortran_number(file, words[i], what);
  return row;
}

/// Goes on to the line "value name ...".
void find_value(TextFile& file, const std::string& name) {
  do next_line(file, "the line of " + name);
  while (file.words().size() < 2 || lower_case(file.words()[1]) != name);
}

int read_count(TextFile& file, const std::string& name, int least) {
  find_value(file, name);
  const int count = file.integer(file.words()[0], name);
  if (count < least)
    file.fail(name + " is " + std::to_string(count) + ".", "give " + std::to_string(least) + " or more.");
  return count;
}

/// Sections over the length from 0 to 1.
std::vector<Beam::Station> read_blade(const std::string& path) {
  TextFile file(path, "give the BeamDyn blade file (BldFile of the primary input).");
  const int count = read_count(file, "station_total", 2);
  const int damping = read_count(file, "damp_type", 0);
  if (damping > 1)
    file.fail("damp_type is " + std::to_string(damping) + ".",
              "give 1, damping proportional to the stiffness, or 0; modal damping belongs to no section.");
  for (int i = 0; i < 3; ++i) next_line(file, "the damping");
  const Vector6 mu =
      damping == 1 ? Vector6(read_numbers<6>(file, "the line of mu1 to mu6").transpose()) : Vector6::Zero();
  do next_line(file, "'Distributed Properties'");
  while (lower_case(file.line()).find("distributed") == std::string::npos);

  std::vector<Beam::Station> stations;
  for (int i = 0; i < count; ++i) {
    const std::string which = "station " + std::to_string(i + 1);
    Beam::Station station;
    station.arc = read_numbers<1>(file, "the place of " + which)[0];
    if (i > 0) require_rising(stations.back().arc, station.arc, file, which, "the place");
    const std::string where = file.where();
    Matrix6 C, M;
    for (int k = 0; k < 6; ++k) C.row(k) = read_numbers<6>(file, "the stiffness of " + which);
    for (int k = 0; k < 6; ++k) M.row(k) = read_numbers<6>(file, "the mass of " + which);
    for (int a = 0; a < 6; ++a) {
      station.section.damping[a] = mu[kFromBeamDyn[a]];
      for (int b = 0; b < 6; ++b) {
        station.section.stiffness(a, b) = C(kFromBeamDyn[a], kFromBeamDyn[b]);
        station.section.mass(a, b) = M(kFromBeamDyn[a], kFromBeamDyn[b]);
      }
    }
    station.section.check(which + " (" + where + ")");
    stations.push_back(station);
  }
  if (std::abs(stations.front().arc) > 1e-9 || std::abs(stations.back().arc - 1) > 1e-9)
    file.fail("its stations go from " + std::to_string(stations.front().arc) + " to " +
                  std::to_string(stations.back().arc) + ".",
              "give them as parts of the length, from 0 at the root to 1 at the tip.");
  return stations;
}

/// Text in quotes, blanks and all, or the first word.
std::string first_text(TextFile& file) {
  const std::string_view text = trimmed(file.line());
  const char quote = text.front();
  if (quote != '"' && quote != '\'') return std::string(file.words()[0]);
  return std::string(text.substr(1, text.find(quote, 1) - 1));
}

Beam::Parameters read_beamdyn(const std::string& path, const BeamTablePlace& place) {
  TextFile file(path, "give a BeamDyn primary input, a BeamDyn blade file or a .csv.");
  bool primary = false, blade = false;
  while (!primary && !blade && file.next()) {
    if (file.words().size() < 2) continue;
    const std::string name = lower_case(file.words()[1]);
    primary = name == "member_total", blade = name == "station_total";
  }
  if (!primary && !blade)
    file.fail("this is no BeamDyn file: it has neither member_total nor station_total.",
              "give a BeamDyn primary input or blade file; a table in columns has a name that ends in .csv.");

  std::vector<KeyPoint> points;
  std::string sections = path;
  if (blade) {
    if (!(place.length > 0 && std::isfinite(place.length)))
      throw SceneError("a BeamDyn blade file has no length, and length is " + std::to_string(place.length), path,
                       "give beam_table(path, {.length = 61.5}), or the primary input with its key points");
    points = {{}, {.position = {0, 0, place.length}}};
  } else {
    const int members = file.integer(file.words()[0], "member_total");
    const int count = read_count(file, "kp_total", 2);
    for (int i = 0; i < members + 2; ++i) next_line(file, "the key points");  // members, names, units
    for (int i = 0; i < count; ++i) {
      const std::string which = "key point " + std::to_string(i + 1);
      const Eigen::RowVector4d row = read_numbers<4>(file, which);
      if (i > 0) require_rising(points.back().position.z(), row[2], file, which, "z");
      points.push_back({.position = row.head<3>().transpose(), .twist = row[3]});
    }
    find_value(file, "bldfile");
    sections = (std::filesystem::path(path).parent_path() / first_text(file)).string();
  }
  Beam::Parameters p = on_line(points, place.root);
  p.sections = read_blade(sections);
  for (Beam::Station& station : p.sections) station.arc *= p.axis.length;
  return p;
}

// ---- CSV ----

class CsvTable {
 public:
  explicit CsvTable(const std::string& path) : file_(path, "give a table with a line of names.") {
    if (!next()) file_.fail("the table is empty.", "give a line of names, then a line for each station.");
    for (const std::string_view field : file_.fields()) {
      const std::string name = standard(std::string(field));
      if (!known(name))
        file_.fail("the column '" + std::string(field) + "' is unknown.",
                   "give z (x, y) or arc, twist, C11 to C66 or EA GA2 GA3 GJ EI2 EI3, M11 to M66 or mass J1 J2 J3, "
                   "damping.");
      if (!column_.emplace(name, column_.size()).second)
        file_.fail("the column '" + std::string(field) + "' gives what another has given.", "give each value once.");
    }
    if (has("z") == has("arc") || (has("arc") && (has("x") || has("y"))))
      file_.fail("the table does not say where its stations are.", "give z, with x and y if it is curved, or arc.");
    for (const char* name : {"C11", "C22", "C33", "C44", "C55", "C66", "M11", "M44", "M55", "M66"})
      if (!has(name))
        file_.fail("the column " + std::string(name) + " is missing.", "give it, or " + plain(name) + ".");
  }

  Beam::Parameters read(const FramePose& root) {
    std::vector<KeyPoint> points;
    std::vector<BeamSection> sections;
    while (next()) {
      const auto& fields = file_.fields();
      if (fields.size() != column_.size())
        file_.fail("the line has " + std::to_string(fields.size()) + " values.",
                   "give " + std::to_string(column_.size()) + ", one for each name.");
      values_.clear();
      for (const auto& [name, i] : column_) values_[name] = file_.number(fields[i], name);
      KeyPoint point{.position = {value("x"), value("y"), has("z") ? value("z") : value("arc")},
                     .twist = value("twist")};
      const std::string which = "station " + std::to_string(points.size() + 1);
      if (!points.empty())
        require_rising(points.back().position.z(), point.position.z(), file_, which, has("z") ? "z" : "arc");
      points.push_back(point);
      sections.push_back(section());
      sections.back().check(which + " (" + file_.where() + ")");
    }
    if (points.size() < 2) file_.fail("the table has fewer than two stations.", "give one at each end.");
    Beam::Parameters p = on_line(points, root);
    const SplineLine line(points);
    for (std::size_t i = 0; i < points.size(); ++i)
      p.sections.push_back({line.arc_at(points[i].position.z()), sections[i]});
    return p;
  }

 private:
  static constexpr std::array<std::pair<const char*, const char*>, 10> kNames = {{{"EA", "C11"},
                                                                                  {"GA2", "C22"},
                                                                                  {"GA3", "C33"},
                                                                                  {"GJ", "C44"},
                                                                                  {"EI2", "C55"},
                                                                                  {"EI3", "C66"},
                                                                                  {"mass", "M11"},
                                                                                  {"J1", "M44"},
                                                                                  {"J2", "M55"},
                                                                                  {"J3", "M66"}}};

  static std::string standard(const std::string& name) {
    for (const auto& [plain, entry] : kNames)
      if (name == plain) return entry;
    return name;
  }
  static std::string plain(const std::string& entry) {
    for (const auto& [plain, name] : kNames)
      if (entry == name) return plain;
    return entry;
  }
  static bool known(const std::string& name) {
    const auto index = [&](std::size_t i) { return name[i] >= '1' && name[i] <= '6'; };
    if (name.size() == 3 && (name[0] == 'C' || name[0] == 'M')) return index(1) && index(2);
    if (name.size() == 8 && name.starts_with("damping")) return index(7);
    return name == "x" || name == "y" || name == "z" || name == "arc" || name == "twist" || name == "damping";
  }

  /// On to a line that says something.
  bool next() {
    while (file_.next())
      if (!file_.blank() && trimmed(file_.line()).front() != '#') return true;
    return false;
  }
  bool has(const std::string& name) const { return column_.contains(name); }
  double value(const std::string& name) const { return has(name) ? values_.at(name) : 0; }

  /// A missing entry is that on the other side of the diagonal.
  double entry(char matrix, int row, int column) const {
    const std::string name{matrix, static_cast<char>('1' + row), static_cast<char>('1' + column)};
    return has(name) ? value(name) : value({matrix, name[2], name[1]});
  }
  BeamSection section() const {
    BeamSection s;
    for (int i = 0; i < 6; ++i) {
      const std::string damping = "damping" + std::to_string(i + 1);
      s.damping[i] = has(damping) ? value(damping) : value("damping");
      for (int k = 0; k < 6; ++k) s.stiffness(i, k) = entry('C', i, k), s.mass(i, k) = entry('M', i, k);
    }
    for (const int i : {1, 2})
      if (!has(i == 1 ? "M22" : "M33")) s.mass(i, i) = s.mass(0, 0);
    return s;
  }

  TextFile file_;
  std::map<std::string, std::size_t> column_;
  std::map<std::string, double> values_;
};

}  // namespace

Beam::Parameters beam_table(const std::string& path, const BeamTablePlace& place) {
  require::finite(place.root.position, "the position of root");
  if (lower_case(std::filesystem::path(path).extension().string()) == ".csv") return CsvTable(path).read(place.root);
  return read_beamdyn(path, place);
}

}  // namespace lithe
