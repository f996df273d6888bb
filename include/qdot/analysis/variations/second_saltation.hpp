#pragma once
// SPDX-License-Identifier: MIT
//
// What an event makes of second derivatives.
//
// A motion that is displaced by s along a direction d of x is, near the moment t of the event and with ψ = ∂²y/∂s² = Σ d_a d_b ∂²y/∂x_a∂x_b, at
//
//     y(t + τ) = y + s Φd + ½ s² ψ + τ f + s τ Φ̇d + ½ τ² ḟ                          up to the second order,
//
// meets h = 0 at a τ of its own, becomes g there, and is, carried back to t by the equations behind the event,
//
//     Y(s) = g − τ (f⁺(t + τ, g) + s ∂f⁺/∂p d) + ½ τ² ḟ⁺ .
//
// Y is computed to rounding for each s, so that ψ⁺ = Y″(0) may be differenced (slope.hpp), to some nine digits. With r_a as far as column
// a may go, and directions r_a e_a and r_a e_a + r_b e_b,
//
//     ∂²y⁺/∂x_a∂x_b = (ψ⁺[r_a e_a + r_b e_b] − ψ⁺[r_a e_a] − ψ⁺[r_b e_b]) / 2 r_a r_b .

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "qdot/analysis/variations/equations.hpp"
#include "qdot/analysis/variations/slope.hpp"

namespace qdot::detail {

template <class = void>  // compiled only where it is made
class SecondSaltation final : public PairsBehind {
  using Index = Eigen::Index;

 public:
  // In front of the event, whose action may change what f is.
  SecondSaltation(const VariationalEquations& of, std::string name, double t, const Eigen::VectorXd& both)
      : of_(of), name_(std::move(name)), t_(t), size_(of.state_size()), columns_(of.columns()), y_(both.head(size_)), both_(both), rates_(rates(both)),
        bend_(bend(y_, rates_.head(size_))) {}

  void write(const Surface& surface, const Crossing& crossing, const Eigen::VectorXd& after, Eigen::VectorXd& both) const override {
    Eigen::VectorXd alone = Eigen::VectorXd::Zero(both.size());
    alone.head(size_) = after;
    const Behind behind{surface, crossing, rates(alone), bend(after, of_.state_rate(t_, after))};
    Eigen::MatrixXd diagonal(size_, columns_);
    Eigen::VectorXd distant(columns_);
    for (Index a = 0; a < columns_; ++a) {
      distant[a] = way(column(both_, a), crossing.time[a], a);
      diagonal.col(a) = second_slope(behind, {a, a, distant[a], 0.0});
    }
    Index place = size_ * (1 + columns_);
    for (Index a = 0; a < columns_; ++a)
      for (Index b = a; b < columns_; ++b, place += size_) {
        Eigen::VectorXd second = diagonal.col(a);
        if (a != b) second = 0.5 * (second_slope(behind, {a, b, distant[a], distant[b]}) - diagonal.col(a) - diagonal.col(b));
        both.segment(place, size_) = second / (distant[a] * distant[b]);
      }
  }

 private:
  struct Direction {  // p e_a + q e_b
    Index a, b;
    double p, q;

    auto of(const auto& at) const { return Eigen::VectorXd(p * at(a) + q * at(b)); }
  };
  struct Behind {
    const Surface& surface;
    const Crossing& crossing;
    Eigen::VectorXd rates, bend;  // f⁺ and ∂f⁺/∂p; ḟ⁺
  };

  // f, and the rates of the columns of Φ.
  Eigen::VectorXd rates(const Eigen::VectorXd& both) const {
    Eigen::VectorXd found = Eigen::VectorXd::Zero(both.size());
    of_.write_rates(t_, both.data(), found.data());
    return found;
  }
  // df/dt along the motion.
  Eigen::VectorXd bend(const Eigen::VectorXd& y, const Eigen::VectorXd& f) const {
    const auto slope = slope_at_zero([&](double s) { return of_.state_rate(t_ + s, y + s * f); }, 0.03125 * of_.reach(y, f, -1), f.cwiseAbs());
    if (!slope) end_undifferentiable(name_, t_, {"is where the equations have no derivative along the motion, so there is no second derivative behind it"});
    return *slope;
  }

  // Column c of one of the two; of a pair, the second derivative in front of the event.
  Eigen::VectorXd column(const Eigen::VectorXd& of, Index c) const { return of.segment(size_ * (1 + c), size_); }
  Eigen::VectorXd pair(Index a, Index b) const { return both_.segment(size_ * (1 + columns_ + a * columns_ - a * (a - 1) / 2 + b - a), size_); }

  // How far the motion goes along a direction before it, or where it meets the event, is another one.
  double way(const Eigen::VectorXd& Phi, double time, Index c) const { return std::min(of_.reach(y_, Phi, c), of_.reach(y_, time * rates_.head(size_), c)); }

  // Y″(0) along d.
  Eigen::VectorXd second_slope(const Behind& behind, const Direction& d) const {
    const auto columns_of = [&](const Eigen::VectorXd& of) { return d.of([&](Index c) { return column(of, c); }); };
    const Eigen::VectorXd Phi = columns_of(both_), Phi_rate = columns_of(rates_), by_parameter = columns_of(behind.rates), f = rates_.head(size_);
    const Eigen::VectorXd psi = d.p * d.p * pair(d.a, d.a) + 2.0 * d.p * d.q * pair(d.a, d.b) + d.q * d.q * pair(d.b, d.b);
    const double time = d.p * behind.crossing.time[d.a] + d.q * behind.crossing.time[d.b], distant = std::min(1.0, way(Phi, time, -1));
    const auto Y = [&](double s) {
      Eigen::VectorXd displaced;
      const auto h = [&](double later) {
        displaced = y_ + s * (Phi + 0.5 * s * psi + later * Phi_rate) + later * (f + 0.5 * later * bend_);
        return behind.surface.h(t_ + later, displaced, -1, 0.0);
      };
      double later = s * time, at = h(later), step = -at / behind.crossing.speed;
      for (int k = 0; k < 20 && step != 0.0 && std::abs(step) > 1e-17 * distant; ++k) {  // by secants
        const double before = std::exchange(at, h(later += step));
        step = at == before ? 0.0 : step * at / (before - at);
      }
      behind.surface.jump(t_ + later, displaced, -1, 0.0);
      return Eigen::VectorXd(displaced - later * (of_.state_rate(t_ + later, displaced) + s * by_parameter) + 0.5 * later * later * behind.bend);
    };
    const auto slope = second_slope_at_zero(Y, distant, of_.largest());
    if (!slope)
      end_undifferentiable(name_, t_,
                           {"changes the state in a way that has no second derivative with respect to ", of_.column_name(d.a), " and ",
                            of_.column_name(d.b), "; let its action be smooth"});
    return *slope;
  }

  const VariationalEquations& of_;
  std::string name_;
  double t_;
  Index size_, columns_;
  Eigen::VectorXd y_, both_, rates_, bend_;
};

}  // namespace qdot::detail
