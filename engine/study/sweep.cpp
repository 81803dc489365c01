#include "engine/study/sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/fnv1a.h"
#include "engine/base/log.h"
#include "engine/base/number_text.h"
#include "engine/output/partial_file.h"
#include "engine/study/study_run.h"
#include "engine/study/sweep_internal.h"

namespace lithe {
namespace {

constexpr int kMostReported = 10;  // failures, in report()

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void check(const SweepScene& scene, const Table& parameters, const SweepOptions& options) {
  const auto refuse = [](const std::string& what, const std::string& fix) { throw SceneError(what, "sweep", fix); };
  if (!scene) refuse("there is no scene", "give a function of a SweepPoint");
  if (options.threads < 0) refuse("the number of threads is negative", "0 means all processors");
  if (parameters.row_count() == 0) refuse("there are no points", "give a table with a row a point, such as grid()");
  for (std::size_t i = 0; i < parameters.columns.size(); ++i) {
    const std::string& name = parameters.columns[i];
    if (name.empty()) refuse("a parameter has no name", "name the columns of the table");
    if (std::count(parameters.columns.begin(), parameters.columns.end(), name) > 1)
      refuse("the parameter '" + name + "' appears twice", "give each a name of its own");
    for (int row = 0; row < parameters.row_count(); ++row)
      if (!std::isfinite(parameters.at(row, static_cast<int>(i))))
        refuse("the parameter '" + name + "' is not finite in row " + std::to_string(row), "fix the table");
  }
}

void check_names(const SweepValues& values, const std::vector<std::string>& parameters) {
  std::vector<std::string> names;
  for (const SweepValue& value : values) {
    if (value.name.empty()) throw SceneError("a result has no name", "the scene of the sweep", "name it");
    if (contains(names, value.name) || contains(parameters, value.name))
      throw SceneError("the result '" + value.name + "' has the name of another result or of a parameter",
                       "the scene of the sweep", "give it a name of its own");
    names.push_back(value.name);
  }
}

bool same_names(const SweepValues& a, const SweepValues& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const SweepValue& x, const SweepValue& y) { return x.name == y.name; });
}

/// The scene at one point; what it throws is part of the outcome.
SweepOutcome compute(const SweepScene& scene, const Table& parameters, int row) {
  const SweepPoint point(parameters, row);
  SweepOutcome outcome{.row = row};
  const auto fail = [&](const std::string& what, const std::string& where, const std::string& fix) {
    outcome.values.clear();
    outcome.failure = SweepFailure{row, point.text(), what, where, fix};
  };
  const auto foreign = [&](const std::string& what) {
    fail(what, "the scene of the sweep", "this error does not come from Lithe: see what the scene calls at this point");
  };
  const auto begun = std::chrono::steady_clock::now();
  try {
    outcome.values = scene(point);
    check_names(outcome.values, parameters.columns);
  } catch (const Error& error) {
    fail(error.problem(), error.where(), error.fix());
  } catch (const std::exception& error) {
    foreign(error.what());
  } catch (...) {
    foreign("something was thrown that is no std::exception");
  }
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return outcome;
}

std::uint64_t fingerprint(const Table& table) {
  std::uint64_t hash = kFnvStart;
  for (const std::string& name : table.columns) hash = fnv1a({name.c_str(), name.size() + 1}, hash);
  return fnv1a({reinterpret_cast<const char*>(table.values.data()), table.values.size() * sizeof(double)}, hash);
}

/// The outcomes, by row, as a table. Its columns are those of the first point that has results.
SweepResult gather(const Table& parameters, std::vector<SweepOutcome> outcomes) {
  SweepResult result{.table = {.columns = parameters.columns}};
  const auto first =
      std::find_if(outcomes.begin(), outcomes.end(), [](const SweepOutcome& outcome) { return !outcome.failure; });
  const SweepValues named = first == outcomes.end() ? SweepValues{} : first->values;
  for (const SweepValue& value : named) result.table.columns.push_back(value.name);
  const std::size_t width = parameters.columns.size();
  for (SweepOutcome& outcome : outcomes) {
    if (!outcome.failure && !same_names(outcome.values, named))
      outcome.failure = SweepFailure{outcome.row, SweepPoint(parameters, outcome.row).text(),
                                     "it names other results than " + SweepPoint(parameters, first->row).text(),
                                     "the scene of the sweep",
                                     "return the same names in the same order; NaN where there is not finite"};
    const auto begin = parameters.values.begin() + static_cast<std::ptrdiff_t>(outcome.row * width);
    std::vector<double> row(begin, begin + static_cast<std::ptrdiff_t>(width));
    for (std::size_t i = 0; i < named.size(); ++i)
      row.push_back(outcome.failure ? std::numeric_limits<double>::quiet_NaN() : outcome.values[i].value);
    result.table.add_row(row);
    if (outcome.failure) result.failures.push_back(*outcome.failure);
  }
  return result;
}

/// Points by name in the bar; the time left from what a point takes on average.
class Bar {
 public:
  Bar(const Table& parameters, Progress::Show show)
      : parameters_(parameters),
        progress_(std::vector<int>(parameters.row_count(), 1), std::numeric_limits<double>::infinity(), show) {}

  void count(const SweepOutcome& outcome, int threads) {
    progress_.begin(outcome.row, SweepPoint(parameters_, outcome.row).text());
    progress_.end(outcome.seconds / threads);
  }

 private:
  const Table& parameters_;
  Progress progress_;
};

/// The table so far, in a file: each time as a whole, so that a kill leaves one that is complete.
class KeptTable {
 public:
  KeptTable(const Table& parameters, std::string path, const std::vector<SweepOutcome>& outcomes)
      : parameters_(parameters), path_(std::move(path)), outcomes_(outcomes) {
    if (!path_.empty()) gather(parameters_, outcomes_).write_csv(path_);
  }
  /// An outcome has changed. It is written soon: at once, or by an update() of later.
  void change() {
    changed_ = true;
    update();
  }
  /// Writes what has changed, unless the last time was so recently that it would cost more than a twentieth of the
  /// time.
  void update() {
    if (changed_ && !path_.empty() && Clock::now() >= next_) try_to_write(gather(parameters_, outcomes_));
  }
  void finish(const SweepResult& result) {
    if (!path_.empty()) try_to_write(result);
  }

 private:
  using Clock = std::chrono::steady_clock;
  void try_to_write(const SweepResult& result) {
    const auto begun = Clock::now();
    changed_ = false;
    try {
      result.write_csv(path_);
    } catch (const FileError& error) {  // the points computed so far are worth more
      if (!warned_) log::warn(error.what());
      warned_ = true;
    }
    next_ = Clock::now() + 20 * (Clock::now() - begun);
  }

  const Table& parameters_;
  const std::string path_;
  const std::vector<SweepOutcome>& outcomes_;
  Clock::time_point next_{};
  bool warned_ = false, changed_ = false;
};

thread_local bool within_point = false;

}  // namespace

double SweepPoint::operator[](const Located& parameter) const {
  const std::size_t count = parameters_.columns.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t column = next_ + i < count ? next_ + i : next_ + i - count;
    if (parameters_.columns[column] != parameter.text) continue;
    next_ = column + 1 < count ? column + 1 : 0;
    return parameters_.at(row_, static_cast<int>(column));
  }
  std::string known;
  for (const std::string& name : parameters_.columns) known += (known.empty() ? "" : ", ") + name;
  throw SceneError("the sweep has no parameter '" + parameter.text + "'", to_string(parameter.where),
                   "known are " + known);
}

std::string SweepPoint::text() const {
  std::string list;
  for (std::size_t i = 0; i < parameters_.columns.size(); ++i)
    list += (list.empty() ? "" : ", ") + parameters_.columns[i] + " " +
            short_number(parameters_.at(row_, static_cast<int>(i)));
  return "point " + std::to_string(row_) + " (" + list + ")";
}

std::string SweepResult::report() const {
  std::string text = std::to_string(failures.size()) + " of " + std::to_string(table.row_count()) + " points failed\n";
  for (std::size_t i = 0; i < failures.size() && i < kMostReported; ++i)
    text += failures[i].point + ": " + failures[i].what + "\n  at:   " + failures[i].where +
            "\n  fix:  " + failures[i].fix + "\n";
  if (failures.size() > kMostReported) text += "and " + std::to_string(failures.size() - kMostReported) + " more\n";
  return text;
}

void SweepResult::write_csv(const std::string& path) const {
  if (rank != 0) return;
  const auto quoted = [](const std::string& cell) {
    if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
    std::string out = "\"";
    for (const char c : cell) out += c == '"' ? "\"\"" : std::string(1, c == '\n' || c == '\r' ? ' ' : c);
    return out + '"';
  };
  std::string line;
  for (const std::string& name : table.columns) line += (line.empty() ? "" : ",") + quoted(name);
  if (!failures.empty()) line += ",error";
  PartialFile file(path);
  file.stream() << line << '\n';
  auto failure = failures.begin();
  for (int row = 0; row < table.row_count(); ++row) {
    line.clear();
    for (int column = 0; column < static_cast<int>(table.columns.size()); ++column) {
      if (column > 0) line += ',';
      if (const double value = table.at(row, column); !std::isnan(value)) append_number(line, value);
    }
    if (!failures.empty()) line += ',';
    if (failure != failures.end() && failure->row == row) {
      line += quoted(failure->what + "; at " + failure->where + "; " + failure->fix);
      ++failure;
    }
    file.stream() << line << '\n';
  }
  file.commit();
}

SweepResult sweep(const SweepScene& scene, const Table& parameters, const SweepOptions& options) {
  check(scene, parameters, options);
  const int count = parameters.row_count();
  std::vector<SweepOutcome> outcomes;
  outcomes.reserve(static_cast<std::size_t>(count));
  for (int row = 0; row < count; ++row)
    outcomes.push_back({.row = row,
                        .failure = SweepFailure{row, SweepPoint(parameters, row).text(), "it was not computed", "sweep",
                                                "run the sweep again: it ended before this point"}});
  if (within_point) {
    KeptTable table(parameters, options.file, outcomes);
    for (int row = 0; row < count; ++row) {
      outcomes[row] = compute(scene, parameters, row);
      table.change();
    }
    SweepResult result = gather(parameters, std::move(outcomes));
    table.finish(result);
    return result;
  }

  SweepRanks* ranks = SweepRanks::find();
  const int rank = ranks ? ranks->rank() : 0;
  const int threads =
      options.threads > 0 ? options.threads : free_processors(ranks ? ranks->ranks_on_this_machine() : 1);
  Bar bar(parameters, rank == 0 ? options.progress : Progress::Show::never);
  KeptTable table(parameters, rank == 0 ? options.file : "", outcomes);
  int finished = 0;
  const auto keep = [&](SweepOutcome outcome, int all_threads) {
    bar.count(outcome, all_threads);
    ++finished;
    outcomes.at(outcome.row) = std::move(outcome);
    table.change();
  };
  SweepThreads team(std::min(threads, count), [&](int row) {
    within_point = true;
    return compute(scene, parameters, row);
  });
  if (ranks) {
    ranks->share(team, count, fingerprint(parameters), keep, [&] { table.update(); });
  } else {
    for (int row = 0; row < count; ++row) team.add(row);
    while (finished < count) {
      for (SweepOutcome& outcome : team.take(std::chrono::seconds(1))) keep(std::move(outcome), team.size());
      table.update();
    }
  }
  SweepResult result = gather(parameters, std::move(outcomes));
  result.rank = rank;
  table.finish(result);
  return result;
}

}  // namespace lithe
