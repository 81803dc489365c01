// An outside program: it includes the one header and links the one target.
#include <cstdio>

#include "lithe/lithe.h"

int main() {
  const lithe::Vector3 a(1, 2, 3), b(4, 5, 6);
  if (!(lithe::skew(a) * b).isApprox(a.cross(b))) return 1;

  // A function that lies in the library, not in a header.
  const lithe::Error error("nothing is wrong", "main.cpp", "nothing");
  std::puts(error.what());
  return error.problem() == "nothing is wrong" ? 0 : 1;
}
