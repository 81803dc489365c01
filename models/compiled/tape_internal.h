#pragma once

#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace lithe {

class CompiledTape;

/// A number of a calculation that is written down instead of done: known, or an entry of a tape. Zeros, ones and signs
/// are dealt with here, so that equations written for any scalar lose by themselves what a scene does not need.
class CompiledNumber {
 public:
  CompiledNumber(double value = 0) : value_(value) {}  // NOLINT: implicit on purpose
  bool known() const { return tape_ == nullptr; }
  double value() const { return value_; }

  friend CompiledNumber operator+(const CompiledNumber& a, const CompiledNumber& b);
  friend CompiledNumber operator-(const CompiledNumber& a, const CompiledNumber& b);
  friend CompiledNumber operator*(const CompiledNumber& a, const CompiledNumber& b);
  friend CompiledNumber operator/(const CompiledNumber& a, const CompiledNumber& b);
  friend CompiledNumber operator-(const CompiledNumber& a);
  friend void sine_cosine(const CompiledNumber& x, CompiledNumber& sine, CompiledNumber& cosine);

 private:
  friend class CompiledTape;
  CompiledNumber(CompiledTape* tape, int entry) : tape_(tape), entry_(entry) {}
  CompiledTape* tape_ = nullptr;
  double value_ = 0;
  int entry_ = -1;
};

/// What a calculation over CompiledNumbers does, each term once, and its text as C++.
class CompiledTape {
 public:
  struct Output {
    std::string to;  // "a[3]"
    CompiledNumber value;
  };
  struct Text {
    std::string code;
    int products = 0, sums = 0, divisions = 0, sines = 0;  // a product that joins a sum counts as both
  };

  CompiledNumber variable(const std::string& name);
  /// Statements over a scalar S (runtime_internal.h), outputs last; what no output needs is left out.
  Text write(const std::vector<Output>& outputs, const std::string& indent) const;

 private:
  friend class CompiledNumber;
  friend CompiledNumber operator+(const CompiledNumber& a, const CompiledNumber& b);
  friend CompiledNumber operator-(const CompiledNumber& a, const CompiledNumber& b);
  friend CompiledNumber operator*(const CompiledNumber& a, const CompiledNumber& b);
  friend CompiledNumber operator/(const CompiledNumber& a, const CompiledNumber& b);
  friend CompiledNumber operator-(const CompiledNumber& a);
  friend void sine_cosine(const CompiledNumber& x, CompiledNumber& sine, CompiledNumber& cosine);

  enum class Kind { constant, variable, add, subtract, multiply, divide, negate, sine, cosine };
  struct Entry {
    Kind kind;
    int a = -1, b = -1;
    double value = 0;    // of a constant
    std::string name{};  // of a variable
  };
  static CompiledTape* of(const CompiledNumber& a, const CompiledNumber& b) { return a.tape_ ? a.tape_ : b.tape_; }
  bool is(const CompiledNumber& x, Kind kind) const { return !x.known() && entries_[x.entry_].kind == kind; }
  CompiledNumber inner(const CompiledNumber& negated) { return {this, entries_[negated.entry_].a}; }
  int index(const CompiledNumber& x);
  CompiledNumber enter(Kind kind, int a, int b = -1);

  std::vector<Entry> entries_;
  std::map<std::tuple<Kind, int, int>, int> known_;
  std::map<double, int> constants_;
};

}  // namespace lithe
