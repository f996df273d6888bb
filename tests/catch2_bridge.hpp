#pragma once
// SPDX-License-Identifier: MIT
//
// Catch2 under one name: version 3 (Debian 13, Fedora, Homebrew) or version 2 (Debian 12, Ubuntu 22.04).
// A test includes this header and writes what both versions have: TEST_CASE, SECTION, GENERATE, REQUIRE_THAT with
// WithinAbs and WithinRel, Approx, TEMPLATE_TEST_CASE.

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_approx.hpp>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators_all.hpp>
#include <catch2/matchers/catch_matchers_all.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp> // says "using Catch::Detail::Approx" itself
#endif

using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
