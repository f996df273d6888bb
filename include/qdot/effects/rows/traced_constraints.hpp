#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ and λ of many coordinates on many constraints, from equations traced when a run began (mechanics/derive/traced_equations.hpp).
//
// Where M is diagonal, as that of point masses and of bodies in Cartesian coordinates is,
//
//     (J M⁻¹ Jᵀ) λ = γ − J u ,      u = M⁻¹(r + Q) ,      q̈ = u + M⁻¹Jᵀλ ,
//
// and all of it but the factors of J M⁻¹ Jᵀ is lines. A chain of rods costs two to three times what it costs by hand. Another M goes to
// the factors of both together (effects/rows/sparse_solve.hpp). Projections ask the same object: the smallest δ in the metric of M with
// J δ = b is M⁻¹Jᵀ(J M⁻¹ Jᵀ)⁻¹ b.
//
// Redundant rows leave zeros in the factors of J M⁻¹ Jᵀ. The motion is as unique as ever, and of all λ the shortest is taken, each row in
// its own length sᵢ = √(J M⁻¹ Jᵀ)ᵢᵢ. With N the null vectors and W = s², this is λ − N (Nᵀ W N)⁻¹ Nᵀ W λ. Rows that are nearly redundant,
// or contradict others, are left to effects/rows/constrained_solve.hpp.

#include <cstddef>
#include <memory>

#include "qdot/effects/rows/recorded_effects.hpp"
#include "qdot/effects/rows/sparse_rows.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/mechanics/derive/kept_motion.hpp"
#include "qdot/mechanics/equations/banded_equations.hpp"

namespace qdot::detail {

/// Equations of a form with constraints.
struct TracedConstraints : Traced {
  virtual bool are_native() const = 0;  // by machine code
  virtual bool are_long() const = 0;    // too long for it
  virtual std::size_t n() const = 0;
  virtual std::size_t rows() const = 0;
  /// Factors M and J at a state; false where the general way must see to it.
  virtual bool move_to(const double* q, const double* qdot, double t, const double* z) = 0;
  /// q̈ at a state, λ if it is wanted, and ż where there are states; false where the general way must see to it.
  virtual bool write(const double* q, const double* qdot, double t, const double* z, double* a, double* lambda, double* zdot) = 0;
  /// δ ← the smallest in the metric of M with J δ = b, after move_to(); b is overwritten.
  virtual bool displacement(double* b, double* delta) = 0;
  /// How many constraints are independent, after move_to().
  virtual std::size_t rank() const = 0;
  /// forces ← Jᵀλ, after move_to() or write().
  virtual void pull(const double* lambda, double* forces) = 0;
  /// J after move_to().
  virtual const SparseRows& jacobian() = 0;
  /// M after move_to().
  virtual BandedMatrix mass() const = 0;
};

/// Those of a form.
///
/// @param cutoff  relative size below which a row of J counts as dependent, where it is not left to the general way
template <class = void>
std::unique_ptr<TracedConstraints> traced_constraints(const RecordableForm& form, double cutoff);

// Which scenes are traced.
template <class Sc>
inline constexpr bool is_traced_scene = false;
template <class Sys, class... Effects>
inline constexpr bool is_traced_scene<Scene<Sys, Effects...>> = TracedSystem<typename Scene<Sys, Effects...>::SystemType> &&
                                                                (effect_is_recordable<Effects, Sys::dof_at_compile_time>() && ...);

// Which scenes can be recorded, n fixed or not; where effects switch, in one phase after the other.
template <class Sc>
inline constexpr bool is_recordable_scene = false;
template <class Sys, class... Effects>
inline constexpr bool is_recordable_scene<Scene<Sys, Effects...>> =
    RecordableEnergies<typename Scene<Sys, Effects...>::SystemType::EnergiesType, Sys::dof_at_compile_time> &&
    (effect_is_recordable<Effects, Sys::dof_at_compile_time, true>() && ...);

// Which scenes have Jacobians from a recording in each of their phases, where functors are formulas.
template <class Sc>
inline constexpr bool has_traced_jacobian = is_recordable_scene<Sc> && Sc::dof_at_compile_time <= 64;

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template std::unique_ptr<TracedConstraints> traced_constraints<void>(const RecordableForm&, double);
}  // namespace qdot::detail
#else
#include "qdot/effects/rows/traced_constraints.ipp"
#endif
