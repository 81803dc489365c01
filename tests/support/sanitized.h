#pragma once

// LITHE_SANITIZED: the program has the memory of AddressSanitizer or ThreadSanitizer. GCC and Clang say it differently.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LITHE_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define LITHE_SANITIZED 1
#endif
#endif
