#pragma once
/// What to write instead of words of other robot and programming languages.
#include <algorithm>
#include <iterator>
#include <string_view>

#include "polyarm/base/text.hpp"

namespace polyarm::program {

struct ForeignWord {
  std::string_view word;  ///< in lower case
  const char* instead;    ///< a sentence
  std::string_view
      keyword;  ///< the statement or closing word that takes its place in the blocks; empty: none
};

namespace foreign {
inline constexpr const char* kFunction = "a function is `func NAME(A, B = 1)` … `return VALUE` … `end`";
inline constexpr const char* kEnd = "a block ends with `end`";
inline constexpr const char* kLet = "a new name is made with `let n = 3`, and changed with `set n = 4`";
inline constexpr const char* kNoModule = "a file is a program; leave this line out";
inline constexpr const char* kJoint = "a joint move is `movej P`";
inline constexpr const char* kLine = "a straight line is `movel P`";
inline constexpr const char* kArc = "an arc is `movec VIA, END`";
inline constexpr const char* kOutput = "outputs are tags of signals.yaml: `set NAME = true`";
inline constexpr const char* kInput = "inputs are tags of signals.yaml: read them by their names";
inline constexpr const char* kWait = "a time is waited with `wait 500ms`";
inline constexpr const char* kWaitFor = "a condition is waited for with `wait NAME timeout 5s`";
inline constexpr const char* kLog = "a line is printed with `log(…)`";
inline constexpr const char* kHold = "`hold \"TEXT\"` waits for a person, `stop` ends the program";
inline constexpr const char* kShift =
    "a place is shifted with `offset(P, z = 80mm)`, in the tool with `tool_offset(P, z = -50mm)`";
inline constexpr const char* kHere = "where the tool is: `here()`; the joints: `here_joints()`";
inline constexpr const char* kIk = "joints of a place: `ik(P)`; the place of joints: `fk(J)`";
inline constexpr const char* kTrap = "a signal interrupts with `trap when C` … `end`";
inline constexpr const char* kBranch = "branches are `if C` … `elif C` … `else` … `end`";
inline constexpr const char* kLoop = "loops are `while C` and `for I in 1 .. 5`; leave them with `break`";
inline constexpr const char* kStream =
    "a socket is a stream of cell.yaml: `send_text(\"NAME\", …)`, `has_line(\"NAME\")`, "
    "`next_line(\"NAME\")`";
inline constexpr const char* kText =
    "texts: `text(a)`, `number(t)`, `length(t)`, `slice(t, 2, 5)`, `find(t, \"part\")`";
inline constexpr const char* kForce = "`comply(\"z\", force = 20N)` makes the tool yield, `stiff()` ends it";

inline constexpr ForeignWord kWords[] = {
    {"def", kFunction, "func"},
    {"deffct", kFunction, "func"},
    {"proc", kFunction, "func"},
    {"function", kFunction, "func"},
    {"fn", kFunction, "func"},
    {"sub", kFunction, "func"},
    {"endproc", kEnd, "end"},
    {"endfct", kEnd, "end"},
    {"endsub", kEnd, "end"},
    {"endfunction", kEnd, "end"},
    {"fi", kEnd, "end"},
    {"next", kEnd, "end"},
    {"wend", kEnd, "end"},
    {"elseif", "a further branch is `elif C`", "elif"},
    {"elsif", "a further branch is `elif C`", "elif"},
    {"module", kNoModule, {}},
    {"endmodule", kNoModule, {}},
    {"var", kLet, {}},
    {"pers", kLet, {}},
    {"const", kLet, {}},
    {"decl", kLet, {}},
    {"global", kLet, {}},
    {"local", kLet, {}},
    {"int", kLet, {}},
    {"real", kLet, {}},
    {"float", kLet, {}},
    {"string", kLet, {}},
    {"j", kJoint, {}},
    {"l", kLine, {}},
    {"c", kArc, {}},
    {"ptp", kJoint, {}},
    {"moveabsj", kJoint, {}},
    {"sptp", kJoint, {}},
    {"servoj", kJoint, {}},
    {"lin", kLine, {}},
    {"slin", kLine, {}},
    {"movep", kLine, {}},
    {"lin_rel", kLine, {}},
    {"circ", kArc, {}},
    {"scirc", kArc, {}},
    {"spline", "a curve through points is `movel [P, Q, R], smooth`", {}},
    {"setdo", kOutput, {}},
    {"setao", kOutput, {}},
    {"setgo", kOutput, {}},
    {"reset", kOutput, {}},
    {"set_digital_out", kOutput, {}},
    {"set_standard_digital_out", kOutput, {}},
    {"set_tool_digital_out", kOutput, {}},
    {"set_configurable_digital_out", kOutput, {}},
    {"set_analog_out", kOutput, {}},
    {"set_standard_analog_out", kOutput, {}},
    {"invertdo", kOutput, {}},
    {"pulsedo", "an output is pulsed with `pulse NAME for 200ms`", {}},
    {"get_digital_in", kInput, {}},
    {"get_standard_digital_in", kInput, {}},
    {"get_tool_digital_in", kInput, {}},
    {"get_configurable_digital_in", kInput, {}},
    {"get_analog_in", kInput, {}},
    {"dinput", kInput, {}},
    {"testdi", kInput, {}},
    {"waittime", kWait, {}},
    {"sleep", kWait, {}},
    {"delay", kWait, {}},
    {"pause", kHold, {}},
    {"sync", "moves are queued and waits end by themselves: leave this line out", {}},
    {"waitdi", kWaitFor, {}},
    {"waitdo", kWaitFor, {}},
    {"waituntil", kWaitFor, {}},
    {"print", kLog, {}},
    {"printf", kLog, {}},
    {"echo", kLog, {}},
    {"tpwrite", kLog, {}},
    {"textmsg", kLog, {}},
    {"msgnotify", kLog, {}},
    {"errwrite", kLog, {}},
    {"popup", kHold, {}},
    {"halt", kHold, {}},
    {"exit", kHold, {}},
    {"quit", kHold, {}},
    {"abort", kHold, {}},
    {"range", "write `for i in 1 .. 5`", {}},
    {"len", "it is called `length(…)`", {}},
    {"dim", "it is called `length(…)`", {}},
    {"get_list_length", "it is called `length(…)`", {}},
    {"append", "a list grows with `set list = list + [value]`", {}},
    {"input", "a person answers to `ask(\"How many?\", 4)`", {}},
    {"tpreadnum", "a person answers to `ask(\"How many?\", 4)`", {}},
    {"offs", kShift, {}},
    {"reltool", kShift, {}},
    {"pose_add", kShift, {}},
    {"pose_trans", "poses are multiplied, `A * B`; a place is shifted with `offset(P, z = 80mm)`", {}},
    {"pose_inv", "it is called `inverse(…)`", {}},
    {"pose_dist", "it is called `distance(…)`", {}},
    {"point_dist", "it is called `distance(…)`", {}},
    {"interpolate_pose", "it is called `interpolate(…)`", {}},
    {"crobt", kHere, {}},
    {"cjointt", kHere, {}},
    {"get_actual_tcp_pose", kHere, {}},
    {"get_target_tcp_pose", kHere, {}},
    {"get_actual_joint_positions", kHere, {}},
    {"get_target_joint_positions", kHere, {}},
    {"get_inverse_kin", kIk, {}},
    {"get_forward_kin", kIk, {}},
    {"calcjointt", kIk, {}},
    {"calcrobt", kIk, {}},
    {"set_tcp", "the tool is chosen with `use tool NAME`", {}},
    {"set_payload", "the load is set with `use payload 2kg`", {}},
    {"gripload", "the load is set with `use payload 2kg`", {}},
    {"accset", "the acceleration is set with `use accel 50%`", {}},
    {"velset", "the speed is set with `use speed 50%`", {}},
    {"thread", "what runs at the same time is a `task NAME` … `end`", {}},
    {"switch", kBranch, {}},
    {"case", kBranch, {}},
    {"select", kBranch, {}},
    {"goto", kLoop, {}},
    {"jmp", kLoop, {}},
    {"repeat", kLoop, {}},
    {"loop", kLoop, {}},
    {"do", kLoop, {}},
    {"connect", kTrap, {}},
    {"interrupt", kTrap, {}},
    {"isignaldi", kTrap, {}},
    {"stopl", "`movel P, until C` ends a move", {}},
    {"stopj", "`movel P, until C` ends a move", {}},
    {"searchl", "a search is `movel P, until C else` … `end`", {}},
    {"socket_open", kStream, {}},
    {"socket_close", kStream, {}},
    {"socket_send_string", kStream, {}},
    {"socket_send_line", kStream, {}},
    {"socket_read_string", kStream, {}},
    {"socket_read_line", kStream, {}},
    {"socketcreate", kStream, {}},
    {"socketconnect", kStream, {}},
    {"socketsend", kStream, {}},
    {"socketreceive", kStream, {}},
    {"to_num", kText, {}},
    {"to_str", kText, {}},
    {"str_cat", "texts are joined with `+`", {}},
    {"str_sub", kText, {}},
    {"str_len", kText, {}},
    {"str_find", kText, {}},
    {"strpart", kText, {}},
    {"strlen", kText, {}},
    {"strfind", kText, {}},
    {"strtoval", kText, {}},
    {"valtostr", kText, {}},
    {"numtostr", kText, {}},
    {"str", kText, {}},
    {"force_mode", kForce, {}},
    {"end_force_mode", kForce, {}},
    {"get_tcp_force", "forces at the tool: `force()`, `wrench()`", {}},
    {"zero_ftsensor", "it is called `zero_force()`", {}},
    {"d2r", "an angle has its unit: `30deg`", {}},
    {"r2d", "an angle has its unit: `30deg`", {}},
};
}  // namespace foreign

/// Null for a word that no other language uses. Upper and lower case do not count.
inline const ForeignWord* foreign_word(std::string_view word) {
  const auto at = std::find_if(std::begin(foreign::kWords), std::end(foreign::kWords),
                               [&](const ForeignWord& each) { return equal_ignoring_case(each.word, word); });
  return at == std::end(foreign::kWords) ? nullptr : at;
}

}  // namespace polyarm::program
