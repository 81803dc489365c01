#include "engine/base/dense.h"

namespace Eigen {

namespace internal {
LITHE_DENSE_PRODUCTS(template)
}
LITHE_DENSE_CLASSES(template)
LITHE_DENSE_FUNCTIONS(template)

}  // namespace Eigen
