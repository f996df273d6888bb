// SPDX-License-Identifier: MIT
#include "qdot/mechanics/derive/any_energies.hpp"

#include <string>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/integrate/energy_balance.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/mass_matrix.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/henon_heiles.hpp"

// Energies behind virtual functions. The oracle is the same functors with their type known.

namespace {

using namespace qdot;

// As the models of the program ask: gradients and momenta, and long double.
template <int n, bool timed>
using Hidden = detail::AnyEnergies<n, timed, Dual<double, n>, Dual<double, n, detail::SlopeByVelocity>, detail::TermDual<long double, n>>;

// T(q, q̇, t) and V(q, t) that depend on all of their arguments.
struct Shaken {
  template <class S>
  S T(const Vector<S, 2>& q, const Vector<S, 2>& v, const S& t) const {
    using std::cos;
    return 0.5 * (1.0 + 0.1 * cos(t)) * v[0] * v[0] + 0.25 * v[1] * v[1] * (2.0 + q[0] * q[0]);
  }
  template <class S>
  S V(const Vector<S, 2>& q, const S& t) const {
    using std::cos, std::sin;
    return 9.81 * (1.0 + 0.2 * sin(3.0 * t)) * cos(q[0]) + q[1] * q[1];
  }
};

}  // namespace

TEST_CASE("energies behind virtual functions give the bits of the functors, of each kind of number that is asked for") {
  const auto known = mechanical_system<2>(Shaken{});
  const System<Hidden<2, true>, 2> hidden(Hidden<2, true>(Shaken{}), known.parts());
  const Eigen::Vector2d q(0.3, -0.7), v(1.2, 0.4);
  const double t = 0.9;

  CHECK(conjugate_momenta(hidden, q, v, t) == conjugate_momenta(known, q, v, t));
  CHECK(detail::lagrangian_gradient<2>(hidden.energies(), q, v, t) == detail::lagrangian_gradient<2>(known.energies(), q, v, t));
  CHECK(mass_matrix(hidden, q, v, t) == mass_matrix(known, q, v, t));
  CHECK(acceleration(hidden, q, v, t) == acceleration(known, q, v, t));
  CHECK(energy_rate(hidden, q, v, t) == energy_rate(known, q, v, t));
  using Long = Vector<long double, 2>;
  CHECK(acceleration(hidden, Long(q.cast<long double>()), Long(v.cast<long double>()), 0.9L) ==
        acceleration(known, Long(q.cast<long double>()), Long(v.cast<long double>()), 0.9L));
}

TEST_CASE("a splitting method takes hidden energies whose T is one of the velocities, and refuses others by name") {
  const auto known = mechanical_system<2>(scenes::HenonHeiles{});
  const System<Hidden<2, false>, 2> hidden(Hidden<2, false>(scenes::HenonHeiles{}), known.parts());
  const State<2> start{0.0, {0.1, 0.2}, {0.3, 0.0}};
  const Splitting method{.step = 0.05};
  CHECK(simulate(hidden, start, 5.0, method, {}).y == simulate(known, start, 5.0, method, {}).y);

  const System<Hidden<2, false>, 2> mixed(Hidden<2, false>(scenes::DoublePendulum{}), mechanical_system<2>(scenes::DoublePendulum{}).parts());
  CHECK(error_message([&] { simulate(mixed, start, 1.0, method, {}); }) ==
        "a splitting method needs a kinetic energy of the velocities alone, T(qdot), and this T takes the coordinates; use Gauss");
}
