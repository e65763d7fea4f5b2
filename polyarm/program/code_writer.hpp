#pragma once
/// The part of the compiler that makes code of names and expressions; for the compiler's own files.
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/program/code.hpp"
#include "polyarm/program/operators.hpp"

namespace polyarm::program {

struct Function;
struct Bound;

class CodeWriter {
 protected:
  explicit CodeWriter(const Program& program) : program_{program} {}

  struct Loop {
    Depths body, outside;
    std::vector<int> breaks, continues;
  };
  struct Handler {
    int count_slot = 0, error_slot = 0, begin = 0;
    Depths outside;
  };
  /// What is known while the code of one function or task is made.
  struct Scope {
    std::vector<std::string> locals;
    std::vector<int> variables;  ///< of each local its entry in the code's list
    Depths depths;               ///< its locals are counted by `locals`
    std::vector<Loop> loops;
    std::vector<Handler> handlers;
    bool counts_passes = true;
  };
  struct Resolved {
    enum class Where { local, global, host } where = Where::host;
    int slot = -1;
    std::vector<std::string> fields;
  };

  int here() const;
  int add(Op op, Place place, int a = -1, int b = -1);
  void land(int step);
  void jump_to(int target, Place place);
  int constant(const Value& value);
  int text(const std::string& text);
  int names(std::vector<std::string> names);
  void refuse(Place place, const OperationError& error);
  Depths depths() const;
  int declare(const std::string& name);
  /// All but the first `keep` locals end here.
  void forget(int keep);
  bool find_variable(const std::string& name, Resolved& out) const;
  /// A variable, a field of a variable, or something of the host's.
  Resolved resolve(const std::string& name) const;
  void push_variable(const Resolved& resolved, const std::string& name, Place place);
  void expression(const Expression& e);
  void binary(const Expression& e);
  void index(const Expression& e);
  void call(const Expression& e);
  void call_function(const Expression& e, std::size_t which);
  void call_builtin(const Expression& e, const Function& function);
  void call_ask(const Expression& e, const Bound& bound);
  /// What a condition reads that others change.
  int reads(const Expression& condition);

  const Program& program_;
  Code code_;
  Scope scope_;
  std::map<std::string, int> globals_;
  std::map<std::string, int> text_at_;
  std::map<std::string, std::size_t> function_at_;
  std::vector<const Statement*> functions_, tasks_, whens_, tests_;
  const Statement* on_stop_ = nullptr;
  const Statement* statement_ = nullptr;
  Place line_;
  bool begins_ = false;
};

}  // namespace polyarm::program
