#pragma once
/// The part of the compiler that generates code for names, expressions and conditions. Private to the
/// compiler's files.
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "polyarm/language/operators.hpp"
#include "polyarm/program/code.hpp"

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
  /// The state while the code of one function or task is generated.
  struct Scope {
    std::vector<std::string> locals;
    std::vector<int> variables;  ///< for each local, its entry in the code's list
    Depths depths;               ///< locals are counted by `locals`
    std::vector<Loop> loops;
    std::vector<Handler> handlers;
    bool counts_passes = true;
  };
  struct Resolved {
    enum class Where { local, global, host } where = Where::host;
    int slot = -1;
    std::vector<std::string> fields;
    bool is_variable() const { return where != Where::host && fields.empty(); }
  };
  /// Releases the temporaries created during its lifetime.
  class Temporaries {
   public:
    explicit Temporaries(CodeWriter& of) : count_{of.temporaries_}, before_{count_} {}
    Temporaries(const Temporaries&) = delete;
    Temporaries& operator=(const Temporaries&) = delete;
    ~Temporaries() { count_ = before_; }

   private:
    int& count_;
    int before_;
  };

  // Steps: code_writer.cpp
  int here() const;
  int add(Op op, Place place, Step operands = {});
  void add_step(Op op, Place place, Step operands);
  int add_binary(Op op, Operator operation, Place place, Step operands);
  Step& step(int at) { return code_.steps[static_cast<std::size_t>(at)]; }
  /// Sets the jump target of the step to this place.
  void land(int step);
  void land(const std::vector<int>& steps);
  void jump_to(int target, Place place);
  Operand constant(const Value& value);
  int text(const std::string& text);
  int names(std::vector<std::string> names);
  void refuse(Place place, const OperationError& error);

  // Registers
  Depths depths() const;
  /// The number of registers in use.
  int height() const { return static_cast<int>(scope_.locals.size()) + temporaries_; }
  void need(int registers);
  /// The next free register, without taking it.
  Operand next();
  /// Takes the next free register.
  Operand temporary();
  int declare(const std::string& name);
  /// Ends all but the first `keep` locals.
  void forget(int keep);
  bool find_variable(const std::string& name, Resolved& out) const;
  /// A variable, a field of a variable, or something of the host's.
  Resolved resolve(const std::string& name) const;
  /// The location of a variable that has a value.
  Operand variable(const Resolved& resolved, Place place);

  // Expressions: code_expressions.cpp
  /// Generates code that leaves the value in some register; variables and constants are read in place.
  Operand read(const Expression& e);
  /// The same if `behind` is evaluated before the value is used.
  Operand read_before(const Expression& e, const Expression& behind);
  /// Into the next temporary, which it takes.
  Operand push(const Expression& e);
  /// Into a register or variable; the variable must not be read by `e`.
  void into(const Expression& e, Operand to);
  /// Into a variable, which keeps its type.
  void change(const Expression& e, Operand variable, Place place);
  /// True if nothing else can run while `e` is evaluated.
  bool at_once(const Expression& e) const;
  void name(const Expression& e, Operand to);
  void fields(Operand root, const std::vector<std::string>& fields, Operand to, Place place);
  Operand calculate(const Expression& e, Operand to, bool changes);
  void logic(const Expression& e, Operand to);
  void element(const Expression& e, Operand to);
  void several(const Expression& e, Operand to);
  void each(const Expression& e, Operand to);
  void append(const Expression& e, Operand variable, Place place);

  // Conditions: conditions.cpp
  /// Generates code that jumps if the condition is false (or true); adds the steps whose target must be set.
  void jump_unless(const Expression& condition, std::vector<int>& jumps);
  void jump_when(const Expression& condition, std::vector<int>& jumps);
  void compare(const Expression& e, Op first, std::vector<int>& jumps);
  /// The number under which a step caches the position of a field.
  std::uint16_t number_of_field() { return fields_++; }
  /// The values read by a condition that others can change.
  int reads(const Expression& condition);

  // Calls: code_calls.cpp
  void call(const Expression& e, Operand to);
  void call_function(const Expression& e, std::size_t which, Operand to);
  void call_builtin(const Expression& e, const Function& function, Operand to);
  void call_ask(const Expression& e, const Bound& bound, Operand to);
  void move_to(Operand to, Operand from, Place place);

  const Program& program_;
  Code code_;
  Scope scope_;
  std::unordered_map<std::string, int> globals_;
  std::unordered_map<std::string, std::size_t> function_at_;
  std::vector<bool> sure_globals_;  ///< those that certainly have a value where the present code runs
  bool all_sure_ = false;
  std::vector<const Statement*> functions_, tasks_, whens_, traps_, timers_, tests_;
  const Statement* on_stop_ = nullptr;
  const Statement* statement_ = nullptr;
  Place line_;
  bool begins_ = false;
  int registers_ = 0;  ///< needed by the present function

 private:
  struct NumberKey {
    std::uint64_t bits = 0;
    int dimension = 0;
    bool operator==(const NumberKey&) const = default;
  };
  struct NumberHash {
    std::size_t operator()(const NumberKey& key) const {
      return static_cast<std::size_t>((key.bits ^ (key.bits >> 29)) * 0x9E3779B97F4A7C15ull) ^
             static_cast<std::size_t>(key.dimension);
    }
  };
  std::unordered_map<std::string, int> text_at_;
  std::unordered_map<NumberKey, int, NumberHash> number_at_;
  std::uint16_t fields_ = 0;
  int since_last_check_ = 0;  ///< number of steps since the last budget check
  int temporaries_ = 0;
};

}  // namespace polyarm::program
