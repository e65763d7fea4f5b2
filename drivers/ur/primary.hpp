#pragma once
/// The primary interface of the controller, TCP 30001: packages of i32 size (with itself), u8 type, body;
/// big-endian. The driver reads what the controller reports about programs, errors and its kinematics. SI
/// units.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/wire/bytes.hpp"

namespace polyarm::ur {

/// Denavit-Hartenberg parameters of the six joints: rad, m.
struct Kinematics {
  std::array<double, 6> theta{}, a{}, d{}, alpha{};
  /// False if all of them are zero: the controller says nothing of its arm.
  bool stated() const noexcept { return *this != Kinematics{}; }
  friend bool operator==(const Kinematics&, const Kinematics&) = default;
};
/// The pose of the flange in the controller's base frame: position (m) and rotation vector (rad).
std::array<double, 6> flange_pose(const Kinematics& kinematics, const std::array<double, 6>& q);

/// What arrived that the driver uses.
struct PrimaryEvent {
  enum class Kind : std::uint8_t {
    version,
    text,
    error,
    started,
    stopped,
    exception,
    kinematics,
    configuration
  } kind;
  std::string text;            ///< of the controller; a program's name; the version "5.15.0"
  int code = 0, argument = 0;  ///< of an error; line and column of an exception; major and minor of a version
  /// kinematics: of this arm, as calibrated at the factory (d of the second to fourth joint may be many
  /// metres, and the arm is where it should be all the same); configuration: of its type.
  Kinematics kinematics;
};
/// The code of an error by which the controller refuses a program because it is in local control.
inline constexpr int kReadOnly = 210;

/// Finds packages in a stream. Allocates; bounded: a package of more than bounds::kPrimaryBytes bytes breaks
/// the stream.
class PrimaryStream {
 public:
  /// Appends what was found. False: the stream is broken, until reset().
  bool feed(wire::Bytes bytes, std::vector<PrimaryEvent>& events);
  void reset() {
    buffer_.clear();
    broken_ = false;
  }

 private:
  std::vector<std::uint8_t> buffer_;
  bool broken_ = false;
};

inline constexpr std::uint8_t kRobotState = 16, kRobotMessage = 20;
inline constexpr std::uint8_t kVersionMessage = 3, kTextMessage = 0, kErrorMessage = 6, kKeyMessage = 7,
                              kExceptionMessage = 10;
/// A whole package.
std::vector<std::uint8_t> primary_package(std::uint8_t type, wire::Bytes body);
/// Messages as the controller sends them; `time`: µs.
std::vector<std::uint8_t> version_message(std::uint64_t time, int major, int minor, int bugfix);
std::vector<std::uint8_t> key_message(std::uint64_t time, const std::string& title, const std::string& text);
std::vector<std::uint8_t> error_message(std::uint64_t time, int code, int argument, int level,
                                        const std::string& text);
std::vector<std::uint8_t> exception_message(std::uint64_t time, int line, int column,
                                            const std::string& text);

}  // namespace polyarm::ur
