#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <numbers>
#include <set>
#include <sstream>

#include "engine/base/error.h"
#include "models/adams/adams_statements_internal.h"

namespace lithe::adams {
namespace {

constexpr std::uintmax_t kLargest = 64 << 20;
/// Between two lines of a statement: a comma that separates, or, within an expression, a space.
constexpr char kNewLine = '\n';

using Names = std::vector<std::string>;

/// The statements that are known, with the names of their arguments; of two that begin alike the first is meant.
const std::vector<std::pair<std::string, Names>>& grammar() {
  static const std::vector<std::pair<std::string, Names>> all = {
      {"PART",
       {"GROUND", "MASS", "MATERIAL", "CM", "IM", "IP", "QG", "REULER", "ZG", "XG", "VX", "VY", "VZ", "VM", "WX", "WY",
        "WZ", "WM", "EXACT"}},
      {"MARKER",
       {"PART", "POINT_MASS", "FLEX_BODY", "NODE_ID", "FLOATING", "QP", "REULER", "ZP", "XP", "USEXP", "CURVE",
        "VELOCITY"}},
      {"JOINT",
       {"CONVEL",        "CYLINDRICAL", "FIXED", "HOOKE", "PLANAR", "RACKPIN", "REVOLUTE", "SCREW", "SPHERICAL",
        "TRANSLATIONAL", "UNIVERSAL",   "I",     "J",     "IC",     "ICROT",   "ICTRAN",   "PITCH", "PD",
        "DELTA_V",       "FRICTION",    "MAXIT", "MU1",   "PRELOAD"}},
      {"JPRIM", {"ATPOINT", "INLINE", "INPLANE", "ORIENTATION", "PARALLEL_AXES", "PERPENDICULAR", "I", "J"}},
      {"MOTION",
       {"JOINT", "ROTATION", "TRANSLATION", "I", "J", "FUNCTION", "DISPLACEMENT", "VELOCITY", "ACCELERATION", "X", "Y",
        "Z", "B1", "B2", "B3", "ICDISP", "ICVEL", "ROUTINE"}},
      {"SFORCE", {"I", "J", "TRANSLATIONAL", "ROTATIONAL", "ACTIONONLY", "FUNCTION", "ROUTINE", "ARRAY"}},
      {"VFORCE", {"I", "JFLOAT", "RM", "FX", "FY", "FZ", "FUNCTION", "ROUTINE"}},
      {"VTORQUE", {"I", "JFLOAT", "RM", "TX", "TY", "TZ", "FUNCTION", "ROUTINE"}},
      {"GFORCE", {"I", "JFLOAT", "RM", "FX", "FY", "FZ", "TX", "TY", "TZ", "FUNCTION", "ROUTINE"}},
      {"SPRINGDAMPER",
       {"I", "J", "TRANSLATION", "ROTATION", "C", "CT", "K", "KT", "FORCE", "TORQUE", "LENGTH", "ANGLE"}},
      {"BUSHING", {"I", "J", "C", "CT", "K", "KT", "FORCE", "TORQUE"}},
      {"BEAM",
       {"I", "J", "LENGTH", "IXX", "IYY", "IZZ", "AREA", "ASY", "ASZ", "EMODULUS", "GMODULUS", "CMATRIX", "CRATIO",
        "FORMULATION"}},
      {"FIELD", {"I", "J", "CMATRIX", "CRATIO", "FORCE", "KMATRIX", "LENGTH", "FUNCTION", "FORMULATION", "ROUTINE"}},
      {"COUPLER", {"JOINTS", "SCALES", "TYPE", "FUNCTION", "ROUTINE"}},
      {"GEAR", {"JOINTS", "CV"}},
      {"GCON", {"I", "FUNCTION"}},
      {"REQUEST", {"DISPLACEMENT", "VELOCITY",  "ACCELERATION", "FORCE",  "I",           "J",  "RM", "COMMENT", "TITLE",
                   "FUNCTION",     "F1",        "F2",           "F3",     "F4",          "F5", "F6", "F7",      "F8",
                   "ROUTINE",      "VARIABLES", "CNAMES",       "CUNITS", "RESULTS_NAME"}},
      {"VARIABLE", {"FUNCTION", "IC", "ROUTINE"}},
      {"SPLINE", {"X", "Y", "LINEAR_EXTRAPOLATE", "FILE", "BLOCK", "CHANNEL", "ROUTINE"}},
      {"UNITS", {"FORCE", "MASS", "LENGTH", "TIME", "SYSTEM", "UCF"}},
      {"ACCGRAV", {"IGRAV", "JGRAV", "KGRAV", "GC"}},
      {"INTEGRATOR", {"GSTIFF", "WSTIFF", "CONSTANT_BDF", "HHT",        "NEWMARK",     "ABAM",   "RKF45",
                      "SI1",    "SI2",    "I3",           "ERROR",      "HMAX",        "HMIN",   "HINIT",
                      "KMAX",   "MAXIT",  "PATTERN",      "ADAPTIVITY", "INTERPOLATE", "SI2",    "CORRECTOR",
                      "DTOUT",  "BETA",   "GAMMA",        "ALPHA",      "FIXIT",       "HRATIO", "SCALE"}},
      {"SIMULATE",
       {"END", "DTOUT", "STEPS", "DURATION", "TRANSIENT", "DYNAMIC", "KINEMATIC", "STATIC", "INITIAL_CONDITIONS",
        "STATICS"}},
      {"END", {}},
      // Known, and without effect on the motion, or left out.
      {"GRAPHICS", {}},
      {"OUTPUT", {}},
      {"RESULTS", {}},
      {"PREFERENCES", {}},
      {"DEBUG", {}},
      {"LSE", {}},
      {"GSE", {}},
      {"TFSISO", {}},
      {"DIFF", {}},
      {"SENSOR", {}},
      {"CONTACT", {}},
      {"FRICTION", {}},
      {"ARRAY", {}},
      {"MATRIX", {}},
      {"STRING", {}},
      {"CURVE", {}},
      {"CVCV", {}},
      {"PTCV", {}},
      {"UCON", {}},
      {"POINT_MASS", {}},
      {"FLEX_BODY", {}},
      {"FE_PART", {}},
      {"FE_NODE", {}},
      {"FE_LOAD", {}},
      {"MFORCE", {}},
      {"NFORCE", {}},
      {"PINPUT", {}},
      {"POUTPUT", {}},
      {"PLANT", {}},
      {"EQUILIBRIUM", {}},
      {"KINEMATICS", {}},
      {"IC", {}},
      {"MOBODY", {}},
      {"SAVE", {}},
      {"STOP", {}},
      {"LINEAR", {}},
      {"ANALYSIS", {}},
      {"DEACTIVATE", {}},
      {"ACTIVATE", {}},
      {"MATERIAL", {}},
      {"GEOMETRY", {}},
      {"VFORCE_TIRE", {}},
      {"TIRE", {}},
      {"GROUP", {}},
      {"LIST", {}},
      {"PSD", {}},
      {"SURFACE", {}}};
  return all;
}

bool is_function(const std::string& statement, const std::string& argument) {
  if (argument == "FUNCTION" || argument == "COMMENT" || argument == "TITLE") return true;
  if (statement == "REQUEST") return argument.size() == 2 && argument[0] == 'F' && std::isdigit(argument[1]);
  return argument.size() == 2 && (argument[0] == 'F' || argument[0] == 'T') && argument[1] >= 'X' && argument[1] <= 'Z';
}

std::string trimmed(const std::string& text) {
  const auto blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)); };
  auto from = std::find_if_not(text.begin(), text.end(), blank);
  auto to = std::find_if_not(text.rbegin(), text.rend(), blank).base();
  return from < to ? std::string(from, to) : "";
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

/// The name that a written one means: itself, or the first that it begins. Empty: none.
std::string completed(const std::string& written, const Names& names) {
  if (std::find(names.begin(), names.end(), written) != names.end()) return written;
  for (const std::string& name : names)
    if (!written.empty() && name.compare(0, written.size(), written) == 0) return name;
  return "";
}

struct Line {
  std::string text;
  int number;
};

/// NAME, blanks, '=' at the start of a piece: where the value begins; 0: it is none.
std::size_t value_of(const std::string& piece) {
  std::size_t at = 0;
  while (at < piece.size() && (std::isalnum(static_cast<unsigned char>(piece[at])) || piece[at] == '_')) ++at;
  if (at == 0 || std::isdigit(static_cast<unsigned char>(piece[0]))) return 0;
  while (at < piece.size() && std::isspace(static_cast<unsigned char>(piece[at]))) ++at;
  return at < piece.size() && piece[at] == '=' ? at + 1 : 0;
}

class StatementReader {
 public:
  StatementReader(DataSet& file, const std::vector<Line>& lines) : file_(file), lines_(lines) {}

  /// Of the lines [from, to): the head and its continuations.
  Statement read(std::size_t from, std::size_t to) {
    made_.line = lines_[from].number;
    const std::string& first = lines_[from].text;
    std::size_t at = first.find('/');
    const std::size_t comma = first.find(',');
    std::string keyword = trimmed(first.substr(0, std::min(at, comma)));
    find_keyword(upper(keyword));
    std::size_t rest = first.size();
    if (at != std::string::npos && at < comma) {
      rest = std::min(comma, first.size());
      const std::string id = trimmed(first.substr(at + 1, rest - at - 1));
      read_id(id);
    } else if (comma != std::string::npos) {
      rest = comma;
    }
    piece_line_ = made_.line;
    for (std::size_t i = from; i < to; ++i) {
      if (i > from) take_break(i);
      feed(i == from ? first.substr(rest) : lines_[i].text, lines_[i].number);
    }
    end_piece();
    return std::move(made_);
  }

 private:
  void find_keyword(const std::string& written) {
    for (const auto& [name, arguments] : grammar())
      if (name == written || (written.size() >= 3 && name.compare(0, written.size(), written) == 0)) {
        made_.keyword = name;
        names_ = &arguments;
        if (name == written) return;
        break;
      }
    for (const auto& [name, arguments] : grammar())  // whole names go first
      if (name == written) made_.keyword = name, names_ = &arguments;
    if (made_.keyword.empty())
      file_.fail(
          made_.line, "'" + written.substr(0, 40) + "' is no statement of an Adams data set.",
          "begin a statement with its keyword, a continued line with a comma; give a data set of the solver (.adm).");
  }

  void read_id(const std::string& text) {
    if (text.empty()) return;
    int id = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
    if (error == std::errc() && end == text.data() + text.size() && id > 0) {
      made_.id = id;
      return;
    }
    if (std::isalpha(static_cast<unsigned char>(text[0]))) {  // SIMULATE/TRANSIENT
      piece_ = text;
      piece_line_ = made_.line;
      end_piece();
      return;
    }
    file_.fail(made_.line, made_.keyword + "/" + text.substr(0, 40) + ": the identifier is no whole number above zero.",
               "number it: " + made_.keyword + "/12.");
  }

  /// Between two lines: within brackets, or in a function that no new argument follows, a space.
  void take_break(std::size_t next) {
    if (depth_ > 0) {
      piece_ += kNewLine;
      return;
    }
    const std::string following = trimmed(lines_[next].text);
    const std::size_t value = value_of(following);
    if (in_function() && value == 0 && !following.empty() && !is_flag(following)) {
      piece_ += kNewLine;
      return;
    }
    end_piece();
  }

  bool is_flag(const std::string& piece) const {
    std::string word;
    for (const char c : piece)
      if (std::isalnum(static_cast<unsigned char>(c)) || c == '_')
        word += c;
      else
        break;
    const std::string after = trimmed(piece.substr(word.size()));
    if (word.size() < 3 || (!after.empty() && after[0] != ',')) return false;
    return !completed(upper(word), *names_).empty();
  }

  bool in_function() const {
    const std::size_t value = value_of(trimmed(piece_));
    if (value > 0) {
      const std::string text = trimmed(piece_);
      return is_function(made_.keyword, completed(upper(trimmed(text.substr(0, value - 1))), *names_));
    }
    return !made_.arguments.empty() && is_function(made_.keyword, made_.arguments.back().name) &&
           piece_.empty() == false;
  }

  void feed(const std::string& text, int line) {
    for (const char c : text) {
      if (c == '(') ++depth_;
      if (c == ')') --depth_;
      if ((c == ',' && depth_ <= 0) || c == '\\') {
        end_piece();
        depth_ = 0;
        piece_line_ = line;
        continue;
      }
      if (trimmed(piece_).empty()) piece_line_ = line;
      piece_ += c;
    }
  }

  void end_piece() {
    const std::string piece = trimmed(piece_);
    piece_.clear();
    if (piece.empty()) return;
    if (names_->empty()) return;  // of a statement that does nothing here
    const std::size_t value = value_of(piece);
    if (value > 0) {
      const std::string written = upper(trimmed(piece.substr(0, value - 1)));
      std::string name = completed(written, *names_);
      if (made_.keyword == "REQUEST" && written == "C") name = "COMMENT";
      if (name.empty())
        file_.fail(piece_line_, made_.name() + " has no argument " + written + ".", "known are " + known() + ".");
      for (const Argument& before : made_.arguments)
        if (before.name == name && name != "Y")
          file_.fail(piece_line_, made_.name() + " has " + name + " twice.", "give it once.");
      const std::string text = trimmed(piece.substr(value));
      made_.arguments.push_back({name, {}, piece_line_});
      if (!text.empty()) made_.arguments.back().values.push_back(text);
      return;
    }
    if (std::isalpha(static_cast<unsigned char>(piece[0]))) {
      const bool of_text = !made_.arguments.empty() &&
                           (made_.arguments.back().name == "COMMENT" || made_.arguments.back().name == "TITLE" ||
                            made_.arguments.back().name == "MATERIAL");
      const std::string name = completed(upper(piece), *names_);
      if (!name.empty() && !(of_text && name != upper(piece))) {
        made_.arguments.push_back({name, {}, piece_line_});
        return;
      }
      if (made_.arguments.empty())
        file_.fail(piece_line_, made_.name() + " has no argument " + piece.substr(0, 40) + ".",
                   "known are " + known() + ".");
    }
    if (made_.arguments.empty())
      file_.fail(piece_line_, made_.name() + ": '" + piece.substr(0, 40) + "' belongs to no argument.",
                 "write NAME = value.");
    made_.arguments.back().values.push_back(piece);
  }

  std::string known() const {
    std::string all;
    for (const std::string& name : *names_) all += (all.empty() ? "" : ", ") + name;
    return all;
  }

  DataSet& file_;
  const std::vector<Line>& lines_;
  Statement made_;
  const Names* names_ = nullptr;
  std::string piece_;
  int piece_line_ = 0, depth_ = 0;
};

}  // namespace

void DataSet::fail(int line, const std::string& problem, const std::string& fix) const {
  throw FileError(problem, path + ":" + std::to_string(line), fix);
}

DataSet::DataSet(const std::filesystem::path& file) : path(file.string()) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  if (error || !std::filesystem::is_regular_file(file))
    throw FileError("there is no such file.", path, "give the path of a model file.");
  if (size > kLargest) throw FileError("the file is larger than 64 MiB.", path, "no model is: give another file.");
  std::ifstream in(file, std::ios::binary);
  std::string text;
  // 1. Lines without comments; a statement's lines follow each other.
  std::vector<Line> lines;
  std::vector<std::size_t> heads;
  int number = 0;
  bool titled = false, ended = false;
  while (!ended && std::getline(in, text)) {
    ++number;
    if (text.find('\0') != std::string::npos) fail(number, "the line holds a zero byte.", "give a text file.");
    if (!titled) {
      titled = true;
      title = trimmed(text);
      continue;
    }
    text.erase(std::min(text.find('!'), text.size()));
    std::string line = trimmed(text);
    if (line.empty()) continue;
    const bool continues = line[0] == ',' || (!lines.empty() && lines.back().text.back() == '&');
    if (!lines.empty() && lines.back().text.back() == '&') lines.back().text.back() = ' ';
    if (line[0] == ',') line[0] = ' ';
    if (!continues) {
      heads.push_back(lines.size());
      if (upper(line) == "END") ended = true;
    } else if (heads.empty()) {
      fail(number, "the line continues a statement, and there is none before it.",
           "begin with a title and a statement, such as UNITS/.");
    }
    lines.push_back({line, number});
  }
  if (!ended)
    fail(std::max(number, 1), "the data set ends without END: it is cut.",
         "give the whole file, its last statement END.");
  // 2. Statements.
  heads.push_back(lines.size());
  for (std::size_t h = 0; h + 1 < heads.size(); ++h)
    statements.push_back(StatementReader(*this, lines).read(heads[h], heads[h + 1]));
}

// ---- arguments ----

void Arguments::fail(const std::string& problem, const std::string& fix) const {
  file_.fail(statement_.line, statement_.name() + " " + problem, fix);
}

const Argument* Arguments::find(const std::string& name) const {
  for (const Argument& argument : statement_.arguments)
    if (argument.name == name) return &argument;
  return nullptr;
}

double Arguments::to_number(const std::string& written) const {
  std::string text = written;
  double factor = 1;
  if (!text.empty() && std::toupper(static_cast<unsigned char>(text.back())) == 'D') {
    factor = std::numbers::pi / 180;
    text.pop_back();
  }
  const char* begin = text.data() + (!text.empty() && text[0] == '+' ? 1 : 0);
  double value = 0;
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  std::string rest(end, static_cast<std::size_t>(text.data() + text.size() - end));
  if (error != std::errc() || !trimmed(rest).empty() || !std::isfinite(value))
    fail("has '" + written.substr(0, 40) + "' where a number should be.",
         "give a finite number, an angle in degrees as 90D.");
  return value * factor;
}

std::optional<int> Arguments::identifier_if(const std::string& name) const {
  if (!has(name)) return {};
  return identifiers(name, 1, 1)[0];
}

int Arguments::identifier(const std::string& name) const {
  if (const auto id = identifier_if(name)) return *id;
  fail("has no " + name + ".", "give " + name + " = the number of a marker or element.");
}

std::vector<int> Arguments::identifiers(const std::string& name, int least, int most) const {
  std::vector<int> all;
  for (const double x : numbers(name, least, most)) {
    if (x != std::floor(x) || x < 1 || x > 2147483647.0)
      fail("has " + name + " that is no identifier.", "give a whole number above zero.");
    all.push_back(static_cast<int>(x));
  }
  return all;
}

double Arguments::number(const std::string& name, std::optional<double> fallback) const {
  if (!has(name) && fallback) return *fallback;
  return numbers(name, 1, 1)[0];
}

std::vector<double> Arguments::numbers(const std::string& name, int least, int most) const {
  const Argument* argument = find(name);
  if (!argument) fail("has no " + name + ".", "give " + name + " = " + (least == 1 ? "number." : "numbers."));
  std::vector<double> all;
  all.reserve(argument->values.size());
  for (const std::string& value : argument->values) all.push_back(to_number(value));
  const int count = static_cast<int>(all.size());
  if (count < least || count > most)
    fail("has " + name + " with " + std::to_string(count) + (count == 1 ? " number." : " numbers."),
         "give " + std::to_string(least) + (most > least ? " to " + std::to_string(most) : "") + ".");
  return all;
}

Vector3 Arguments::vector(const std::string& name, const Vector3& fallback) const {
  if (!has(name)) return fallback;
  const std::vector<double> all = numbers(name, 3, 3);
  return {all[0], all[1], all[2]};
}

std::string Arguments::text(const std::string& name) const {
  const Argument* argument = find(name);
  if (!argument || argument->values.empty()) return "";
  std::string all = argument->values[0];
  for (std::size_t i = 1; i < argument->values.size(); ++i) all += "," + argument->values[i];
  return all;
}

}  // namespace lithe::adams
