// Only its precompiled header is used.
#include "engine/plugin.h"
