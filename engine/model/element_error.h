#pragma once

#include <cstddef>

#include "engine/model/element.h"

namespace lithe {

/// Within a handler: rethrows an exception of an element's own code as an Error that names the element, its line in the
/// scene and the time.
[[noreturn]] void rethrow_of(const Element& element, double time);

/// job(i) for each of a batch's elements; an exception is reported with the element's name.
template <class Elements, class Job>
inline void for_each_named(const Elements& elements, double time, Job&& job) {
  std::size_t i = 0;
  try {
    for (const std::size_t count = elements.size(); i < count; ++i) job(i);
  } catch (...) {
    rethrow_of(*elements[i], time);
  }
}

}  // namespace lithe
