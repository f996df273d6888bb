// SPDX-License-Identifier: MIT
//
// How long a user waits for the compiler, beside a program that only includes Eigen. The programs write T and V and integrate the motion, from a double
// pendulum to a scene of eight coordinates, or ask for more about it. The first is also compiled with the library's headers precompiled, as CMake's
// target_precompile_headers() does it: that is the time of each further edit. The compiler, its include directories and the library's sources must be
// where they were when the program was built.
#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "bench/bench.hpp"

namespace qdot::bench {

namespace {

namespace fs = std::filesystem;

constexpr const char* user_program = R"program(#include <cmath>
#include <cstdio>

#include <qdot/integrate/cvode.hpp>
#include <qdot/integrate/simulate.hpp>

// Two bobs on two massless rods; both angles from the downward vertical.
struct DoublePendulum {
  double m1 = 1.0, m2 = 1.0;  // kg
  double l1 = 1.0, l2 = 1.0;  // m
  double g = 9.81;            // m/s²

  auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return 0.5 * (m1 + m2) * l1 * l1 * qdot[0] * qdot[0]
         + 0.5 * m2 * l2 * l2 * qdot[1] * qdot[1]
         + m2 * l1 * l2 * qdot[0] * qdot[1] * cos(q[0] - q[1]);
  }

  auto V(const auto& q) const {
    using std::cos;
    return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[1]);
  }
};

int main() {
  const auto system = qdot::mechanical_system<2>(DoublePendulum{});
  const qdot::State<2> start{0.0, {1.7, 1.7}, {0.0, 0.0}};

  const auto run = qdot::simulate(system, start, 3.0, qdot::CvodeAdams{}, {.rtol = 1e-12, .atol = 1e-12});
  if (!run.completed()) {
    std::printf("%s\n", run.message.c_str());
    return 1;
  }
  const auto end = run.state();
  std::printf("t = %g  theta1 = %.10f  theta2 = %.10f\n", end.t, end.q[0], end.q[1]);
  std::printf("energy drift %.1e J\n", qdot::energy(system, end) - qdot::energy(system, start));
  return 0;
}
)program";

// What else users write, each in its shortest form: a name, and the program.
struct UserProgram {
  const char* name;
  std::string source;
};

// What two of them move.
constexpr const char* double_pendulum = R"program(
struct DoublePendulum {
  auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return qdot[0] * qdot[0] + 0.5 * qdot[1] * qdot[1] + qdot[0] * qdot[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -9.81 * (2.0 * cos(q[0]) + cos(q[1]));
  }
};
)program";

const UserProgram more_programs[] = {
    {"double pendulum with Automatic", std::string(R"program(#include <qdot/integrate/cvode_automatic.hpp>
#include <qdot/integrate/simulate.hpp>
)program") + double_pendulum + R"program(
int main() {
  const auto run = simulate(qdot::mechanical_system<2>(DoublePendulum{}), qdot::State<2>{0.0, {1.7, 1.7}, {0.0, 0.0}}, 3.0, qdot::Automatic{});
  return run.completed() ? 0 : 1;
}
)program"},
    {"bob on a rod with an event, Automatic", R"program(#include <qdot/effects/constraints.hpp>
#include <qdot/effects/scene_form.hpp>
#include <qdot/integrate/cvode_automatic.hpp>
#include <qdot/integrate/simulate.hpp>

int main() {
  const auto bob = qdot::mechanical_system<2>([](const auto& qdot) { return 0.5 * (qdot[0] * qdot[0] + qdot[1] * qdot[1]); },
                                              [](const auto& q) { return 9.81 * q[1]; });
  const auto rod = qdot::holonomic("rod", [](const auto& q) { return 0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0); });
  const auto top = qdot::event("top", [](const auto&, const auto& qdot) { return qdot[1]; }).falling();
  const auto run = simulate(scene(bob, rod), qdot::State<2>{0.0, {0.8, -0.6}, {0.3, 0.4}}, 10.0, qdot::Automatic{}, top);
  return run.completed() ? 0 : 1;
}
)program"},
    {"rigid body by a rotation vector, Automatic", R"program(#include <qdot/integrate/cvode_automatic.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/mechanics/rigid_body.hpp>

int main() {
  const qdot::RigidBody box = qdot::body_about_centre(2.0, qdot::inertia::box(2.0, 0.3, 0.2, 0.1));
  const auto rotation = [](const auto& q) { return qdot::rotation_from_vector(q.template tail<3>().eval()); };
  const auto centre = [](const auto& q) { return q.template head<3>().eval(); };
  const auto T = [=](const auto& q, const auto& qdot) { return kinetic_energy_of_body(box, rotation, centre, q, qdot); };
  qdot::State<6> start;
  start.q << 0, 0, 0, 0.3, 0.1, -0.2;
  start.qdot << 1, 0, 2, 0.4, -0.2, 3.0;
  const auto run = simulate(qdot::mechanical_system<6>(T, [](const auto& q) { return 19.62 * q[2]; }), start, 1.0, qdot::Automatic{});
  return run.completed() ? 0 : 1;
}
)program"},
    {"8 coordinates, a constraint and friction, Dop853", R"program(#include <cmath>

#include <qdot/effects/constraints.hpp>
#include <qdot/effects/dissipation.hpp>
#include <qdot/effects/scene_form.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>

int main() {
  const auto T = [](const auto& q, const auto& qdot) {
    auto sum = 0.0 * q[0];
    for (int i = 0; i < 8; ++i) sum += 0.5 * qdot[i] * qdot[i];
    return sum;
  };
  const auto V = [](const auto& q) {
    using std::sqrt;
    auto sum = 9.81 * (q[1] + q[3] + q[5] + q[7]);
    for (int i = 0; i < 6; i += 2) {
      const auto dx = q[i + 2] - q[i], dy = q[i + 3] - q[i + 1], stretch = sqrt(dx * dx + dy * dy) - 1.0;
      sum += 25.0 * stretch * stretch;
    }
    return sum;
  };
  const auto rod = qdot::holonomic("rod", [](const auto& q) { return 0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0); });
  const auto air = qdot::rayleigh([](const auto&, const auto& qdot) { return 0.05 * qdot.squaredNorm(); });
  qdot::State<8> start;
  start.q << 1, 0, 2, 0, 3, 0, 4, 0;
  start.qdot.setZero();
  const auto run = simulate(scene(qdot::mechanical_system<8>(T, V), rod, air), start, 3.0, qdot::Dop853{});
  return run.completed() ? 0 : 1;
}
)program"},
    {"double pendulum with its sensitivities, Dop853", std::string(R"program(#include <qdot/analysis/sensitivity.hpp>
#include <qdot/integrate/runge_kutta.hpp>
)program") + double_pendulum + R"program(
int main() {
  const auto found = sensitivities(qdot::mechanical_system<2>(DoublePendulum{}), qdot::State<2>{0.0, {1.7, 1.7}, {0.0, 0.0}}, 3.0, qdot::Dop853{});
  return found.completed() ? 0 : 1;
}
)program"},
    {"pendulum that swings periodically", R"program(#include <cmath>

#include <qdot/analysis/periodic_orbit.hpp>

struct Pendulum {
  auto T(const auto& qdot) const { return 0.5 * qdot[0] * qdot[0]; }
  auto V(const auto& q) const {
    using std::cos;
    return -cos(q[0]);
  }
};

int main() {
  const auto swing = periodic_orbit_near(qdot::mechanical_system<1>(Pendulum{}), qdot::State<1>{0.0, {1.3}, {0.0}}, 6.5, qdot::hold_coordinate(0));
  return swing.found() ? 0 : 1;
}
)program"},
    {"bead on a hoop and where it rests, by the hoop's speed", R"program(#include <cmath>

#include <qdot/analysis/equilibrium_branch.hpp>

struct Bead {
  double Omega = 1.0;
  auto T(const auto& q, const auto& qdot) const {
    using std::sin;
    return 0.5 * (qdot[0] * qdot[0] + Omega * Omega * sin(q[0]) * sin(q[0]));
  }
  auto V(const auto& q) const {
    using std::cos;
    return -9.81 * cos(q[0]);
  }
};

int main() {
  const Eigen::VectorXd start = Eigen::VectorXd::Constant(1, 0.01);
  const auto found = qdot::equilibrium_branches([](double Omega) { return qdot::mechanical_system<1>(Bead{Omega}); }, start, 1.0, 6.0);
  return found.size() > 1 ? 0 : 1;
}
)program"},
};

constexpr const char* eigen_only = R"program(#include <Eigen/Dense>
int main() { return static_cast<int>(Eigen::Matrix2d::Identity().inverse()(0, 1)); }
)program";

/// A directory that is removed with everything in it.
class ScratchDirectory {
 public:
  ScratchDirectory() {
    std::string pattern = (fs::temp_directory_path() / "qdot-bench-XXXXXX").string();
    if (mkdtemp(pattern.data()) != nullptr) path_ = pattern;
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  ~ScratchDirectory() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Processor seconds that finished child processes have used; unlike wall time they do not depend on other programs that compute.
double children_seconds() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

constexpr const char* headers_of_the_library = R"program(#include <qdot/integrate/cvode.hpp>
#include <qdot/integrate/simulate.hpp>
)program";

/// The compiler with all its options, started in `directory`.
std::string compiler_in(const fs::path& directory) {
  return "cd '" + directory.string() + "' && " QDOT_BENCH_COMPILER " -std=c++20 -O2 -DOMPI_SKIP_MPICXX -DMPICH_SKIP_MPICXX " QDOT_BENCH_INCLUDES " ";
}

/// Processor seconds to compile a source text, the better of two attempts; 0 if it does not compile.
double compile_seconds(const fs::path& directory, const std::string& source, const std::string& options = "") {
  const fs::path file = directory / "program.cpp";
  std::ofstream(file) << source;
  const std::string command = compiler_in(directory) + options + " -c program.cpp -o program.o >messages.txt 2>&1";
  double best = 0;
  for (int attempt = 0; attempt < 2; ++attempt) {
    const double before = children_seconds();
    if (std::system(command.c_str()) != 0) return 0;
    const double seconds = children_seconds() - before;
    best = attempt == 0 ? seconds : std::min(best, seconds);
  }
  return best;
}

Findings measured() {
  const ScratchDirectory scratch;
  if (scratch.path().empty()) return {.rows = {}, .note = {}, .cannot_run = "no temporary directory can be made"};
  const double baseline = compile_seconds(scratch.path(), eigen_only);
  if (baseline == 0) {
    return {.rows = {}, .note = {}, .cannot_run = "the compiler " QDOT_BENCH_COMPILER " with Eigen is not where it was"};
  }
  const double seconds = compile_seconds(scratch.path(), user_program);
  if (seconds == 0) return {.rows = {}, .note = {}, .cannot_run = "the library's headers are not where they were"};
  std::vector<Row> rows = {{"double pendulum with CVODE, 40 lines", seconds, baseline, "a program that includes Eigen/Dense", "s"}};
  for (const UserProgram& program : more_programs) {
    const double more = compile_seconds(scratch.path(), program.source);
    if (more == 0) return {.rows = {}, .note = {}, .cannot_run = std::string("this does not compile: ") + program.name};
    rows.push_back({program.name, more, baseline, "a program that includes Eigen/Dense", "s"});
    const double linked = compile_seconds(scratch.path(), program.source, "-DQDOT_COMPILED -DQDOT_COMPILED_ANALYSIS");
    const char* library = program.source.find("qdot/analysis/") == std::string::npos ? ", with qdot::compiled" : ", with qdot::compiled_analysis";
    if (linked != 0) rows.push_back({std::string(program.name) + library, linked, baseline, "a program that includes Eigen/Dense", "s"});
  }
  if (const double linked = compile_seconds(scratch.path(), user_program, "-DQDOT_COMPILED"); linked != 0)
    rows.push_back({"double pendulum with CVODE, with qdot::compiled", linked, baseline, "a program that includes Eigen/Dense", "s"});
  if (const double all = compile_seconds(scratch.path(), std::string("#include <qdot/qdot.hpp>\n") + user_program); all != 0)
    rows.push_back({"the same with all of qdot.hpp", all, baseline, "a program that includes Eigen/Dense", "s"});
  std::ofstream(scratch.path() / "library.hpp") << headers_of_the_library;
  for (const bool linked : {false, true}) {
    const std::string options = linked ? "-DQDOT_COMPILED " : "";
    if (std::system((compiler_in(scratch.path()) + options + "-x c++-header library.hpp -o library.hpp.gch >messages.txt 2>&1").c_str()) != 0) break;
    const double edit = compile_seconds(scratch.path(), user_program, options + "-include library.hpp");
    if (edit != 0)
      rows.push_back({linked ? "the same with qdot::compiled, too" : "the same with the library's headers precompiled", edit, baseline,
                      "a program that includes Eigen/Dense", "s"});
  }
  return {.rows = rows,
          .note = "processor time of " QDOT_BENCH_COMPILER " -std=c++20 -O2 -c, the better of two attempts"};
}

}  // namespace

Benchmark benchmark() {
  return {"compile", "time to compile programs of 20 to 40 lines that integrate a motion", measured};
}

}  // namespace qdot::bench
