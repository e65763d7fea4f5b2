#pragma once
/// Reports of a controller of UFACTORY, which it sends by itself over TCP: a length, then fields at fixed
/// places. Port 30001 (normal) and 30002 (rich) are for people, at about 5 Hz; port 30003 is for motion, at
/// up to 100 Hz. Newer firmware appends fields. Radians and millimetres, as on the wire.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/wire/shaper.hpp"
#include "drivers/xarm/ux.hpp"

namespace polyarm::xarm {

using wire::Seven;
using wire::Six;

inline constexpr int kNormalPort = 30001, kRichPort = 30002, kRealPort = 30003;
inline constexpr std::size_t kCommonReport = 87, kForceReport = 135, kNormalReport = 145, kRichReport = 495;
inline constexpr std::size_t kLongestReport = 2048;

enum class ReportKind : std::uint8_t { normal, rich, real };

/// What each report has.
struct Report {
  State state = State::stopped;
  Mode mode = Mode::position;
  int queued = 0;  ///< commands
  Seven position{};
  Six pose{};  ///< of the TCP: mm, roll, pitch, yaw about fixed axes
  Seven torque{};
  // With at least kForceReport bytes at port 30003: of a force sensor.
  bool has_force = false;
  Six force{};
};
/// What the reports for people have beside that.
struct SlowReport {
  std::uint8_t brakes = 0, enabled = 0;  ///< a bit for each joint
  int error = 0, warning = 0;
  Six tcp_offset{};
  double load = 0;  ///< kg
  std::array<double, 3> load_centre{};
  int collision_sensitivity = 0, teach_sensitivity = 0;
  std::array<double, 3> gravity{};
  // Of the rich report.
  int type = 0, axes = 0;
  std::string version;
  std::uint16_t inputs = 0, outputs = 0;  ///< digital signals of the control box, 0 to 7
};

std::vector<std::uint8_t> encode(const Report& report, const SlowReport& slow, ReportKind kind);
/// `bytes`: a whole report with its length. Nothing if it is too short, or a position is not finite.
std::optional<Report> decode_report(Bytes bytes, ReportKind kind);
/// Of port 30001 or 30002.
std::optional<SlowReport> decode_slow_report(Bytes bytes);

/// Cuts a stream of bytes into reports.
class ReportReader {
 public:
  /// False: a length that no report has; the connection is of no use.
  bool feed(Bytes bytes);
  std::optional<std::vector<std::uint8_t>> next();

 private:
  bool length_is_wrong() const;
  std::size_t length() const;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace polyarm::xarm
