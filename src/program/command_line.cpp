// SPDX-License-Identifier: MIT
//
#include "program/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "program/arguments.hpp"
#include "program/catalogue.hpp"
#include "program/scene_file.hpp"

namespace qdot::program {

namespace {

constexpr int bad_arguments = 2;

/// Takes an option that may be given several times, one value each.
void add_repeatable(CLI::App* command, const std::string& name, std::vector<std::string>& values, const std::string& help) {
  command->add_option(name, values, help)->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

/// Takes an option with one value; CLI11's own conversions are not used, so that our messages name rule and value.
void add_text(CLI::App* command, const std::string& name, std::optional<std::string>& value, const std::string& help,
              const std::string& type) {
  command->add_option_function<std::string>(name, [&value](const std::string& text) { value = text; }, help)
      ->type_name(type)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
}

/// Takes the name of a scene, which may be left away where there is only one.
void add_scene_name(CLI::App* command, std::string& name) {
  const bool only = named_scenes().size() == 1;
  if (only) name = named_scenes().front().name;
  command->add_option("SCENE", name, "a name from qdot list, or a file of C++ (qdot new)")->required(!only);
}

/// Takes what all commands about one scene take.
void add_scene(CLI::App* command, SceneOptions& options) {
  add_scene_name(command, options.scene);
  add_repeatable(command, "--set", options.set, "parameter or initial value (theta or q0, thetadot or qdot0), NAME=VALUE");
  add_repeatable(command, "--with", options.with, "switch an effect on, EFFECT[=VALUE]");
  add_repeatable(command, "--without", options.without, "switch an effect off");
  add_text(command, "--by", options.by, "how T and V are evaluated: fastest (default), duals, lines, machine_code", "WAY");
}

/// What CLI11 did not recognize, as an error of ours.
void refuse_extras(const CLI::App* command) {
  const std::vector<std::string> extras = command->remaining();
  if (extras.empty()) return;
  const std::string name = extras.front().substr(0, extras.front().find('='));
  if (!name.starts_with("-")) {
    throw UsageError("arguments: must be options after the first, given \"" + name + "\"");
  }
  std::vector<std::string> valid;
  for (const CLI::Option* option : command->get_options()) {
    for (const std::string& long_name : option->get_lnames()) valid.push_back("--" + long_name);
  }
  throw unknown_name(name, "an option of qdot " + command->get_name(), name, valid);
}

int execute(int argc, char** argv, std::string& command_name, int (*bench)(const BenchOptions&)) {
  CLI::App app("qdot: from kinetic and potential energy to motion", "qdot");
  app.set_version_flag("--version", "qdot " QDOT_VERSION);
  app.require_subcommand(1);
  app.footer("Exit status: 0 completed, 1 the run failed, 2 bad arguments.");

  ListOptions list_options;
  CLI::App* list_command = app.add_subcommand("list", "scenes with their parameters, or one of them in detail");
  list_command->add_option_function<std::string>(
      "SCENE", [&](const std::string& text) { list_options.scene = text; }, "one of them, or a file of C++, with units and meanings; all of them without a name");
  list_command->add_flag("--json", list_options.json, "one JSON object on stdout");

  NewOptions new_options;
  CLI::App* new_command = app.add_subcommand("new", "write a file with a scene of your own, to begin with");
  new_command->add_option("NAME", new_options.name, "of the scene; the file is NAME.cpp")->required();

  RunOptions run_options;
  CLI::App* run_command = app.add_subcommand("run", "simulate a scene");
  add_scene(run_command, run_options);
  add_text(run_command, "--t-end", run_options.t_end, "time to end at", "T");
  add_text(
      run_command, "--method", run_options.method,
      "auto (default: chooses and says why), taylor, dop853, dopri5, adams, bdf (stiff), or symplectic with a fixed step: gauss2 … gauss8, verlet, yoshida_4, blanes_moan_6 …; all in qdot list",
      "NAME");
  add_text(run_command, "--step", run_options.step, "step of a method with a fixed one (default: from --rtol, by a short pilot run)", "H");
  add_text(run_command, "--rtol", run_options.rtol, "relative tolerance of the local error (default 1e-10)", "R");
  add_text(run_command, "--atol", run_options.atol, "absolute tolerance of the local error (default 1e-10)", "A");
  add_text(run_command, "--accuracy", run_options.accuracy, "error of the whole motion; chooses both tolerances", "E");
  add_text(run_command, "--samples", run_options.samples, "rows of the table (default 500, or fewer for many coordinates)", "N");
  add_repeatable(
      run_command, "--compare", run_options.compare,
      "one more run beside it, in the same plots and picture: NAME=VALUE,… of parameters, initial values, method, step, rtol, atol, accuracy; with EFFECT[=VALUE]; without EFFECT");
  add_text(run_command, "--out", run_options.out, "write PATH.csv, PATH.npz, PATH.html and PATH.svg", "PATH");
  run_command->add_flag("--forces", run_options.forces, "arrows of the constraints' and the effects' forces in the moving picture, with --out");
  run_command->add_flag("--json", run_options.json, "one JSON object on stdout");
  run_command->add_flag("--quiet", run_options.quiet, "no progress bar");

  AccuracyOptions accuracy_options;
  CLI::App* accuracy_command = app.add_subcommand("accuracy", "what accuracy costs in time, with each method");
  add_scene(accuracy_command, accuracy_options);
  add_text(accuracy_command, "--t-end", accuracy_options.t_end, "time to end at", "T");
  add_repeatable(accuracy_command, "--method", accuracy_options.methods, "a method to compare; all that fit without it");
  add_text(accuracy_command, "--samples", accuracy_options.samples, "times at which errors are measured (default 32)", "N");
  add_text(accuracy_command, "--out", accuracy_options.out, "write PATH.csv, PATH.html and PATH.svg", "PATH");
  accuracy_command->add_flag("--quick", accuracy_options.quick, "fewer tolerances and shorter measurements");
  accuracy_command->add_flag("--json", accuracy_options.json, "one JSON object on stdout");
  accuracy_command->add_flag("--quiet", accuracy_options.quiet, "no progress line");

  EffectsOptions effects_options;
  CLI::App* effects_command = app.add_subcommand("effects", "what each effect of a scene costs");
  add_scene_name(effects_command, effects_options.scene);
  add_repeatable(effects_command, "--set", effects_options.set, "parameter or state (theta or q0, thetadot or qdot0), NAME=VALUE");
  effects_command->add_flag("--json", effects_options.json, "one JSON object on stdout");

  EquationsOptions equations_options;
  CLI::App* equations_command = app.add_subcommand("equations", "Lagrange's equations of a scene as formulas");
  add_scene_name(equations_command, equations_options.scene);
  add_repeatable(equations_command, "--set", equations_options.set, "parameter, NAME=VALUE; what a formula does not depend on does not show");
  equations_command->add_flag("--latex", equations_options.latex, "for LaTeX, with amsmath");
  equations_command->add_flag("--mathml", equations_options.mathml, "for a page");
  add_text(equations_command, "--c", equations_options.c, "write q̈ and its Jacobian as a C99 file", "FILE");

  ModesOptions modes_options;
  EquilibriaOptions equilibria_options;
  const auto add_small_motions = [&](const char* name, const char* what, ModesOptions& options) {
    CLI::App* command = app.add_subcommand(name, what);
    add_scene(command, options);
    command->add_flag("--steady", options.steady, "coordinates turn at the velocities of the start, which nothing may depend on");
    add_text(command, "--out", options.out, "write PATH.csv and PATH.html", "PATH");
    command->add_flag("--json", options.json, "one JSON object on stdout");
    return command;
  };
  CLI::App* modes_command = add_small_motions("modes", "the equilibrium near the start, its stability, frequencies and damping", modes_options);
  CLI::App* equilibria_command = add_small_motions("equilibria", "the equilibria of a scene and their stability", equilibria_options);
  add_text(equilibria_command, "--along", equilibria_options.along,
           "follow the one near the start along a parameter, or an effect that is on, with what branches off: NAME=FROM:TO; --out then writes PATH.svg, too", "NAME=FROM:TO");
  add_text(equilibria_command, "--show", equilibria_options.show, "with --along: which coordinates are drawn, the first of them in PATH.svg", "NAME,…");

  ConservedOptions conserved_options;
  CLI::App* conserved_command = app.add_subcommand("conserved", "which momenta and energies a scene conserves, and why");
  add_scene(conserved_command, conserved_options);
  conserved_command->add_flag("--json", conserved_options.json, "one JSON object on stdout");

  LyapunovCommandOptions lyapunov_options;
  CLI::App* lyapunov_command = app.add_subcommand("lyapunov", "how fast motions part that begin close to the start");
  add_scene(lyapunov_command, lyapunov_options);
  add_text(lyapunov_command, "--t-end", lyapunov_options.t_end, "time to end at (default: fifty times that of run)", "T");
  add_text(lyapunov_command, "--interval", lyapunov_options.interval, "time between orthonormalizations", "T");
  add_text(lyapunov_command, "--settle", lyapunov_options.settle, "time that is not counted (default: a tenth)", "T");
  add_text(lyapunov_command, "--rtol", lyapunov_options.rtol, "tolerance of the local error, relative and absolute (default 1e-9)", "R");
  add_text(lyapunov_command, "--out", lyapunov_options.out, "write PATH.csv and PATH.html", "PATH");
  lyapunov_command->add_flag("--json", lyapunov_options.json, "one JSON object on stdout");
  lyapunov_command->add_flag("--quiet", lyapunov_options.quiet, "no progress bar");

  SectionCommandOptions section_options;
  CLI::App* section_command = app.add_subcommand("section", "where motions pass a plane, as points (Poincaré)");
  add_scene(section_command, section_options);
  add_text(section_command, "--plane", section_options.plane, "the surface: a coordinate or velocity has a value, NAME=VALUE", "NAME=VALUE");
  add_text(section_command, "--every", section_options.every, "in place of a plane: once in each period T", "T");
  add_text(section_command, "--direction", section_options.direction, "in which the plane is passed: rising (default), falling, either", "D");
  add_repeatable(section_command, "--angle", section_options.angles,
                 "a coordinate that is an angle: its plane is passed in each turn, and its values are from -pi to pi");
  add_text(section_command, "--count", section_options.count, "points of each motion (default 200)", "N");
  add_repeatable(section_command, "--over", section_options.over, "several starts: a coordinate or velocity goes through values, NAME=A:B:COUNT or NAME=A,B");
  add_text(section_command, "--keep-energy", section_options.keep_energy,
           "the velocity that is chosen such that all starts have the energy of the first", "NAME");
  add_text(section_command, "--show", section_options.show, "which two of coordinates and velocities are drawn, NAME,NAME", "X,Y");
  add_text(section_command, "--t-end", section_options.t_end, "time to end at, whether there are N points or not (default: N times that of run)", "T");
  add_text(section_command, "--rtol", section_options.rtol, "tolerance of the local error, relative and absolute (default 1e-10)", "R");
  add_text(section_command, "--out", section_options.out, "write PATH.csv, PATH.html and PATH.svg", "PATH");
  section_command->add_flag("--json", section_options.json, "one JSON object on stdout");
  section_command->add_flag("--quiet", section_options.quiet, "no progress bar");

  OrbitCommandOptions orbit_options;
  CLI::App* orbit_command = app.add_subcommand("orbit", "the periodic orbit near the start, its stability, and its family");
  add_scene(orbit_command, orbit_options);
  add_text(orbit_command, "--period", orbit_options.period,
           "what the period is: of a drive, or a multiple; or that of one of the orbits where energy is conserved", "T");
  add_text(orbit_command, "--period-guess", orbit_options.period_guess, "where to begin (default: when the motion is nearest to its start again)", "T");
  add_text(orbit_command, "--hold", orbit_options.hold,
           "which orbit of a family is meant: energy (default, where it is conserved) of the start, energy=E, NAME of a coordinate, or nothing (default elsewhere)", "WHAT");
  add_text(orbit_command, "--settle", orbit_options.settle, "let the motion go on for so long, and begin there", "T");
  add_text(orbit_command, "--along", orbit_options.along,
           "follow the family: energy=FROM:TO, period=FROM:TO, or a parameter or an effect that is on; without FROM from what it is",
           "NAME=FROM:TO");
  add_text(orbit_command, "--show", orbit_options.show, "which two of coordinates and velocities are drawn, NAME,NAME", "X,Y");
  add_text(orbit_command, "--out", orbit_options.out, "write PATH.csv, PATH.html and PATH.svg", "PATH");
  orbit_command->add_flag("--json", orbit_options.json, "one JSON object on stdout");

  SensitivityCommandOptions sensitivity_options;
  CLI::App* sensitivity_command = app.add_subcommand("sensitivity", "what a motion depends on: derivatives by its start and by parameters");
  add_scene(sensitivity_command, sensitivity_options);
  add_text(sensitivity_command, "--of", sensitivity_options.of, "which coordinates and velocities (default: all)", "NAME,…");
  add_text(sensitivity_command, "--to", sensitivity_options.to,
           "which parameters, effects that are on, and coordinates and velocities of the start (default: all)", "NAME,…");
  add_text(sensitivity_command, "--t-end", sensitivity_options.t_end, "time to end at", "T");
  add_text(sensitivity_command, "--method", sensitivity_options.method,
           "dop853 (default), dopri5, adams, bdf, and without contacts and dry friction taylor and gauss2 … gauss8", "NAME");
  add_text(sensitivity_command, "--step", sensitivity_options.step, "step of gauss2 … gauss8 (default: by --rtol and a pilot run)", "H");
  add_text(sensitivity_command, "--rtol", sensitivity_options.rtol, "tolerance of the local error, relative and absolute (default 1e-11)", "R");
  add_text(sensitivity_command, "--samples", sensitivity_options.samples, "rows of the table of the whole motion (default 400)", "N");
  add_text(sensitivity_command, "--out", sensitivity_options.out, "write PATH.csv, PATH.html and PATH.svg", "PATH");
  sensitivity_command->add_flag("--json", sensitivity_options.json, "one JSON object on stdout");

  SweepOptions sweep_options;
  CLI::App* sweep_command = app.add_subcommand("sweep", "many motions of a scene: over a grid of parameters and starts, or a random sample");
  add_scene(sweep_command, sweep_options);
  add_repeatable(sweep_command, "--over", sweep_options.over,
                 "what varies: NAME=FROM:TO:COUNT[:log], NAME=A,B,C, or with --random NAME~uniform(A,B), NAME~normal(MEAN,SIGMA); NAME is a parameter, an effect, a coordinate or a velocity");
  add_repeatable(sweep_command, "--record", sweep_options.record,
                 "what to keep: NAME at the end, max(NAME), min(NAME), t(NAME=VALUE) and t(|NAME|=VALUE) when first passed, t(event EVENT), energy, energy_drift_max, lyapunov (the greatest exponent), alignment (of two deviations, GALI: below 1e-8 in chaos), steps, t (default: all coordinates at the end)");
  add_text(sweep_command, "--random", sweep_options.random, "a sample of so many motions in place of a grid", "N");
  add_text(sweep_command, "--seed", sweep_options.seed, "of the sample (default 1)", "S");
  add_text(sweep_command, "--threads", sweep_options.threads, "default: one for each core, and one with --processes or --shard; the results are the same", "N");
  add_text(sweep_command, "--processes", sweep_options.processes, "so many worker processes; implies --resume", "N");
  add_text(sweep_command, "--shard", sweep_options.shard,
           "K/N: only the K-th of N shares; auto: one of several processes that MPI or Slurm has started; implies --resume", "K/N");
  add_text(sweep_command, "--t-end", sweep_options.t_end, "time to end at", "T");
  add_text(sweep_command, "--method", sweep_options.method, "as for run (default auto)", "NAME");
  add_text(sweep_command, "--rtol", sweep_options.rtol, "relative tolerance of the local error (default 1e-8)", "R");
  add_text(sweep_command, "--atol", sweep_options.atol, "absolute tolerance of the local error (default that of --rtol)", "A");
  add_text(sweep_command, "--out", sweep_options.out, "write PATH.csv, PATH.npz and PATH.html", "PATH");
  sweep_command->add_flag("--resume", sweep_options.resume,
                          "record each motion in the directory PATH.sweep, and go on with what is there; to be given from the beginning");
  sweep_command->add_flag("--json", sweep_options.json, "one JSON object on stdout");
  sweep_command->add_flag("--quiet", sweep_options.quiet, "no progress bar");

  BenchOptions bench_options;
  CLI::App* bench_command = nullptr;
  if (bench != nullptr) {
    bench_command = app.add_subcommand("bench", "the project's own benchmarks");
    bench_command->add_option_function<std::string>(
        "NAME", [&](const std::string& text) { bench_options.name = text; }, "all of them without a name");
    bench_command->add_flag("--json", bench_options.json, "one JSON object on stdout");
    add_text(bench_command, "--page", bench_options.page, "write the benchmark's page of the documentation (hard)", "FILE");
  }

  std::vector<std::string> names;
  for (CLI::App* command : app.get_subcommands({})) {
    names.push_back(command->get_name());
    command->allow_extras();
  }
  if (argc > 1 && argv[1][0] != '-') {
    command_name = argv[1];
    if (std::find(names.begin(), names.end(), command_name) == names.end()) {
      command_name.clear();
      throw unknown_name("command", "a command", argv[1], names);
    }
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    return app.exit(success);
  } catch (const CLI::ArgumentMismatch& error) {  // "--t-end: 1 required T missing"
    const std::string message = error.what();
    throw UsageError(message.substr(0, message.find(':')) + ": must be followed by one value, given none");
  } catch (const CLI::ParseError& error) {
    std::string all;
    for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
    throw UsageError(argc > 1 ? error.what() : "command: must be one of " + all + "; see qdot --help");
  }
  refuse_extras(app.get_subcommands().front());

  if (list_command->parsed()) return list(list_options);
  if (run_command->parsed()) return run(run_options);
  if (accuracy_command->parsed()) return accuracy(accuracy_options);
  if (effects_command->parsed()) return effects(effects_options);
  if (equations_command->parsed()) return equations(equations_options);
  if (modes_command->parsed()) return modes(modes_options);
  if (equilibria_command->parsed()) return equilibria(equilibria_options);
  if (conserved_command->parsed()) return conserved(conserved_options);
  if (lyapunov_command->parsed()) return lyapunov(lyapunov_options);
  if (section_command->parsed()) return section(section_options);
  if (orbit_command->parsed()) return orbit(orbit_options);
  if (sensitivity_command->parsed()) return sensitivity(sensitivity_options);
  if (new_command->parsed()) return new_scene(new_options);
  if (sweep_command->parsed()) return sweep(sweep_options);
  return bench(bench_options);
}

}  // namespace

int command_line(int argc, char** argv, int (*bench)(const BenchOptions&)) {
  std::string command;
  int status = 1;
  const auto complain = [&](std::string message) {  // on one line, and without what a terminal would obey, whatever was typed
    std::replace_if(message.begin(), message.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, '?');
    std::fprintf(stderr, "qdot%s%s: %s\n", command.empty() ? "" : " ", command.c_str(), message.c_str());
  };
  try {
    status = execute(argc, argv, command, bench);
    std::cout.flush();  // of CLI11
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout)
      throw Error("standard output must take all that is printed, but did not; make room where it goes, or send it elsewhere");
    return status;
  } catch (const SceneFileError& error) {
    complain(error.what());
    std::fputs(error.details().c_str(), stderr);
    return bad_arguments;
  } catch (const UsageError& error) {
    complain(error.what());
    return bad_arguments;
  } catch (const std::bad_alloc&) {
    complain("out of memory; ask for fewer samples or coordinates");
  } catch (const std::exception& error) {
    complain(error.what());
  }
  return std::max(status, 1);
}

}  // namespace qdot::program
