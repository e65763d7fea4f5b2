#pragma once
/// The text format of a data set: lines of `Key: value`.
///
///   Name: Home            the name of the value that follows; without a new Name a value overwrites the last
///   Bool: True            True or False
///   Num: 10               a number; SI unless a unit is given
///   Text: cycle           the rest of the line
///   JS: elbow wrist       the joints of the Points that follow, in the order of their numbers
///   Pose: RPY             the Points that follow are x, y, z, roll, pitch, yaw (metres, radians), or with
///                         `Pose: Quaternion` x, y, z, qx, qy, qz, qw
///   Point: 0.1, 0.2       numbers separated by commas
///   Group: conveyor       the group that the name belongs to, for lists
///
/// Keys are case-insensitive. Blank lines, lines that start with #, and a # after a value other than a text
/// or a name are comments. CRLF and a byte order mark are kept.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/data/data_set.hpp"

namespace polyarm::data {

/// The meaning of the numbers of a Point.
struct PointFormat {
  enum class Form { none, joints, rpy, quaternion } form = Form::none;
  std::vector<std::string> joints;
  friend bool operator==(const PointFormat&, const PointFormat&) = default;
};

/// The text of a data file. A new value changes only its own line.
class ImportFile {
 public:
  /// Reads all valid lines and reports the others, with file, line and column.
  static ImportFile parse(std::string_view text, const std::string& file, Problems& problems);
  /// Reads the file; throws Error with all its problems.
  static ImportFile load(const std::string& path);

  const std::string& file() const { return file_; }
  /// What load() found that is probably a mistake.
  const std::vector<Problem>& warnings() const { return warnings_; }
  /// The values that parse() would read from text().
  const DataSet& values() const { return values_; }
  /// Changes the line of `name`, or appends name and value. Does nothing if the value is equal. Throws
  /// Error("cannot-keep") for a value that this format cannot hold: a list, a text with a line break.
  void set(const std::string& name, const Value& value);
  /// Puts a name of the file into a group by a line `Group:` above its value; an empty text removes it from
  /// its group. Throws Error("unknown-name"), and Error("bad-group") for an invalid group name.
  void set_group(const std::string& name, const std::string& group);
  std::string text() const;

 private:
  struct Line {
    std::string text;
    std::string ending;
  };
  struct Slot {
    std::string name;
    std::size_t line = 0;
    PointFormat format;                 ///< of a Point in this line
    std::vector<std::size_t> groups{};  ///< its `Group:` lines; the last one counts
  };
  friend class ImportReader;

  std::string block(const Value& value, const PointFormat& format, const std::string& old_line) const;
  void append(const std::string& name, const Value& value);
  Slot* slot_of(const std::string& name);
  void insert_line(std::size_t at, const std::string& text);
  void erase_line(std::size_t at);

  std::string file_;
  std::string mark_;  ///< the byte order mark, if the file has one
  std::string newline_ = "\n";
  std::vector<Line> lines_;
  std::vector<Slot> slots_;
  PointFormat last_format_;
  DataSet values_;
  std::vector<Problem> warnings_;
};

/// Throws Error("cannot-keep") if the format cannot hold this name or value.
void check_can_keep(const std::string& name, const Value& value, const std::string& file);

/// Throws Error("bad-group") unless `group` is one line of at most 64 bytes without #.
void check_group(const std::string& group);

/// A sentence that explains why `content` is not a text file (a pickle, NUL bytes), or empty.
std::optional<std::string> why_not_text(std::string_view content);

}  // namespace polyarm::data
