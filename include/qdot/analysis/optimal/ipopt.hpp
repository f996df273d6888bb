#pragma once
// SPDX-License-Identifier: MIT
//
// The bridge to Ipopt, the only header that names it.
//
// Ipopt is an interior point method for large sparse programs (A. Wächter, L. T. Biegler, Math. Program. 106, 2006). It calls back for values and
// derivatives. An exception must not pass through it, so a callback that fails returns false, and Ipopt tries a shorter step. It prints nothing.
// Its linear solver (MUMPS in Debian's package) is one per process: solve in one thread at a time.

#include <algorithm>
#include <exception>
#include <string>
#include <vector>

#include <Eigen/Core>

#if __has_include(<coin-or/IpIpoptApplication.hpp>)
#include <coin-or/IpIpoptApplication.hpp>
#include <coin-or/IpSolveStatistics.hpp>
#include <coin-or/IpTNLP.hpp>
#elif __has_include(<coin/IpIpoptApplication.hpp>)
#include <coin/IpIpoptApplication.hpp>
#include <coin/IpSolveStatistics.hpp>
#include <coin/IpTNLP.hpp>
#else  // pkg-config's path ends in that folder
#include <IpIpoptApplication.hpp>
#include <IpSolveStatistics.hpp>
#include <IpTNLP.hpp>
#endif

#include "qdot/analysis/optimal/sparse_program.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

template <class = void>  // compiled only where it is made
class IpoptProblem final : public Ipopt::TNLP {
  using Number = Ipopt::Number;
  using Index = Ipopt::Index;

 public:
  explicit IpoptProblem(SparseProgram& program) : program_(&program), start_(program.start()) {}

  ProgramSolution solution{};

  bool get_nlp_info(Index& n, Index& m, Index& in_jacobian, Index& in_hessian, IndexStyleEnum& style) override {
    n = static_cast<Index>(start_.size());
    m = static_cast<Index>(program_->rows());
    in_jacobian = static_cast<Index>(program_->jacobian_places().size());
    in_hessian = static_cast<Index>(program_->hessian_places().size());
    style = TNLP::C_STYLE;
    return true;
  }
  bool get_bounds_info(Index n, Number* lower, Number* upper, Index m, Number* least, Number* most) override {
    const Eigen::VectorXd low = program_->lower(), high = program_->upper();
    std::copy_n(low.data(), n, lower);
    std::copy_n(high.data(), n, upper);
    std::fill_n(least, m, 0.0);
    std::fill_n(most, m, 0.0);
    return true;
  }
  bool get_starting_point(Index n, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    std::copy_n(start_.data(), n, x);
    return true;
  }
  bool eval_f(Index n, const Number* x, bool, Number& value) override {
    return answered([&] { value = program_->objective(at(n, x)); });
  }
  bool eval_grad_f(Index n, const Number* x, bool, Number* gradient) override {
    return answered([&] { std::copy_n(program_->gradient(at(n, x)).data(), n, gradient); });
  }
  bool eval_g(Index n, const Number* x, bool, Index m, Number* g) override {
    return answered([&] { std::copy_n(program_->residual(at(n, x)).data(), m, g); });
  }
  bool eval_jac_g(Index n, const Number* x, bool, Index, Index, Index* row, Index* column, Number* values) override {
    if (values == nullptr) return placed(program_->jacobian_places(), row, column);
    return answered([&] {
      const std::vector<double> found = program_->jacobian(at(n, x));
      std::copy(found.begin(), found.end(), values);
    });
  }
  bool eval_h(Index n, const Number* x, bool, Number sigma, Index m, const Number* lambda, bool, Index, Index* row, Index* column,
              Number* values) override {
    if (values == nullptr) return placed(program_->hessian_places(), row, column);
    return answered([&] {
      const std::vector<double> found = program_->hessian(at(n, x), sigma, at(m, lambda));
      std::copy(found.begin(), found.end(), values);
    });
  }
  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* x, const Number*, const Number*, Index, const Number*, const Number*, Number value,
                         const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    solution.x = at(n, x);
    solution.objective = value;
  }

  const std::string& trouble() const noexcept { return trouble_; }
  const std::exception_ptr& thrown() const noexcept { return thrown_; }

 private:
  static Eigen::VectorXd at(Index n, const Number* x) { return Eigen::Map<const Eigen::VectorXd>(x, n); }
  static bool placed(const std::vector<Place>& places, Index* row, Index* column) {
    for (const Place& place : places) {
      *row++ = static_cast<Index>(place.row);
      *column++ = static_cast<Index>(place.column);
    }
    return true;
  }
  template <class Ask>
  bool answered(const Ask& ask) {
    if (thrown_) return false;
    try {
      ask();
      return true;
    } catch (const Error& error) {
      trouble_ = error.what();
    } catch (...) {  // the user's own, which reaches the caller when Ipopt has ended
      thrown_ = std::current_exception();
    }
    return false;
  }

  SparseProgram* program_;
  Eigen::VectorXd start_;
  std::string trouble_;
  std::exception_ptr thrown_;
};

template <class = void>  // compiled only where it is called
ProgramSolution solved_by_ipopt(SparseProgram& program, const ProgramOptions& options) {
  Ipopt::SmartPtr<IpoptProblem<>> problem = new IpoptProblem<>(program);
  Ipopt::SmartPtr<Ipopt::IpoptApplication> solver = new Ipopt::IpoptApplication(false);
  solver->Options()->SetIntegerValue("print_level", 0);
  solver->Options()->SetStringValue("sb", "yes");
  solver->Options()->SetNumericValue("tol", options.tolerance);
  solver->Options()->SetIntegerValue("max_iter", options.most_iterations);
  ProgramSolution& found = problem->solution;
  found.x = program.start();
  if (solver->Initialize("") != Ipopt::Solve_Succeeded) {
    found.status = "Ipopt could not begin";
    return found;
  }
  const Ipopt::ApplicationReturnStatus status = solver->OptimizeTNLP(Ipopt::SmartPtr<Ipopt::TNLP>(Ipopt::GetRawPtr(problem)));
  if (problem->thrown()) std::rethrow_exception(problem->thrown());
  if (Ipopt::IsValid(solver->Statistics())) found.iterations = static_cast<int>(solver->Statistics()->IterationCount());
  const auto ended = [&](ProgramOutcome outcome, const char* words) {
    found.outcome = outcome;
    found.status = words;
    return found;
  };
  switch (status) {
    case Ipopt::Solve_Succeeded: return ended(ProgramOutcome::solved, "solved");
    case Ipopt::Solved_To_Acceptable_Level: return ended(ProgramOutcome::solved, "solved to Ipopt's acceptable level");
    case Ipopt::Infeasible_Problem_Detected: return ended(ProgramOutcome::infeasible, "no point meets all conditions near by");
    case Ipopt::Restoration_Failed: return ended(ProgramOutcome::infeasible, "Ipopt could not get nearer to the conditions");
    case Ipopt::Maximum_Iterations_Exceeded: return ended(ProgramOutcome::iteration_limit, "as many iterations as were allowed");
    default: break;
  }
  found.outcome = ProgramOutcome::failed;
  found.status = sentence({"Ipopt ended with status ", static_cast<int>(status)});
  if (!problem->trouble().empty()) found.status += ", and where it looked last: " + problem->trouble();
  return found;
}

}  // namespace qdot::detail
