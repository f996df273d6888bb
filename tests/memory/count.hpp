#pragma once
// SPDX-License-Identifier: MIT
//
// Counts the allocations of the whole program, SUNDIALS' included, and those that are still alive.
//
// A sanitizer has a malloc of its own, and tells who asks; elsewhere on Linux the C library's is put behind a counter. Where neither
// can be done QDOT_TEST_COUNTS_ALLOCATIONS is not defined.

#include <atomic>
#include <cstddef>

namespace memory {
inline std::atomic<long> allocations{0};
inline std::atomic<long> alive{0};
}  // namespace memory

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define QDOT_TEST_SANITIZER_HOOKS
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define QDOT_TEST_SANITIZER_HOOKS
#endif
#endif

#if defined(QDOT_TEST_SANITIZER_HOOKS)
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*)(const volatile void*, std::size_t), void (*)(const volatile void*));
namespace memory {
inline const int installed = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { ++allocations, ++alive; },
    [](const volatile void* freed) {
      if (freed != nullptr) --alive;
    });
}
#define QDOT_TEST_COUNTS_ALLOCATIONS
#elif defined(__GLIBC__)
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void __libc_free(void*);

[[gnu::used]] inline void* malloc(std::size_t size) noexcept {
  ++memory::allocations, ++memory::alive;
  return __libc_malloc(size);
}
[[gnu::used]] inline void* calloc(std::size_t count, std::size_t size) noexcept {
  ++memory::allocations, ++memory::alive;
  return __libc_calloc(count, size);
}
[[gnu::used]] inline void* realloc(void* old, std::size_t size) noexcept {
  ++memory::allocations;
  if (old == nullptr) ++memory::alive;
  if (old != nullptr && size == 0) --memory::alive;  // glibc frees it
  return __libc_realloc(old, size);
}
[[gnu::used]] inline void free(void* old) noexcept {
  if (old != nullptr) --memory::alive;
  __libc_free(old);
}
}
#define QDOT_TEST_COUNTS_ALLOCATIONS
#endif
