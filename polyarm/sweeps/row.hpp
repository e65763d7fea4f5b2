#pragma once
/// The result of one variant: one row of the table. Columns of the database, of CSV and JSON, and the page of
/// the reference come from one list.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/sweeps/sweep.hpp"

/// TEXT(name, meaning) and NUMBER(name, meaning), in the order of the table.
#define POLYARM_SWEEP_COLUMNS(TEXT, NUMBER)                                                        \
  TEXT(key, "identifies the variant")                                                              \
  TEXT(robot, "model; empty: that of the cell")                                                    \
  NUMBER(x_m, "base in the world, m; empty: as in the cell")                                       \
  NUMBER(y_m, "the same")                                                                          \
  NUMBER(z_m, "the same")                                                                          \
  NUMBER(yaw_rad, "the same, rad")                                                                 \
  TEXT(program, "empty: that of the cell")                                                         \
  NUMBER(speed, "override, share of the programmed speed")                                         \
  TEXT(fault, "name of what fails; empty: nothing")                                                \
  NUMBER(seed, "of the deviations")                                                                \
  TEXT(given, "values of tags and variables, NAME=VALUE")                                          \
  TEXT(ended, "completed, time-up, stopped, failed or crashed")                                    \
  TEXT(code, "of the first problem")                                                               \
  TEXT(cause, "the first problem in one sentence")                                                 \
  TEXT(place, "file and line of the problem")                                                      \
  NUMBER(time_s, "cell time of the whole run, s")                                                  \
  NUMBER(cycles, "passes of the program's outermost while")                                        \
  NUMBER(parts, "parts that were put where they belong")                                           \
  NUMBER(cycle_s, "mean time of a pass without the first; or of the only one, s")                  \
  NUMBER(cycle_p95_s, "95 % of these passes take at most so long, s")                              \
  NUMBER(clearance_m,                                                                              \
         "smallest distance of the links to anything, m; negative: overlap; empty: nothing near")  \
  TEXT(clearance_a, "that link")                                                                   \
  TEXT(clearance_b, "what it came near to")                                                        \
  NUMBER(clearance_at_s, "when, s of cell time")                                                   \
  TEXT(clearance_place, "file and line of the move")                                               \
  NUMBER(tool_clearance_m, "the same of the tool and of held parts, which come near on purpose")   \
  NUMBER(path_m, "way of all TCPs, m")                                                             \
  NUMBER(speed_share, "highest commanded joint speed, share of its limit")                         \
  TEXT(speed_joint, "that joint")                                                                  \
  NUMBER(effort_share, "highest measured joint effort, share of its limit; empty without physics") \
  TEXT(effort_joint, "that joint")                                                                 \
  NUMBER(limit_m_rad, "smallest distance to the end of a joint's range, rad or m")                 \
  TEXT(limit_joint, "that joint")                                                                  \
  NUMBER(energy_j, "mechanical work of all joints, driving and braking, J; empty without physics") \
  NUMBER(out_of_reach, "points of the cell that the robot cannot reach from its base")             \
  TEXT(trace, "hash of all commands and states")                                                   \
  NUMBER(wall_s, "what the variant cost, s of wall time; not repeatable")

namespace polyarm::sweeps {

struct Row {
#define POLYARM_TEXT(name, meaning) std::string name;
#define POLYARM_NUMBER(name, meaning) std::optional<double> name;
  POLYARM_SWEEP_COLUMNS(POLYARM_TEXT, POLYARM_NUMBER)
#undef POLYARM_TEXT
#undef POLYARM_NUMBER
  bool completed() const {
    return ended == "completed";
  }
};

/// A column by name; either a text or a number.
struct Column {
  std::string name, meaning;
  std::string Row::*text = nullptr;
  std::optional<double> Row::*number = nullptr;
};
const std::vector<Column>& columns();

/// The columns of the variant; the results are empty.
Row row_of(const Variant& variant, std::string key);

/// For the result of a worker.
std::string to_json(const Row& row);
/// Empty if the text is not such a row.
std::optional<Row> row_from_json(std::string_view text);

std::string csv_head();
std::string csv_line(const Row& row);
/// The table of the columns in docs/sweeps.md.
std::string reference();

}  // namespace polyarm::sweeps
