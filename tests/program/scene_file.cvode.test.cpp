// SPDX-License-Identifier: MIT
//
// Scenes in files of C++: what examples/scenes shows, and what is wrong with others.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "catch2_bridge.hpp"
#include "command.hpp"

using nlohmann::json;
using program_test::content;
using program_test::Directory;
using program_test::ended;
using program_test::qdot;

namespace {

const std::string scenes = QDOT_SOURCE_DIR "/examples/scenes";

// Compiled libraries go to a cache of the tests: beside the program, which is rebuilt when headers change, or one that is thrown away.
void keep_compiled_in(const std::string& directory) { setenv("XDG_CACHE_HOME", directory.c_str(), 1); }
void keep_compiled() { keep_compiled_in((std::filesystem::path(QDOT_PROGRAM).parent_path() / "scene-cache").string()); }

void write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

TEST_CASE("a scene in a file is a scene to all commands") {
  keep_compiled();
  const Directory directory;
  const std::string own = scenes + "/own.cpp";

  SECTION("it moves as a pendulum does") {
    // theta0 = 1 at rest, t = 10; state from an integration in quadruple precision.
    const auto run = qdot("run " + own + " --set q0=1 --t-end 10 --rtol 1e-12 --atol 1e-12 --json --out " + directory.file("own"));
    INFO(run.err);
    REQUIRE(run.status == 0);
    const json result = json::parse(run.out);
    CHECK(result["scene"] == "own");
    CHECK(result["coordinates"] == json{"theta"});
    CHECK_THAT(result["q"][0].get<double>(), WithinAbs(-0.46325276873178667, 1e-8));
    CHECK_THAT(result["qdot"][0].get<double>(), WithinAbs(2.6365495135496304, 1e-8));
    CHECK(content(directory.file("own.html")).find("<canvas") != std::string::npos);
  }
  SECTION("its parameters have ranges") {
    const auto refused = qdot("run " + own + " --set g=100.5");
    CHECK(refused.status == 2);
    CHECK(refused.err == "qdot run: --set: g (gravity) must be from 0 to 100, given 100.5\n");
    CHECK(qdot("run " + own + " --set l=0").err == "qdot run: --set: l (length of the rod) must be positive, given 0\n");
    CHECK(
        qdot("run " + own + " --set length=1").err.find("must be a parameter or initial value of own, given \"length\"; the nearest is") !=
        std::string::npos);
  }
  SECTION("it has effects") {
    // Small swings with damping: exp(−c t / 2 m l²) of the amplitude, here once more than e^-4 of it.
    const json damped = json::parse(qdot("run " + own + " --with damping=0.8 --set q0=1e-3 --t-end 10 --json").out);
    CHECK(std::abs(damped["q"][0].get<double>()) < 1.1e-3 * std::exp(-4.0));
    const json costs = json::parse(qdot("effects " + own + " --json").out);
    CHECK(costs["rows"][1]["effects"] == "damping");
  }
  SECTION("it can be looked at, by what examples/scenes/own.txt shows") {
    CHECK(ended("cd", scenes + " && '" QDOT_PROGRAM "' list own.cpp").out == content(scenes + "/own.txt"));
    CHECK(json::parse(qdot("list " + own + " --json").out)["scenes"][0]["parameters"][2]["range"] == "from 0 to 100");
    CHECK(qdot("equations " + own).out.find("= −(g/l) sin θ\n") != std::string::npos);
    CHECK(qdot("modes " + own).status == 0);
    CHECK(qdot("accuracy " + own + " --quick --quiet --t-end 1 --method dop853").status == 0);
  }
  SECTION("it is what qdot new writes, which overwrites nothing") {
    const std::string in = "cd '" + directory.file("") + "' && '" QDOT_PROGRAM "' ";
    CHECK(ended("true", "&& " + in + "new own").out == "wrote own.cpp; now: qdot run own.cpp --out out/own\n");
    CHECK(content(directory.file("own.cpp")) == content(own));
    const auto again = ended("true", "&& " + in + "new own");
    CHECK(again.status == 2);
    CHECK(again.err == "qdot new: NAME: must be that of a file that is not there yet, given own.cpp, which is\n");
    CHECK(ended("true", "&& " + in + "new two_words").status == 0);
    CHECK(content(directory.file("two_words.cpp")).find("struct TwoWords {") != std::string::npos);
    CHECK(qdot("new " + directory.file("1x")).status == 2);
  }
}

TEST_CASE("T and V are enough for a scene, and it is compiled once") {
  const Directory cache, directory;
  keep_compiled_in(cache.file(""));
  const std::string arguments = "run " + scenes + "/least.cpp --set qdot0=1 --t-end 3 --rtol 1e-12 --atol 1e-12 --json --out " + directory.file("x");
  const auto run = qdot(arguments);
  INFO(run.err);
  REQUIRE(run.status == 0);
  // ẍ = 1 − x from x = 0 with ẋ = 1.
  CHECK_THAT(json::parse(run.out)["q"][0].get<double>(), WithinAbs(1.0 - std::cos(3.0) + std::sin(3.0), 1e-10));
  CHECK(json::parse(run.out)["q"][1] == 0.0);
  const std::string page = content(directory.file("x.html"));
  CHECK(page.find("<canvas") == std::string::npos);
  CHECK(page.find("<svg") != std::string::npos);

  // What is in the cache is what runs: nothing is added to it, and it needs no compiler's output.
  namespace fs = std::filesystem;
  const auto entries = [&] { return std::distance(fs::directory_iterator(cache.file("qdot")), fs::directory_iterator()); };
  CHECK(entries() == 3);  // the library, what it depends on, and what the compiler said
  CHECK(qdot(arguments).status == 0);
  CHECK(entries() == 3);
  CHECK(qdot("run " + scenes + "/least.cpp --forces --out " + directory.file("y"))
            .err.find("with a scene that has a view, but least has plots only") != std::string::npos);
  const auto shown = qdot("list " + scenes + "/least.cpp");
  CHECK(shown.out.find("  V = ½ q₀² − q₀ + 2 q₁²\n") != std::string::npos);
  CHECK(shown.out.find("for example: qdot run " + scenes + "/least.cpp --out out/least") != std::string::npos);
}

TEST_CASE("of a file that does not compile the library's words come first, the compiler's after them") {
  const Directory directory;
  keep_compiled_in(directory.file("cache"));
  const std::string head = "#include <scenes/own_scene.hpp>\nusing namespace qdot::scenes;\n\nstruct S {\n  ";
  const std::string tail = "};\nOwnScene qdot_scene() { return runnable(Scene<S, 1>{}); }\n";
  const std::string T = "auto T(const auto& qdot) const { return 0.5 * qdot[0] * qdot[0]; }\n  ";

  write(directory.file("not_generic.cpp"), head + T + "double V(const Eigen::VectorXd& q) const { return q[0]; }\n" + tail);
  const auto words = qdot("run " + directory.file("not_generic.cpp"));
  CHECK(words.status == 2);
  CHECK(words.out.empty());
  INFO(words.err);
  CHECK(first_line(words.err).starts_with("qdot run: SCENE: must compile, given " + directory.file("not_generic.cpp") + "; "));
  CHECK(first_line(words.err).find("; line 8: qdot: the potential energy V must return the scalar type of its argument") != std::string::npos);
  CHECK(words.err.find("error: ") != std::string::npos);
  CHECK(words.err.find("All that the compiler said: " + directory.file("cache/qdot/not_generic-")) != std::string::npos);

  write(directory.file("syntax.cpp"), head + T + "auto V(const auto& q) const { return q[0] }\n" + tail);
  const auto slip = qdot("list " + directory.file("syntax.cpp"));
  CHECK(slip.status == 2);
  CHECK(first_line(slip.err).find("line 6: error: expected") != std::string::npos);
}

TEST_CASE("a file without a scene is told what it lacks") {
  const Directory directory;
  keep_compiled_in(directory.file("cache"));
  write(directory.file("empty.cpp"), "#include <cmath>\n");
  const auto empty = qdot("run " + directory.file("empty.cpp"));
  CHECK(empty.status == 2);
  CHECK(empty.err.find("must define OwnScene qdot_scene()") != std::string::npos);

  const auto absent = qdot("run " + directory.file("absent.cpp"));
  CHECK(absent.status == 2);
  CHECK(absent.err == "qdot run: SCENE: must be a name from qdot list or a file of C++, given \"" + directory.file("absent.cpp") +
                          "\", which cannot be read\n");
}

TEST_CASE("a scene that contradicts itself is refused with the reason") {
  const Directory directory;
  keep_compiled_in(directory.file("cache"));
  write(directory.file("long_start.cpp"),
        "#include <stdexcept>\n#include <memory>\nnamespace qdot::program { class RunnableScene; }\n"
        "std::unique_ptr<qdot::program::RunnableScene> qdot_scene() { throw std::runtime_error(\"start must have one number for each coordinate\"); }\n"
        "namespace qdot::program { class RunnableScene { public: virtual ~RunnableScene() = default; }; }\n");
  const auto run = qdot("run " + directory.file("long_start.cpp"));
  CHECK(run.status == 2);
  CHECK(run.err == "qdot run: SCENE: " + directory.file("long_start.cpp") + ": start must have one number for each coordinate\n");
}
