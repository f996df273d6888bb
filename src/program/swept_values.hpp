#pragma once
// SPDX-License-Identifier: MIT
//
// Which values a sweep goes through: a grid of axes, the first running fastest, or a sample, where motion i draws from random numbers of its own.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace qdot::program {

enum class Distribution { none, uniform, normal };

struct SweptAxis {
  std::string name = {};
  std::vector<double> values = {};                 // of a grid
  Distribution distribution = Distribution::none;  // of a sample, with its two numbers
  double a = 0.0, b = 0.0;
  bool logarithmic = false;
  bool is_effect = false;
};

class SweptValues {
 public:
  SweptValues(std::vector<SweptAxis> axes, std::size_t random, std::uint64_t seed) : axes_(std::move(axes)), random_(random), seed_(seed) {}

  bool is_random() const { return random_ > 0; }
  std::size_t count() const;
  std::vector<double> of(std::size_t i) const;
  std::vector<SweptAxis>& axes() { return axes_; }
  const std::vector<SweptAxis>& axes() const { return axes_; }

 private:
  std::vector<SweptAxis> axes_;
  std::size_t random_;
  std::uint64_t seed_;
};

/// @throws UsageError
SweptValues swept_values(const std::vector<std::string>& over, const std::optional<std::string>& random, const std::optional<std::string>& seed);

}  // namespace qdot::program
