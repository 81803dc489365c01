#include "engine/page/page.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <string_view>
#include <unordered_map>

#include "engine/base/version.h"
#include "engine/output/partial_file.h"
#include "engine/page/run_record_internal.h"

namespace lithe {
namespace page_parts {

using Json = nlohmann::json;
using Rows = Eigen::Map<const MatrixX>;

/// The arrays of a page: one buffer, little-endian, each array at a multiple of 8. Equal ones, as bodies of one mesh
/// have them, are stored once.
class Arrays {
 public:
  Json add(ConstMatrixRef values, const std::string& type) {
    if (type == "f64") return write<double>(values, type);
    if (type == "f32") return write<float>(values, type);
    if (type == "u32") return write<std::uint32_t>(values, type);
    if (type == "u16") return write<std::uint16_t>(values, type);
    throw SceneError("an array of type '" + type + "'", "write_page", "f64, f32, u32 and u16 are known");
  }
  /// As 16-bit integers times a scale of each column where that leaves no sum of columns times coordinates, of at most
  /// `largest`, off by more than `error`; else as floats.
  Json add_shapes(ConstMatrixRef values, const VectorX& largest, double error) {
    if (values.size() == 0) return write<float>(values, "f32");
    VectorX scale = values.cwiseAbs().colwise().maxCoeff().transpose() / 32767;
    if (!(0.5 * scale.dot(largest) <= error)) return write<float>(values, "f32");
    for (double& s : scale)
      if (s == 0) s = 1;
    Json reference = write<std::int16_t>(values * scale.cwiseInverse().asDiagonal(), "i16");
    reference["scale"] = scale;
    return reference;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  template <class Stored>
  Json write(ConstMatrixRef values, const std::string& type) {
    bytes_.resize((bytes_.size() + 7) / 8 * 8, '\0');
    const std::size_t at = bytes_.size();
    bytes_.resize(at + static_cast<std::size_t>(values.size()) * sizeof(Stored));
    char* to = bytes_.data() + at;
    for (Eigen::Index c = 0; c < values.cols(); ++c)
      for (Eigen::Index r = 0; r < values.rows(); ++r, to += sizeof(Stored)) {
        Stored stored{};
        if constexpr (std::is_integral_v<Stored>)
          stored = static_cast<Stored>(std::lround(values(r, c)));
        else
          stored = static_cast<Stored>(values(r, c));
        if (!std::isfinite(static_cast<double>(stored)) || !std::isfinite(values(r, c)))
          throw SceneError("a number of the page is " + std::to_string(values(r, c)), "write_page",
                           "see which shape or mode of the scene is not finite, or too large for a float");
        std::memcpy(to, &stored, sizeof stored);
      }
    return {{"at", placed(at)}, {"n", values.size()}, {"type", type}};
  }
  /// Where the bytes from `at` on have been before, and are taken away from the end; or `at`.
  std::size_t placed(std::size_t at) {
    const std::string_view written = std::string_view(bytes_).substr(at);
    auto& alike = by_hash_[std::hash<std::string_view>()(written)];
    for (const auto& [first, size] : alike)
      if (std::string_view(bytes_).substr(first, size) == written) {
        bytes_.resize(at);
        return first;
      }
    alike.emplace_back(at, written.size());
    return at;
  }

  std::string bytes_;
  std::unordered_map<std::size_t, std::vector<std::pair<std::size_t, std::size_t>>> by_hash_;  // at, bytes
};

double size_of(const MatrixX& points) {
  return points.size() > 0 ? (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm() : 0;
}

/// Largest magnitude of each row.
VectorX largest_of(ConstMatrixRef coordinates) {
  return coordinates.cols() > 0 ? VectorX(coordinates.cwiseAbs().rowwise().maxCoeff())
                                : VectorX::Zero(coordinates.rows());
}

/// One run as the page has it: the recorder's description with every array in the buffer.
class PageRun {
 public:
  PageRun(const RunRecord& record, Arrays& arrays, PageKind kind)
      : record_(record),
        arrays_(arrays),
        live_(kind == PageKind::live),
        rows_(record.rows.data(), record.width, record.row_count()),
        json_(Json::parse(record.scene)) {}

  Json make() {
    for (Json& body : json_["bodies"]) {
      if (body["mesh"].is_null()) continue;
      if (!body["mesh"].contains("nodal"))
        add_natural(body["mesh"]);
      else if (!live_)
        add_fitted(body);
    }
    json_["name"] = record_.name;
    resolve(json_);
    add_contacts();
    json_["events"] = Json::array();
    for (const EventRecord& event : record_.events)
      json_["events"].push_back({{"time", event.time}, {"name", event.name}});
    return std::move(json_);
  }

 private:
  Rows::ConstRowsBlockXpr part(const Json& place) const {
    return rows_.middleRows(place.at("row").get<int>(), place.at("width").get<int>());
  }
  const MatrixX& set(const Json& place) const { return record_.sets.at(place.at("set").get<std::string>()); }

  static constexpr double kAnyMotion = 1e100;  // modal coordinates that a run to come stays below

  /// Modes of the body: exact to 1e-6 of its size, the stress to 5e-4 of its largest.
  void add_natural(Json& mesh) {
    const MatrixX eta = part(mesh["coordinates"]), shapes = set(mesh["shapes"]);
    const VectorX largest = live_ ? VectorX::Constant(eta.rows(), kAnyMotion) : largest_of(eta);
    const double size = size_of(set(mesh["points"]));
    mesh["shapes"] = arrays_.add_shapes(shapes, largest, 5e-7 * size);
    if (mesh["pairs"].is_object()) add_pairs(mesh, set(mesh["pairs"]), largest, size);
    if (!mesh["stress"].is_object()) return;
    Json& place = mesh["stress"]["shapes"];
    MatrixX stress = set(place);
    double peak = 0;
    for (Eigen::Index i = 0; i < eta.cols(); i += std::max<Eigen::Index>(1, eta.cols() / 50))
      peak = std::max(peak, (stress * eta.col(i)).lpNorm<Eigen::Infinity>());
    place = arrays_.add_shapes(stress, largest, 5e-4 * peak);
  }

  /// Those that move a point by more than nothing: the sum of what is left out stays below 1e-7 of the size.
  void add_pairs(Json& mesh, const MatrixX& pairs, const VectorX& largest, double size) {
    std::vector<std::array<int, 2>> all;
    for (int l = 0; l < largest.size(); ++l)
      for (int k = 0; k <= l; ++k) all.push_back({k, l});
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto reach = [&](std::size_t p) {
      return largest[all[p][0]] * largest[all[p][1]] *
             pairs.col(static_cast<Eigen::Index>(p)).lpNorm<Eigen::Infinity>();
    };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return reach(a) < reach(b); });
    double left_out = 0;
    std::size_t first = 0;
    while (first < order.size() && left_out + reach(order[first]) < 1e-7 * size) left_out += reach(order[first++]);
    order.erase(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(first));
    std::sort(order.begin(), order.end());
    MatrixX ij(2, static_cast<Eigen::Index>(order.size())), shapes(pairs.rows(), ij.cols());
    VectorX products(ij.cols());
    for (Eigen::Index i = 0; i < ij.cols(); ++i) {
      const auto& pair = all[order[static_cast<std::size_t>(i)]];
      ij(0, i) = pair[0], ij(1, i) = pair[1];
      shapes.col(i) = pairs.col(static_cast<Eigen::Index>(order[static_cast<std::size_t>(i)]));
      products[i] = largest[pair[0]] * largest[pair[1]];
    }
    mesh["pairs"] = nullptr;
    if (order.empty()) return;
    mesh["pairs"] = {{"ij", arrays_.add(ij, "u16")}, {"shapes", arrays_.add_shapes(shapes, products, 3e-7 * size)}};
  }

  /// Points as they were recorded: shapes fitted to them, and where the body has no frame, its pose too.
  void add_fitted(Json& body) {
    Json& mesh = body["mesh"];
    const MatrixX points = part(mesh["nodal"]);
    const Matrix3X drawn = set(mesh["points"]);
    MatrixX displacements(points.rows(), points.cols()), positions(3, points.cols()), rotations(4, points.cols());
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const Eigen::Map<const Matrix3X> now(points.col(i).data(), 3, drawn.cols());
      BestFit fit{Matrix3::Identity(), Vector3::Zero()};
      if (!body["frame"]) fit = best_fit(drawn, now);
      const Matrix3X own = fit.rotation.transpose() * (now.colwise() - fit.translation);
      displacements.col(i) = (own - drawn).reshaped();
      positions.col(i) = fit.translation;
      Vector4 e = quaternion_of(fit.rotation);
      if (i > 0 && e.dot(rotations.col(i - 1)) < 0) e = -e;
      rotations.col(i) = e;
    }
    if (!body["frame"]) {
      body["position"] = arrays_.add(positions, "f32");
      body["rotation"] = arrays_.add(rotations, "f32");
    }
    const double size = size_of(drawn);
    const FittedShapes fitted = fit_shapes(displacements, 1e-4 * size);
    mesh["coordinates"] = arrays_.add(fitted.coordinates, "f32");
    mesh["shapes"] = arrays_.add_shapes(fitted.shapes, largest_of(fitted.coordinates), 1e-5 * size);
    for (Eigen::Index k = 0; k < fitted.shapes.cols(); ++k)
      mesh["modes"].push_back({{"name", "fitted shape " + std::to_string(k + 1)}, {"frequency", nullptr}});
    mesh.erase("nodal");
  }

  void resolve(Json& json) {
    if (json.is_object() && json.contains("set"))
      json = arrays_.add(set(json), json["as"]);
    else if (json.is_object() && json.contains("row")) {
      Json reference = arrays_.add(part(json), json["as"]);
      if (live_) reference["row"] = json["row"], reference["width"] = json["width"];
      json = std::move(reference);
    } else if (json.is_structured())
      for (Json& inner : json) resolve(inner);
  }

  void add_contacts() {
    if (!json_["contacts"].get<bool>()) {
      json_["contacts"] = nullptr;
      return;
    }
    const auto count = static_cast<Eigen::Index>(record_.contacts.size()) / RunRecord::kContactWidth;
    const Eigen::Map<const MatrixX> points(record_.contacts.data(), RunRecord::kContactWidth, count);
    MatrixX first = MatrixX::Zero(1, rows_.cols() + 1);
    for (Eigen::Index i = 0; i < count; ++i) first(0, static_cast<Eigen::Index>(points(0, i)) + 1) += 1;
    std::partial_sum(first.data(), first.data() + first.size(), first.data());
    json_["contacts"] = {{"first", arrays_.add(first, "u32")},
                         {"points", arrays_.add(points.middleRows(2, 3), "f32")},
                         {"forces", arrays_.add(points.middleRows(5, 3), "f32")},
                         {"pair", arrays_.add(points.middleRows(1, 1), "u16")}};
  }

  const RunRecord& record_;
  Arrays& arrays_;
  const bool live_;
  const Rows rows_;
  Json json_;
};

/// Numbers that are none would become null.
void require_numbers(const Json& json, const std::string& path) {
  if (json.is_number_float() && !std::isfinite(json.get<double>()))
    throw SceneError("a number in the description of the scene is not finite", path,
                     "see which shape or marker has it");
  if (json.is_structured())
    for (const Json& inner : json) require_numbers(inner, path);
}

std::string text_of(const Json& json, const std::string& path) {
  require_numbers(json, path);
  std::string text, escaped;
  try {
    text = json.dump();
  } catch (const Json::exception&) {
    throw SceneError("a name in the page is not UTF-8", path, "save the scene's source as UTF-8, or use other names");
  }
  for (const char c : text) {
    if (c == '<')
      escaped += "\\u003c";  // "</script>" would end the data
    else
      escaped += c;
  }
  return escaped;
}

}  // namespace page_parts

void write_page(const Run& run, const std::string& path, const PageOptions& options) {
  write_page(std::vector<std::reference_wrapper<const Run>>{run}, path, options);
}

void write_page(const std::vector<std::reference_wrapper<const Run>>& runs, const std::string& path,
                const PageOptions& options) {
  if (runs.empty()) throw SceneError("a page without a run", path, "give the runs that it is to show");
  PageOptions page = options;
  std::set<std::string> names;
  std::vector<std::shared_ptr<const RunRecord>> kept;
  std::vector<const RunRecord*> records;
  for (const Run& run : runs) {
    if (!names.insert(run.name()).second)
      throw SceneError("two runs of the page are called '" + run.name() + "'", path,
                       "give each its own RunOptions::name");
    if (options.title.empty()) page.title += (page.title.empty() ? "" : ", ") + run.name();
    kept.push_back(run.record());
    records.push_back(kept.back().get());
    if (records.back()->row_count() == 0)
      throw SceneError("the run '" + run.name() + "' has no states", path,
                       "call simulation.observe(run, every(...)) before simulation.run()");
  }
  const std::string text = page_text(records, page, path);
  PartialFile file(path);
  file.stream() << text;
  file.commit();
}

std::string page_text(const std::vector<const RunRecord*>& runs, const PageOptions& options, const std::string& where,
                      PageKind kind) {
  using namespace page_parts;
  Arrays arrays;
  Json page = {{"format", "lithe-page"},    {"version", 1},
               {"title", options.title},    {"made_by", "lithe " + std::string(kVersion)},
               {"findings", Json::array()}, {"runs", Json::array()}};
  for (const PageFinding& found : options.findings)
    page["findings"].push_back(
        {{"kind", found.kind}, {"text", found.text}, {"fix", found.fix}, {"alarm", found.alarm}});
  if (kind == PageKind::live) page["live"] = {{"width", runs[0]->width}};
  for (const RunRecord* run : runs) try {
      page["runs"].push_back(PageRun(*run, arrays, kind).make());
    } catch (const Json::exception&) {  // of a file that another program has changed
      throw SceneError("the run '" + run->name + "' lacks a part of its description", where, "record the run again");
    }

  constexpr std::string_view kPlace = "<!--LITHE-DATA-->";
  const std::string_view viewer = viewer_template();
  const std::size_t at = viewer.find(kPlace);
  if (at == std::string_view::npos)
    throw SceneError("the viewer in this library has no place for data", where, "build it with tools/viewer/build.sh");
  std::string text(viewer.substr(0, at));
  text += "<script type=\"application/json\" id=\"lithe-scene\">" + text_of(page, where);
  text += "</script>\n<script type=\"text/plain\" id=\"lithe-data\">" + packed_text(arrays.bytes()) + "</script>";
  return text.append(viewer.substr(at + kPlace.size()));
}

}  // namespace lithe
