#pragma once

#include "tools/scenes/parts.h"

namespace lithe::test {

using scenes::about_z;
using scenes::axes_with_z;
using scenes::Part;
using scenes::rod;

}  // namespace lithe::test
