// SPDX-License-Identifier: MIT
//
#include "program/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <iostream>
#include <memory>
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
  add_repeatable(command, "--set", options.set,
                 "parameter or initial value (theta or q0, thetadot or qdot0), NAME=VALUE; numbers are 0.5, 1e-3, pi/2, -3*pi/4, 90deg, here and in all options");
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

// The options of each command, in the order of its --help.
void add_options(CLI::App* command, ListOptions& options) {
  command->add_option_function<std::string>(
      "SCENE", [&options](const std::string& text) { options.scene = text; }, "one of them, or a file of C++, with units and meanings; all of them without a name");
  command->add_flag("--json", options.json, "one JSON object on stdout");
}

void add_options(CLI::App* command, NewOptions& options) {
  command->add_option("NAME", options.name, "of the scene; the file is NAME.cpp")->required();
}

void add_options(CLI::App* command, RunOptions& options) {
  add_scene(command, options);
  add_text(command, "--t-end", options.t_end, "time to end at", "T");
  add_text(
      command, "--method", options.method,
      "auto (default: chooses and says why), taylor, dop853, dopri5, adams, bdf (stiff), or symplectic with a fixed step: gauss2 … gauss8, verlet, yoshida_4, blanes_moan_6 …; all in qdot list",
      "NAME");
  add_text(command, "--step", options.step, "step of a method with a fixed one (default: from --rtol, by a short pilot run)", "H");
  add_text(command, "--rtol", options.rtol, "relative tolerance of the local error (default 1e-10)", "R");
  add_text(command, "--atol", options.atol, "absolute tolerance of the local error (default 1e-10)", "A");
  add_text(command, "--accuracy", options.accuracy, "error of the whole motion; chooses both tolerances", "E");
  add_text(command, "--samples", options.samples, "rows of the table (default 500, or fewer for many coordinates)", "N");
  add_repeatable(
      command, "--compare", options.compare,
      "one more run beside it, in the same plots and picture: NAME=VALUE,… of parameters, initial values, method, step, rtol, atol, accuracy; with EFFECT[=VALUE]; without EFFECT");
  add_text(command, "--out", options.out, "write PATH.csv, PATH.npz, PATH.html and PATH.svg", "PATH");
  command->add_flag("--forces", options.forces, "arrows of the constraints' and the effects' forces in the moving picture, with --out");
  command->add_flag("--json", options.json, "one JSON object on stdout");
  command->add_flag("--quiet", options.quiet, "no progress bar");
}

void add_options(CLI::App* command, AccuracyOptions& options) {
  add_scene(command, options);
  add_text(command, "--t-end", options.t_end, "time to end at", "T");
  add_repeatable(command, "--method", options.methods, "a method to compare; all that fit without it");
  add_text(command, "--samples", options.samples, "times at which errors are measured (default 32)", "N");
  add_text(command, "--out", options.out, "write PATH.csv, PATH.html and PATH.svg", "PATH");
  command->add_flag("--quick", options.quick,
                    "fewer tolerances and shorter measurements, and of the runs only those that are the cheapest way to some accuracy");
  command->add_flag("--json", options.json, "one JSON object on stdout");
  command->add_flag("--quiet", options.quiet, "no progress line");
}

void add_options(CLI::App* command, EffectsOptions& options) {
  add_scene_name(command, options.scene);
  add_repeatable(command, "--set", options.set, "parameter or state (theta or q0, thetadot or qdot0), NAME=VALUE; numbers are 0.5, 1e-3, pi/2, -3*pi/4, 90deg");
  command->add_flag("--json", options.json, "one JSON object on stdout");
}

void add_options(CLI::App* command, EquationsOptions& options) {
  add_scene_name(command, options.scene);
  add_repeatable(command, "--set", options.set, "parameter, NAME=VALUE; what a formula does not depend on does not show");
  command->add_flag("--latex", options.latex, "for LaTeX, with amsmath");
  command->add_flag("--mathml", options.mathml, "for a page");
  add_text(command, "--c", options.c, "write q̈ and its Jacobian as a C99 file", "FILE");
}

void add_options(CLI::App* command, ModesOptions& options) {
  add_scene(command, options);
  command->add_flag("--steady", options.steady, "coordinates turn at the velocities of the start, which nothing may depend on");
  add_text(command, "--out", options.out, "write PATH.csv and PATH.html", "PATH");
  command->add_flag("--json", options.json, "one JSON object on stdout");
}

void add_options(CLI::App* command, EquilibriaOptions& options) {
  add_options(command, static_cast<ModesOptions&>(options));
  add_text(command, "--along", options.along,
           "follow the one near the start along a parameter, or an effect that is on, with what branches off: NAME=FROM:TO; --out then writes PATH.svg, too", "NAME=FROM:TO");
  add_text(command, "--show", options.show, "with --along: which coordinates are drawn, the first of them in PATH.svg", "NAME,…");
}

void add_options(CLI::App* command, ConservedOptions& options) {
  add_scene(command, options);
  command->add_flag("--json", options.json, "one JSON object on stdout");
}

void add_options(CLI::App* command, LyapunovCommandOptions& options) {
  add_scene(command, options);
  add_text(command, "--t-end", options.t_end, "time to end at (default: fifty times that of run)", "T");
  add_text(command, "--interval", options.interval, "time between orthonormalizations", "T");
  add_text(command, "--settle", options.settle, "time that is not counted (default: a tenth)", "T");
  add_text(command, "--rtol", options.rtol, "tolerance of the local error, relative and absolute (default 1e-9)", "R");
  add_text(command, "--out", options.out, "write PATH.csv and PATH.html", "PATH");
  command->add_flag("--json", options.json, "one JSON object on stdout");
  command->add_flag("--quiet", options.quiet, "no progress bar");
}

void add_options(CLI::App* command, SectionCommandOptions& options) {
  add_scene(command, options);
  add_text(command, "--plane", options.plane, "the surface: a coordinate or velocity has a value, NAME=VALUE", "NAME=VALUE");
  add_text(command, "--every", options.every, "in place of a plane: once in each period T", "T");
  add_text(command, "--direction", options.direction, "in which the plane is passed: rising (default), falling, either", "D");
  add_repeatable(command, "--angle", options.angles,
                 "a coordinate that is an angle: its plane is passed in each turn, and its values are from -pi to pi");
  add_text(command, "--count", options.count, "points of each motion (default 200)", "N");
  add_repeatable(command, "--over", options.over, "several starts: a coordinate or velocity goes through values, NAME=A:B:COUNT or NAME=A,B");
  add_text(command, "--keep-energy", options.keep_energy,
           "the velocity that is chosen such that all starts have the energy of the first", "NAME");
  add_text(command, "--show", options.show, "which two of coordinates and velocities are drawn, NAME,NAME", "X,Y");
  add_text(command, "--t-end", options.t_end, "time to end at, whether there are N points or not (default: N times that of run)", "T");
  add_text(command, "--rtol", options.rtol, "tolerance of the local error, relative and absolute (default 1e-10)", "R");
  add_text(command, "--out", options.out, "write PATH.csv, PATH.html and PATH.svg", "PATH");
  command->add_flag("--json", options.json, "one JSON object on stdout");
  command->add_flag("--quiet", options.quiet, "no progress bar");
}

void add_options(CLI::App* command, OrbitCommandOptions& options) {
  add_scene(command, options);
  add_text(command, "--period", options.period,
           "what the period is: of a drive, or a multiple; or that of one of the orbits where energy is conserved", "T");
  add_text(command, "--period-guess", options.period_guess,
           "where to begin (default: when the motion is close to its start again, early rather than late)", "T");
  add_text(command, "--hold", options.hold,
           "which orbit of a family is meant: energy (default, where it is conserved) of the start, energy=E, NAME of a coordinate, or nothing (default elsewhere)", "WHAT");
  add_text(command, "--settle", options.settle, "let the motion go on for so long, and begin there", "T");
  add_text(command, "--along", options.along,
           "follow the family: energy=FROM:TO, period=FROM:TO, or a parameter or an effect that is on; without FROM from what it is",
           "NAME=FROM:TO");
  add_text(command, "--show", options.show, "which two of coordinates and velocities are drawn, NAME,NAME", "X,Y");
  add_text(command, "--out", options.out, "write PATH.csv, PATH.html and PATH.svg", "PATH");
  command->add_flag("--json", options.json, "one JSON object on stdout");
}

void add_options(CLI::App* command, SensitivityCommandOptions& options) {
  add_scene(command, options);
  add_text(command, "--of", options.of, "which coordinates and velocities (default: all)", "NAME,…");
  add_text(command, "--to", options.to,
           "which parameters, effects that are on, and coordinates and velocities of the start (default: all)", "NAME,…");
  add_text(command, "--t-end", options.t_end, "time to end at", "T");
  add_text(command, "--method", options.method,
           "dop853 (default), dopri5, adams, bdf, and without contacts and dry friction taylor and gauss2 … gauss8", "NAME");
  add_text(command, "--step", options.step, "step of gauss2 … gauss8 (default: by --rtol and a pilot run)", "H");
  add_text(command, "--rtol", options.rtol, "tolerance of the local error, relative and absolute (default 1e-11)", "R");
  add_text(command, "--samples", options.samples, "rows of the table of the whole motion (default 400)", "N");
  add_text(command, "--out", options.out, "write PATH.csv, PATH.html and PATH.svg", "PATH");
  command->add_flag("--json", options.json, "one JSON object on stdout");
}

void add_options(CLI::App* command, SweepOptions& options) {
  add_scene(command, options);
  add_repeatable(command, "--over", options.over,
                 "what varies: NAME=FROM:TO:COUNT[:log], NAME=A,B,C, or with --random NAME~uniform(A,B), NAME~normal(MEAN,SIGMA); NAME is a parameter, an effect, a coordinate or a velocity");
  add_repeatable(command, "--record", options.record,
                 "what to keep: NAME at the end, max(NAME), min(NAME), t(NAME=VALUE) and t(|NAME|=VALUE) when first passed, t(event EVENT), energy, energy_drift_max, lyapunov (the greatest exponent), gali (the generalized alignment index of two deviations: below 1e-8 in chaos), steps, t (default: all coordinates at the end)");
  add_text(command, "--random", options.random, "a sample of so many motions in place of a grid", "N");
  add_text(command, "--seed", options.seed, "of the sample (default 1)", "S");
  add_text(command, "--threads", options.threads, "default: one for each core, and one with --processes or --shard; the results are the same", "N");
  add_text(command, "--processes", options.processes, "so many worker processes; implies --resume", "N");
  add_text(command, "--shard", options.shard,
           "K/N: only the K-th of N shares; auto: one of several processes that MPI or Slurm has started; implies --resume", "K/N");
  add_text(command, "--t-end", options.t_end, "time to end at", "T");
  add_text(command, "--method", options.method, "as for run (default auto)", "NAME");
  add_text(command, "--rtol", options.rtol, "relative tolerance of the local error (default 1e-8)", "R");
  add_text(command, "--atol", options.atol, "absolute tolerance of the local error (default that of --rtol)", "A");
  add_text(command, "--out", options.out, "write PATH.csv, PATH.npz and PATH.html", "PATH");
  command->add_flag("--resume", options.resume,
                    "record each motion in the directory PATH.sweep, and go on with what is there; to be given from the beginning");
  command->add_flag("--json", options.json, "one JSON object on stdout");
  command->add_flag("--quiet", options.quiet, "no progress bar");
}

void add_options(CLI::App* command, BenchOptions& options) {
  command->add_option_function<std::string>("NAME", [&options](const std::string& text) { options.name = text; }, "all of them without a name");
  command->add_flag("--json", options.json, "one JSON object on stdout");
  add_text(command, "--page", options.page, "write the benchmark's page of the documentation (hard)", "FILE");
}

/// A command as CLI11 knows it, and what runs it with the options that were read.
struct Command {
  CLI::App* app;
  std::function<int()> run;
};

template <class Options>
Command added_command(CLI::App& app, const char* name, const char* what, int (*run)(const Options&)) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(name, what);
  command->allow_extras();  // for refuse_extras()
  add_options(command, *options);
  return {command, [run, options] { return run(*options); }};
}

/// All commands, in the order of `qdot --help`; `bench` only where there is a function for it.
std::vector<Command> added_commands(CLI::App& app, int (*bench)(const BenchOptions&)) {
  std::vector<Command> commands = {
      added_command(app, "list", "scenes with their parameters, or one of them in detail", list),
      added_command(app, "new", "write a file with a scene of your own, to begin with", new_scene),
      added_command(app, "run", "simulate a scene", run),
      added_command(app, "accuracy", "what accuracy costs in time, with each method", accuracy),
      added_command(app, "effects", "what each effect of a scene costs", effects),
      added_command(app, "equations", "Lagrange's equations of a scene as formulas", equations),
      added_command(app, "modes", "the equilibrium near the start, its stability, frequencies and damping", modes),
      added_command(app, "equilibria", "the equilibria of a scene and their stability", equilibria),
      added_command(app, "conserved", "which momenta and energies a scene conserves, and why", conserved),
      added_command(app, "lyapunov", "how fast motions part that begin close to the start", lyapunov),
      added_command(app, "section", "where motions pass a plane, as points (Poincaré)", section),
      added_command(app, "orbit", "a periodic orbit that the start leads to, its stability, and its family", orbit),
      added_command(app, "sensitivity", "what a motion depends on: derivatives by its start and by parameters", sensitivity),
      added_command(app, "sweep", "many motions of a scene: over a grid of parameters and starts, or a random sample", sweep)};
  if (bench != nullptr) commands.push_back(added_command(app, "bench", "the project's own benchmarks", bench));
  return commands;
}

/// The command that was typed; "" where the first argument is an option, or there is none.
///
/// @throws UsageError  where there is no such command
std::string typed_command(int argc, char** argv, const std::vector<std::string>& names) {
  if (argc <= 1 || argv[1][0] == '-') return {};
  if (std::find(names.begin(), names.end(), argv[1]) == names.end()) throw unknown_name("command", "a command", argv[1], names);
  return argv[1];
}

/// Reads the arguments into the options of the command; the exit status where nothing is left to run, after --help and --version.
std::optional<int> read_arguments(CLI::App& app, int argc, char** argv, const std::vector<std::string>& names) {
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
  return std::nullopt;
}

int execute(int argc, char** argv, std::string& command_name, int (*bench)(const BenchOptions&)) {
  CLI::App app("qdot: from kinetic and potential energy to motion", "qdot");
  app.set_version_flag("--version", "qdot " QDOT_VERSION);
  app.require_subcommand(1);
  app.footer("Exit status: 0 completed, 1 the run failed, 2 bad arguments.");
  const std::vector<Command> commands = added_commands(app, bench);

  std::vector<std::string> names;
  for (const Command& command : commands) names.push_back(command.app->get_name());
  command_name = typed_command(argc, argv, names);
  if (const std::optional<int> status = read_arguments(app, argc, argv, names)) return *status;
  const auto is_parsed = [](const Command& command) { return command.app->parsed(); };
  return std::find_if(commands.begin(), commands.end(), is_parsed)->run();
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
