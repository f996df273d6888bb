#pragma once
// SPDX-License-Identifier: MIT
//
// The scenes of `qdot bench scenes`, each with what an expert would write in its place (hand_derived_scenes.hpp). A case is a type
// with
//
//     n, constraints         coordinates, rows of constraints that are active
//     name, effect           as the table calls them
//     Hand                   the function object that is the baseline
//     lowest, highest        of the coordinates
//     scene()                the scene as a user writes it
//     states()               where effects have states of their own: currents, phases

#include <cmath>
#include <type_traits>
#include <vector>

#include "bench/chain_energies.hpp"
#include "bench/hand_derived_scenes.hpp"
#include "bench/scenes.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/kinematic_system.hpp"
#include "scenes/cartesian_pendulum.hpp"
#include "scenes/cartpole.hpp"
#include "scenes/chaplygin_sleigh.hpp"
#include "scenes/four_bar.hpp"
#include "scenes/friction_block.hpp"
#include "scenes/rolling_hoop.hpp"
#include "scenes/rope_pendulum.hpp"
#include "scenes/slider_crank.hpp"

namespace qdot::bench {

// The ways in which a chain is given to the library, T and V with qdot::unroll, with a plain loop, and positions.
struct UnrolledEnergies {
  static constexpr const char* name = "chain, T and V with unroll";
  template <int n>
  static auto system() { return mechanical_system<n>(UnrolledChain<n>{}); }
};
struct LoopedEnergies {
  static constexpr const char* name = "chain, T and V with for";
  template <int n>
  static auto system() { return mechanical_system<n>(LoopedChain{}); }
};
struct LoopsInARun {
  static constexpr const char* name = "chain, T and V with for, in a run";
  template <int n>
  static auto system() { return in_a_run(mechanical_system<n>(LoopedChain{})); }
};
struct PlacedMasses {
  static constexpr const char* name = "chain, positions";
  template <int n>
  static auto system() { return kinematic_system<n>(UnrolledPositions<n>{}, gravity_along<1>(-9.81)); }
};

// The sizes of a case, and where its states lie: anywhere, or near a configuration in which a mechanism moves freely.
enum class Where { anywhere, near };
template <int coordinates, int rows, Where states = Where::anywhere>
struct Case {
  static constexpr int n = coordinates, constraints = rows;
  static constexpr double lowest = states == Where::near ? 0.3 : -2.0, highest = states == Where::near ? 1.2 : 2.0;
};

template <class Way, int length, int rows>
struct ChainCase : Case<length, rows> {
  static constexpr const char* name = Way::name;
};

template <class Way, int length>
struct BareChain : ChainCase<Way, length, 0> {
  static constexpr const char* effect = "none";
  using Hand = ChainSceneByHand<length, false, false>;
  static auto scene() { return qdot::scene(Way::template system<length>()); }
};
template <class Way, int length>
struct DampedChain : ChainCase<Way, length, 0> {
  static constexpr const char* effect = "damping";
  using Hand = ChainSceneByHand<length, true, false>;
  static auto scene() { return qdot::scene(Way::template system<length>(), viscous_damping(Vector<double, length>(Vector<double, length>::Constant(0.1)))); }
};
template <class Way, int length>
struct GuidedChain : ChainCase<Way, length, 1> {
  static constexpr const char* effect = "tip guided";
  using Hand = ChainSceneByHand<length, false, true>;
  static auto scene() { return qdot::scene(Way::template system<length>(), holonomic("tip", TipOfChain<length>{})); }
};
template <class Way, int length>
struct DampedGuidedChain : ChainCase<Way, length, 1> {
  static constexpr const char* effect = "damping, tip guided";
  using Hand = ChainSceneByHand<length, true, true>;
  static auto scene() {
    return qdot::scene(Way::template system<length>(), viscous_damping(Vector<double, length>(Vector<double, length>::Constant(0.1))),
                       holonomic("tip", TipOfChain<length>{}));
  }
};
/// Its baseline is the bare chain by the same door.
template <class Way, int length>
struct OneJointDamped : ChainCase<Way, length, 0> {
  static constexpr const char* effect = "damping of one joint";
  static auto scene() {
    return qdot::scene(Way::template system<length>(),
                       viscous_damping(Vector<double, length>(0.1 * Vector<double, length>::Unit(length / 2))));
  }
};

/// Chains of these lengths by one of the ways, and one of eight, if there is one, beside itself with one joint damped.
template <class Way, int... lengths>
std::vector<SceneRow> rows_of_chains() {
  std::vector<SceneRow> rows;
  const auto add = [&](const std::vector<SceneRow>& more) { rows.insert(rows.end(), more.begin(), more.end()); };
  (add(rows_of_cases<DampedChain<Way, lengths>, GuidedChain<Way, lengths>, DampedGuidedChain<Way, lengths>>()), ...);
  if constexpr (((lengths == 8) || ...)) rows.push_back(row_beside<OneJointDamped<Way, 8>>(by_scene<BareChain<Way, 8>>, "its bare q̈"));
  return rows;
}

/// A cart and pole with a motor on the cart.
struct CartpoleWithMotor : Case<2, 0> {
  static constexpr const char *name = "cartpole", *effect = "motor";
  using Hand = CartpoleByHand<true, false>;
  static auto motor() {
    return controller(
        [](const auto& q, const auto&, const auto& z, const auto&) {
          using S = typename std::decay_t<decltype(q)>::Scalar;
          return Vector<S, 2>(2.0 * z[0], S(0.0));
        },
        [](const auto& q, const auto& qdot, const auto& z, const auto&) {
          using S = typename std::decay_t<decltype(q)>::Scalar;
          return Vector<S, 1>((12.0 - z[0] - 2.0 * qdot[0]) / 0.05);
        },
        Vector<double, 1>(1.5));
  }
  static auto scene() { return qdot::scene(mechanical_system<2>(scenes::Cartpole{}), motor()); }
  static auto states() { return Vector<double, 1>(1.5); }
};
struct CartpoleWithMotorAndFriction : CartpoleWithMotor {
  static constexpr const char* effect = "motor, friction, damping";
  using Hand = CartpoleByHand<true, true>;
  static auto scene() {
    return qdot::scene(mechanical_system<2>(scenes::Cartpole{}), motor(), regularized_friction(0, 1.0, 1e-3), viscous_damping(Vector<double, 2>(0.0, 0.1)));
  }
};

struct CartesianPendulumOnRod : Case<2, 1, Where::near> {
  static constexpr const char *name = "cartesian_pendulum", *effect = "rod";
  using Hand = CartesianPendulumByHand<false>;
  static auto rod() {
    return holonomic("rod", [l = 1.0](const auto& q) { return 0.5 * (q[0] * q[0] + q[1] * q[1] - l * l); });
  }
  static auto scene() { return qdot::scene(mechanical_system<2>(scenes::CartesianPendulum{}), rod()); }
};
struct CartesianPendulumInAir : CartesianPendulumOnRod {
  static constexpr const char* effect = "rod, drag";
  using Hand = CartesianPendulumByHand<true>;
  static auto scene() {
    return qdot::scene(mechanical_system<2>(scenes::CartesianPendulum{}), rod(), quadratic_drag([](const auto& q) { return q; }, 0.1));
  }
};

struct TautRope : Case<2, 1, Where::near> {
  static constexpr const char *name = "rope_pendulum", *effect = "taut rope";
  using Hand = TautRopeByHand;
  static auto scene() {
    return qdot::scene(mechanical_system<2>(scenes::RopePendulum{}), rope("rope", [](const auto& q) { return q; }, Vector<double, 2>(0.0, 0.0), 1.0));
  }
  static auto states() { return Vector<double, 1>(static_cast<double>(ContactPhase::closed)); }
};

struct FourBarLinkage : Case<3, 2, Where::near> {
  static constexpr const char *name = "four_bar", *effect = "loop";
  using Hand = FourBarByHand<false>;
  static auto loop() {
    return holonomic("loop", [s = scenes::FourBar{}](const auto& q) {
      using std::cos, std::sin;
      using S = typename std::decay_t<decltype(q)>::Scalar;
      return Vector<S, 2>(s.a * cos(q[0]) + s.b * cos(q[1]) - s.c * cos(q[2]) - s.d, s.a * sin(q[0]) + s.b * sin(q[1]) - s.c * sin(q[2]));
    });
  }
  static auto scene() { return qdot::scene(mechanical_system<3>(scenes::FourBar{}), loop()); }
};
struct DrivenFourBar : FourBarLinkage {
  static constexpr const char* effect = "loop, torque on the crank";
  using Hand = FourBarByHand<true>;
  static auto scene() {
    return qdot::scene(mechanical_system<3>(scenes::FourBar{}), loop(),
                       generalized_force([torque = 1.0](const auto&, const auto&, const auto&) { return Vector<double, 3>(torque, 0.0, 0.0); }));
  }
};

struct SliderAndCrank : Case<3, 2, Where::near> {
  static constexpr const char *name = "slider_crank", *effect = "linkage";
  using Hand = SliderCrankByHand;
  static auto scene() {
    return qdot::scene(mechanical_system<3>(scenes::SliderCrank{}), holonomic("linkage", [s = scenes::SliderCrank{}](const auto& q) {
                         using std::cos, std::sin;
                         using S = typename std::decay_t<decltype(q)>::Scalar;
                         return Vector<S, 2>(s.r * cos(q[0]) + s.l * cos(q[1]) - q[2], s.r * sin(q[0]) - s.l * sin(q[1]));
                       }));
  }
};

// A scene of the catalogue and its effect.
template <class Scene>
struct OfCatalogue : Case<Scene::n, Scene::constraints> {
  static constexpr const char *name = Scene::name, *effect = Scene::effect;
  using Hand = typename Scene::Hand;
  static auto scene() { return qdot::scene(mechanical_system<Scene::n>(typename Scene::Energies{}), Scene::with()); }
  static auto states()
    requires requires { Scene::states(); }
  { return Scene::states(); }
};

struct HolonomicHoop : Case<2, 1> {
  static constexpr const char *name = "rolling_hoop", *effect = "rolling, holonomic";
  using Hand = RollingHoopByHand;
  using Energies = scenes::RollingHoop;
  static auto with() { return holonomic("rolling", [R = 0.2](const auto& q) { return q[0] - R * q[1]; }); }
};
struct NonholonomicHoop : HolonomicHoop {
  static constexpr const char* effect = "rolling, nonholonomic";
  static auto with() { return nonholonomic("rolling", [R = 0.2](const auto&, const auto& qdot, const auto&) { return qdot[0] - R * qdot[1]; }); }
};
struct Sleigh : Case<3, 1> {
  static constexpr const char *name = "chaplygin_sleigh", *effect = "blade, nonholonomic";
  using Hand = ChaplyginSleighByHand;
  using Energies = scenes::ChaplyginSleigh;
  static auto with() {
    return nonholonomic("blade", [](const auto& q, const auto& qdot, const auto&) {
      using std::cos, std::sin;
      return qdot[1] * cos(q[2]) - qdot[0] * sin(q[2]);
    });
  }
};
struct Block : Case<1, 0> {
  static constexpr const char *name = "friction_block", *effect = "dry friction, sliding";
  using Hand = SlidingBlockByHand;
  using Energies = scenes::FrictionBlock;
  static auto with() { return dry_friction("block", 0, 0.3); }
  static auto states() { return Vector<double, 1>(static_cast<double>(FrictionPhase::forward)); }
};
using RollingHoopHolonomic = OfCatalogue<HolonomicHoop>;
using RollingHoopNonholonomic = OfCatalogue<NonholonomicHoop>;
using SleighOnBlade = OfCatalogue<Sleigh>;
using SlidingBlock = OfCatalogue<Block>;

/// Two masses by their positions, and a spring-damper between the middle of the upper rod and the lower mass.
struct SprungDoublePendulum : Case<2, 0> {
  static constexpr const char *name = "double_pendulum, positions", *effect = "spring-damper between bodies";
  static constexpr double lowest = -0.7, highest = 0.7;
  using Hand = SprungDoublePendulumByHand;
  static auto scene() {
    const auto middle = [](const auto& q) {
      using std::cos, std::sin;
      return vector(0.5 * sin(q[0]), -0.5 * cos(q[0]));
    };
    const auto end = [](const auto& q) {
      using std::cos, std::sin;
      return vector(sin(q[0]) + sin(q[1]), -cos(q[0]) - cos(q[1]));
    };
    return qdot::scene(kinematic_system<2>(UnrolledPositions<2>{}, gravity_along<1>(-9.81)), spring_damper(middle, end, 20.0, 1.2, 0.5));
  }
};

// Coordinates of a rotation, and the matrix of it by the library's words.
struct ByQuaternion {
  static constexpr int n = 4;
  static constexpr const char* name = "free body, quaternion";
  auto operator()(const auto& p) const { return rotation_from_quaternion(p); }
};
struct ByRotationVector {
  static constexpr int n = 3;
  static constexpr const char* name = "free body, rotation vector";
  auto operator()(const auto& u) const { return rotation_from_vector(u); }
};
struct ByEulerAngles {
  static constexpr int n = 3;
  static constexpr const char* name = "free body, Euler angles";
  auto operator()(const auto& q) const { return euler_rotation_313(q[0], q[1], q[2]); }
};

/// T = ½ Ω·I Ω, and ½ (|p|²/2)˙² where the length has an inertia of its own.
template <class Rotation, bool long_inertia = false>
struct TurningEnergy {
  TurningBody body;
  auto T(const auto& q, const auto& qdot) const {
    const auto w = body_angular_velocity_of(Rotation{}, q, qdot);
    const auto turning = 0.5 * (body.A * w[0] * w[0] + body.B * w[1] * w[1] + body.C * w[2] * w[2]);
    if constexpr (long_inertia) {
      const auto growth = q[0] * qdot[0] + q[1] * qdot[1] + q[2] * qdot[2] + q[3] * qdot[3];
      return turning + 0.5 * growth * growth;
    } else {
      return turning;
    }
  }
  auto V(const auto& q) const { return 0.0 * q[0]; }
};

/// A rigid body in space about its centre of mass, free or under a torque that is constant in space.
template <class Rotation, bool driven, class HandDerived, bool long_inertia = false>
struct TurningBodyCase {
  static constexpr int n = Rotation::n, constraints = 0;
  static constexpr const char *name = Rotation::name, *effect = driven ? "torque" : "none";
  static constexpr double lowest = 0.4, highest = 1.2;
  using Hand = HandDerived;
  static auto system() { return mechanical_system<n>(TurningEnergy<Rotation, long_inertia>{}); }
  static auto torque() {
    const TurningBody body;
    return torque_on_body(Rotation{}, Eigen::Vector3d(body.torque[0], body.torque[1], body.torque[2]));
  }
  static auto scene() {
    if constexpr (driven) {
      return qdot::scene(system(), torque());
    } else {
      return qdot::scene(system());
    }
  }
};
/// A turning body, given by where it is.
template <class Rotation, bool driven, class HandDerived>
struct PlacedBodyCase : TurningBodyCase<Rotation, driven, HandDerived> {
  static constexpr const char* effect = driven ? "positions, torque" : "positions";
  static auto scene() {
    const auto body = kinematic_system<Rotation::n>([](const auto& q, auto& bodies) {
      const TurningBody of;
      bodies.rigid_body(1.0, Eigen::Vector3d(of.A, of.B, of.C).asDiagonal().toDenseMatrix(), vector(0.0 * q[0], 0.0 * q[0], 0.0 * q[0]), Rotation{}(q));
    }, no_gravity);
    if constexpr (driven) {
      return qdot::scene(body, PlacedBodyCase::torque());
    } else {
      return qdot::scene(body);
    }
  }
  static constexpr auto no_gravity = gravity_along<2>(0.0);
};

/// Two bodies on a ball joint, by where they are from their common centre of mass.
struct JoinedBodies : Case<6, 0> {
  static constexpr const char *name = "two bodies on a ball joint, Euler angles", *effect = "positions";
  static constexpr double lowest = 0.4, highest = 1.2;
  using Hand = JoinedBodiesByHand;
  static auto scene() {
    return qdot::scene(kinematic_system<6>([](const auto& q, auto& bodies) {
      const JoinedBodiesByHand two;
      const Eigen::Matrix3d I = Eigen::Vector3d(two.A, two.B, two.C).asDiagonal();
      const auto R = euler_rotation_313(q[0], q[1], q[2]), S = euler_rotation_313(q[3], q[4], q[5]);
      const auto still = vector(0.0 * q[0], 0.0 * q[0], 0.0 * q[0]);
      bodies.rigid_body(1.0, I, still, R);
      bodies.rigid_body(1.0, I, still, S);
      bodies.point_mass(two.m, vector(two.alpha * R(0, 2) + two.beta * S(0, 2), two.alpha * R(1, 2) + two.beta * S(1, 2),
                                      two.alpha * R(2, 2) + two.beta * S(2, 2)));
    }, gravity_along<2>(0.0)));
  }
};
template <bool driven>
using PlacedEulerAnglesBody = PlacedBodyCase<ByEulerAngles, driven, EulerAnglesBodyByHand<driven>>;
template <bool driven>
using PlacedRotationVectorBody = PlacedBodyCase<ByRotationVector, driven, RotationVectorBodyByHand<driven>>;
template <bool driven>
using RotationVectorBody = TurningBodyCase<ByRotationVector, driven, RotationVectorBodyByHand<driven>>;
template <bool driven>
using EulerAnglesBody = TurningBodyCase<ByEulerAngles, driven, EulerAnglesBodyByHand<driven>>;
template <bool driven>
struct QuaternionBody : TurningBodyCase<ByQuaternion, driven, QuaternionBodyByHand<driven>, true> {
  static constexpr const char* effect = driven ? "length has inertia, torque" : "length has inertia";
};
template <bool driven>
struct UnitQuaternionBody : TurningBodyCase<ByQuaternion, driven, UnitQuaternionBodyByHand<driven>> {
  static constexpr int constraints = 1;
  static constexpr const char* effect = driven ? "unit length, torque" : "unit length";
  static auto scene() {
    const auto body = mechanical_system<4>(TurningEnergy<ByQuaternion>{}).with_indefinite_mass_matrix();
    const auto unit = holonomic("unit length", [](const auto& p) { return 0.5 * (p.squaredNorm() - 1.0); });
    if constexpr (driven) {
      return qdot::scene(body, unit, UnitQuaternionBody::torque());
    } else {
      return qdot::scene(body, unit);
    }
  }
};

}  // namespace qdot::bench
