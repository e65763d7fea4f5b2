#pragma once
/// A program flattened to steps with jumps, so that where it stands is one number and it can be left and
/// resumed between any two steps.
#include <vector>

#include "polyarm/program/ast.hpp"

namespace polyarm::program {

enum class Op {
  load,
  set_literal,
  set,
  let,
  move,
  wait_time,
  wait,
  ask,
  log,
  call,
  jump,         ///< to target
  jump_unless,  ///< to target where the condition is false
  for_begin,    ///< evaluates the range, makes three locals: what is run over, how far, and the loop's name
  for_next,     ///< next value, or to target
  keep_locals,  ///< forgets all but the first `locals`
  pass,         ///< end of a pass of an outermost while; to target when no more are wanted
  stop,
  finish,
};

struct Step {
  Op op;
  Place place;
  const Statement* statement = nullptr;
  const Expression* expression = nullptr;  ///< of jump_unless
  int target = -1;
  int locals = 0;
};

using Code = std::vector<Step>;

/// The steps refer into `program`, which has to outlive them unmoved.
Code flatten(const Program& program);

}  // namespace polyarm::program
