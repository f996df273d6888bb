// SPDX-License-Identifier: MIT
//
// Many motions by the ranks of MPI are the bits of ensemble() without it. All ranks run the same tests; started by mpirun with 1, 2 and 4 of them.
#include "qdot/integrate/ensemble_mpi.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/integrate/counter_random.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/mechanics/system.hpp"

using namespace qdot;

namespace {

// MPI from the first test that needs it to the end of the program.
class Mpi {
 public:
  Mpi() {
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &size);
  }
  ~Mpi() { MPI_Finalize(); }
  int rank = 0, size = 1;
};

const Mpi& mpi() {
  static const Mpi one;
  return one;
}

template <class S>
struct Pendulum {
  S l;
  auto T(const auto& v) const { return 0.5 * l * l * v[0] * v[0]; }
  auto V(const auto& q) const {
    using std::cos;
    return -9.81 * l * cos(q[0]);
  }
};
template <class S>
Pendulum(S) -> Pendulum<S>;

State<1> start_of(std::size_t i) {
  CounterRandom random(7, i);
  return {0.0, Vector<double, 1>(random.uniform(-3.0, 3.0)), Vector<double, 1>(random.normal())};
}

// Some longer than others.
State<1> end_of(std::size_t i) {
  const Options options{.rtol = 1e-8, .keep_trajectory = false};
  const auto run = simulate(mechanical_system<1>(Pendulum{1.0 + 0.01 * static_cast<double>(i)}), start_of(i),
                            0.1 * static_cast<double>(1 + i % 9), Dop853{}, options);
  return {run.t, Vector<double, 1>(run.y[0]), Vector<double, 1>(run.y[1])};
}

bool same(const State<1>& a, const State<1>& b) { return a.t == b.t && a.q == b.q && a.qdot == b.qdot; }

// What a user keeps, and how it is sent.
struct Note {
  std::vector<std::string> words;
};
std::string to_bytes(const Note& note) {
  if (note.words.size() == 5) throw std::runtime_error("five cannot be written");
  std::string bytes;
  for (const std::string& word : note.words) bytes += word + '\n';
  return bytes;
}
void from_bytes(std::string_view bytes, Note& note) {
  for (std::size_t end = 0; (end = bytes.find('\n')) != std::string_view::npos; bytes.remove_prefix(end + 1)) note.words.emplace_back(bytes.substr(0, end));
  if (note.words.size() == 6) throw 6;
}

constexpr std::size_t count = 103;

}  // namespace

TEST_CASE("without MPI it is said that MPI is not there") {  // the first test: MPI is begun by the next
  const std::string message = error_message([] { ensemble(MpiRanks{}, 3, end_of); });
  CHECK(message.find("must be called between MPI_Init_thread() and MPI_Finalize(), but MPI is not initialized; say MPI_Init_thread(") != std::string::npos);
}

TEST_CASE("motions by ranks are the bits of one after another, on rank 0, whatever the ranks, threads and chunks") {
  const bool is_first = mpi().rank == 0;
  for (const EnsembleOptions& many : {EnsembleOptions{}, EnsembleOptions{.chunk = 1}, EnsembleOptions{.threads = 2, .chunk = 7}, EnsembleOptions{.threads = 3},
                                      EnsembleOptions{.chunk = std::numeric_limits<std::size_t>::max()}}) {
    const auto all = ensemble(MpiRanks{}, count, end_of, many);
    REQUIRE(all.size() == (is_first ? count : 0));
    std::size_t equal = 0;
    for (std::size_t i = 0; i < all.size(); ++i) equal += same(*all[i].value, end_of(i));
    CHECK(equal == all.size());
  }
  CHECK(ensemble(MpiRanks{}, 0, end_of).empty());
  CHECK(ensemble(MpiRanks{}, 2, end_of, {.threads = 2}).size() == (is_first ? 2 : 0));
}

TEST_CASE("results are on all ranks where that is asked for") {
  (void)mpi();
  const auto all = ensemble(MpiRanks{.results_on_all = true}, count, [](std::size_t i) {
    if (i == 50) throw std::runtime_error("fifty");
    return end_of(i);
  });
  REQUIRE(all.size() == count);
  for (std::size_t i = 0; i < count; ++i) CHECK((i == 50 ? all[i].message() == "fifty" : same(*all[i].value, end_of(i))));
}

TEST_CASE("a reduction sees motions in the order of their numbers, on rank 0, and its value is the same bits for all who get it") {
  const auto number = [](std::size_t i) { return 1.0 / static_cast<double>(1 + i); };
  double expected = 0.0;
  for (std::size_t i = 0; i < 5000; ++i) expected += number(i);
  for (const EnsembleOptions& many : {EnsembleOptions{.chunk = 3}, EnsembleOptions{.threads = 2, .chunk = 3}, EnsembleOptions{}})
    for (const bool on_all : {false, true}) {
      std::size_t next = 0;
      const double sum = ensemble(
          MpiRanks{.results_on_all = on_all}, 5000, number, 0.0,
          [&](double& value, std::size_t i, Kept<double>&& kept) {
            next += i == next;
            value += *kept.value;
          },
          many);
      CHECK(next == (mpi().rank == 0 ? 5000u : 0u));
      CHECK(sum == (mpi().rank == 0 || on_all ? expected : 0.0));
    }
}

TEST_CASE("what a motion throws stays with its number as its message, on whatever rank it was thrown") {
  const auto all = ensemble(MpiRanks{.results_on_all = true}, 50, [](std::size_t i) {
    if (mpi().size > 1 && i % 7 == 3) throw std::runtime_error("unlucky " + std::to_string(i));
    if (i == 14) throw 14;
    return i;
  });
  for (std::size_t i = 0; i < all.size(); ++i) {
    CHECK(all[i].completed() == (i != 14 && (mpi().size == 1 || i % 7 != 3)));
    if (i == 14) CHECK(all[i].message() == "what was thrown is no std::exception");
    else if (!all[i].completed()) CHECK(all[i].message() == "unlucky " + std::to_string(i));
    else CHECK(*all[i].value == i);
  }
}

TEST_CASE("what is kept may be numbers, strings, vectors of any length, pairs of them, and what its user turns into bytes") {
  (void)mpi();
  const MpiRanks ranks{.results_on_all = true};
  using Mixed = std::tuple<std::string, std::vector<double>, std::array<std::pair<int, Eigen::MatrixXd>, 2>, std::vector<bool>,
                           std::vector<std::vector<float>>>;
  const auto mixed = [](std::size_t i) {
    const auto k = static_cast<Eigen::Index>(i % 4);
    const auto x = static_cast<double>(i);
    return Mixed{std::string(i, 'x'),
                 std::vector<double>(i, 1.0 / x),
                 {std::pair(3, Eigen::MatrixXd(Eigen::MatrixXd::Constant(k, 2, x))), std::pair(4, Eigen::MatrixXd())},
                 std::vector<bool>(i % 5, true),
                 std::vector<std::vector<float>>(i % 3, std::vector<float>(i, 0.5f))};
  };
  const auto all = ensemble(ranks, 60, mixed, {.chunk = 4});
  for (std::size_t i = 0; i < 60; ++i) CHECK((all[i].completed() && *all[i].value == mixed(i)));

  const auto long_ones = ensemble(ranks, 9, [](std::size_t i) { return std::vector<double>(400'000, static_cast<double>(i)); },
                                  {.chunk = 1});  // beyond what MPI sends at once
  for (std::size_t i = 0; i < 9; ++i) CHECK((long_ones[i].value->size() == 400'000 && long_ones[i].value->back() == static_cast<double>(i)));

  const auto notes = ensemble(ranks, 8, [](std::size_t i) { return Note{std::vector<std::string>(i, "word")}; });
  for (std::size_t i = 0; i < 8; ++i) CHECK(notes[i].completed() == (i != 5 && i != 6));
  CHECK(notes[4].value->words == std::vector<std::string>(4, "word"));
  CHECK(notes[5].message() == "five cannot be written");
  CHECK(notes[6].message() == "what was thrown is no std::exception");
}

TEST_CASE("motions in lanes by ranks are the bits of those without, outcomes, events and messages included") {
  (void)mpi();
  const MpiRanks ranks{.results_on_all = true};
  const auto pendulum = mechanical_system<1>(Pendulum{1.0});
  const auto turns = event("turns", [](const auto& q) { return q[0] - 2.0; }).stop();
  const Options options{.rtol = 1e-9, .max_steps = 60};
  const auto starts = [](std::size_t i) {
    if (i == 20) throw std::runtime_error("no start");
    return start_of(i);
  };
  const auto here = ensemble(pendulum, count, starts, 10.0, Dop853{}, options, turns);
  for (const EnsembleOptions& many : {EnsembleOptions{}, EnsembleOptions{.threads = 2, .chunk = 10}}) {
    const auto all = ensemble(ranks, pendulum, count, starts, 10.0, Dop853{}, options, turns, many);
    REQUIRE(all.size() == count);
    int stopped = 0, out_of_steps = 0;
    for (std::size_t i = 0; i < count; ++i) {
      CHECK(all[i].message() == here[i].message());
      if (i == 20) continue;
      const auto &a = *all[i].value, &b = *here[i].value;
      CHECK((same(a.state, b.state) && a.outcome == b.outcome && a.message == b.message && a.event == b.event && a.steps == b.steps &&
             a.evaluations == b.evaluations));
      stopped += a.event == "turns";
      out_of_steps += !a.message.empty() && a.event.empty();
    }
    CHECK((stopped > 0 && out_of_steps > 0));
  }
  const auto lengths = family<1>([](const auto& p) { return Pendulum{p[0]}; },
                                 [](std::size_t i) { return Vector<double, 1>(1.0 + 0.01 * static_cast<double>(i)); });
  const auto add = [](double& sum, std::size_t, Kept<MotionEnd<1>>&& kept) { sum += kept.value->state.q[0]; };
  const double expected = ensemble(lengths, count, start_of, 2.0, Dop853{}, {}, events(), 0.0, add);
  CHECK(ensemble(ranks, lengths, count, start_of, 2.0, Dop853{}, {}, events(), 0.0, add) == expected);
}

TEST_CASE("ranks that disagree are told about what, on all of them") {
  const auto rank = static_cast<std::size_t>(mpi().rank);
  const std::string last = std::to_string(mpi().size - 1);
  const bool is_last = mpi().rank == mpi().size - 1;
  if (mpi().size > 1) {
    CHECK(error_message([&] { ensemble(MpiRanks{}, rank == 0 ? 100 : 90, end_of); }) ==
          "all ranks must call ensemble() with the same number of motions, but rank 0 says 100 and rank 1 90; send rank 0's to the others by MPI_Bcast()");
    CHECK(error_message([&] { ensemble(MpiRanks{}, 3, end_of, {.chunk = is_last ? 2u : 1u}); }) ==
          "all ranks must call ensemble() with the same EnsembleOptions::chunk, but rank 0 says 1 and rank " + last + " 2; set it to one number on all, or to 0");
    CHECK(error_message([&] {
            ensemble(MpiRanks{.results_on_all = is_last}, 3, end_of);
          }).find("the same MpiRanks::results_on_all, but rank 0 says 0 and rank " + last + " 1") != std::string::npos);
    const auto late = error_message([&] {
      ensemble(MpiRanks{}, mechanical_system<1>(Pendulum{1.0}), 3, start_of, is_last ? std::numeric_limits<double>::infinity() : 1.0, Dop853{});
    });
    CHECK(late.starts_with(is_last ? "t_end must be finite"
                                   : "all ranks must call ensemble() with valid arguments, but on rank " + last +
                                         ": t_end must be finite"));
  }
  CHECK(error_message([&] { ensemble(MpiRanks{}, 3, end_of, {.threads = is_last ? -2 : 1}); }) ==
        "the number of threads must not be negative, but is -2 on rank " + last + "; 0 means one in each rank");
  CHECK(error_message([&] {
          ensemble(MpiRanks{.communicator = MPI_COMM_NULL}, 3, end_of);
        }).starts_with("the communicator must have this rank in it, but is MPI_COMM_NULL; call "));
  struct Unsendable {
    std::optional<std::string> text;
  };
  CHECK(error_message([&] { ensemble(MpiRanks{.results_on_all = true}, 3, end_of, Unsendable{}, [](Unsendable&, std::size_t, Kept<State<1>>&&) {}); })
            .starts_with("a reduction's value must be one that can be sent for MpiRanks::results_on_all, but its type has no bytes; "));
  CHECK(ensemble(MpiRanks{.results_on_all = true}, 3, end_of).size() == 3);  // nothing of it is left
}

TEST_CASE("an intercommunicator is refused") {
  if (mpi().size < 2) return;
  MPI_Comm half, between;
  const int side = mpi().rank == 0 ? 0 : 1;
  MPI_Comm_split(MPI_COMM_WORLD, side, 0, &half);
  MPI_Intercomm_create(half, 0, MPI_COMM_WORLD, side == 0 ? 1 : 0, 3, &between);
  CHECK(error_message([&] { ensemble(MpiRanks{between}, 3, end_of); }) ==
        "the communicator must be of one group of ranks, but is an intercommunicator; make it one by MPI_Intercomm_merge()");
  MPI_Comm_free(&between);
  MPI_Comm_free(&half);
}

TEST_CASE("groups of ranks have studies of their own, and no message of the user is taken for one of them") {
  MPI_Comm half;
  MPI_Comm_split(MPI_COMM_WORLD, mpi().rank % 2, 0, &half);
  int mine = mpi().rank, theirs = -1;
  MPI_Request request;
  const int other = (mpi().rank + 1) % mpi().size;
  MPI_Isend(&mine, 1, MPI_INT, other, 1, MPI_COMM_WORLD, &request);
  const std::size_t own = 40 + static_cast<std::size_t>(mpi().rank % 2);
  const auto all = ensemble(MpiRanks{half, true}, own, end_of);
  CHECK(all.size() == own);
  for (std::size_t i = 0; i < own; ++i) CHECK(same(*all[i].value, end_of(i)));
  MPI_Recv(&theirs, 1, MPI_INT, MPI_ANY_SOURCE, 1, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
  CHECK(theirs == (mpi().rank + mpi().size - 1) % mpi().size);
  MPI_Comm_free(&half);
}

TEST_CASE("what a reduction throws ends the study on all ranks: rank 0 as it was, the others by its message") {
  const auto stop = [](int&, std::size_t i, Kept<std::size_t>&&) {
    if (i == 20) throw std::out_of_range("enough");
  };
  std::string said;
  try {
    ensemble(MpiRanks{}, 100'000, [](std::size_t i) { return i; }, 0, stop);
  } catch (const std::out_of_range& thrown) {
    said = "rank 0's: " + std::string(thrown.what());
  } catch (const Error& thrown) {
    said = thrown.what();
  }
  CHECK(said == (mpi().rank == 0 ? "rank 0's: enough" : "the study must come to its end on all ranks, but was ended on rank 0: enough"));
}

TEST_CASE("a rank that cannot go on ends the study on all, and is named") {
  const std::string last = std::to_string(mpi().size - 1);
  const auto said = error_message([&] {
    detail::RankQueue queue(MPI_COMM_WORLD, 1000, false, {}, 64, [] {});
    queue.run<int>(
        [](std::size_t begin, std::size_t end) -> std::vector<Kept<int>> {
          if (mpi().rank == mpi().size - 1) throw std::bad_alloc();
          return std::vector<Kept<int>>(end - begin, Kept<int>{7, nullptr});
        },
        [](std::size_t, auto&&) {}, false);
  });
  const std::string message = "rank " + last + " could not go on, " + std::bad_alloc().what();
  CHECK(said == (mpi().rank == 0 ? message : "the study must come to its end on all ranks, but was ended on rank 0: " + message));
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
TEST_CASE("simulate_many by MPI is ensemble by its old name") {
  static_cast<void>(mpi());
  const auto square = [](std::size_t i) { return i * i; };
  const auto all = qdot::simulate_many(MpiRanks{.results_on_all = true}, 4, square, {.chunk = 1});
  REQUIRE(all.size() == 4);
  CHECK(all[3].value == 9u);
  const auto add = [](std::size_t& sum, std::size_t, auto&& kept) { sum += *kept.value; };
  CHECK(qdot::simulate_many(MpiRanks{.results_on_all = true}, 4, square, std::size_t(0), add) == 14u);
}
#pragma GCC diagnostic pop
