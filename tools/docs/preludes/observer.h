#pragma once

#include "engine/archive/archive.h"
#include "engine/observe/observer.h"

/// What the pages show of an observer is part of a class derived from this.
namespace lithe::observer {

struct Scene : Observer {
  double peak_ = 0;
  void observe(Snapshot&) override {}
  void run() {}
};

}  // namespace lithe::observer
