#pragma once

#include <filesystem>

#include "models/adams/adams_model.h"
#include "models/adams/adams_statements_internal.h"
#include "models/model_description.h"
#include "models/notes_internal.h"

namespace lithe::adams {

/// What the units of a data set are in SI, by its UNITS. Throws FileError, naming the line.
AdamsUnits read_adams_units(const DataSet& file);

/// Reads a data set into a description, statement by statement.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : file_(path) {
    model_.path = file_.path;
    model_.format = "Adams data set";
    model_.name = file_.title.substr(file_.title.find_last_of(" :\t") + 1);
    if (model_.name.empty()) model_.name = "model";
    names_.variable = [this](int id) { return variable_text(id); };
    names_.curve = [this](int id, AdamsCurve::Kind kind) { return curve(id, kind); };
    names_.fail = [this](const std::string& problem, const std::string& fix) { file_.fail(line_, problem, fix); };
  }

  ModelDescription read();

 private:
  template <class Read>
  void for_each(const std::string& keyword, Read&& read) {
    for (const Statement& statement : file_.statements)
      if (statement.keyword == keyword) {
        line_ = statement.line;
        read(statement, Arguments(file_, statement));
      }
  }

  void check_identifiers();

  // ---- parts and markers ----

  /// Axes from points on z and in the xz plane, as of ZP, XP and ZG, XG.
  Matrix3 axes_of_points(const Arguments& a, const char* z_name, const char* x_name, const Vector3& origin);
  Matrix3 orientation(const Arguments& a, const char* z_name, const char* x_name, const Vector3& origin);
  void add_part(const Statement& s, const Arguments& a);
  void add_marker(const Statement& s, const Arguments& a);
  const AdamsModel::MarkerFrame& marker_of(const Arguments& a, int id, const std::string& argument);
  void add_mass(const Statement& s, const Arguments& a);
  Matrix3 world_axes(const AdamsModel::MarkerFrame& marker) const;

  // ---- functions ----

  AdamsFunction function(const Arguments& a, const std::string& name);
  const Statement* statement(const std::string& keyword, int id) const;
  std::string variable_text(int id);
  AdamsCurve curve(int id, AdamsCurve::Kind kind);
  void check_spline(const Statement& s, const Arguments& a);

  // ---- all others ----

  std::pair<int, int> ends(const Arguments& a);
  void list(const Statement& s, const std::string& kind, int i, int j);
  /// The one of several names that is there.
  std::string kind_of(const Arguments& a, const std::vector<std::string>& kinds);
  void read(const Statement& s, const Arguments& a);
  void add_joint(const Statement& s, const Arguments& a);
  void add_motion(const Statement& s, const Arguments& a);
  void refuse_routine(const Arguments& a);
  void refuse_euler_parameters(const Arguments& a, const AdamsFunction& f);
  void refuse_loads(const Arguments& a, const AdamsFunction& f);
  void add_sforce(const Statement& s, const Arguments& a);
  std::pair<int, int> ends_or_one(const Arguments& a);
  void add_components(const Statement& s, const Arguments& a);
  void add_spring(const Statement& s, const Arguments& a);
  /// From matrices and vectors of the file, which act on (lengths, radians) and give (forces, torques), to SI.
  void add_scaled(const Statement& s, AdamsModel::Field field, const std::string& kind);
  void add_bushing(const Statement& s, const Arguments& a);
  void add_beam(const Statement& s, const Arguments& a);
  void add_field(const Statement& s, const Arguments& a);
  void add_damping(const Arguments& a, AdamsModel::Field& field);
  void add_coupler(const Statement& s, const Arguments& a);
  void list_all(const Statement& s, const std::string& kind, const AdamsFunction& f);
  void add_request(const Statement& s, const Arguments& a);
  void add_simulation(const Statement& s, const Arguments& a);
  /// What could only be checked once all is read.
  void check_references();

  DataSet file_;
  ModelDescription model_;
  AdamsModel made_;
  Notes notes_;
  AdamsNames names_;
  std::map<int, int> part_places_;
  int ground_ = -1, line_ = 0;
  bool has_gravity_ = false;
};

}  // namespace lithe::adams
