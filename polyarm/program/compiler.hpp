#pragma once
/// Generates the steps of statements. Private to the compiler's files.
#include <set>
#include <string>
#include <vector>

#include "polyarm/program/code_writer.hpp"

namespace polyarm::program {

class Compiler : private CodeWriter {
 public:
  explicit Compiler(const Program& program) : CodeWriter{program} {}
  Code run();

 private:
  // The program as a whole, and blocks: code.cpp
  void add_global(const std::string& name);
  void collect(const Block& top);
  void begin_apart(const Statement& s, bool counts_passes);
  void compile_apart(const Statement& s, FunctionCode& out);
  void compile_when(const Statement& s, FunctionCode& out);
  void compile_trap(const Statement& s, FunctionCode& out);
  void compile_function(const Statement& s, FunctionCode& out);
  void compile_block(const Block& statements, bool top = false);
  void statement(const Statement& s, bool top);
  void structure(const Statement& s);
  int note_start(const Statement& s, bool top);
  void leave(const Depths& from, const Depths& to, Place place);
  void meetings_in(const Block& block, std::set<std::string>& out, std::set<std::string>& seen) const;
  void count_meetings();
  void weigh();

  // Names: code_names.cpp
  void let(const Statement& s, bool top);
  void set(const Statement& s);
  void set_part(const Statement& s, const Resolved& resolved);
  bool set_part_in_place(const Statement& s, const Resolved& resolved);
  void set_literal(const Statement& s);

  // Loops, branches, errors: code_flow.cpp
  void while_loop(const Statement& s);
  void for_loop(const Statement& s);
  void leave_loop(const Statement& s, bool breaks);
  void branches(const Statement& s);
  void give(const Statement& s);
  void try_block(const Statement& s);
  void raise(const Statement& s);
  void retry(const Statement& s);

  // Moves, waits and meetings: code_world.cpp
  void clause_value(const Clause& clause);
  void move(const Statement& s);
  void use(const Statement& s);
  void check_until(Op op, const Expression& condition, bool has_else, const Block& otherwise,
                  const Statement& s);
  void or_else(int step, bool has_else, const Block& otherwise, const Statement& s);
  void timeout(const Statement& s);
  void wait(const Statement& s, const Expression& condition);
  void wait_time(const Statement& s);
  void expect(const Statement& s);
  void ask(const Statement& s);
  void hold(const Statement& s);
  void log(const Statement& s);
  void together(const Statement& s);
  void meet(const Statement& s);
  void lock(const Statement& s);
  void pulse(const Statement& s);

  bool in_main_ = true;
  int function_ = -1;
};

}  // namespace polyarm::program
