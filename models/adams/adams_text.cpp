// A function of an Adams data set as text once more.
#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "models/adams/adams_words_internal.h"

namespace lithe {
namespace {

using Operation = AdamsFunction::Operation;
enum class Binding { sum, product, power, whole };

template <class Words, class Is>
std::string word_of(const Words& words, Is&& is) {
  for (const auto& [word, meaning] : words)
    if (is(meaning)) return word;
  return "";
}

class TextOfFunction {
 public:
  explicit TextOfFunction(const AdamsFunction& f) : f_(f) {}

  /// In brackets where it binds less than `least`.
  std::string of(int node, Binding least) const {
    const auto [text, binding] = bare(f_.nodes[static_cast<std::size_t>(node)]);
    return binding < least ? "(" + text + ")" : text;
  }

 private:
  std::pair<std::string, Binding> bare(const AdamsFunction::Node& node) const {
    const auto argument = [&](int i) { return f_.arguments[static_cast<std::size_t>(node.first + i)]; };
    const auto operation = [&](int i) { return f_.nodes[static_cast<std::size_t>(argument(i))].operation; };
    std::string text;
    switch (node.operation) {
      case Operation::number:
        return {number_text(node.number), node.number < 0 ? Binding::sum : Binding::whole};
      case Operation::time:
        return {"TIME", Binding::whole};
      case Operation::measure:
        return {measure(f_.measures[static_cast<std::size_t>(node.index)]), Binding::whole};
      case Operation::add:
        for (int i = 0; i < node.count; ++i) {
          const bool minus = operation(i) == Operation::negate;
          text += i == 0 || minus ? "" : "+";
          text +=
              minus ? bare(f_.nodes[static_cast<std::size_t>(argument(i))]).first : of(argument(i), Binding::product);
        }
        return {text, Binding::sum};
      case Operation::negate:
        return {"-" + of(argument(0), Binding::product), Binding::sum};
      case Operation::multiply:
        for (int i = 0; i < node.count; ++i)
          text += (i == 0 ? "" : "*") +
                  of(argument(i), i == 0 && operation(0) == Operation::divide ? Binding::product : Binding::power);
        return {text, Binding::product};
      case Operation::divide:
        return {of(argument(0), Binding::product) + "/" + of(argument(1), Binding::power), Binding::product};
      case Operation::power:
        return {of(argument(0), Binding::whole) + "**" + of(argument(1), Binding::whole), Binding::power};
      case Operation::branch:
        return {"IF(" + of(argument(0), Binding::sum) + ": " + of(argument(1), Binding::sum) + ", " +
                    of(argument(2), Binding::sum) + ", " + of(argument(3), Binding::sum) + ")",
                Binding::whole};
      case Operation::curve:
        throw SceneError("a function reads a SPLINE, which has no text of its own", "adams_text()",
                         "keep the data set");
      default:
        break;
    }
    for (int i = 0; i < node.count; ++i) text += (i == 0 ? "" : ", ") + of(argument(i), Binding::sum);
    return {word_of(adams::function_words(), [&](const auto& known) { return known.operation == node.operation; }) +
                "(" + text + ")",
            Binding::whole};
  }

  static std::string measure(AdamsMeasure m) {
    using enum AdamsMeasure::Kind;
    if (m.of_load())
      throw SceneError("a function reads a load, which has no text of its own", "adams_text()", "keep the data set");
    std::string text =
        m.kind >= E0 && m.kind <= E3
            ? "ORIENT(27, " + std::to_string(static_cast<int>(m.kind) - static_cast<int>(E0) + 1) + ", "
            : word_of(adams::measure_words(), [&](AdamsMeasure::Kind kind) { return kind == m.kind; }) + "(";
    bool first = true;
    for (const int* id : adams::markers_of(m)) text += (first ? "" : ", ") + std::to_string(*id), first = false;
    return text + ")";
  }

  const AdamsFunction& f_;
};

}  // namespace

std::string adams_text(const AdamsFunction& function) {
  return TextOfFunction(function).of(function.root, Binding::sum);
}

}  // namespace lithe
