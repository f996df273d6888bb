#pragma once
// SPDX-License-Identifier: MIT
//
// The Jacobians that a form keeps, derived from its recorded functors.
//
// They are made when they are first asked for, and again where a leg begins and the functors are others by then. A form whose Jacobian is not asked for
// is not traced for it, nor is that compiled. mechanics/derive/traced_jacobian.hpp has what is kept.

#include <Eigen/Core>
#include <atomic>
#include <memory>
#include <span>

#include "qdot/mechanics/derive/recordable_form.hpp"

namespace qdot::detail {

/// The size that loops are unrolled for, of n coordinates.
template <int n>
inline constexpr int unrolled_size = n >= 1 && n <= 4 ? n : Eigen::Dynamic;

/// Jacobians by lines, one for each combination of phases in which they are asked.
struct AnyJacobians {
  virtual ~AnyJacobians() = default;
  virtual std::unique_ptr<AnyJacobians> copy() const = 0;
  /// ydot ← ẏ, if it is wanted, and out ← ∂ẏ/∂y; false where another way must see to it.
  virtual bool write(const RecordableForm& form, std::span<const double> phases, double t, const double* y, double* ydot,
                     Eigen::Ref<Eigen::MatrixXd> out) = 0;
  /// Looks whether the functors are the same still; if not, all is forgotten.
  virtual void renew(const RecordableForm& form) = 0;
};
/// Those of n coordinates, or Dynamic.
template <int n>
std::unique_ptr<AnyJacobians> traced_jacobians();

/// The Jacobians that a form keeps, from the first that is asked for. Several threads may ask at once; copies share what one of them has made.
class KeptJacobians {
 public:
  KeptJacobians() = default;
  KeptJacobians(const KeptJacobians& other) : kept_(other.copied()) {}
  KeptJacobians& operator=(const KeptJacobians& other) {
    if (this != &other) delete kept_.exchange(other.copied());
    return *this;
  }
  ~KeptJacobians() { delete kept_.load(); }

  static constexpr Eigen::Index most_coordinates = 128;  // of a dense Jacobian that is worth keeping

  /// As AnyJacobians::write(), of so many coordinates.
  template <int n>
  bool write(const RecordableForm& form, std::span<const double> phases, double t, const double* y, double* ydot, Eigen::Ref<Eigen::MatrixXd> out) const {
    if (form.dof > most_coordinates) return false;
    AnyJacobians* kept = kept_.load(std::memory_order_acquire);
    if (!kept) kept = added(traced_jacobians<n>());
    return kept->write(form, phases, t, y, ydot, out);
  }
  /// As AnyJacobians::renew(). No other thread may ask meanwhile.
  void renew(const RecordableForm& form) {
    if (AnyJacobians* const kept = kept_.load()) kept->renew(form);
  }

 private:
  AnyJacobians* copied() const {
    const AnyJacobians* const kept = kept_.load(std::memory_order_acquire);
    return kept ? kept->copy().release() : nullptr;
  }
  // Of several threads the first adds.
  AnyJacobians* added(std::unique_ptr<AnyJacobians> made) const {
    AnyJacobians* there = nullptr;
    return kept_.compare_exchange_strong(there, made.get(), std::memory_order_acq_rel) ? made.release() : there;
  }

  mutable std::atomic<AnyJacobians*> kept_{nullptr};
};

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template std::unique_ptr<AnyJacobians> traced_jacobians<1>();
extern template std::unique_ptr<AnyJacobians> traced_jacobians<2>();
extern template std::unique_ptr<AnyJacobians> traced_jacobians<3>();
extern template std::unique_ptr<AnyJacobians> traced_jacobians<4>();
extern template std::unique_ptr<AnyJacobians> traced_jacobians<Eigen::Dynamic>();
}  // namespace qdot::detail
#else
#include "qdot/mechanics/derive/kept_equations.ipp"
#endif
