#pragma once
// SPDX-License-Identifier: MIT
//
// The mechanics behind ydot = f(t, y), without the type of the system.
//
// A method of momenta and forces, d/dt p = F (form_mechanics.hpp), depends on the numbers of coordinates and of effects' states alone, when it asks for
// them through a table.

#include <Eigen/Core>
#include <cstddef>
#include <memory>

#include "qdot/integrate/steps/form_mechanics.hpp"
#include "qdot/integrate/steps/rates.hpp"

namespace qdot::detail {

template <class F>
struct mechanical_form;

/// What a structure-preserving method asks of its system, with y = [q; q̇; z].
template <int n, int states>
struct MechanicalRates : Rates {
  using Vec = Vector<double, n>;
  using States = Vector<double, states>;

  virtual Eigen::Index dof() const = 0;
  virtual bool has_effects() const = 0;
  virtual Vec momenta(const Vec& q, const Vec& v, double t) const = 0;
  virtual Matrix<double, n> inverse_mass(const Vec& q, const Vec& v, double t) const = 0;
  // Of several states, at one call.
  virtual void write_momenta(std::size_t count, const Vec* q, const Vec* v, const double* t, Vec* p) const = 0;
  virtual void write_forces(std::size_t count, const Vec* q, const Vec* v, const States* z, const double* t, Vec* force) const = 0;
  virtual States zdot(const Vec& q, const Vec& v, const States& z, double t) const = 0;
  virtual States zddot(const Vec& q, const Vec& v, const Vec& a, const States& z, const States& w, double t) const = 0;  // accelerations a, rates w of z
};

/// That of a copy of a form; of states only where there are some.
template <class F>
class MechanicalRatesOf final : public RatesOf<F, MechanicalRates<Mechanics<F>::n, Mechanics<F>::states>> {
  using Behind = Mechanics<F>;
  using Face = MechanicalRates<Behind::n, Behind::states>;
  using typename Face::States, typename Face::Vec;
  using RatesOf<F, Face>::form_;

 public:
  using RatesOf<F, Face>::RatesOf;

  Eigen::Index dof() const override { return Behind::dof(form_); }
  bool has_effects() const override { return !mechanical_form<F>::value; }
  Vec momenta(const Vec& q, const Vec& v, double t) const override { return Behind::momenta(form_, q, v, t); }
  Matrix<double, Behind::n> inverse_mass(const Vec& q, const Vec& v, double t) const override { return Behind::inverse_mass(form_, q, v, t); }
  void write_momenta(std::size_t count, const Vec* q, const Vec* v, const double* t, Vec* p) const override {
    for (std::size_t i = 0; i < count; ++i) p[i] = Behind::momenta(form_, q[i], v[i], t[i]);
  }
  void write_forces(std::size_t count, const Vec* q, const Vec* v, const States* z, const double* t, Vec* force) const override {
    for (std::size_t i = 0; i < count; ++i) force[i] = Behind::force(form_, q[i], v[i], z[i], t[i]);
  }
  States zdot([[maybe_unused]] const Vec& q, [[maybe_unused]] const Vec& v, const States& z, [[maybe_unused]] double t) const override {
    if constexpr (Behind::states != 0) return Behind::zdot(form_, q, v, z, t);
    else return z;
  }
  States zddot([[maybe_unused]] const Vec& q, [[maybe_unused]] const Vec& v, [[maybe_unused]] const Vec& a, const States& z,
               [[maybe_unused]] const States& w, [[maybe_unused]] double t) const override {
    if constexpr (Behind::states != 0) return Behind::zddot(form_, q, v, a, z, w, t);
    else return z;
  }
};

}  // namespace qdot::detail
