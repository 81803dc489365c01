#include "engine/base/dense.h"

namespace Eigen {

LITHE_DENSE_EIGEN(template)

}  // namespace Eigen
