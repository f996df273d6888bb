// SPDX-License-Identifier: MIT
//
// <windows.h> makes min and max macros, which would change each std::max behind it.
// flags: -Wfatal-errors
// message: define NOMINMAX
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Core>

#define max(a, b) (((a) > (b)) ? (a) : (b))
#include <qdot/error.hpp>

int main() {}
