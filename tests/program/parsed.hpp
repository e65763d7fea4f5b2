#pragma once
#include <string>

#include "polyarm/base/error.hpp"
#include "polyarm/language/parser.hpp"

namespace polyarm::program {

/// Throws Error with what is wrong, and the program.
inline Program parsed(const std::string& text) {
  Problems problems;
  Program program = parse(text, "test.script", problems);
  if (problems.has_errors()) throw Error("bad-test", problems.list().front().text() + " in\n" + text);
  return program;
}

}  // namespace polyarm::program
