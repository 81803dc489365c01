#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "models/model_description.h"

namespace lithe {

/// What of a file does not act; the same twice is one note with its number.
class Notes {
 public:
  void add(int line, const std::string& what, const std::string& why) {
    const auto [at, added] = places_.try_emplace(what, notes_.size());
    if (added)
      notes_.push_back({.line = line, .what = what, .why = why});
    else
      ++notes_[at->second].count;
  }
  std::vector<ModelNote> take() { return std::move(notes_); }

 private:
  std::map<std::string, std::size_t> places_;
  std::vector<ModelNote> notes_;
};

}  // namespace lithe
