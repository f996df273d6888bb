#pragma once
// SPDX-License-Identifier: MIT
//
// The shared scenes with M and rhs derived by hand, in the order of the catalogue. Parameters are chosen
// unequal and different from 1, so that a forgotten factor shows.

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "scenes/atwood.hpp"
#include "scenes/bead_on_hoop.hpp"
#include "scenes/cartpole.hpp"
#include "scenes/chain.hpp"
#include "scenes/charged_particle.hpp"
#include "scenes/coupled_oscillators.hpp"
#include "scenes/cycloid.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/duffing.hpp"
#include "scenes/elastic_pendulum.hpp"
#include "scenes/harmonic_oscillator.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/henon_heiles.hpp"
#include "scenes/kepler.hpp"
#include "scenes/mathieu.hpp"
#include "scenes/morse.hpp"
#include "scenes/pendulum.hpp"
#include "scenes/projectile.hpp"
#include "scenes/rod_and_ring.hpp"
#include "scenes/spherical_pendulum.hpp"
#include "systems/hand_derived.hpp"
#include "systems/shaken_pendulum.hpp"

namespace qdot::systems {

inline VectorXd column(std::initializer_list<double> entries) {
  return Eigen::Map<const VectorXd>(entries.begin(), static_cast<Eigen::Index>(entries.size()));
}

inline MatrixXd symmetric(double a, double b, double c) {
  MatrixXd M(2, 2);
  M << a, b, b, c;
  return M;
}

inline std::vector<std::unique_ptr<const LawSystem>> catalogue() {
  using std::cos, std::sin, std::exp, std::sqrt;
  using V = const VectorXd&;
  std::vector<std::unique_ptr<const LawSystem>> all;

  const scenes::Projectile p{.m = 1.7, .g = 9.81};
  all.push_back(law_system("projectile", mechanical_system<3>(p),
                           {.M = [=](V) -> MatrixXd { return p.m * MatrixXd::Identity(3, 3); },
                            .rhs = [=](V, V, double) { return column({0.0, 0.0, -p.m * p.g}); }}));

  const scenes::HarmonicOscillator ho{.m = 1.7, .k = 4.3};
  all.push_back(law_system("harmonic_oscillator", mechanical_system<1>(ho),
                           {.M = [=](V) { return MatrixXd::Constant(1, 1, ho.m); },
                            .rhs = [=](V q, V, double) { return column({-ho.k * q[0]}); }}));

  const scenes::Pendulum pe{.m = 1.7, .l = 0.6, .g = 9.81};
  all.push_back(law_system("pendulum", mechanical_system<1>(pe),
                           {.M = [=](V) { return MatrixXd::Constant(1, 1, pe.m * pe.l * pe.l); },
                            .rhs = [=](V q, V, double) { return column({-pe.m * pe.g * pe.l * sin(q[0])}); }}));

  const scenes::DoublePendulum dp{.m1 = 1.3, .m2 = 0.7, .l1 = 0.9, .l2 = 1.4, .g = 9.81};
  all.push_back(law_system(
      "double_pendulum", mechanical_system<2>(dp),
      {.M = [=](V q) {
         return symmetric((dp.m1 + dp.m2) * dp.l1 * dp.l1, dp.m2 * dp.l1 * dp.l2 * cos(q[0] - q[1]), dp.m2 * dp.l2 * dp.l2);
       },
       .rhs = [=](V q, V v, double) {
         const double k = dp.m2 * dp.l1 * dp.l2 * sin(q[0] - q[1]);
         return column({-k * v[1] * v[1] - (dp.m1 + dp.m2) * dp.g * dp.l1 * sin(q[0]),
                        k * v[0] * v[0] - dp.m2 * dp.g * dp.l2 * sin(q[1])});
       }}));

  for (const int n : {1, 3, 7, 10}) {
    const scenes::Chain c{.n = n, .m = 0.7, .l = 1.3, .g = 9.81};
    all.push_back(law_system(
        "chain of " + std::to_string(n), mechanical_system(n, c),
        {.M = [=](V q) {
           MatrixXd M(n, n);
           for (int j = 0; j < n; ++j)
             for (int k = 0; k < n; ++k) M(j, k) = c.m * c.l * c.l * (n - std::max(j, k)) * cos(q[j] - q[k]);
           return M;
         },
         .rhs = [=](V q, V v, double) {
           VectorXd f(n);
           for (int j = 0; j < n; ++j) {
             f[j] = -(n - j) * c.m * c.g * c.l * sin(q[j]);
             for (int k = 0; k < n; ++k) f[j] -= c.m * c.l * c.l * (n - std::max(j, k)) * sin(q[j] - q[k]) * v[k] * v[k];
           }
           return f;
         }}));
  }

  const scenes::RodAndRing rr{};
  all.push_back(law_system(
      "rod_and_ring", mechanical_system<2>(rr),
      {.M = [=](V q) { return symmetric(rr.m, 0.0, rr.M * rr.L * rr.L / 3.0 + rr.m * q[0] * q[0]); },
       .rhs = [=](V q, V v, double) {
         return column({rr.m * q[0] * v[1] * v[1] - rr.m * rr.g * sin(q[1]),
                        -2.0 * rr.m * q[0] * v[0] * v[1] - (rr.m * q[0] + 0.5 * rr.M * rr.L) * rr.g * cos(q[1])});
       }}));

  const scenes::ElasticPendulum ep{.m = 1.3, .k = 29.0, .l0 = 0.8, .g = 9.81};
  all.push_back(law_system(
      "elastic_pendulum", mechanical_system<2>(ep),
      {.M = [=](V q) { return symmetric(ep.m, 0.0, ep.m * q[0] * q[0]); },
       .rhs = [=](V q, V v, double) {
         return column({ep.m * q[0] * v[1] * v[1] - ep.k * (q[0] - ep.l0) + ep.m * ep.g * cos(q[1]),
                        -2.0 * ep.m * q[0] * v[0] * v[1] - ep.m * ep.g * q[0] * sin(q[1])});
       },
       .lowest = {0.5, -2.0}, .highest = {2.0, 2.0}}));

  const scenes::SphericalPendulum sp{.m = 1.3, .l = 0.8, .g = 9.81};
  all.push_back(law_system(
      "spherical_pendulum", mechanical_system<2>(sp),
      {.M = [=](V q) { return symmetric(sp.m * sp.l * sp.l, 0.0, sp.m * sp.l * sp.l * sin(q[0]) * sin(q[0])); },
       .rhs = [=](V q, V v, double) {
         const double I = sp.m * sp.l * sp.l, s = sin(q[0]), c = cos(q[0]);
         return column({I * s * c * v[1] * v[1] - sp.m * sp.g * sp.l * s, -2.0 * I * s * c * v[0] * v[1]});
       },
       .lowest = {0.4, -2.0}, .highest = {2.7, 2.0}}));

  const scenes::BeadOnHoop bh{.m = 1.3, .R = 0.8, .g = 9.81, .Omega = 5.0};
  all.push_back(law_system(
      "bead_on_hoop", mechanical_system<1>(bh),
      {.M = [=](V) { return MatrixXd::Constant(1, 1, bh.m * bh.R * bh.R); },
       .rhs = [=](V q, V, double) {
         return column({bh.m * bh.R * bh.R * bh.Omega * bh.Omega * sin(q[0]) * cos(q[0]) - bh.m * bh.g * bh.R * sin(q[0])});
       },
       .T0 = [=](V q, double) { return 0.5 * bh.m * std::pow(bh.R * bh.Omega * sin(q[0]), 2); }}));

  const scenes::Kepler ke{.mu = 1.3};
  all.push_back(law_system("kepler", mechanical_system<2>(ke),
                           {.M = [](V) -> MatrixXd { return MatrixXd::Identity(2, 2); },
                            .rhs = [=](V q, V, double) -> VectorXd { return -ke.mu * q / std::pow(q.norm(), 3); },
                            .lowest = {0.4, -2.0}, .highest = {2.0, 2.0}}));

  const scenes::Cartpole cp{.M = 2.3, .m = 0.7, .l = 1.2, .g = 9.81};
  all.push_back(law_system(
      "cartpole", mechanical_system<2>(cp),
      {.M = [=](V q) { return symmetric(cp.M + cp.m, cp.m * cp.l * cos(q[1]), cp.m * cp.l * cp.l); },
       .rhs = [=](V q, V v, double) {
         return column({cp.m * cp.l * sin(q[1]) * v[1] * v[1], -cp.m * cp.g * cp.l * sin(q[1])});
       }}));

  const scenes::HeavyTop ht{.I1 = 1.1, .I3 = 0.7, .m = 1.4, .g = 9.81, .l = 0.2};
  all.push_back(law_system(
      "heavy_top", mechanical_system<3>(ht),
      {.M = [=](V q) {
         const double s = sin(q[0]), c = cos(q[0]);
         MatrixXd M(3, 3);
         M << ht.I1, 0.0, 0.0, 0.0, ht.I1 * s * s + ht.I3 * c * c, ht.I3 * c, 0.0, ht.I3 * c, ht.I3;
         return M;
       },
       .rhs = [=](V q, V v, double) {
         const double s = sin(q[0]), c = cos(q[0]), spin = v[2] + v[1] * c;
         return column({ht.I1 * s * c * v[1] * v[1] - ht.I3 * spin * v[1] * s + ht.m * ht.g * ht.l * s,
                        -2.0 * ht.I1 * s * c * v[0] * v[1] + ht.I3 * s * v[0] * spin + ht.I3 * c * s * v[0] * v[1],
                        ht.I3 * s * v[0] * v[1]});
       },
       .lowest = {0.4, -2.0, -2.0}, .highest = {2.7, 2.0, 2.0}}));

  const scenes::ChargedParticle ch{.m = 1.3, .e = 0.9, .B = 2.1, .E = 0.3, .omega = 1.6};
  all.push_back(law_system(
      "charged_particle", mechanical_system<2>(ch),
      {.M = [=](V) -> MatrixXd { return ch.m * MatrixXd::Identity(2, 2); },
       .rhs = [=](V, V v, double t) {
         return column({ch.e * ch.B * v[1] + ch.e * ch.E * cos(ch.omega * t), -ch.e * ch.B * v[0]});
       },
       .a = [=](V q, double) { return column({-0.5 * ch.e * ch.B * q[1], 0.5 * ch.e * ch.B * q[0]}); }}));

  const scenes::Atwood at{.m1 = 2.3, .m2 = 0.9, .I = 0.02, .R = 0.15, .g = 9.81};
  all.push_back(law_system("atwood", mechanical_system<1>(at),
                           {.M = [=](V) { return MatrixXd::Constant(1, 1, at.m1 + at.m2 + at.I / (at.R * at.R)); },
                            .rhs = [=](V, V, double) { return column({(at.m1 - at.m2) * at.g}); }}));

  const scenes::CoupledOscillators co{.m = 1.3, .k = 4.1, .kappa = 0.6};
  all.push_back(law_system("coupled_oscillators", mechanical_system<2>(co),
                           {.M = [=](V) -> MatrixXd { return co.m * MatrixXd::Identity(2, 2); },
                            .rhs = [=](V q, V, double) {
                              const double joint = co.kappa * (q[0] - q[1]);
                              return column({-co.k * q[0] - joint, -co.k * q[1] + joint});
                            }}));

  const scenes::Cycloid cy{.m = 1.3, .R = 0.6, .g = 9.81};
  all.push_back(law_system(
      "cycloid", mechanical_system<1>(cy),
      {.M = [=](V q) { return MatrixXd::Constant(1, 1, 2.0 * cy.m * cy.R * cy.R * (1.0 + cos(q[0]))); },
       .rhs = [=](V q, V v, double) { return column({cy.m * cy.R * sin(q[0]) * (cy.R * v[0] * v[0] - cy.g)}); }}));

  const scenes::Duffing du{.m = 1.3, .alpha = -0.8, .beta = 1.7};
  all.push_back(law_system("duffing", mechanical_system<1>(du),
                           {.M = [=](V) { return MatrixXd::Constant(1, 1, du.m); },
                            .rhs = [=](V q, V, double) { return column({-du.alpha * q[0] - du.beta * q[0] * q[0] * q[0]}); }}));

  const scenes::Morse mo{.m = 1.3, .D = 2.2, .a = 0.7};
  all.push_back(law_system("morse", mechanical_system<1>(mo),
                           {.M = [=](V) { return MatrixXd::Constant(1, 1, mo.m); },
                            .rhs = [=](V q, V, double) {
                              const double decay = exp(-mo.a * q[0]);
                              return column({-2.0 * mo.D * mo.a * decay * (1.0 - decay)});
                            }}));

  const scenes::HenonHeiles hh{.lambda = 0.9};
  all.push_back(law_system("henon_heiles", mechanical_system<2>(hh),
                           {.M = [](V) -> MatrixXd { return MatrixXd::Identity(2, 2); },
                            .rhs = [=](V q, V, double) {
                              return column({-q[0] - 2.0 * hh.lambda * q[0] * q[1],
                                             -q[1] - hh.lambda * (q[0] * q[0] - q[1] * q[1])});
                            }}));

  const scenes::Mathieu ma{.a = 1.3, .q = 0.4};
  all.push_back(law_system("mathieu", mechanical_system<1>(ma),
                           {.M = [](V) { return MatrixXd::Constant(1, 1, 1.0); },
                            .rhs = [=](V q, V, double t) { return column({-(ma.a - 2.0 * ma.q * cos(2.0 * t)) * q[0]}); }}));

  const ShakenPendulum sh{};
  all.push_back(law_system(
      "shaken pendulum", mechanical_system<1>(sh),
      {.M = [=](V) { return MatrixXd::Constant(1, 1, sh.m * sh.l * sh.l); },
       .rhs = [=](V q, V, double t) {
         return column({-sh.m * sh.l * sin(q[0]) * (sh.g - sh.A * sh.gamma * sh.gamma * cos(sh.gamma * t))});
       },
       .a = [=](V q, double t) { return column({-sh.m * sh.l * sin(q[0]) * sh.A * sh.gamma * sin(sh.gamma * t)}); },
       .T0 = [=](V, double t) { return 0.5 * sh.m * std::pow(sh.A * sh.gamma * sin(sh.gamma * t), 2); }}));
  return all;
}

}  // namespace qdot::systems
