#pragma once
// SPDX-License-Identifier: MIT
//
// The record of an evaluation, and what follows from it: X L = ∂L/∂q − D ∂L/∂q̇ and M = ∂²L/∂q̇∂q̇.
//
// Each node is a sum of two others, left and right, in the sense of ad/lagrange/graded.hpp:
//
//     g = a_l g_l + a_r g_r ,    X = a_l X_l + b_l g_l + (the same of r) ,
//     H = a_l H_l + w_l g_l g_lᵀ + (the same of r) + c (g_l g_rᵀ + g_r g_lᵀ) .
//
// Swept from L back, A and B with X L = Σ A X_k + B g_k reach the leaves, where g = e_i and X = 0, so that X_i L = B_i. On the way
// M = Σ D_k g_k g_kᵀ + … collects a weight D_k for each node. Only the velocities among the nodes have such weights. Their rows g_k are computed
// forwards, R_k = ∂(weights)/∂g_k backwards as a row too, and the row R_i of a leaf is that of M. A chain of n links takes of the
// order of n² operations that way, as its equations derived by hand do; the sum of n products g gᵀ would take n³.

#include <algorithm>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>

namespace qdot::detail {

// Four numbers that are computed with at once, on every machine; in memory they are plain numbers at any alignment.
using Block = double __attribute__((vector_size(32)));

[[gnu::always_inline]] inline void read(Block& block, const double* from) { __builtin_memcpy(&block, from, sizeof block); }
[[gnu::always_inline]] inline void write(double* to, const Block& block) { __builtin_memcpy(to, &block, sizeof block); }

// to ← c from;  to ← to + c from
[[gnu::always_inline]] inline void set_block(double* to, double c, const double* from) {
  Block b;
  read(b, from);
  write(to, c * b);
}
[[gnu::always_inline]] inline void add_block(double* to, double c, const double* from) {
  Block a, b;
  read(a, to);
  read(b, from);
  write(to, a + c * b);
}

// A stack whose first `usual` elements need no allocation. Elements are not initialized.
template <class T, int usual>
class ShortStack {
 public:
  ShortStack() = default;
  ShortStack(const ShortStack&) = delete;
  ShortStack& operator=(const ShortStack&) = delete;

  int size() const { return size_; }
  T& operator[](int i) { return data_[i]; }
  const T& operator[](int i) const { return data_[i]; }
  void clear() { size_ = 0; }
  T& push() {
    if (size_ == capacity_) grow(2 * capacity_);
    return data_[size_++];
  }
  void resize(int size) {
    if (size > capacity_) grow(size);
    size_ = size;
  }

 private:
  // Not inlined where a whole pass is (graded_evaluation.hpp), once for each operation of T.
  [[gnu::cold, gnu::noinline]] void grow(int capacity) {
    std::unique_ptr<T[]> larger(new T[static_cast<std::size_t>(capacity)]);
    for (int i = 0; i < size_; ++i) larger[static_cast<std::size_t>(i)] = data_[i];
    allocated_ = std::move(larger);
    data_ = allocated_.get();
    capacity_ = capacity;
  }

  T first_[usual];
  std::unique_ptr<T[]> allocated_;
  T* data_ = first_;
  int size_ = 0;
  int capacity_ = usual;
};

struct SineAndCosine {
  double angle, sine, cosine;
};

// The last sine and cosine at each of a few nodes: T and V of a chain ask for those of each coordinate three times.
template <int places>
class KnownAngles {
  static_assert((places & (places - 1)) == 0);

 public:
  KnownAngles() {
    for (SineAndCosine& place : places_) place.angle = std::numeric_limits<double>::quiet_NaN();
  }
  SineAndCosine& known(int node) { return places_[node & (places - 1)]; }

 private:
  SineAndCosine places_[places];
};

template <int blocks>
class HessianRecord : public KnownAngles<blocks <= 1 ? 4 : blocks <= 2 ? 8 : blocks <= 4 ? 16 : 32> {
 public:

  // The nodes 0 … n − 1 are the coordinates.
  explicit HessianRecord(int n) : leaves_(n) {}
  HessianRecord(const HessianRecord&) = delete;
  HessianRecord& operator=(const HessianRecord&) = delete;

  // The node of u v, or of u + sign v, of values on different nodes.
  template <class Value>
  [[gnu::always_inline]] int add_product(const Value& u, const Value& v) {
    return add(u.node, v.value * u.a, v.value * u.b - v.rate * u.a, v.value * u.w, v.node, u.value * v.a, u.value * v.b - u.rate * v.a,
               u.value * v.w, u.a * v.a);
  }
  template <class Value>
  [[gnu::always_inline]] int add_sum(const Value& u, const Value& v, double sign) {
    return add(u.node, u.a, u.b, u.w, v.node, sign * v.a, sign * v.b, sign * v.w, 0.0);
  }

  bool is_leaf(int node) const { return node < leaves_; }

  // A node and a factor c with c g = Σ J_i e_i over first ≤ i < last, and X = 0; −1 where J is zero.
  int add_row(const double* J, int first, int last, double& c) {
    int node = -1;
    for (int i = first; i < std::min(last, leaves_); ++i) {
      if (J[i] == 0.0) continue;
      if (node >= 0) {
        node = add(node, c, 0.0, 0.0, i, J[i], 0.0, 0.0, 0.0);
        c = 1.0;
      } else {
        node = i;
        c = J[i];
      }
    }
    return node;
  }

  // X L into r; M, rows 4·blocks apart, of which what is above the diagonal has no meaning. L = (a, b, w) of a node.
  void equations(int root, double a, double b, double w, double* M, double* r) {
    const int end = std::max(root + 1, leaves_);
    sums_.resize(end);
    for (int k = 0; k < end; ++k) sums_[k] = {0.0, 0.0, 0.0, 0, -1};
    if (root >= 0) sums_[root] = {a, b, w, w != 0.0, -1};
    for (int k = end - 1; k >= leaves_; --k) {
      const Node& node = nodes_[k - leaves_];
      const double A = sums_[k].a, B = sums_[k].b;
      const int needed = sums_[k].needed | (node.cross != 0.0);
      Sums& left = sums_[node.left];
      left.a += A * node.la;
      left.b += A * node.lb + B * node.la;
      left.d += A * node.lw;
      left.needed |= needed | (node.lw != 0.0);
      Sums& right = sums_[node.right];
      right.a += A * node.ra;
      right.b += A * node.rb + B * node.ra;
      right.d += A * node.rw;
      right.needed |= needed | (node.rw != 0.0);
    }
    for (int i = 0; i < leaves_; ++i) {
      r[i] = sums_[i].b;
      double* const row = M + stride * i;
      for (int j = 0; j < i / 4; ++j) write(row + 4 * j, Block{});
      Block e;
      set_unit(e, i);
      write(row + 4 * (i / 4), sums_[i].d * e);
    }
    rows_.clear();
    for (int k = leaves_; k < end; ++k)
      if (sums_[k].needed) set_row(k);
    for (int k = leaves_; k < end; ++k) {
      const Node& node = nodes_[k - leaves_];
      if (node.cross == 0.0) continue;
      const double c = sums_[k].a * node.cross;
      add_gradient(node.left, c, node.right, M);
      add_gradient(node.right, c, node.left, M);
    }
    for (int k = end - 1; k >= leaves_; --k) {
      if (!sums_[k].needed) continue;
      const Node& node = nodes_[k - leaves_];
      const Row& row = rows_[sums_[k].row];
      add_weights(node.left, node.la, row, M);
      add_weights(node.right, node.ra, row, M);
    }
  }

 private:
  static constexpr int stride = 4 * blocks;

  [[gnu::always_inline]] int add(int left, double la, double lb, double lw, int right, double ra, double rb, double rw, double cross) {
    Node& node = nodes_.push();
    node = {left, right, la, lb, lw, ra, rb, rw, cross};
    return leaves_ + nodes_.size() - 1;
  }

  struct Node {
    int left, right;
    double la, lb, lw, ra, rb, rw, cross;
  };
  struct Sums {
    double a, b, d;
    int needed, row;
  };
  // g and R of a node, zero and of no interest from block `last` on.
  struct Row {
    int last;
    double g[stride], R[stride];
  };

  int last_block(int k) const { return k < leaves_ ? k / 4 + 1 : rows_[sums_[k].row].last; }

  // e_k within its block. Numbers that are read in blocks are also written in blocks: a processor waits for a write that it finds in pieces.
  [[gnu::always_inline]] static void set_unit(Block& e, int k) {
    static constexpr double numbers[7] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
    read(e, numbers + 3 - k % 4);
  }
  static void add_unit(double* to, double c, int k) {
    Block b, e;
    set_unit(e, k);
    read(b, to + 4 * (k / 4));
    write(to + 4 * (k / 4), b + c * e);
  }
  // to ← to + c g_k in the first `last` blocks
  void add_row(double* to, double c, int k, int last) const {
    if (k < leaves_) {
      if (k < 4 * last) add_unit(to, c, k);
    } else {
      const Row& row = rows_[sums_[k].row];
      for (int j = 0; j < std::min(last, row.last); ++j) add_block(to + 4 * j, c, row.g + 4 * j);
    }
  }
  void set_row(int k) {
    const Node& node = nodes_[k - leaves_];
    const int last = std::max(last_block(node.left), last_block(node.right));
    sums_[k].row = rows_.size();
    Row& row = rows_.push();
    row.last = last;
    int from = node.left, other = node.right;
    double c = node.la, c_other = node.ra;
    if (from < leaves_) {
      std::swap(from, other);
      std::swap(c, c_other);
    }
    int set = 0;
    if (from >= leaves_) {
      const Row& first = rows_[sums_[from].row];
      for (; set < first.last; ++set) set_block(row.g + 4 * set, c, first.g + 4 * set);
      for (; set < last; ++set) write(row.g + 4 * set, Block{});
    } else {
      for (; set < last; ++set) write(row.g + 4 * set, Block{});
      add_unit(row.g, c, from);
    }
    add_row(row.g, c_other, other, last);
    const double d = sums_[k].d;
    for (int j = 0; j < last; ++j) set_block(row.R + 4 * j, d, row.g + 4 * j);
  }
  double* weights_of(int k, double* M) { return k < leaves_ ? M + stride * k : rows_[sums_[k].row].R; }
  void add_gradient(int k, double c, int of, double* M) { add_row(weights_of(k, M), c, of, last_block(k)); }
  void add_weights(int k, double c, const Row& row, double* M) {
    double* const to = weights_of(k, M);
    const int last = last_block(k);
    for (int j = 0; j < last; ++j) add_block(to + 4 * j, c, row.R + 4 * j);
  }

  int leaves_;
  ShortStack<Node, 40 * blocks + 24> nodes_;
  ShortStack<Sums, 44 * blocks + 24> sums_;
  ShortStack<Row, 8 * blocks + 8> rows_;
};

}  // namespace qdot::detail
