// SPDX-License-Identifier: MIT
//
// What libstdc++ leaves to the inliner, and has in no library: these tests are compiled without one.
#include <memory>

template class std::allocator<char>;
