#pragma once
// SPDX-License-Identifier: MIT
//
// A nonlinear program as a solver asks for it: of all x within bounds with g(x) within bounds, the one with the least f(x).
//
// Solvers of large ones want ∇f, the entries of ∂g/∂x that are not always zero, and those of the Hessian of σ f + Σ λ g, lower triangle. Places of
// entries are asked for once; entries at one place add up.

#include <string>
#include <vector>

#include <Eigen/Core>

namespace qdot::detail {

struct Place {
  Eigen::Index row, column;
};

class SparseProgram {
 public:
  virtual ~SparseProgram() = default;
  virtual Eigen::VectorXd lower() const = 0;  // of x
  virtual Eigen::VectorXd upper() const = 0;
  virtual Eigen::VectorXd start() const = 0;
  virtual Eigen::Index rows() const = 0;  // of g, all of which are to be zero
  virtual const std::vector<Place>& jacobian_places() const = 0;
  virtual const std::vector<Place>& hessian_places() const = 0;
  // May throw where there are no values.
  virtual double objective(const Eigen::VectorXd& x) = 0;
  virtual Eigen::VectorXd gradient(const Eigen::VectorXd& x) = 0;
  virtual Eigen::VectorXd residual(const Eigen::VectorXd& x) = 0;
  virtual std::vector<double> jacobian(const Eigen::VectorXd& x) = 0;
  virtual std::vector<double> hessian(const Eigen::VectorXd& x, double sigma, const Eigen::VectorXd& lambda) = 0;
};

enum class ProgramOutcome { solved, infeasible, iteration_limit, failed };

struct ProgramSolution {
  ProgramOutcome outcome = ProgramOutcome::failed;
  std::string status{};  // in the solver's words
  Eigen::VectorXd x{};
  double objective = 0.0;
  int iterations = 0;
};

struct ProgramOptions {
  double tolerance = 1e-9;
  int most_iterations = 500;
};

}  // namespace qdot::detail
