#include <algorithm>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "models/compiled/tape_internal.h"

namespace lithe {

CompiledNumber CompiledTape::variable(const std::string& name) {
  entries_.push_back({.kind = Kind::variable, .name = name});
  return {this, static_cast<int>(entries_.size()) - 1};
}

int CompiledTape::index(const CompiledNumber& x) {
  if (!x.known()) return x.entry_;
  const auto [found, fresh] = constants_.try_emplace(x.value_, static_cast<int>(entries_.size()));
  if (fresh) entries_.push_back({.kind = Kind::constant, .value = x.value_});
  return found->second;
}

CompiledNumber CompiledTape::enter(Kind kind, int a, int b) {
  if ((kind == Kind::add || kind == Kind::multiply) && a > b) std::swap(a, b);
  const auto [found, fresh] = known_.try_emplace({kind, a, b}, static_cast<int>(entries_.size()));
  if (fresh) entries_.push_back({.kind = kind, .a = a, .b = b});
  return {this, found->second};
}

CompiledNumber operator-(const CompiledNumber& a) {
  if (a.known()) return -a.value_;
  using Kind = CompiledTape::Kind;
  if (a.tape_->is(a, Kind::negate)) return a.tape_->inner(a);
  const auto entry = a.tape_->entries_[a.entry_];
  if (entry.kind == Kind::subtract) return a.tape_->enter(Kind::subtract, entry.b, entry.a);
  return a.tape_->enter(Kind::negate, a.entry_);
}

CompiledNumber operator+(const CompiledNumber& a, const CompiledNumber& b) {
  if (a.known() && b.known()) return a.value_ + b.value_;
  if (a.known() && a.value_ == 0) return b;
  if (b.known() && b.value_ == 0) return a;
  CompiledTape* tape = CompiledTape::of(a, b);
  using Kind = CompiledTape::Kind;
  if (tape->is(b, Kind::negate)) return a - tape->inner(b);
  if (tape->is(a, Kind::negate)) return b - tape->inner(a);
  return tape->enter(Kind::add, tape->index(a), tape->index(b));
}

CompiledNumber operator-(const CompiledNumber& a, const CompiledNumber& b) {
  if (a.known() && b.known()) return a.value_ - b.value_;
  if (b.known() && b.value_ == 0) return a;
  if (a.known() && a.value_ == 0) return -b;
  CompiledTape* tape = CompiledTape::of(a, b);
  using Kind = CompiledTape::Kind;
  if (tape->is(b, Kind::negate)) return a + tape->inner(b);
  if (tape->is(a, Kind::negate)) return -(tape->inner(a) + b);
  if (!a.known() && !b.known() && a.entry_ == b.entry_) return 0;
  return tape->enter(Kind::subtract, tape->index(a), tape->index(b));
}

CompiledNumber operator*(const CompiledNumber& a, const CompiledNumber& b) {
  if (a.known() && b.known()) return a.value_ * b.value_;
  if (b.known()) return b * a;
  CompiledTape* tape = b.tape_;
  using Kind = CompiledTape::Kind;
  if (a.known()) {
    if (a.value_ == 0) return 0;
    if (a.value_ == 1) return b;
    if (a.value_ < 0) return -(-a * b);
  } else if (tape->is(a, Kind::negate)) {
    return -(tape->inner(a) * b);
  }
  if (tape->is(b, Kind::negate)) return -(a * tape->inner(b));
  return tape->enter(Kind::multiply, tape->index(a), tape->index(b));
}

CompiledNumber operator/(const CompiledNumber& a, const CompiledNumber& b) {
  if (b.known() && b.value_ == 0)
    throw SceneError("a link has no inertia that its joint moves", "lithe compile",
                     "give its bodies inertia about the axis");
  if (b.known()) return a * (1 / b.value_);
  return b.tape_->enter(CompiledTape::Kind::divide, b.tape_->index(a), b.entry_);
}

void sine_cosine(const CompiledNumber& x, CompiledNumber& sine, CompiledNumber& cosine) {
  using Kind = CompiledTape::Kind;
  if (x.tape_->is(x, Kind::negate)) {
    sine_cosine(x.tape_->inner(x), sine, cosine);
    sine = -sine;
    return;
  }
  sine = x.tape_->enter(Kind::sine, x.entry_);
  cosine = x.tape_->enter(Kind::cosine, x.entry_);
}

CompiledTape::Text CompiledTape::write(const std::vector<Output>& outputs, const std::string& indent) const {
  const int n = static_cast<int>(entries_.size());
  // 1. How often each is used; a sine and its cosine are made together.
  std::vector<int> uses(n, 0);
  for (const Output& output : outputs)
    if (!output.value.known()) ++uses[output.value.entry_];
  for (int i = n; i-- > 0;) {
    const Entry& e = entries_[i];
    if (uses[i] == 0) continue;
    for (const int operand : {e.a, e.b})
      if (operand >= 0) ++uses[operand];
  }
  // 2. A product that one sum alone needs becomes part of it.
  const auto joins = [&](int i) { return entries_[i].kind == Kind::multiply && uses[i] == 1; };
  std::vector<char> joined(n, 0);
  for (int i = 0; i < n; ++i) {
    const Entry& e = entries_[i];
    if (uses[i] == 0 || (e.kind != Kind::add && e.kind != Kind::subtract)) continue;
    if (joins(e.a))
      joined[e.a] = 1;
    else if (joins(e.b))
      joined[e.b] = 1;
  }
  // 3. Statements in the order of the calculation.
  Text text;
  std::vector<char> sines_written(n, 0);
  std::vector<std::string> names(n);
  const auto statement = [&](int i, const std::string& right) {
    names[i] = "t" + std::to_string(i);
    text.code += indent + "const S " + names[i] + " = " + right + ";\n";
  };
  for (int i = 0; i < n; ++i) {
    const Entry& e = entries_[i];
    if (uses[i] == 0 || joined[i]) continue;
    const auto operand = [&](int k) { return names[k]; };
    const auto product = [&](int k) { return names[entries_[k].a] + ", " + names[entries_[k].b]; };
    switch (e.kind) {
      case Kind::constant:
        names[i] = "S(" + number_text(e.value) + ")";
        break;
      case Kind::variable:
        names[i] = e.name;
        break;
      case Kind::negate:
        names[i] = "(-" + names[e.a] + ")";
        break;
      case Kind::add:
      case Kind::subtract: {
        const bool adds = e.kind == Kind::add;
        ++text.sums;
        if (joined[e.a])
          statement(i, (adds ? "product_plus(" : "product_minus(") + product(e.a) + ", " + operand(e.b) + ")");
        else if (joined[e.b])
          statement(i, (adds ? "product_plus(" : "minus_product(") + product(e.b) + ", " + operand(e.a) + ")");
        else
          statement(i, operand(e.a) + (adds ? " + " : " - ") + operand(e.b));
        text.products += joined[e.a] || joined[e.b];
        break;
      }
      case Kind::multiply:
        ++text.products;
        statement(i, operand(e.a) + " * " + operand(e.b));
        break;
      case Kind::divide:
        ++text.divisions;
        statement(i, operand(e.a) + " / " + operand(e.b));
        break;
      case Kind::sine:
      case Kind::cosine: {
        names[i] = (e.kind == Kind::sine ? "s" : "c") + std::to_string(e.a);
        if (sines_written[e.a]) break;
        sines_written[e.a] = 1;
        ++text.sines;
        const std::string s = "s" + std::to_string(e.a), c = "c" + std::to_string(e.a);
        text.code +=
            indent + "S " + s + ", " + c + ";\n" + indent + "sine_cosine(" + names[e.a] + ", " + s + ", " + c + ");\n";
        break;
      }
    }
  }
  for (const Output& output : outputs)
    text.code += indent + output.to + " = " +
                 (output.value.known() ? "S(" + number_text(output.value.value_) + ")" : names[output.value.entry_]) +
                 ";\n";
  return text;
}

}  // namespace lithe
