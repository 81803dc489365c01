#include "engine/model/element_error.h"

#include "engine/base/error.h"
#include "engine/base/number_text.h"

namespace lithe {

void rethrow_of(const Element& element, double time) {
  const std::string who = "'" + element.name() + "'", where = element.where() + ", " + time_text(time);
  try {
    rethrow_as_error(who, where, "see what its code does there; the state reached before is kept");
  } catch (const SimulationError& error) {
    if (error.where() == where) throw;  // just made
    const bool named = error.problem().find(who) != std::string::npos;
    throw SimulationError(named ? error.problem() : who + ": " + error.problem(), where, error.fix());
  } catch (const Error& error) {
    throw SimulationError(who + ": " + error.problem(), where, error.fix());
  }
}

}  // namespace lithe
