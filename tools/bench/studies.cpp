#include "tools/bench/studies.h"

#include "lithe/lithe.h"

// Each study defines scene(): here in a namespace of its own. What they include stands above.
namespace lithe::bench::andrews_squeezer {
#include "examples/studies/andrews_squeezer.cpp"
}
namespace lithe::bench::flyball_governor {
#include "examples/studies/flyball_governor.cpp"
}
