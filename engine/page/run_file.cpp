#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/output/hdf5_file.h"
#include "engine/output/hdf5_series.h"
#include "engine/page/run_record_internal.h"

namespace lithe {
namespace {

constexpr const char* kFormat = "lithe run";
constexpr int kEventName = 60;  // bytes of an event's name that are kept

std::vector<int> bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

}  // namespace

struct RunFile::Parts {
  Hdf5Series file;
};

RunFile::RunFile(const std::string& path, const RunRecord& record) : parts_(new Parts{Hdf5Series(path)}) {
  Hdf5Series& file = parts_->file;
  file.attribute("/", "format", kFormat);
  file.attribute("/", "version", std::to_string(RunRecord::kVersion));
  file.write("/scene", bytes_of(record.scene));
  // Data sets without groups: "/mesh/1/points" is set 7, named in /set_names.
  std::string names;
  int number = 0;
  for (const auto& [name, matrix] : record.sets) {
    file.write("/set_" + std::to_string(number++), matrix);
    names += name + '\n';
  }
  file.write("/set_names", bytes_of(names));
  file.add("/contacts", RunRecord::kContactWidth);
  file.add("/events", 1 + kEventName);
  file.add("/rows", record.width);
  file.begin();
}

RunFile::~RunFile() = default;

void RunFile::append(const VectorX& row, const std::vector<double>& contacts) {
  Hdf5Series& file = parts_->file;
  for (std::size_t i = 0; i < contacts.size(); i += RunRecord::kContactWidth)
    file.append("/contacts", Eigen::Map<const VectorX>(contacts.data() + i, RunRecord::kContactWidth));
  if (!contacts.empty()) file.flush();
  file.append("/rows", row);  // last: it says that the state is complete
  file.flush();
}

void RunFile::append(const std::vector<EventRecord>& events) {
  for (const EventRecord& event : events) {
    VectorX row = VectorX::Zero(1 + kEventName);
    row[0] = event.time;
    for (std::size_t i = 0; i < std::min<std::size_t>(event.name.size(), kEventName); ++i)
      row[static_cast<Eigen::Index>(i) + 1] = static_cast<unsigned char>(event.name[i]);
    parts_->file.append("/events", row);
  }
  parts_->file.flush();
}

namespace {

std::string text_of(const std::vector<int>& bytes) {
  std::string text;
  for (int byte : bytes) text += static_cast<char>(byte);
  return text;
}

/// Every array that the scene names is there, and every part of a row is within it.
void check_arrays(const Hdf5Reader& file, const nlohmann::json& json, const RunRecord& record) {
  if (json.is_object() && json.contains("set") && !record.sets.contains(json.at("set").get<std::string>()))
    file.refuse("/scene", "names an array that the file does not hold");
  if (json.is_object() && json.contains("row")) {
    const int first = json.at("row").get<int>(), width = json.at("width").get<int>();
    if (first < 0 || width < 0 || first > record.width || width > record.width - first)
      file.refuse("/scene", "names numbers beyond the rows");
  }
  if (json.is_structured())
    for (const auto& part : json) check_arrays(file, part, record);
}

/// Rows of that width; 0: any.
MatrixX rows_of(const Hdf5Reader& file, const std::string& name, int width) {
  const MatrixX rows = file.matrix(name);
  if (rows.size() == 0) return {width, 0};
  if (width > 0 && rows.rows() != width) file.refuse(name, "has rows of another width");
  if (rows.rows() > RunRecord::kMostColumns) file.refuse(name, "has rows that are too wide");
  if (!rows.allFinite()) file.refuse(name, "has a number that is not finite");
  return rows;
}

/// What a page needs of each body and channel is there and fits.
void check_scene(const Hdf5Reader& file, const nlohmann::json& scene, const RunRecord& record) {
  const auto set = [&](const nlohmann::json& place) -> const MatrixX& {
    return record.sets.at(place.at("set").get<std::string>());
  };
  scene.at("contacts").get<bool>();
  for (const auto& channel : scene.at("channels")) {
    channel.at("name").get_ref<const std::string&>();
    if (channel.at("values").at("width").get<int>() != 1) file.refuse("/scene", "has a channel that is not one number");
  }
  for (const auto& body : scene.at("bodies")) {
    body.at("frame").get<bool>();
    const auto& mesh = body.at("mesh");
    if (mesh.is_null()) continue;
    const MatrixX& points = set(mesh.at("points"));
    bool fits = points.rows() == 3 && points.cols() > 0;
    if (mesh.contains("nodal")) {
      fits = fits && mesh["nodal"].at("width").get<int>() == points.size();
    } else {
      const auto modes = mesh.at("coordinates").at("width").get<Eigen::Index>();
      const auto has = [&](const nlohmann::json& place, Eigen::Index rows, Eigen::Index columns) {
        return set(place).cols() == columns && (columns == 0 || set(place).rows() == rows);
      };
      fits = fits && has(mesh.at("shapes"), points.size(), modes);
      if (mesh.at("pairs").is_object()) fits = fits && has(mesh["pairs"], points.size(), modes * (modes + 1) / 2);
      if (mesh.at("stress").is_object()) fits = fits && has(mesh["stress"].at("shapes"), 2 * points.size(), modes);
    }
    if (!fits) file.refuse("/scene", "has a body whose mesh and shapes do not fit each other");
  }
}

/// Parsed; what reads it calls itself once a level.
nlohmann::json parsed(const Hdf5Reader& file, const std::string& text) {
  constexpr int kDeepest = 50;
  return nlohmann::json::parse(text, [&](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
    if (depth > kDeepest) file.refuse("/scene", "is nested more deeply than a scene is");
    return true;
  });
}

}  // namespace

RunRecord read_run_file(const std::string& path) {
  const Hdf5Reader file(path);
  if (!file.has("/scene") || !file.has("/rows") || file.text_attribute("/", "format") != kFormat)
    throw FileError("this HDF5 file holds no run.", path, "give a file that Run::stream() wrote.");
  const std::string version = file.text_attribute("/", "version");
  if (version != std::to_string(RunRecord::kVersion))
    throw FileError("this run was written in version " + version + " of the format; this library reads version " +
                        std::to_string(RunRecord::kVersion) + ".",
                    path, "read it with the library that wrote it, or record the run again.");
  RunRecord record;
  record.scene = text_of(file.integers("/scene"));
  const std::string names = text_of(file.integers("/set_names"));
  int number = 0;
  for (std::size_t from = 0; from < names.size();) {
    const std::size_t end = std::min(names.find('\n', from), names.size());
    record.sets[names.substr(from, end - from)] = file.matrix("/set_" + std::to_string(number++));
    from = end + 1;
  }
  const MatrixX rows = rows_of(file, "/rows", 0);
  record.width = std::max(1, static_cast<int>(rows.rows()));
  record.rows.assign(rows.data(), rows.data() + rows.size());
  const MatrixX contacts = rows_of(file, "/contacts", RunRecord::kContactWidth);
  for (Eigen::Index i = 0; i < contacts.cols(); ++i) {
    if (contacts(0, i) < 0) file.refuse("/contacts", "has a point of no row");
    if (contacts(0, i) < static_cast<double>(rows.cols()))  // of a row that was written
      record.contacts.insert(record.contacts.end(), contacts.col(i).begin(), contacts.col(i).end());
  }
  const MatrixX events = rows_of(file, "/events", 1 + kEventName);
  for (Eigen::Index i = 0; i < events.cols(); ++i) {
    std::string name;
    for (Eigen::Index k = 1; k < events.rows() && events(k, i) > 0; ++k)
      name += static_cast<char>(static_cast<unsigned char>(std::min(events(k, i), 255.0)));
    record.events.push_back({events(0, i), name, -1});
  }
  try {
    const auto scene = parsed(file, record.scene);
    record.name = scene.at("name").get<std::string>();
    check_arrays(file, scene, record);
    if (record.row_count() > 0) check_scene(file, scene, record);
  } catch (const nlohmann::json::exception&) {
    file.refuse("/scene", "is not the description of a run");
  }
  return record;
}

std::vector<double> channel_of(const RunRecord& record, const Located& name) {
  int column = name.text == "t" ? 0 : -1;
  std::string known = "t";
  const auto scene = record.row_count() > 0 ? nlohmann::json::parse(record.scene) : nlohmann::json();
  if (!scene.is_null())
    for (const auto& channel : scene.at("channels")) {
      const auto called = channel.at("name").get<std::string>();
      known += ", " + called;
      if (called == name.text) column = channel.at("values").at("row").get<int>();
    }
  if (column < 0)
    throw SceneError("the run '" + record.name + "' has no channel '" + name.text + "'", to_string(name.where),
                     "it has " + known);
  std::vector<double> values;
  for (int row = 0; row < record.row_count(); ++row)
    values.push_back(record.rows[static_cast<std::size_t>(row) * static_cast<std::size_t>(record.width) +
                                 static_cast<std::size_t>(column)]);
  return values;
}

}  // namespace lithe
