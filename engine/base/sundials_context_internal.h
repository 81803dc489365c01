#pragma once

#include <sundials/sundials_config.h>
#include <sundials/sundials_context.h>

namespace lithe {

/// What every object of SUNDIALS is made with, by 6 (Debian 12) and 7 (Debian 13); null if the memory is short.
inline SUNContext make_sundials_context() {
  SUNContext context = nullptr;
#if SUNDIALS_VERSION_MAJOR < 7
  SUNContext_Create(nullptr, &context);
#else
  SUNContext_Create(SUN_COMM_NULL, &context);
#endif
  return context;
}

}  // namespace lithe
