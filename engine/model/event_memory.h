#pragma once

namespace lithe {

/// An element whose equations depend on events that a run has had, besides time and state.
class EventMemory {
 public:
  virtual ~EventMemory() = default;
  /// Its equations are those before any event, as drawn; or those of the run again.
  virtual void set_as_drawn(bool drawn) const = 0;
};

}  // namespace lithe
