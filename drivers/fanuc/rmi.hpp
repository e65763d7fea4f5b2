#pragma once
/// Lines of FANUC's Remote Motion Interface (option R912): one JSON object a line, ended by CR LF. Degrees,
/// millimetres. Keys and their meaning: FANUC-CORPORATION/fanuc_driver v2.2.0, fanuc_libs/rmi. Const: any
/// thread. Allocates.
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "drivers/wire/bytes.hpp"
#include "drivers/wire/tcp.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/base/descriptor.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::fanuc {

/// A line that arrived. Members of nested objects are named with a dot: "JointAngle.J1".
struct RmiMessage {
  enum class Kind : std::uint8_t { unknown, communication, command, instruction };
  Kind kind = Kind::unknown;
  std::string name;  ///< "FRC_GetStatus"
  std::map<std::string, double, std::less<>> numbers;
  std::map<std::string, std::string, std::less<>> texts;

  bool has(std::string_view key) const { return numbers.contains(key); }
  double number(std::string_view key, double otherwise = 0) const;
  std::string text(std::string_view key) const;
  /// A number that is whole and within the range; else empty.
  std::optional<int> whole(std::string_view key, int low, int high) const;
  int error() const { return static_cast<int>(whole("ErrorID", 0, 1 << 30).value_or(0)); }
};
/// Empty: no JSON object, or more than bounds::kRmiNesting brackets within each other.
std::optional<RmiMessage> parse_rmi(std::string_view line);

/// Builds one line.
class RmiLine {
 public:
  using Group = std::span<const std::pair<const char*, double>>;
  /// `kind`: "Communication", "Command", "Instruction".
  RmiLine(std::string_view kind, std::string_view name) { text(kind, name); }
  RmiLine& text(std::string_view key, std::string_view value);
  RmiLine& number(std::string_view key, double value);
  RmiLine& group(std::string_view key, Group values);
  /// With its end.
  std::string line() const { return "{" + text_ + "}\r\n"; }

 private:
  RmiLine& put(std::string_view key, const std::string& value);
  std::string text_;
};

/// Finds lines in a stream.
class RmiLines {
 public:
  /// Calls take(line) for each whole line. False: a line is longer than bounds::kRmiLineBytes.
  template <typename Take>
  bool feed(wire::Bytes bytes, Take take) {
    buffer_.append(bytes.begin(), bytes.end());
    std::size_t begin = 0;
    for (std::size_t end; (end = buffer_.find('\n', begin)) != std::string::npos; begin = end + 1) {
      std::string_view line(buffer_.data() + begin, end - begin);
      if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
      if (line.size() > bounds::kRmiLineBytes) return false;
      if (!line.empty()) take(line);
    }
    buffer_.erase(0, begin);
    return buffer_.size() <= bounds::kRmiLineBytes;
  }
  void reset() { buffer_.clear(); }

 private:
  std::string buffer_;
};

/// What an error number of the interface means; never null.
const char* rmi_error(int id);
inline constexpr int kRmiServoOff = 2556935, kRmiNotRunning = 2556937, kRmiNotPaused = 2556938,
                     kRmiBadCommand = 2556941, kRmiFailed = 2556942, kRmiBadState = 2556943,
                     kRmiBadInstruction = 2556948, kRmiBadValue = 2556949, kRmiBadPosition = 2556951,
                     kRmiHold = 2556952, kRmiConnected = 2556954, kRmiWaitCommand = 2556955,
                     kRmiWaitInstruction = 2556956, kRmiSequence = 2556957, kRmiSpeedType = 2556958,
                     kRmiSpeedValue = 2556959, kRmiTermType = 2556960, kRmiTermValue = 2556961,
                     kRmiDestination = 2556964, kRmiVia = 2556965, kRmiPort = 2556966, kRmiProgram = 2556981,
                     kRmiToolNumber = 2556930, kRmiFrameNumber = 2556931, kRmiOverride = 2556933,
                     kRmiCannotRun = 2556934, kRmiCannotResume = 2556939, kRmiSelected = 7015,
                     kRmiInUse = 7004;

/// The driver's connection. One thread at a time.
class RmiSession {
 public:
  /// Connects, asks for the port of the session and connects there. `greeting`: the message that opens it.
  /// False: `why` holds a reason, or `error` the controller's number.
  bool open(const std::string& host, int port, const std::string& greeting, Nanoseconds timeout,
            std::string& why, int& error);
  /// Says good-bye.
  void close(Nanoseconds timeout);
  explicit operator bool() const { return static_cast<bool>(socket_); }
  int descriptor() const { return socket_.number(); }
  bool send(const RmiLine& line);
  /// Sends a request and waits for the answer of the same name. Other messages in between are dropped.
  std::optional<RmiMessage> ask(std::string_view kind, std::string_view name, const RmiLine& line,
                                Nanoseconds timeout);
  /// Takes what has arrived. False: the controller closed the connection, or sent what is no line.
  template <typename Take>
  bool poll(Take take) {
    std::array<std::uint8_t, 4096> bytes;
    for (;;) {
      const wire::Received got = wire::receive(socket_.number(), bytes);
      if (got.got == wire::Got::nothing) return true;
      const bool whole =
          got.got == wire::Got::bytes && lines_.feed(wire::Bytes(bytes).first(got.count), [&](auto line) {
            if (const auto message = parse_rmi(line)) take(*message);
          });
      if (!whole) return false;
    }
  }
  /// "9.0"
  const std::string& version() const { return version_; }

 private:
  Descriptor socket_;
  RmiLines lines_;
  std::string version_;
};

}  // namespace polyarm::fanuc
