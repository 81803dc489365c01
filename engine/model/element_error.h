#pragma once

#include <cstddef>

#include "engine/model/element.h"

namespace lithe {

/// Within a handler: rethrows an exception of an element's own code as an Error that names the element, its line in the
/// scene and the time.
[[noreturn]] void rethrow_of(const Element& element, double time);

/// Elements of a batch, from `first` to before `last`.
struct BatchRange {
  int first = 0, last = 0;
  bool empty() const { return first == last; }
};

/// job(i) for some of a batch's elements; an exception is reported with the element's name.
template <class Elements, class Job>
inline void for_each_named(const Elements& elements, BatchRange range, double time, Job&& job) {
  auto i = static_cast<std::size_t>(range.first);
  try {
    for (const auto last = static_cast<std::size_t>(range.last); i < last; ++i) job(i);
  } catch (...) {
    rethrow_of(*elements[i], time);
  }
}

}  // namespace lithe
