#pragma once
// SPDX-License-Identifier: MIT
//
// A system without its type, for what records T and V, asks whether they are the same still, and keeps lines of them.

#include <algorithm>
#include <vector>

#include "qdot/mechanics/derive/fingerprint.hpp"
#include "qdot/mechanics/derive/kept_rates.hpp"
#include "qdot/mechanics/derive/recorded_energies.hpp"
#include "qdot/mechanics/equations/solve.hpp"

namespace qdot::detail {

template <class Sys>
void run_system(const void* system, RecordedMotion& m, std::vector<char>*) {
  run_energies<Sys::dof_at_compile_time>(m, static_cast<const Sys*>(system)->energies());
}

/// T and V of a system, to be recorded.
template <class Sys>
RecordableForm recordable(const Sys& system) {
  const auto print = [](const void* it, const double*, const Answers* answers) {
    const auto& of = *static_cast<const Sys*>(it);
    return fingerprint<Sys::dof_at_compile_time>(of.energies(), static_cast<int>(of.dof()), answers);
  };
  return {.form = &system,
          .run = run_system<Sys>,
          .key = plain_system,
          .print = print,
          .dof = system.dof(),
          .by = system.kept_lines()->by(),
          .limits = {.singular = singular_pivot<double>(system.dof()), .dependent = 0.0}};
}

// Which systems have lines of q̈: of few coordinates, whose T and V take the scalar that records.
template <class Sys>
inline constexpr bool system_has_rates = may_have_rates<Sys::dof_at_compile_time> && Sys::inertia == Inertia::positive_definite &&
                                         RecordableEnergies<typename Sys::EnergiesType, Sys::dof_at_compile_time>;

// a ← q̈ by lines that are checked; false where there are none, and in a run, whose lines of M and r need no check.
template <class Sys, int n>
bool write_acceleration_by_lines(const Sys& system, const Vector<double, n>& q, const Vector<double, n>& qdot, double t, double* a) {
  const KeptLines& kept = *system.kept_lines();
  if (!kept.may_be_lines() || !kept.shared() || kept.once()) return false;
  double y[2 * n], ydot[2 * n];
  std::copy_n(qdot.data(), n, std::copy_n(q.data(), n, y));
  SharedRates& shared = rates_of(*kept.shared());
  const auto written = [&] {
    const AnyRates* const latest = shared.latest(plain_system, false);
    if (latest != nullptr && latest->are_of(fingerprint<n>(system.energies(), n, latest->answers()))) {
      const AnyRates::Written found = latest->write(t, y, ydot);
      if (AnyRates::is_on_branch(found)) return found == AnyRates::Written::yes;
    }
    return shared.write(recordable(system), t, y, {}, ydot);
  };
  if (!written()) return false;
  std::copy_n(ydot + n, n, a);
  return true;
}

}  // namespace qdot::detail
