#pragma once
/// The text form of a data set: lines of `Key: value`.
///
///   Name: Home            the name of the value that follows; without a new Name a value overwrites the last
///   Bool: True            True or False
///   Num: 10               a number, SI unless it says a unit
///   Text: cycle           the rest of the line
///   JS: elbow wrist       the joints of the Points that follow, in the order of their numbers
///   Pose: RPY             the Points that follow are x, y, z, roll, pitch, yaw (metres, radians), or with
///                         `Pose: Quaternion` x, y, z, qx, qy, qz, qw
///   Point: 0.1, 0.2       numbers between commas
///   Group: conveyor       the group that the name belongs to, for lists
///
/// Keys are read in any case. Blank lines, lines that start with #, and a # after a value other than a text
/// or a name are comments. CRLF and a byte order mark are kept.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/data/data_set.hpp"

namespace polyarm::data {

/// How the numbers of a Point are meant.
struct PointFormat {
  enum class Form { none, joints, rpy, quaternion } form = Form::none;
  std::vector<std::string> joints;
  friend bool operator==(const PointFormat&, const PointFormat&) = default;
};

/// A data file that is held as its text, so that changing a value changes only that value's line.
class ImportFile {
 public:
  /// Reads everything that is right and reports everything that is not, with file, line and column.
  static ImportFile parse(std::string_view text, const std::string& file, Problems& problems);
  /// Reads the file; throws Error with every problem of it.
  static ImportFile load(const std::string& path);

  const std::string& file() const { return file_; }
  /// The values as a reader of text() would get them.
  const DataSet& values() const { return values_; }
  /// Changes the line of `name`, or appends name and value. Nothing changes where the value is equal.
  /// Throws Error("cannot-keep") for a value that this form cannot hold: a list, a text with a line break.
  void set(const std::string& name, const Value& value);
  /// Puts a name of the file into a group by a line `Group:` over its value; an empty text: into none. Throws
  /// Error("unknown-name"), and Error("bad-group") for a text that is no name of a group.
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
    PointFormat format;                 ///< that a Point in this line has
    std::vector<std::size_t> groups{};  ///< its lines `Group:`, the last one counts
  };
  friend class ImportReader;

  std::string block(const Value& value, const PointFormat& format, const std::string& old_line) const;
  void append(const std::string& name, const Value& value);
  Slot* slot_of(const std::string& name);
  void insert_line(std::size_t at, const std::string& text);
  void erase_line(std::size_t at);

  std::string file_;
  std::string mark_;  ///< the byte order mark, where the file has one
  std::string newline_ = "\n";
  std::vector<Line> lines_;
  std::vector<Slot> slots_;
  PointFormat last_format_;
  DataSet values_;
};

/// Throws Error("cannot-keep") where the form has no place for this name or value.
void check_can_keep(const std::string& name, const Value& value, const std::string& file);

/// Throws Error("bad-group") where `group` is no name of a group: one line of at most 64 bytes without #.
void check_group(const std::string& group);

/// A sentence why `content` is no text file (a pickle, NUL bytes), or nothing.
std::optional<std::string> why_not_text(std::string_view content);

}  // namespace polyarm::data
