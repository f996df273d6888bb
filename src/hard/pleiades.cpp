// SPDX-License-Identifier: MIT
//
// Seven stars in the plane: F. Mazzia, C. Magherini, Test Set for Initial Value Problem Solvers, problem plei; E. Hairer,
// S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.10. The end state is computed with 34 digits.
#include "hard/motion.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::hard {
namespace {

// Masses 1 … 7, constant of gravitation 1; q = [x₁ … x₇, y₁ … y₇].
struct SevenStars {
  auto T(const auto& v) const {
    using S = typename std::decay_t<decltype(v)>::Scalar;
    S sum(0.0);
    for (int i = 0; i < 7; ++i) sum += 0.5 * (i + 1.0) * (v[i] * v[i] + v[i + 7] * v[i + 7]);
    return sum;
  }
  auto V(const auto& q) const {
    using std::sqrt;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (int i = 0; i < 7; ++i)
      for (int j = 0; j < i; ++j) {
        const S dx = q[i] - q[j], dy = q[i + 7] - q[j + 7];
        sum -= (i + 1.0) * (j + 1.0) / sqrt(dx * dx + dy * dy);
      }
    return sum;
  }
};

std::vector<Row> rows() {
  const auto stars = mechanical_system<14>(SevenStars{});
  const auto moving = motion(stars);
  const Problem problem{
      .name = "Pleiades",
      .t_end = 3.0,
      .start = numbers({3, 3, -1, -3, 2, -2, 2, 3, -3, 2, 0, 0, -4, 4,  //
                        0, 0, 0, 0, 0, 1.75, -1.5, 0, 0, 0, -1.25, 1, 0, 0}),
      .exact = numbers({0.3706139143970512900940,  3.237284092057233092803,   -3.222559032418323347100,  0.6597091455775308359350,
                        0.3425581707156579790377,  1.562172101400631016046,   -0.7003092922212495385147, -3.943437585517392055278,
                        -3.271380973972549928021,  5.225081843456544192439,   -2.590612434977469510811,  1.198213693392274637514,
                        -0.2429682344935823409161, 1.091449240428979747882,   3.417003806314314752292,   1.354584501625501221477,
                        -2.590065597810775419619,  2.025053734714241106485,   -1.155815100160449092712,  -0.8072988170223021725660,
                        0.5952396354208718766608,  -3.741244961234008471205,  0.3773459685750629036558,  0.9386858869551078886947,
                        0.3667922227200569866696,  -0.3474046353808494366007, 2.344915448180936923142,   -1.947020434263291900674}),
      .reference_digits = 22,
      .gain = 130,
      .best_published = "PSIDE 14.5"};
  return {solved(problem, moving, By::dop853, {.rtol = 2.5e-15, .atol = 1e-16}),
          solved(problem, moving, stars, Splitting{.step = 1e-4, .scheme = SplittingScheme::kahan_li_8}, "kahan_li_8, h = 1e-4", {}),
          solved(problem, moving, stars, Taylor{}, "taylor, 2.5e-15", {.rtol = 2.5e-15, .atol = 1e-16})};
}

}  // namespace

Case pleiades() {
  return {"pleiades", "Pleiades",
          "Seven stars of mass 1 to 7 in the plane, with close passes. The published end state (PSIDE with 111573 evaluations) "
          "is right to 14.5 digits; errors grow 130 times.",
          rows};
}

}  // namespace qdot::hard
