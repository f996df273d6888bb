// SPDX-License-Identifier: MIT
//
// driver LIBRARY…: measures the peers' functions in turn over the same states and prints one line for each peer and n: the library, n, ns for one
// q̈, and the largest relative difference from the first library's.
#include <dlfcn.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <vector>

#include "bench/peers/peer.hpp"

int main(int argc, char** argv) {
  constexpr std::size_t states = 64, many = 1024;
  for (const int n : {1, 2, 4, 8, 16}) {
    const std::size_t size = static_cast<std::size_t>(n);
    struct Peer {
      const char* library;
      ChainAcceleration f = nullptr;
      ChainAccelerations many_at_once = nullptr;
      double ns = std::numeric_limits<double>::infinity();
      std::vector<double> a{};
    };
    std::vector<Peer> peers;
    for (int i = 1; i < argc; ++i) {
      void* const library = dlopen(argv[i], RTLD_NOW | RTLD_LOCAL);
      if (!library) {
        std::fprintf(stderr, "%s\n", dlerror());
        continue;
      }
      const auto of_chain = reinterpret_cast<ChainAcceleration (*)(int)>(dlsym(library, "acceleration_of_chain"));
      const auto of_chains = reinterpret_cast<ChainAccelerations (*)(int)>(dlsym(library, "accelerations_of_chains"));
      Peer peer{.library = argv[i], .f = of_chain ? of_chain(n) : nullptr, .many_at_once = of_chains ? of_chains(n) : nullptr};
      if (!peer.f && !peer.many_at_once) continue;
      peer.a.resize((peer.f ? states : many) * size);
      peers.push_back(peer);
    }
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-2.0, 2.0);
    std::vector<double> q(states * size), v(states * size);
    for (double& x : q) x = uniform(random);
    for (double& x : v) x = uniform(random);
    // For many at once the 64 states again and again, coordinate by coordinate.
    std::vector<double> q_rows(many * size), v_rows(many * size);
    for (std::size_t k = 0; k < many; ++k)
      for (std::size_t i = 0; i < size; ++i) {
        q_rows[i * many + k] = q[(k % states) * size + i];
        v_rows[i * many + k] = v[(k % states) * size + i];
      }
    for (int repeat = 0; repeat < 200; ++repeat)
      for (Peer& peer : peers) {
        const auto began = std::chrono::steady_clock::now();
        if (peer.f) {
          for (std::size_t k = 0; k < states; ++k) peer.f(&q[k * size], &v[k * size], &peer.a[k * size]);
        } else {
          peer.many_at_once(q_rows.data(), v_rows.data(), peer.a.data(), static_cast<int>(many));
        }
        const double ns = std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - began).count();
        peer.ns = std::min(peer.ns, ns / static_cast<double>(peer.f ? states : many));
      }
    for (const Peer& peer : peers) {
      double worst = 0.0;
      for (std::size_t k = 0; k < states; ++k)
        for (std::size_t i = 0; i < size; ++i) {
          const double a = peer.f ? peer.a[k * size + i] : peer.a[i * many + k], by_hand = peers[0].a[k * size + i];
          worst = std::max(worst, std::abs(a - by_hand) / (1.0 + std::abs(by_hand)));
        }
      std::printf("%s %d %.2f %.1e\n", peer.library, n, peer.ns, worst);
    }
  }
}
