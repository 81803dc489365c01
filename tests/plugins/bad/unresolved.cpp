// Needs a symbol that nobody has.
#include "engine/plugin_abi.h"
extern "C" int nobody_has_this();
extern "C" int32_t lithe_plugin_v1(const lithe_host*) { return nobody_has_this(); }
