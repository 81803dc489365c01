#include "engine/model/element.h"

#include "engine/model/body.h"
#include "engine/model/connector.h"

namespace lithe {

Element::~Element() = default;
Connector::~Connector() = default;
BodyCache::~BodyCache() = default;

}  // namespace lithe
