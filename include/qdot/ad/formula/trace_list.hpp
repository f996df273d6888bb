#pragma once
// SPDX-License-Identifier: MIT
//
// The list of operations that a traced run (ad/formula/trace.hpp) leaves behind, made ready for going through.
//
// Two runs of the compiler, with different parameters, tell literals (equal in both) from parameters, and parameters that are always equal from
// those that only happen to be. What is added to a literal zero or multiplied by a literal one is then gone, and equal steps are
// one. All of it is a guess from two examples: describes() compares an object's own run with what was assumed.

#include "qdot/ad/formula/trace.hpp"

namespace qdot::trace {

// What a run left behind, without the space that it did not need, and made ready for going through: literals are known, what is
// added to zero or multiplied by one is gone, equal steps are one.
template <int steps, int constants>
struct List {
  int raw_result = 0;
  Step raw[steps + 1] = {};             // as recorded, to be compared with an object's own run
  bool literal[constants + 1] = {};
  double value[constants + 1] = {};
  int same_as[constants + 1] = {};      // the first constant that is always equal to this one

  int count = 0, result = 0;
  Step step[steps + 1] = {};

  constexpr bool is_literal(int operand, double number) const {
    return operand < 0 && literal[-1 - operand] && value[-1 - operand] == number;
  }

  // `other` is a run with other parameters, or null.
  constexpr List(const Recording& run, const Recording* other) : raw_result(run.result) {
    bool comparable = other != nullptr && other->steps == steps && other->constants == constants && other->result == run.result;
    for (int i = 0; i < steps; ++i) {
      raw[i] = run.step[i];
      if (comparable && !(other->step[i] == raw[i])) comparable = false;
    }
    for (int k = 0; k < constants; ++k) {
      same_as[k] = k;
      value[k] = run.constant[k];
      if (!comparable || !run.exact[k]) continue;
      literal[k] = run.constant[k] == other->constant[k];
      for (int j = 0; j < k; ++j)
        if (run.exact[j] && run.constant[j] == run.constant[k] && other->constant[j] == other->constant[k]) {
          same_as[k] = same_as[j];
          break;
        }
    }
    make_steps(run.inputs);
  }

  // True when a run of an object did just this; its parameters are then its constants.
  constexpr bool describes(const Recording& run) const {
    if (run.branches || run.too_long || run.steps != steps || run.constants != constants || run.result != raw_result) return false;
    for (int i = 0; i < steps; ++i)
      if (!(run.step[i] == raw[i])) return false;
    for (int k = 0; k < constants; ++k) {
      if (literal[k] && !(run.constant[k] == value[k])) return false;
      if (!literal[k] && !(run.constant[k] == run.constant[same_as[k]])) return false;
    }
    return true;
  }

 private:
  constexpr void make_steps(int inputs) {
    constexpr int heads = 64;
    int now[steps + 1] = {};  // the operand that a recorded step has become
    int newest[heads] = {}, older[steps + 1] = {};
    for (int& h : newest) h = -1;
    const auto renamed = [&](int operand) {
      if (operand < 0) return -1 - same_as[-1 - operand];
      return operand < inputs ? operand : now[operand - inputs];
    };
    for (int i = 0; i < steps; ++i) {
      const Step s{raw[i].operation, renamed(raw[i].a), renamed(raw[i].b)};
      const Operation o = s.operation;
      if ((o == Operation::add && is_literal(s.a, 0.0)) || (o == Operation::multiply && is_literal(s.a, 1.0))) {
        now[i] = s.b;
        continue;
      }
      if (((o == Operation::add || o == Operation::subtract) && is_literal(s.b, 0.0)) ||
          ((o == Operation::multiply || o == Operation::divide) && is_literal(s.b, 1.0))) {
        now[i] = s.a;
        continue;
      }
      const auto head = static_cast<unsigned>(s.a * 7 + s.b * 13 + static_cast<int>(o)) % static_cast<unsigned>(heads);
      int equal = newest[head];
      while (equal >= 0 && !(step[equal] == s)) equal = older[equal];
      if (equal < 0) {
        equal = count++;
        step[equal] = s;
        older[equal] = newest[head];
        newest[head] = equal;
      }
      now[i] = inputs + equal;
    }
    result = renamed(raw_result);
  }
};

}  // namespace qdot::trace
