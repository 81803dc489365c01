// Will not serve.
#include "engine/plugin_abi.h"
extern "C" int32_t lithe_plugin_v1(const lithe_host*) { return -3; }
