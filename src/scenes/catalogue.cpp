// SPDX-License-Identifier: MIT
//
// The scenes of the program qdot.
#include "program/catalogue.hpp"

#include <vector>

namespace qdot::program {

// Each is defined in src/scenes/NAME.cpp.
std::unique_ptr<RunnableScene> make_projectile();
std::unique_ptr<RunnableScene> make_harmonic_oscillator();
std::unique_ptr<RunnableScene> make_pendulum();
std::unique_ptr<RunnableScene> make_double_pendulum();
std::unique_ptr<RunnableScene> make_chain();
std::unique_ptr<RunnableScene> make_rod_and_ring();
std::unique_ptr<RunnableScene> make_elastic_pendulum();
std::unique_ptr<RunnableScene> make_spherical_pendulum();
std::unique_ptr<RunnableScene> make_bead_on_hoop();
std::unique_ptr<RunnableScene> make_kepler();
std::unique_ptr<RunnableScene> make_cartpole();
std::unique_ptr<RunnableScene> make_heavy_top();
std::unique_ptr<RunnableScene> make_charged_particle();
std::unique_ptr<RunnableScene> make_coupled_oscillators();
std::unique_ptr<RunnableScene> make_atwood();
std::unique_ptr<RunnableScene> make_cycloid();
std::unique_ptr<RunnableScene> make_duffing();
std::unique_ptr<RunnableScene> make_morse();
std::unique_ptr<RunnableScene> make_mathieu();
std::unique_ptr<RunnableScene> make_henon_heiles();
std::unique_ptr<RunnableScene> make_cartesian_pendulum();
std::unique_ptr<RunnableScene> make_four_bar();
std::unique_ptr<RunnableScene> make_slider_crank();
std::unique_ptr<RunnableScene> make_rolling_hoop();
std::unique_ptr<RunnableScene> make_chaplygin_sleigh();
std::unique_ptr<RunnableScene> make_bouncing_ball();
std::unique_ptr<RunnableScene> make_friction_block();
std::unique_ptr<RunnableScene> make_rope_pendulum();
std::unique_ptr<RunnableScene> make_lattice();
std::unique_ptr<RunnableScene> make_string();
std::unique_ptr<RunnableScene> make_net();
std::unique_ptr<RunnableScene> make_rod_chain();
std::unique_ptr<RunnableScene> make_truss();

const std::vector<NamedScene>& named_scenes() {
  static const std::vector<NamedScene> scenes = {
      {"projectile", make_projectile},
      {"harmonic_oscillator", make_harmonic_oscillator},
      {"pendulum", make_pendulum},
      {"double_pendulum", make_double_pendulum},
      {"chain", make_chain},
      {"rod_and_ring", make_rod_and_ring},
      {"elastic_pendulum", make_elastic_pendulum},
      {"spherical_pendulum", make_spherical_pendulum},
      {"bead_on_hoop", make_bead_on_hoop},
      {"kepler", make_kepler},
      {"cartpole", make_cartpole},
      {"heavy_top", make_heavy_top},
      {"charged_particle", make_charged_particle},
      {"coupled_oscillators", make_coupled_oscillators},
      {"atwood", make_atwood},
      {"cycloid", make_cycloid},
      {"duffing", make_duffing},
      {"morse", make_morse},
      {"mathieu", make_mathieu},
      {"henon_heiles", make_henon_heiles},
      {"cartesian_pendulum", make_cartesian_pendulum},
      {"four_bar", make_four_bar},
      {"slider_crank", make_slider_crank},
      {"rolling_hoop", make_rolling_hoop},
      {"chaplygin_sleigh", make_chaplygin_sleigh},
      {"bouncing_ball", make_bouncing_ball},
      {"friction_block", make_friction_block},
      {"rope_pendulum", make_rope_pendulum},
      {"lattice", make_lattice},
      {"string", make_string},
      {"net", make_net},
      {"rod_chain", make_rod_chain},
      {"truss", make_truss},
  };
  return scenes;
}

}  // namespace qdot::program
