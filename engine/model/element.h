#pragma once

#include <string>
#include <utility>

namespace lithe {

/// A named thing of a system graph. Made by SystemGraph::add alone; its address lasts as long as the graph.
class Element {
 public:
  Element() = default;
  Element(const Element&) = delete;
  Element& operator=(const Element&) = delete;
  virtual ~Element();  // in element.cpp, as its table of virtual functions is then: not in each source that adds one

  const std::string& name() const { return name_; }
  /// "file.cpp:12" of the add() call, for messages.
  const std::string& where() const { return where_; }

 private:
  friend class SystemGraph;
  std::string name_, where_;
};

}  // namespace lithe
