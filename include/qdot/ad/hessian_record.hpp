#pragma once
// SPDX-License-Identifier: MIT
//
// Rows of blocks, and the record of all products of two velocities in one evaluation of T.
//
// T is a weighted sum of such products, T = Σ w_k u_k v_k + …, and M = Σ w_k (g_k h_kᵀ + h_k g_kᵀ) with the gradients g, h of u,
// v in q̇. The weights are known at the end only: in 0.5 * m * (x*x + y*y) the products come first. The record keeps
// what became of each product as sums with factors; one sweep from T back gives each product its weight, and the
// products are then summed block by block of M, sixteen numbers in registers at a time.

#include <algorithm>
#include <cstddef>
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

// `blocks` blocks, zero outside [first, last).
template <int blocks>
struct BlockRow {
  int first, last;
  double number[4 * blocks];

  BlockRow() = default;
  BlockRow(const BlockRow& o) : first(o.first), last(o.last) {
    copy_numbers(o);
  }
  BlockRow& operator=(const BlockRow& o) {
    first = o.first;
    last = o.last;
    copy_numbers(o);
    return *this;
  }

  double* block(int i) { return number + 4 * i; }
  const double* block(int i) const { return number + 4 * i; }

  void copy_numbers(const BlockRow& o) {
    for (int i = first; i < last; ++i) {
      Block b;
      read(b, o.block(i));
      write(block(i), b);
    }
  }
  bool empty() const { return first == last; }
  double operator[](int i) const { return i / 4 >= first && i / 4 < last ? number[i] : 0.0; }

  void clear() { first = last = 0; }
  // The unit vector e_i.
  void set_unit(int i) {
    first = i / 4;
    last = first + 1;
    for (int k = 4 * first; k < 4 * last; ++k) number[k] = k == i ? 1.0 : 0.0;
  }
  // this ← c a
  void set(double c, const BlockRow& a) {
    first = a.first;
    last = a.last;
    for (int i = first; i < last; ++i) set_block(block(i), c, a.block(i));
  }
  // this ← this + c a
  void add(double c, const BlockRow& a) {
    if (a.empty()) return;
    if (empty()) {
      set(c, a);
      return;
    }
    for (int i = a.first; i < first; ++i) write(block(i), Block{});
    for (int i = last; i < a.last; ++i) write(block(i), Block{});
    first = std::min(first, a.first);
    last = std::max(last, a.last);
    for (int i = a.first; i < a.last; ++i) add_block(block(i), c, a.block(i));
  }
  // A row of one block of zeros becomes empty. NaN is no zero.
  void drop_zero_block() {
    if (last - first != 1) return;
    const double* b = block(first);
    if (b[0] == 0.0 && b[1] == 0.0 && b[2] == 0.0 && b[3] == 0.0) last = first;
  }
};

// A stack whose first `usual` elements need no allocation. Elements are not initialized.
template <class T, int usual>
class ShortStack {
 public:
  ShortStack() = default;
  ShortStack(const ShortStack&) = delete;
  ShortStack& operator=(const ShortStack&) = delete;

  int size() const { return size_; }
  T& operator[](int i) { return data_[i]; }
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
  void grow(int capacity) {
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

template <int blocks>
class HessianRecord {
 public:
  HessianRecord() = default;
  HessianRecord(const HessianRecord&) = delete;
  HessianRecord& operator=(const HessianRecord&) = delete;

  // fl H_left + fr H_right
  int add_sum(int left, double fl, int right, double fr) { return add_node(left, fl, right, fr, -1, 0.0); }

  // ½ w (g hᵀ + h gᵀ) + fl H_left + fr H_right, where h is g when it is null.
  int add_product(double w, const BlockRow<blocks>& g, const BlockRow<blocks>* h, int left, double fl, int right, double fr) {
    const int product = rows_.size();
    rows_.push() = g;
    if (h != nullptr) rows_.push() = *h;
    return add_node(left, fl, right, fr, h != nullptr ? product | two_rows : product, w);
  }

  // M ← factor · H_root, the lower triangle, rows 4·blocks apart; what is above the diagonal has no meaning.
  void hessian(int root, double factor, double* M) {
    products_.clear();
    weights_.resize(root + 1);
    for (int k = 0; k < root; ++k) weights_[k] = 0.0;
    if (root >= 0) weights_[root] = factor;
    for (int k = root; k >= 0; --k) {
      const double w = weights_[k];
      const Node& node = nodes_[k];
      if (node.left >= 0) weights_[node.left] += w * node.fl;
      if (node.right >= 0) weights_[node.right] += w * node.fr;
      if (node.product < 0 || w == 0.0) continue;
      const BlockRow<blocks>* g = &rows_[node.product & ~two_rows];
      if ((node.product & two_rows) == 0) {
        add_weighted(g, g, w * node.weight);
      } else {
        add_weighted(g, g + 1, 0.5 * w * node.weight);
        add_weighted(g + 1, g, 0.5 * w * node.weight);
      }
    }
    for (int i = 0; i < blocks; ++i)
      for (int j = 0; j <= i; ++j) {
        Block row0{}, row1{}, row2{}, row3{};
        for (int k = 0; k < products_.size(); ++k) {
          const Product& p = products_[k];
          if (i < p.g->first || i >= p.g->last || j < p.h->first || j >= p.h->last) continue;
          Block g, h;
          read(g, p.g->block(i));
          read(h, p.h->block(j));
          g *= p.weight;
          row0 += g[0] * h;
          row1 += g[1] * h;
          row2 += g[2] * h;
          row3 += g[3] * h;
        }
        double* const at = M + 16 * blocks * i + 4 * j;
        write(at, row0);
        write(at + 4 * blocks, row1);
        write(at + 8 * blocks, row2);
        write(at + 12 * blocks, row3);
      }
  }

 private:
  struct Node {
    int left, right, product;  // −1: none
    double fl, fr, weight;
  };
  struct Product {
    const BlockRow<blocks>* g;
    const BlockRow<blocks>* h;
    double weight;
  };
  static constexpr int two_rows = 1 << 30;

  int add_node(int left, double fl, int right, double fr, int product, double weight) {
    Node& node = nodes_.push();
    node.left = left;
    node.right = right;
    node.product = product;
    node.fl = fl;
    node.fr = fr;
    node.weight = weight;
    return nodes_.size() - 1;
  }
  void add_weighted(const BlockRow<blocks>* g, const BlockRow<blocks>* h, double weight) {
    Product& p = products_.push();
    p.g = g;
    p.h = h;
    p.weight = weight;
  }

  ShortStack<Node, 32 * blocks + 16> nodes_;
  ShortStack<double, 32 * blocks + 16> weights_;
  ShortStack<BlockRow<blocks>, 12 * blocks + 8> rows_;
  ShortStack<Product, 16 * blocks + 8> products_;
};

}  // namespace qdot::detail
