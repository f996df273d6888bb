#pragma once
// SPDX-License-Identifier: MIT
//
// Recipes for splitting: sequences of kicks and drifts.
//
// With T(q̇) and V(q) apart, each half of the motion is solved exactly:
//
//     drift   q ← q + a h q̇         (V switched off)
//     kick    q̇ ← q̇ − b h M⁻¹ ∂V/∂q (T switched off)
//
// Each is the exact flow of a Hamiltonian, so any sequence of them is symplectic. What remains is to choose a₁, b₁, a₂, … such that the
// sequence agrees with the true motion up to hᵖ. More than two orders need some backward steps; Sheng and Suzuki proved that there is no
// way round. A palindrome (same forth and back) is time-reversible: its error has even powers of h only.
//
// References: H. Yoshida, Phys. Lett. A 150 (1990) 262; R. McLachlan, P. Atela, Nonlinearity 5 (1992) 541;
// W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089; S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313.

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace qdot {

/// Which sequence of kicks and drifts makes a step.
enum class SplittingScheme {
  verlet,             ///< order 2, one kick
  yoshida_4,          ///< order 4, 3 kicks: three Verlet steps of lengths γ₁, 1 − 2γ₁, γ₁
  mclachlan_atela_4,  ///< order 4, the least error of all with 4 kicks
  blanes_moan_4,      ///< order 4, 6 kicks, for T quadratic in q̇: ten to a hundred times better again at equal work (Kepler, e = 0.6)
  kahan_li_6,         ///< order 6, nine Verlet steps
  blanes_moan_6,      ///< order 6, 11 kicks, for T quadratic in q̇
  kahan_li_8          ///< order 8, seventeen Verlet steps
};

namespace detail {

// kick[0], drift[0], kick[1], drift[1], …; a zero is left out.
struct Splitting {
  std::string_view name;
  int order;
  std::span<const double> kicks;
  std::span<const double> drifts;
};

// Palindromes of Verlet steps of lengths γ: half a kick, drift, kicks joined where steps meet.
template <std::size_t half>
struct VerletSteps {
  static constexpr std::size_t steps = 2 * half + 1;
  std::array<double, steps + 1> kicks{};
  std::array<double, steps + 1> drifts{};
  constexpr explicit VerletSteps(const std::array<double, half>& outer) {
    double sum = 0.0;
    for (const double gamma : outer) sum += gamma;
    for (std::size_t i = 0; i < half; ++i) drifts[i] = drifts[steps - 1 - i] = outer[i];
    drifts[half] = 1 - 2 * sum;
    for (std::size_t i = 0; i < steps; ++i) {
      kicks[i] += drifts[i] / 2;
      kicks[i + 1] += drifts[i] / 2;
    }
  }
};

inline constexpr VerletSteps<0> verlet_steps{{}};
inline constexpr VerletSteps<1> yoshida_4_steps{{1.3512071919596576340476878}};  // 1/(2 − ∛2)
inline constexpr VerletSteps<4> kahan_li_6_steps{
    {0.39216144400731413927925056, 0.33259913678935943859974864, -0.70624617255763935980996482,
     0.08221359629355080023149045}};
inline constexpr VerletSteps<8> kahan_li_8_steps{
    {0.13020248308889008087881763, 0.56116298177510838456196441, -0.38947496264484728640807860,
     0.15884190655515560089621075, -0.39590389413323757733623154, 0.18453964097831570709183254,
     0.25837438768632204729397911, 0.29501172360931029887096624}};

inline constexpr std::array<double, 4> mclachlan_atela_4_kicks = {0.134496199277431089, -0.224819803079420806,
                                                                  0.756320000515668291, 0.334003603286321425};
inline constexpr std::array<double, 4> mclachlan_atela_4_drifts = {0.515352837431122936, -0.085782019412973646,
                                                                   0.441583023616466524, 0.128846158365384185};


inline constexpr std::array<double, 7> blanes_moan_4_kicks = [] {
  const double b1 = 0.0829844064174052, b2 = 0.396309801498368, b3 = -0.0390563049223486;
  return std::array<double, 7>{b1, b2, b3, 1 - 2 * (b1 + b2 + b3), b3, b2, b1};
}();
inline constexpr std::array<double, 7> blanes_moan_4_drifts = [] {
  const double a1 = 0.245298957184271, a2 = 0.604872665711080, a3 = 0.5 - (a1 + a2);
  return std::array<double, 7>{a1, a2, a3, a3, a2, a1, 0.0};
}();
inline constexpr std::array<double, 12> blanes_moan_6_kicks = [] {
  const double b1 = 0.0414649985182624, b2 = 0.198128671918067, b3 = -0.0400061921041533, b4 = 0.0752539843015807,
               b5 = -0.0115113874206879, b6 = 0.5 - (b1 + b2 + b3 + b4 + b5);
  return std::array<double, 12>{b1, b2, b3, b4, b5, b6, b6, b5, b4, b3, b2, b1};
}();
inline constexpr std::array<double, 12> blanes_moan_6_drifts = [] {
  const double a1 = 0.123229775946271, a2 = 0.290553797799558, a3 = -0.127049212625417, a4 = -0.246331761062075,
               a5 = 0.357208872795928, a6 = 1 - 2 * (a1 + a2 + a3 + a4 + a5);
  return std::array<double, 12>{a1, a2, a3, a4, a5, a6, a5, a4, a3, a2, a1, 0.0};
}();

constexpr Splitting splitting(SplittingScheme scheme) {
  switch (scheme) {
    case SplittingScheme::verlet: return {"verlet", 2, verlet_steps.kicks, verlet_steps.drifts};
    case SplittingScheme::yoshida_4: return {"yoshida_4", 4, yoshida_4_steps.kicks, yoshida_4_steps.drifts};
    case SplittingScheme::mclachlan_atela_4:
      return {"mclachlan_atela_4", 4, mclachlan_atela_4_kicks, mclachlan_atela_4_drifts};
    case SplittingScheme::blanes_moan_4: return {"blanes_moan_4", 4, blanes_moan_4_kicks, blanes_moan_4_drifts};
    case SplittingScheme::kahan_li_6: return {"kahan_li_6", 6, kahan_li_6_steps.kicks, kahan_li_6_steps.drifts};
    case SplittingScheme::blanes_moan_6: return {"blanes_moan_6", 6, blanes_moan_6_kicks, blanes_moan_6_drifts};
    case SplittingScheme::kahan_li_8: return {"kahan_li_8", 8, kahan_li_8_steps.kicks, kahan_li_8_steps.drifts};
  }
  return {};
}

}  // namespace detail
}  // namespace qdot
