#pragma once
// SPDX-License-Identifier: MIT
//
// What a function returns while compiling, or nothing where a compiler cannot run it to its end.
//
// Compilers stop after a number of operations, and some take no function of <cmath> for constants. To ask whether a value is there and then for the value
// is to have it made twice by clang, which remembers no constant. Here it is the default argument of a template: there is such a template or not, and the
// value is read from there.

namespace qdot::formula {

template <auto make, auto value = make()>
consteval auto constant_where_possible(int) {
  return value;
}
template <auto make>
consteval auto constant_where_possible(long) {
  return decltype(make()){};
}

/// What `make`, a function without arguments, returns as a constant; a default object of that type where it cannot.
template <auto make>
inline constexpr auto made_where_possible = constant_where_possible<make>(0);

}  // namespace qdot::formula
