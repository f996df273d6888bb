#pragma once
// SPDX-License-Identifier: MIT
//
// Memory for machine code.
//
// Code is written into private pages that are writable, and then the pages become executable and are no longer writable. They are never both
// at a time, so an error elsewhere in the program cannot write code. A system may refuse: SELinux, systemd's MemoryDenyWriteExecute and
// others do so by an error of mmap or mprotect. Then there is no code, and error() says why.
//
// Linux on x86-64 and AArch64 only. macOS ends a hardened process that tries, and Windows wants tables for its exceptions.

#if defined(__linux__) && (defined(__x86_64__) || defined(__aarch64__))
#include <sys/mman.h>
#include <unistd.h>
#endif

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace qdot::formula {

/// Pages that hold machine code, which may be called as long as this object lives.
class ExecutablePages {
 public:
  /// Copies code into pages of its own; none where the system refuses them.
  [[gnu::cold]] explicit ExecutablePages(std::span<const std::uint8_t> code) {
#if defined(__linux__) && (defined(__x86_64__) || defined(__aarch64__))
    const long page = ::sysconf(_SC_PAGESIZE);
    if (code.empty() || page <= 0) return;
    const auto unit = static_cast<std::size_t>(page);
    size_ = (before_entry + code.size() + unit - 1) / unit * unit;
    void* const pages = ::mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED) {
      error_ = errno;
      return;
    }
    auto* const entry = static_cast<std::uint8_t*>(pages) + before_entry;
    std::memcpy(entry, code.data(), code.size());
    __builtin___clear_cache(reinterpret_cast<char*>(entry), reinterpret_cast<char*>(entry) + code.size());  // of instructions, where data has one of its own
    if (::mprotect(pages, size_, PROT_READ | PROT_EXEC) != 0) {
      error_ = errno;
      ::munmap(pages, size_);
      return;
    }
    pages_ = static_cast<std::uint8_t*>(pages);
#else
    (void)code;
    error_ = ENOTSUP;
#endif
  }
  ~ExecutablePages() {
#if defined(__linux__) && (defined(__x86_64__) || defined(__aarch64__))
    if (pages_) ::munmap(pages_, size_);
#endif
  }
  ExecutablePages(const ExecutablePages&) = delete;
  ExecutablePages& operator=(const ExecutablePages&) = delete;

  /// The first instruction; null where there are no pages.
  void* entry() const noexcept { return pages_ ? pages_ + before_entry : nullptr; }
  /// errno of the system's refusal; 0 where it did not refuse.
  int error() const noexcept { return error_; }

 private:
  static constexpr std::size_t before_entry = 16;  // bytes, which some sanitizers read when a function is called

  std::uint8_t* pages_ = nullptr;
  std::size_t size_ = 0;
  int error_ = 0;
};

}  // namespace qdot::formula
