// SPDX-License-Identifier: MIT
#include "program/swept_values.hpp"

#include <cmath>
#include <set>

#include "program/arguments.hpp"
#include "qdot/integrate/counter_random.hpp"

namespace qdot::program {

namespace {

std::vector<std::string> parts_of(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) parts.emplace_back();
    else parts.back() += c;
  }
  return parts;
}

/// What a number is of, for messages.
std::string option(const SweptAxis& axis) { return "--over " + axis.name; }

SweptAxis sampled_axis(const std::string& text, std::size_t tilde) {
  SweptAxis axis{.name = text.substr(0, tilde)};
  const std::string law = text.substr(tilde + 1);
  const std::size_t open = law.find('(');
  const std::string kind = law.substr(0, open);
  const std::vector<std::string> numbers = open == std::string::npos || law.back() != ')'
                                               ? std::vector<std::string>()
                                               : parts_of(law.substr(open + 1, law.size() - open - 2), ',');
  if ((kind != "uniform" && kind != "normal") || numbers.size() != 2)
    throw UsageError("--over: must be NAME~uniform(A,B) or NAME~normal(MEAN,SIGMA) with --random, given " + text);
  axis.distribution = kind == "uniform" ? Distribution::uniform : Distribution::normal;
  axis.a = finite_number(option(axis), numbers[0]);
  axis.b = finite_number(option(axis), numbers[1]);
  if (axis.distribution == Distribution::uniform ? !(axis.b > axis.a) : !(axis.b >= 0.0))
    throw UsageError("--over: must be uniform from a smaller to a greater number, or normal with a SIGMA that is not negative, given " + text);
  return axis;
}

SweptAxis grid_axis(const std::string& text, std::size_t equals) {
  SweptAxis axis{.name = text.substr(0, equals)};
  const std::string values = text.substr(equals + 1);
  if (values.find(':') == std::string::npos) {
    for (const std::string& value : parts_of(values, ',')) axis.values.push_back(finite_number(option(axis), value));
    return axis;
  }
  const std::vector<std::string> parts = parts_of(values, ':');
  if (parts.size() < 3 || parts.size() > 4 || (parts.size() == 4 && parts[3] != "log"))
    throw UsageError("--over: must be NAME=FROM:TO:COUNT, with :log behind it or not, or NAME=A,B,C, given " + text);
  const double from = finite_number(option(axis), parts[0]), to = finite_number(option(axis), parts[1]);
  const long count = whole_number(option(axis) + ": COUNT", parts[2], 1, 100'000'000);
  axis.logarithmic = parts.size() == 4;
  if (axis.logarithmic && !(from > 0.0 && to > 0.0)) throw UsageError("--over: must go between positive numbers with :log, given " + text);
  for (long i = 0; i < count; ++i) {
    const double share = count == 1 ? 0.0 : static_cast<double>(i) / static_cast<double>(count - 1);
    axis.values.push_back(i == 0 ? from : i + 1 == count ? to : axis.logarithmic ? from * std::pow(to / from, share) : from + share * (to - from));
  }
  return axis;
}

}  // namespace

std::size_t SweptValues::count() const {
  if (random_ > 0) return random_;
  double all = 1.0;
  std::size_t count = 1;
  for (const SweptAxis& axis : axes_) {
    count *= axis.values.size();
    all *= static_cast<double>(axis.values.size());
  }
  return all > 1e15 ? static_cast<std::size_t>(1e15) : count;
}

std::vector<double> SweptValues::of(std::size_t i) const {
  std::vector<double> values;
  CounterRandom random(seed_, i);
  for (const SweptAxis& axis : axes_) {
    if (random_ > 0) {
      values.push_back(axis.distribution == Distribution::uniform ? random.uniform(axis.a, axis.b) : axis.a + axis.b * random.normal());
    } else {
      values.push_back(axis.values[i % axis.values.size()]);
      i /= axis.values.size();
    }
  }
  return values;
}

SweptValues swept_values(const std::vector<std::string>& over, const std::optional<std::string>& random, const std::optional<std::string>& seed) {
  if (over.empty()) throw UsageError("--over: must be given at least once, NAME=FROM:TO:COUNT, or NAME~normal(MEAN,SIGMA) with --random");
  if (seed && !random) throw UsageError("--seed: must stand with --random, given without");
  std::vector<SweptAxis> axes;
  std::set<std::string> names;
  for (const std::string& text : over) {
    const std::size_t tilde = text.find('~'), equals = text.find('=');
    if (random ? tilde == std::string::npos || tilde == 0 : equals == std::string::npos || equals == 0)
      throw UsageError(random ? "--over: must be NAME~uniform(A,B) or NAME~normal(MEAN,SIGMA) with --random, given " + text
                              : "--over: must be NAME=FROM:TO:COUNT or NAME=A,B,C (a distribution goes with --random), given " + text);
    axes.push_back(random ? sampled_axis(text, tilde) : grid_axis(text, equals));
    if (!names.insert(axes.back().name).second) throw UsageError("--over: must name each quantity once, given " + axes.back().name + " twice");
  }
  const auto count = random ? static_cast<std::size_t>(whole_number("--random", *random, 1, 100'000'000)) : 0;
  return {std::move(axes), count, seed ? static_cast<std::uint64_t>(whole_number("--seed", *seed, 0, 2'147'483'647)) : 1u};
}

}  // namespace qdot::program
