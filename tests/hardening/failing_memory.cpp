#include "tests/hardening/failing_memory.h"

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <new>

#include "tests/support/sanitized.h"

namespace lithe::test::memory {
namespace {

// Of the initial executable: reading them allocates nothing.
thread_local bool armed = false, failed = false;
thread_local long left = 0;
thread_local Shortage kind = Shortage::once;
thread_local Layer counted_layer = Layer::any;
std::atomic<long> in_use{0};

bool short_of_memory(Layer layer) {
  if (!armed || layer != counted_layer || left-- > 0) return false;
  failed = true;
  if (kind == Shortage::once) armed = false;
  return true;
}

}  // namespace

void fail_at(long n, Shortage shortage, Layer layer) {
#ifdef LITHE_SANITIZED
  layer = Layer::cpp;
#endif
  left = n, kind = shortage, counted_layer = layer;
  failed = false, armed = true;
}

bool recover() {
  armed = false;
  return failed;
}

long blocks() { return in_use; }

}  // namespace lithe::test::memory

namespace memory = lithe::test::memory;

void* operator new(std::size_t size) {
  if (memory::short_of_memory(memory::Layer::cpp)) throw std::bad_alloc();
  void* block = std::malloc(size > 0 ? size : 1);
  if (!block) throw std::bad_alloc();
  return block;
}
void* operator new[](std::size_t size) { return operator new(size); }
/// std::stable_sort() asks by this one.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return memory::short_of_memory(memory::Layer::cpp) ? nullptr : std::malloc(size > 0 ? size : 1);
}
void operator delete(void* block) noexcept { std::free(block); }
void operator delete[](void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }
void operator delete[](void* block, std::size_t) noexcept { std::free(block); }

#ifndef LITHE_SANITIZED

extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

static void* counted(void* block) {
  if (block) ++memory::in_use;
  return block;
}
static void* refused() {
  errno = ENOMEM;
  return nullptr;
}

void* malloc(std::size_t size) {
  return memory::short_of_memory(memory::Layer::any) ? refused() : counted(__libc_malloc(size));
}
void* calloc(std::size_t count, std::size_t size) {
  return memory::short_of_memory(memory::Layer::any) ? refused() : counted(__libc_calloc(count, size));
}
void* realloc(void* block, std::size_t size) {
  if (memory::short_of_memory(memory::Layer::any)) return refused();
  if (!block) return counted(__libc_realloc(block, size));
  if (size == 0) --memory::in_use;
  return __libc_realloc(block, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  return memory::short_of_memory(memory::Layer::any) ? refused() : counted(__libc_memalign(alignment, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  void* found = memalign(alignment, size);
  if (!found) return ENOMEM;
  *block = found;
  return 0;
}
void free(void* block) {
  if (block) --memory::in_use;
  __libc_free(block);
}
}

#endif
