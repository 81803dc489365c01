#pragma once

/// The test binary's own allocator: one that fails when told to, and counts. Under GNU's C library it takes the place
/// of malloc itself, so that Eigen and the C libraries run short too; under sanitizers, which need malloc, only of
/// operator new, and they look for leaks.
namespace lithe::test::memory {

enum class Shortage { once, lasting };
enum class Layer { any, cpp };  // every allocation, or those by operator new alone

/// Allocation number n (from 0) of this thread fails from now on: it alone, or all from it on.
void fail_at(long n, Shortage shortage, Layer layer = Layer::any);
/// No more failures; whether there was one.
bool recover();
/// Blocks that are in use; 0 always where the sanitizers count.
long blocks();

}  // namespace lithe::test::memory
