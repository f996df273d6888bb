// SPDX-License-Identifier: MIT
//
// qdot sweep: its values from closed forms, the same bits for any number of threads, and what it refuses.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "command.hpp"

using nlohmann::json;
using program_test::qdot;

namespace {

constexpr double integrated = 1e-6;  // over some seconds at the default tolerance of 1e-8

json swept(const std::string& arguments, int status = 0) {
  const auto ended = qdot("sweep " + arguments + " --json --quiet");
  INFO(ended.err);
  REQUIRE(ended.status == status);
  return json::parse(ended.out);
}

}  // namespace

TEST_CASE("a sweep over stiffness and start finds the oscillator's closed form in every cell, the first axis fastest") {
  const json found = swept("harmonic_oscillator --over k=1,4 --over q0=0.5:1.5:3 --record q0 --record 't(q0=0)' --record 'max(qdot0)' --t-end 2");
  REQUIRE(found["motions"] == 6);
  CHECK(found["over"] == json({"k", "q0"}));
  for (std::size_t i = 0; i < 6; ++i) {
    const json& row = found["rows"][i];
    const double k = row[0], start = row[1], omega = std::sqrt(k);
    CHECK(k == (i % 2 == 0 ? 1.0 : 4.0));
    CHECK(start == 0.5 + 0.5 * static_cast<double>(i / 2));
    CHECK_THAT(row[2].get<double>(), WithinAbs(start * std::cos(omega * 2.0), integrated));
    CHECK_THAT(row[3].get<double>(), WithinAbs(std::numbers::pi / (2 * omega), integrated));
    CHECK(row[5] == "completed");
  }
}

TEST_CASE("a sweep is the same bytes for one thread and four, also of a sample") {
  for (const std::string what : {"double_pendulum --over q0=-3:3:7 --over q1=-3:3:7 --record 't(|q1|=3.14159)' --t-end 3",
                                 "pendulum --random 40 --seed 5 --over 'l~normal(1,0.05)' --over 'q0~uniform(0,1)' --t-end 3"}) {
    const auto one = qdot("sweep " + what + " --json --quiet --threads 1"), four = qdot("sweep " + what + " --json --quiet --threads 4");
    CHECK(one.status == 0);
    CHECK(one.out == four.out);
  }
}

// Skokos, Bountis, Antonopoulos, Physica D 231 (2007) 30: of energy 1/8, x = 0, y = -0.25, xdot = 0.42081 is chaotic with an exponent of 0.047, y = 0.1,
// xdot = 0.49057 is regular.
TEST_CASE("a sweep knows a chaotic motion of Henon and Heiles from a regular one") {
  const json found = swept("henon_heiles --set q0=0 --set q1=-0.25 --set qdot0=0.42081 --set qdot1=0 --over q1=-0.25,0.1 --over qdot0=0.42081,0.49057 "
                           "--record gali --record lyapunov --t-end 2000");
  REQUIRE(found["motions"] == 4);
  const json &chaotic = found["rows"][0], &regular = found["rows"][3];
  CHECK(chaotic[2].get<double>() < 1e-8);
  CHECK_THAT(chaotic[3].get<double>(), WithinAbs(0.047, 0.02));  // of a run that is short for an exponent
  CHECK(regular[2].get<double>() > 1e-2);
  CHECK(regular[3].get<double>() < 0.01);
}

TEST_CASE("a quantity of a sweep that has a new name is taken by its old one, with a remark") {
  const std::string sweep = "sweep henon_heiles --over q1=0.1,0.2 --t-end 10 --quiet --json --record ";
  const auto old = qdot(sweep + "alignment"), now = qdot(sweep + "gali");
  CHECK(old.status == 0);
  CHECK(old.out == now.out);
  CHECK(old.err == "qdot sweep: --record alignment is deprecated; say --record gali\n");
}

TEST_CASE("what a motion meets stands in its cell, and the others are there") {
  const json found = swept("kepler --over qdot1=0,1 --record t --t-end 3", 1);  // without angular momentum it falls into the centre
  CHECK(found["completed"] == 1);
  CHECK(found["rows"][0][2] != "completed");
  CHECK(found["rows"][1][2] == "completed");
  const json wrong = swept("pendulum --over l=1,-1 --record q0 --t-end 1", 1);
  CHECK(wrong["rows"][0][2] == "completed");
  CHECK(wrong["rows"][1][1].is_null());
}

TEST_CASE("a sweep writes a table with a line for each motion, arrays and a page") {
  const program_test::Directory directory;
  const std::string path = directory.file("sweep");
  const auto ended = qdot("sweep pendulum --over q0=0.1:1:4 --over l=1,2,3 --t-end 1 --quiet --out " + path);
  INFO(ended.err);
  REQUIRE(ended.status == 0);
  std::ifstream csv(path + ".csv"), page(path + ".html"), arrays(path + ".npz", std::ios::binary);
  std::string line;
  std::getline(csv, line);
  CHECK(line == "q0,l,theta,outcome");
  int lines = 0;
  while (std::getline(csv, line)) ++lines;
  CHECK(lines == 12);
  std::stringstream text;
  text << page.rdbuf();
  CHECK(text.str().find("class=\"heatmap\"") != std::string::npos);
  CHECK(text.str().find("http") == std::string::npos);
  CHECK(arrays.good());
}

TEST_CASE("a page shows of a motion that failed why it did, and not what it had come to") {
  const program_test::Directory directory;
  const std::string path = directory.file("falls");  // two of four fall into the centre
  REQUIRE(qdot("sweep kepler --over qdot1=0,1 --over q0=1,1.2 --record q0 --t-end 3 --quiet --out " + path).status == 1);
  const std::string page = program_test::content(path + ".html"), table = program_test::content(path + ".csv");
  CHECK(page.find("\"values\":[null,") != std::string::npos);
  const std::string outcome = table.substr(table.find_last_of(',', table.find('\n', table.find('\n') + 1)) + 1);
  const std::string name = outcome.substr(0, outcome.find('\n'));
  CHECK(name != "completed");
  CHECK(page.find("\"remarks\":{\"0\":\"" + name + ": ") != std::string::npos);
  CHECK(page.find("Motions that failed") != std::string::npos);
  CHECK(page.find("first number 0, qdot1=0, q0=1: ") != std::string::npos);
}

TEST_CASE("a sweep that means nothing is refused by argument, rule and value") {
  CHECK(qdot("sweep four_bar --over q0=0,1 --record lyapunov").err.find("--record lyapunov: four_bar must have no constraints") != std::string::npos);
  const auto err = [](const std::string& arguments) {
    const auto ended = qdot("sweep " + arguments);
    CHECK(ended.status == 2);
    return ended.err;
  };
  CHECK(err("pendulum") == "qdot sweep: --over: must be given at least once, NAME=FROM:TO:COUNT, or NAME~normal(MEAN,SIGMA) with --random\n");
  CHECK(err("pendulum --over length=1,2")
            .find("--over: must be a parameter or initial value of pendulum, given \"length\"; the nearest is \"l\"") != std::string::npos);
  CHECK(err("pendulum --over l=1:2") == "qdot sweep: --over: must be NAME=FROM:TO:COUNT, with :log behind it or not, or NAME=A,B,C, given l=1:2\n");
  CHECK(err("pendulum --over l=-1:2:5:log").find("must go between positive numbers with :log") != std::string::npos);
  const std::string no_number = "qdot sweep: --over l: must be a finite number, given \"\"; type one such as 0.5, 1e-3, pi/2, -3*pi/4 or 90deg\n";
  CHECK(err("pendulum --over l=") == no_number);
  CHECK(err("pendulum --over q0=1,2 --over l=1,,2") == no_number);
  CHECK(err("pendulum --over l=1:2:0") == "qdot sweep: --over l: COUNT: must be a whole number from 1 to 100000000, given \"0\"\n");
  CHECK(err("pendulum --over l=0:2:3") == "qdot sweep: --over: l (length of the rod) must be positive, given 0\n");
  CHECK(err("pendulum --over l=1,2 --over l=3,4") == "qdot sweep: --over: must name each quantity once, given l twice\n");
  CHECK(err("pendulum --over l=1,2 --record speed")
            .find("--record: must be a coordinate, a velocity or a quantity of pendulum, given \"speed\"") != std::string::npos);
  CHECK(err("pendulum --over l=1,2 --record 't(event flip)'") ==
        "qdot sweep: --record t(event flip): pendulum has no contacts or dry friction, and no events; t(NAME=VALUE) is when a coordinate passes a value\n");
  CHECK(err("bouncing_ball --over g=1,2 --record 't(event nix)'") == "qdot sweep: --record t(event nix): bouncing_ball has events of floor only\n");
  CHECK(err("pendulum --random 5 --over l=1,2").find("must be NAME~uniform(A,B) or NAME~normal(MEAN,SIGMA) with --random") != std::string::npos);
  CHECK(err("pendulum --over l=1,2 --seed 3") == "qdot sweep: --seed: must stand with --random, given without\n");
  CHECK(err("pendulum --over l=1,2 --threads 0").find("--threads: must be") != std::string::npos);
}

namespace {

const std::string oscillators = "harmonic_oscillator --over k=1:4:10 --over q0=0.5:1.5:20 --record q0 --t-end 2 --quiet --out ";

/// Whether a sweep wrote what one without records writes.
void check_same(const program_test::Directory& directory, const std::string& name) {
  if (program_test::content(directory.file("plain.csv")).empty()) REQUIRE(qdot("sweep " + oscillators + directory.file("plain")).status == 0);
  for (const std::string ending : {".csv", ".npz", ".html"})
    CHECK(program_test::content(directory.file(name + ending)) == program_test::content(directory.file("plain" + ending)));
}

/// The files with records of a sweep.
std::vector<std::filesystem::path> records(const program_test::Directory& directory, const std::string& name) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(directory.file(name + ".sweep")))
    if (entry.path().extension() == ".records") files.push_back(entry.path());
  return files;
}

}  // namespace

TEST_CASE("a recorded sweep is the bytes of one that is kept in memory, by threads, processes and shares, and once more from its records") {
  const program_test::Directory directory;
  for (const std::string how : {"--resume --threads 1", "--resume --threads 3", "--processes 2", "--processes 3 --threads 2"}) {
    CHECK(qdot("sweep " + oscillators + directory.file("kept") + " " + how).status == 0);
    check_same(directory, "kept");
    std::filesystem::remove(directory.file("kept.csv"));
    const auto again = qdot("sweep " + oscillators + directory.file("kept") + " " + how);
    CHECK(again.out.find("200 of them recorded before") != std::string::npos);
    check_same(directory, "kept");
    std::filesystem::remove_all(directory.file("kept.sweep"));
  }
  for (const std::string share : {"3/3", "1/3"}) {
    const auto part = qdot("sweep " + oscillators + directory.file("shared") + " --shard " + share);
    CHECK(part.status == 0);
    CHECK(part.out.find("the share " + share + " is done; ") != std::string::npos);
    CHECK(!std::filesystem::exists(directory.file("shared.csv")));
  }
  CHECK(qdot("sweep " + oscillators + directory.file("shared") + " --shard 2/3").status == 0);
  check_same(directory, "shared");
}

TEST_CASE("a process of MPI or Slurm begins with its share and does what nobody else does") {
  const program_test::Directory directory;
  int k = 0;
  for (const std::string variables : {"OMPI_COMM_WORLD_RANK=1 OMPI_COMM_WORLD_SIZE=4", "PMI_RANK=0 PMI_SIZE=2", "SLURM_PROCID=2 SLURM_NTASKS=3",
                                      "SLURM_ARRAY_TASK_ID=17 SLURM_ARRAY_TASK_COUNT=3 SLURM_ARRAY_TASK_MIN=7 SLURM_ARRAY_TASK_STEP=5"}) {
    const std::string name = "by" + std::to_string(k++);
    CHECK(program_test::ended("/usr/bin/env", variables + " " QDOT_PROGRAM " sweep " + oscillators + directory.file(name) + " --shard auto").status == 0);
    check_same(directory, name);
  }
}

// Each would do all of it, and write the same files at the same time.
TEST_CASE("a sweep by several processes that are not told to share it is refused, and only then") {
  const program_test::Directory directory;
  const auto under = [&](const std::string& variables, const std::string& more) {
    return program_test::ended("/usr/bin/env", variables + " " QDOT_PROGRAM " sweep pendulum --over l=1,2 --t-end 1 --quiet " + more);
  };
  const std::string out = "--out " + directory.file("x");
  for (const std::string variables : {"OMPI_COMM_WORLD_RANK=0 OMPI_COMM_WORLD_SIZE=4", "PMI_RANK=3 PMI_SIZE=4", "SLURM_PROCID=1 SLURM_STEP_NUM_TASKS=4"}) {
    const auto alike = under(variables, out);
    CHECK(alike.status == 2);
    const std::string size = variables.substr(variables.find(' ') + 1, variables.size() - variables.find(' ') - 3);
    CHECK(alike.err == "qdot sweep: --shard: must be given where several processes are started together (" + size +
                           " is 4), as each would do the whole sweep and write the same files; give --out PATH --shard auto and they share it, or --shard 1/1 where each has a sweep and a PATH "
                           "of its own\n");
    CHECK(!std::filesystem::exists(directory.file("x.csv")));
  }
  for (const std::string more : {"--resume", "--processes 2", "--shard 1/1"})
    CHECK(under("OMPI_COMM_WORLD_RANK=0 OMPI_COMM_WORLD_SIZE=4", out + " " + more).status == 0);
  CHECK(under("OMPI_COMM_WORLD_RANK=0 OMPI_COMM_WORLD_SIZE=1", "").status == 0);
  CHECK(under("SLURM_PROCID=0 SLURM_NTASKS=64", "").status == 0);  // the script of a job, which is alone
}

TEST_CASE("records that were changed, cut short or lost are done again, and it is said") {
  const program_test::Directory directory;
  const std::string command = "sweep " + oscillators + directory.file("x") + " --resume";
  REQUIRE(qdot(command).status == 0);
  const auto file = records(directory, "x").at(0);
  std::string bytes = program_test::content(file.string());
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  std::ofstream(file, std::ios::binary) << bytes.substr(0, bytes.size() - 7);
  const auto again = qdot(command);
  CHECK(again.status == 0);
  CHECK(again.err == "qdot sweep: " + file.string() + " was cut short or changed in 2 places; what stood there was left out and done again\n");
  CHECK(again.out.find("198 of them recorded before") != std::string::npos);
  check_same(directory, "x");
  for (const auto& lost : records(directory, "x")) std::filesystem::remove(lost);
  CHECK(qdot(command).err.empty());
  check_same(directory, "x");
}

TEST_CASE("a sweep that finds no room keeps what it has, and goes on when there is some") {
  const program_test::Directory directory;
  const std::string arguments = " sweep " + oscillators + directory.file("x");
  for (const std::string how : {" --resume", " --processes 2"}) {
    const auto full = program_test::ended("/bin/sh", "-c \"ulimit -f 4; " QDOT_PROGRAM + arguments + how + "\"");  // 2 or 4 kB
    CHECK(full.status == 1);
    CHECK(full.err.find("the records of a sweep must be written, but ") != std::string::npos);
    CHECK(full.err.find("the same command ") != std::string::npos);
    REQUIRE(records(directory, "x").size() >= 1);
    const auto after = qdot(arguments + how);
    CHECK(after.status == 0);
    CHECK(after.out.find(" of them recorded before") != std::string::npos);
    CHECK(after.err.empty());
    check_same(directory, "x");
    std::filesystem::remove_all(directory.file("x.sweep"));
  }
}

TEST_CASE("results that cannot be written when all is recorded are written by the same command later") {
  const program_test::Directory directory;
  const std::string arguments = "sweep " + oscillators + directory.file("x") + " --resume", in_the_way = directory.file("x.csv.unfinished");
  std::filesystem::create_directory(in_the_way);
  const auto refused = qdot(arguments);
  CHECK(refused.status == 1);
  CHECK(refused.err.find("x.csv is not (Is a directory)") != std::string::npos);
  CHECK(refused.err.find("; all motions are recorded in " + directory.file("x.sweep") + ", and the same command writes the results\n") != std::string::npos);
  std::filesystem::remove(in_the_way);
  CHECK(qdot(arguments).status == 0);
  check_same(directory, "x");
}

TEST_CASE("records of another sweep are refused by what is another, and left alone") {
  const program_test::Directory directory;
  const std::string path = directory.file("x"), records_of_it = path + ".sweep";
  const auto err = [&](const std::string& arguments) {
    const auto ended = qdot("sweep " + arguments + " --quiet --out " + path);
    CHECK(ended.status == 2);
    return ended.err;
  };
  const std::string sample = "pendulum --random 20 --over 'l~normal(1,0.05)' --t-end 1 --resume";
  REQUIRE(qdot("sweep " + sample + " --set g=9.81 --quiet --out " + path).status == 0);
  CHECK(qdot("sweep " + sample + " --set g=9.810 --threads 1 --out " + path).status == 0);
  const std::string begin = "qdot sweep: --out: must go on with the sweep that is in " + records_of_it + ", but ",
                    end = "; repeat its options, or choose another --out\n";
  CHECK(err(sample + " --set g=9.81 --seed 2") == begin + "--seed was 1 and is 2" + end);
  CHECK(err(sample + " --record q0 --record t") == begin + "--set was g=9.81 and is nothing; --record was theta and is q0 t" + end);
  CHECK(
      err("pendulum --random 30 --over 'l~normal(1,0.06)' --set g=9.81 --t-end 2 --rtol 1e-6 --resume") ==
      begin +
          "--over was l~normal(1,0.05) and is l~normal(1,0.06); --random was 20 and is 30; --t-end was 1.0 and is 2.0; "
          "--rtol was 1e-08 and is 1e-06; --atol was 1e-08 and is 1e-06" +
          end);
  const auto plain = qdot("sweep pendulum --over l=1,2 --t-end 1 --out " + path);
  CHECK(plain.status == 0);
  CHECK(plain.err == "qdot sweep: " + records_of_it + " keeps records of a sweep, which are left alone; --resume goes on with them\n");
  std::filesystem::create_directory(directory.file("y.sweep"));
  std::filesystem::copy(records(directory, "x").at(0), directory.file("y.sweep") + "/other.records");
  CHECK(qdot("sweep pendulum --over l=1,2 --resume --out " + directory.file("y")).err ==
        "qdot sweep: --out: must go on with the sweep that is in " + directory.file("y.sweep") + ", but other.records there is of another; move it away\n");
  std::ofstream(records_of_it + "/manifest.json") << "{";
  CHECK(err(sample).find("/manifest.json cannot be read; choose another --out, or move ") != std::string::npos);
  std::filesystem::remove(records_of_it + "/manifest.json");
  std::filesystem::create_directory(records_of_it + "/manifest.json");
  CHECK(err(sample).find("/manifest.json cannot be read; choose another --out, or move ") != std::string::npos);
  std::filesystem::remove(records_of_it + "/manifest.json");
  std::ofstream(records_of_it + "/letter.txt") << "mine";
  CHECK(err(sample).find("must leave " + records_of_it + " to qdot, but it holds letter.txt; choose another --out") != std::string::npos);
}

TEST_CASE("a recorded sweep that means nothing is refused by argument, rule and value") {
  const program_test::Directory directory;
  const auto err = [&](const std::string& arguments) {
    const auto ended =
        program_test::ended("/usr/bin/env", "-u OMPI_COMM_WORLD_RANK -u PMI_RANK -u SLURM_PROCID -u SLURM_ARRAY_TASK_ID " QDOT_PROGRAM
                                            " sweep pendulum --over l=1,2 --out " +
                                                directory.file("x") + " " + arguments);
    CHECK(ended.status == 2);
    return ended.err;
  };
  const auto without = qdot("sweep pendulum --over l=1,2 --resume");
  CHECK(without.err == "qdot sweep: --resume: must stand with --out PATH, as records are kept in PATH.sweep, given without\n");
  CHECK(err("--processes 0").find("--processes: must be a whole number from 1 to 1024, given \"0\"") != std::string::npos);
  CHECK(err("--shard 5/4").find("--shard: must be a whole number from 1 to 4, given \"5\"") != std::string::npos);
  CHECK(err("--shard some").find("--shard: must be K/N, the K-th of N shares, or auto, given \"some\"") != std::string::npos);
  CHECK(err("--shard auto").find("--shard: auto must be started by MPI or Slurm, but of OMPI_COMM_WORLD_RANK and _SIZE") != std::string::npos);
  const auto beyond = program_test::ended(
      "/usr/bin/env", "PMI_RANK=4 PMI_SIZE=4 " QDOT_PROGRAM " sweep pendulum --over l=1,2 --out " + directory.file("x") + " --shard auto");
  CHECK(beyond.err == "qdot sweep: --shard: auto: PMI_RANK must be below PMI_SIZE, but they are 4 and 4\n");
  std::ofstream(directory.file("file.sweep")) << "";
  CHECK(err("--resume --out " + directory.file("file.sweep/x")).find("file.sweep/x.sweep cannot (Not a directory)") != std::string::npos);
  CHECK(err("--resume --out " + directory.file("file")).find("must be a path at which a directory can be made") != std::string::npos);
}
