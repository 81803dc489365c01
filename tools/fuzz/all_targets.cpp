#include "tools/fuzz/targets.h"

namespace lithe::fuzz {

std::vector<Target> all_targets() {
  std::vector<Target> all;
  for (const auto& some :
       {body_targets(), table_targets(), model_targets(), checkpoint_targets(), run_targets(), plugin_targets()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace lithe::fuzz
