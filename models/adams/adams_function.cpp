#include "models/adams/adams_function.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <set>

#include "models/adams/adams_words_internal.h"

namespace lithe {
namespace {

using Operation = AdamsFunction::Operation;
using Kind = AdamsMeasure::Kind;

constexpr int kDeepest = 100, kTallest = 250, kLongest = 20000;

const std::map<std::string, int>& loads() {
  static const std::map<std::string, int> all = {{"FM", 1}, {"FX", 2}, {"FY", 3}, {"FZ", 4},
                                                 {"TM", 5}, {"TX", 6}, {"TY", 7}, {"TZ", 8}};
  return all;
}

/// Functions of the load of one element: statement and function have the same name, but for two.
const std::map<std::string, std::string>& load_elements() {
  static const std::map<std::string, std::string> all = {
      {"JOINT", "JOINT"},   {"JPRIM", "JPRIM"},   {"MOTION", "MOTION"},     {"SFORCE", "SFORCE"},
      {"VFORCE", "VFORCE"}, {"VTORQ", "VTORQUE"}, {"GFORCE", "GFORCE"},     {"BUSH", "BUSHING"},
      {"BEAM", "BEAM"},     {"FIELD", "FIELD"},   {"SPDP", "SPRINGDAMPER"}, {"GCON", "GCON"}};
  return all;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

class Reader {
 public:
  Reader(const AdamsNames& names, int line) : names_(names) { made_.line = line; }

  AdamsFunction read(const std::string& text) {
    made_.root = whole(text, 0);
    return std::move(made_);
  }

 private:
  struct Text {
    const std::string& all;
    std::size_t at = 0;
  };

  [[noreturn]] void fail(const std::string& problem, const std::string& fix) const {
    names_.fail("the function '" + shown() + "': " + problem, fix);
    std::abort();  // fail() throws
  }
  std::string shown() const {
    std::string text = text_ ? text_->all : "";
    for (char& c : text)
      if (std::isspace(static_cast<unsigned char>(c))) c = ' ';
    return text.size() > 60 ? text.substr(0, 60) + "..." : text;
  }

  int whole(const std::string& all, int depth) {
    Text text{all};
    Text* before = text_;
    text_ = &text;
    const int node = sum(depth);
    skip();
    if (text.at != all.size())
      fail(std::string("'") + all[text.at] + "' does not belong here.", "write one expression.");
    text_ = before;
    return node;
  }

  void skip() {
    while (text_->at < text_->all.size() && std::isspace(static_cast<unsigned char>(text_->all[text_->at])))
      ++text_->at;
  }
  char next() {
    skip();
    return text_->at < text_->all.size() ? text_->all[text_->at] : '\0';
  }
  bool power_follows() {
    skip();
    return text_->all.compare(text_->at, 2, "**") == 0;
  }
  void expect(char c) {
    if (next() != c)
      fail(text_->at < text_->all.size() ? std::string("'") + next() + "' stands where '" + c + "' should."
                                         : std::string("it ends where '") + c + "' should be.",
           "close the brackets and separate arguments by commas.");
    ++text_->at;
  }

  int add(AdamsFunction::Node node, const std::vector<int>& arguments = {}) {
    if (static_cast<int>(made_.nodes.size()) >= kLongest)
      fail("it has more than " + std::to_string(kLongest) + " terms, those of its VARIABLEs included.", "shorten it.");
    node.first = static_cast<int>(made_.arguments.size());
    node.count = static_cast<int>(arguments.size());
    made_.arguments.insert(made_.arguments.end(), arguments.begin(), arguments.end());
    int depth = 1;  // of the tree: evaluation descends it
    for (const int argument : arguments) depth = std::max(depth, 1 + depths_[static_cast<std::size_t>(argument)]);
    if (depth > kTallest) fail("its tree is deeper than " + std::to_string(kTallest) + " levels.", "simplify it.");
    depths_.push_back(depth);
    made_.nodes.push_back(node);
    return static_cast<int>(made_.nodes.size()) - 1;
  }
  int make(Operation operation, const std::vector<int>& arguments) { return add({.operation = operation}, arguments); }
  int number(double value) { return add({.operation = Operation::number, .number = value}); }

  // sum: [+-] product {[+-] product};  product: power {[*/] power};  power: factor [** signed power]
  int sum(int depth) {
    if (depth > kDeepest) fail("it is nested deeper than " + std::to_string(kDeepest) + " levels.", "simplify it.");
    std::vector<int> terms = {signed_product(depth)};
    for (;;) {
      const char c = next();
      if (c != '+' && c != '-') return terms.size() == 1 ? terms[0] : make(Operation::add, terms);
      ++text_->at;
      const int right = signed_product(depth + 1);
      terms.push_back(c == '+' ? right : make(Operation::negate, {right}));
    }
  }
  /// Fortran: -a**2 is -(a**2), -a*b is -(a*b).
  int signed_product(int depth) {
    if (depth > kDeepest) fail("it is nested deeper than " + std::to_string(kDeepest) + " levels.", "simplify it.");
    const char c = next();
    if (c == '+' || c == '-') {
      ++text_->at;
      const int of = signed_product(depth + 1);
      return c == '-' ? make(Operation::negate, {of}) : of;
    }
    return product(depth);
  }
  int product(int depth) {
    std::vector<int> factors = {power(depth)};
    const auto joined = [&] { return factors.size() == 1 ? factors[0] : make(Operation::multiply, factors); };
    for (;;) {
      const char c = next();
      if ((c != '*' && c != '/') || power_follows()) return joined();
      ++text_->at;
      const char sign = next();
      const int right = sign == '-' || sign == '+' ? signed_factor(depth + 1) : power(depth + 1);
      if (c == '*')
        factors.push_back(right);
      else
        factors = {make(Operation::divide, {joined(), right})};
    }
  }
  int signed_factor(int depth) {
    if (depth > kDeepest) fail("it is nested deeper than " + std::to_string(kDeepest) + " levels.", "simplify it.");
    const char c = next();
    if (c != '+' && c != '-') return power(depth);
    ++text_->at;
    const int of = signed_factor(depth + 1);
    return c == '-' ? make(Operation::negate, {of}) : of;
  }
  int power(int depth) {
    const int base = factor(depth);
    if (!power_follows()) return base;
    text_->at += 2;
    return make(Operation::power, {base, signed_factor(depth + 1)});
  }
  int factor(int depth) {
    const char c = next();
    if (c == '(') {
      ++text_->at;
      const int inner = sum(depth + 1);
      expect(')');
      return inner;
    }
    if (std::isdigit(static_cast<unsigned char>(c)) || c == '.') return number(literal());
    if (std::isalpha(static_cast<unsigned char>(c))) return named(depth);
    fail(c == '\0' ? "it ends where a number or a name should be."
                   : std::string("'") + c + "' stands where a number or a name should.",
         "complete the expression.");
  }

  double literal() {
    const std::string& all = text_->all;
    double value = 0;
    const auto [end, error] = std::from_chars(all.data() + text_->at, all.data() + all.size(), value);
    if (error != std::errc() || !std::isfinite(value))
      fail("a number in it cannot be read.", "write numbers as 1.5E-3.");
    text_->at = static_cast<std::size_t>(end - all.data());
    if (text_->at < all.size() && std::toupper(static_cast<unsigned char>(all[text_->at])) == 'D') {
      value *= std::numbers::pi / 180;
      ++text_->at;
    }
    if (text_->at < all.size() && std::isalnum(static_cast<unsigned char>(all[text_->at])))
      fail("a number in it is followed by a letter or digit.", "write degrees as 90D, powers of ten as 1E3.");
    return value;
  }

  std::string name() {
    const std::size_t from = text_->at;
    const std::string& all = text_->all;
    while (text_->at < all.size() &&
           (std::isalnum(static_cast<unsigned char>(all[text_->at])) || all[text_->at] == '_'))
      ++text_->at;
    return upper(all.substr(from, text_->at - from));
  }

  std::vector<int> arguments(const std::string& of, int least, int most, char separator, int depth) {
    std::vector<int> all;
    expect('(');
    for (;;) {
      all.push_back(sum(depth + 1));
      const char c = next();
      // IF(x: a, b, c)
      if (c == ',' || (separator == ':' && c == ':' && all.size() == 1)) {
        ++text_->at;
        continue;
      }
      expect(')');
      break;
    }
    const int count = static_cast<int>(all.size());
    if (count < least || count > most)
      fail(of + " has " + std::to_string(count) + (count == 1 ? " argument." : " arguments."),
           "give it " + std::to_string(least) + (most > least ? " to " + std::to_string(most) : "") + ".");
    return all;
  }

  /// Arguments that must be whole numbers: markers, identifiers.
  std::vector<int> identifiers(const std::string& of, int least, int most) {
    std::vector<int> all;
    expect('(');
    for (;;) {
      skip();
      const std::string& text = text_->all;
      int value = 0;
      const auto [end, error] = std::from_chars(text.data() + text_->at, text.data() + text.size(), value);
      if (error != std::errc() || value < 0)
        fail(of + " wants whole numbers: identifiers.", "give it the numbers of markers or elements.");
      text_->at = static_cast<std::size_t>(end - text.data());
      all.push_back(value);
      if (next() != ',') break;
      ++text_->at;
    }
    expect(')');
    const int count = static_cast<int>(all.size());
    if (count < least || count > most)
      fail(of + " has " + std::to_string(count) + (count == 1 ? " argument." : " arguments."),
           "give it " + std::to_string(least) + (most > least ? " to " + std::to_string(most) : "") + ".");
    return all;
  }

  int measure(AdamsMeasure what) {
    made_.measures.push_back(std::move(what));
    return add({.operation = Operation::measure, .index = static_cast<int>(made_.measures.size()) - 1});
  }

  int named(int depth) {
    const std::string word = name();
    if (word == "TIME") return make(Operation::time, {});
    if (word == "PI") return number(std::numbers::pi);
    if (word == "RTOD") return number(180 / std::numbers::pi);
    if (word == "DTOR") return number(std::numbers::pi / 180);
    if (word == "IF") return make(Operation::branch, arguments(word, 4, 4, ':', depth));
    if (const auto known = adams::function_words().find(word); known != adams::function_words().end())
      return make(known->second.operation, arguments(word, known->second.least, known->second.most, ',', depth));
    if (const auto known = adams::measure_words().find(word); known != adams::measure_words().end())
      return of_markers(word, known->second);
    if (const auto known = loads().find(word); known != loads().end()) {
      const auto id = identifiers(word, 1, 3);
      return measure({.kind = Kind::between,
                      .i = id[0],
                      .j = id.size() > 1 ? id[1] : 0,
                      .k = id.size() > 2 ? id[2] : 0,
                      .component = known->second});
    }
    if (const auto known = load_elements().find(word); known != load_elements().end()) {
      const auto id = identifiers(word, 4, 4);
      if (id[1] > 1 || id[2] < 1 || id[2] > 8)
        fail(word + " wants (id, 0 or 1, component 1 to 8, marker of the axes).", "correct its arguments.");
      return measure({.kind = Kind::of_element,
                      .k = id[3],
                      .component = id[2],
                      .element = known->second + "/" + std::to_string(id[0]),
                      .on_j = id[1] == 1});
    }
    if (word == "ORIENT") {
      const auto id = identifiers(word, 4, 4);
      if (id[0] != 27 || id[1] < 1 || id[1] > 4)
        fail("ORIENT is read for type 27 (Euler parameters), components 1 to 4, alone.",
             "write ORIENT(27, n, i, j), or PSI, THETA, PHI, YAW, PITCH, ROLL.");
      return measure({.kind = static_cast<Kind>(static_cast<int>(Kind::E0) + id[1] - 1), .i = id[2], .j = id[3]});
    }
    if (word == "AKISPL" || word == "CUBSPL") return spline(word, depth);
    if (word == "VARVAL") return variable(identifiers(word, 1, 1)[0], depth);
    fail("'" + word + "' is no function, measure or constant that is read.",
         "read are the operators + - * / **, IF, STEP, STEP5, HAVSIN, BISTOP, IMPACT, AKISPL, CUBSPL, POLY, SHF, "
         "FORSIN, "
         "FORCOS, CHEBY, the functions of Fortran, measures of displacement, velocity, acceleration and load, VARVAL, "
         "TIME, PI, RTOD, DTOR.");
  }

  int of_markers(const std::string& word, Kind kind) {
    AdamsMeasure made{.kind = kind};
    const std::vector<int*> wanted = adams::markers_of(made);
    const auto id = identifiers(word, 1, static_cast<int>(wanted.size()));
    for (std::size_t n = 0; n < id.size(); ++n) *wanted[n] = id[n];
    if (made.of_acceleration() && made.l != 0)
      fail(word + " seen from another frame than the global one is not read.", "leave its last argument out.");
    return measure(made);
  }

  int spline(const std::string& word, int depth) {
    std::vector<int> all = arguments(word, 3, 4, ',', depth);
    const auto constant = [&](std::size_t i) {
      const AdamsFunction::Node& node = made_.nodes[static_cast<std::size_t>(all[i])];
      if (node.operation != Operation::number || node.number != std::floor(node.number) || std::abs(node.number) > 2e9)
        fail("the second and later arguments of " + word + " must be whole numbers.",
             "give (x, 0, id), or (x, 0, id, order): surfaces are not read.");
      return static_cast<int>(node.number);
    };
    if (constant(1) != 0) fail(word + " of a surface (z not 0) is not read.", "give curves alone: (x, 0, id).");
    const int id = constant(2), order = all.size() > 3 ? constant(3) : 0;
    if (order < 0 || order > 2) fail("the order of a derivative of " + word + " is 0, 1 or 2.", "correct it.");
    made_.curves.push_back(names_.curve(id, word == "AKISPL" ? AdamsCurve::Kind::akima : AdamsCurve::Kind::cubic));
    AdamsFunction::Node node{.operation = Operation::curve};
    node.index = static_cast<int>(made_.curves.size()) - 1;
    node.order = order;
    return add(node, {all[0]});
  }

  int variable(int id, int depth) {
    if (open_.count(id))
      fail("VARIABLE/" + std::to_string(id) + " reads itself.",
           "implicit variables are not solved: write it explicitly.");
    if (open_.size() > 30) fail("VARIABLEs are nested deeper than 30 levels.", "simplify them.");
    open_.insert(id);
    const int node = whole(names_.variable(id), depth + 1);
    open_.erase(id);
    return node;
  }

  const AdamsNames& names_;
  AdamsFunction made_;
  Text* text_ = nullptr;
  std::set<int> open_;
  std::vector<int> depths_;  // of the nodes
};

/// The parabola through three points, or the line through two, at x.
AdamsCurve::Value beyond(const double* x, const double* y, bool line, bool left, double at) {
  // Newton's divided differences from the end inwards.
  const double x0 = x[left ? 0 : 2], x1 = x[1], x2 = x[left ? 2 : 0];
  const double y0 = y[left ? 0 : 2], y1 = y[1], y2 = y[left ? 2 : 0];
  const double first = (y1 - y0) / (x1 - x0);
  const double second = line ? 0 : ((y2 - y1) / (x2 - x1) - first) / (x2 - x0);
  return {y0 + (at - x0) * (first + second * (at - x1)), first + second * (2 * at - x0 - x1), 2 * second};
}

}  // namespace

AdamsFunction AdamsFunction::constant(double value) {
  AdamsFunction made;
  made.nodes.push_back({.number = value});
  return made;
}

AdamsFunction read_adams_function(const std::string& text, int line, const AdamsNames& names) {
  return Reader(names, line).read(text);
}

AdamsCurve::AdamsCurve(std::vector<double> x, std::vector<double> y, bool linear_ends, Kind kind)
    : x_(std::move(x)), y_(std::move(y)), slope_(x_.size()), linear_ends_(linear_ends) {
  const std::size_t n = x_.size();
  std::vector<double> h(n - 1), m(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) h[i] = x_[i + 1] - x_[i], m[i] = (y_[i + 1] - y_[i]) / h[i];
  if (kind == Kind::akima) {
    // Two slopes are added at each end, as Akima (J. ACM 17, 1970, 589) extrapolates them.
    std::vector<double> all = {3 * m[0] - 2 * m[1], 2 * m[0] - m[1]};
    all.insert(all.end(), m.begin(), m.end());
    all.push_back(2 * m[n - 2] - m[n - 3]);
    all.push_back(3 * m[n - 2] - 2 * m[n - 3]);
    for (std::size_t i = 0; i < n; ++i) {
      const double left = std::abs(all[i + 1] - all[i]), right = std::abs(all[i + 3] - all[i + 2]);
      const double sum = left + right;
      slope_[i] = sum > 0 ? (right * all[i + 1] + left * all[i + 2]) / sum : 0.5 * (all[i + 1] + all[i + 2]);
    }
    return;
  }
  // Not-a-knot, in slopes (de Boor, A Practical Guide to Splines, ch. IV): one tridiagonal system.
  std::vector<double> lower(n), diagonal(n), above(n), right(n);
  diagonal[0] = h[1], above[0] = h[0] + h[1];
  right[0] = ((h[0] + 2 * above[0]) * h[1] * m[0] + h[0] * h[0] * m[1]) / above[0];
  for (std::size_t i = 1; i + 1 < n; ++i) {
    lower[i] = h[i], diagonal[i] = 2 * (h[i - 1] + h[i]), above[i] = h[i - 1];
    right[i] = 3 * (h[i] * m[i - 1] + h[i - 1] * m[i]);
  }
  const double a = h[n - 2], b = h[n - 3];
  lower[n - 1] = a + b, diagonal[n - 1] = b;
  right[n - 1] = (a * a * m[n - 3] + (2 * (a + b) + a) * b * m[n - 2]) / (a + b);
  for (std::size_t i = 1; i < n; ++i) {
    const double factor = lower[i] / diagonal[i - 1];
    diagonal[i] -= factor * above[i - 1];
    right[i] -= factor * right[i - 1];
  }
  slope_[n - 1] = right[n - 1] / diagonal[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) slope_[i] = (right[i] - above[i] * slope_[i + 1]) / diagonal[i];
}

AdamsCurve::Value AdamsCurve::operator()(double x) const {
  const std::size_t n = x_.size();
  if (x < x_[0]) return beyond(x_.data(), y_.data(), linear_ends_, true, x);
  if (x > x_[n - 1]) return beyond(x_.data() + n - 3, y_.data() + n - 3, linear_ends_, false, x);
  const auto after = std::upper_bound(x_.begin() + 1, x_.end() - 1, x);
  const std::size_t i = static_cast<std::size_t>(after - x_.begin()) - 1;
  const double h = x_[i + 1] - x_[i], u = x - x_[i], m = (y_[i + 1] - y_[i]) / h;
  const double c = (3 * m - 2 * slope_[i] - slope_[i + 1]) / h, d = (slope_[i] + slope_[i + 1] - 2 * m) / (h * h);
  return {y_[i] + u * (slope_[i] + u * (c + u * d)), slope_[i] + u * (2 * c + 3 * u * d), 2 * c + 6 * u * d};
}

}  // namespace lithe
