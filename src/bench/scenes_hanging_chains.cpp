// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: hanging chains and ladders of four-bars, with as many constraints as masses, or nearly.
#include "bench/four_bar_ladder.hpp"
#include "bench/scenes.hpp"
#include "qdot/effects/rows/traced_constraints.hpp"

namespace qdot::bench {

namespace {

struct Chain {
  static constexpr const char* name = "hanging chain, Cartesian";
  static constexpr int coordinates = 2, rods = 1;  // for each link
  using ByHand = HangingChainByHand;
  static auto scene(int links) { return hanging_chain(links); }
  static double straight_down(int i) { return i % 2 == 0 ? 0.0 : -(i + 1) / 2; }
};

struct Ladder {
  static constexpr const char* name = "ladder of four-bars, Cartesian";
  static constexpr int coordinates = 4, rods = 3;
  using ByHand = FourBarLadderByHand;
  static auto scene(int links) { return four_bar_ladder(links); }
  static double straight_down(int i) { return i % 2 == 1 ? -(i / 4 + 1) : i % 4 == 0 ? 0.0 : 1.0; }
};

template <class Model, int links>
[[gnu::noinline]] void by_hand(const double* q, const double* v, double* a) {
  static const typename Model::ByHand hand{links};
  hand(q, v, a);
}

// As a run evaluates it, from equations that it has traced when it began.
template <class Model, int links>
[[gnu::noinline]] void by_scene(const double* q, const double* v, double* a) {
  static const auto form = first_order_form(Model::scene(links));
  constexpr double cutoff = detail::clearly_independent * default_rank_cutoff * default_rank_cutoff;
  static const auto traced = detail::traced_constraints(detail::recordable_scene(form.scene()), cutoff);
  traced->write(q, v, 0.0, q, a, a + Model::coordinates * links, nullptr);
}

template <class Model, int... links>
void add_rows(std::vector<SceneRow>& rows) {
  (rows.push_back({.evaluation = {.system = Model::name,
                                  .n = Model::coordinates * links,
                                  .door = "",
                                  .baseline = by_hand<Model, links>,
                                  .measured = by_scene<Model, links>,
                                  .lowest = -0.3,
                                  .highest = 0.3,
                                  .numbers_out = (Model::coordinates + Model::rods) * links,
                                  .middle = Model::straight_down},
                   .constraints = Model::rods * links,
                   .effect = "rods"}),
   ...);
}

}  // namespace

std::vector<SceneRow> hanging_chain_scene_rows() {
  std::vector<SceneRow> rows;
  add_rows<Chain, 10, 40, 160, 640>(rows);
  add_rows<Ladder, 10, 40, 160>(rows);
  return rows;
}

}  // namespace qdot::bench
