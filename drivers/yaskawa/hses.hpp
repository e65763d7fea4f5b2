#pragma once
/// Yaskawa's High-Speed Ethernet Server (HSES): one UDP datagram for each request, one for its answer.
/// Little-endian; pulses, micrometres and 0.0001 degrees, as on the wire.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/wire/ordered_bytes.hpp"
#include "drivers/yaskawa/words.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/base/descriptor.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::yaskawa {

using wire::Bytes;

inline constexpr int kHsesPort = 10040;
inline constexpr std::size_t kHsesHeader = 32,
                             kHsesPayload =
                                 bounds::kHsesPayloadBytes;  ///< bytes; the protocol allows no more
inline constexpr std::uint32_t kLastBlock = 0x80000000;

/// What a request does with its command's data.
enum class HsesService : std::uint8_t {
  get_all = 0x01,
  set_all = 0x02,
  get_one = 0x0E,
  set_one = 0x10,
  read_many = 0x33,
  write_many = 0x34,
};
enum class HsesCommand : std::uint16_t {
  alarm = 0x70,
  alarm_history = 0x71,
  status = 0x72,
  job = 0x73,
  axis_names = 0x74,
  position = 0x75,
  position_error = 0x76,
  torque = 0x77,
  io = 0x78,
  register_ = 0x79,
  byte = 0x7A,
  integer = 0x7B,
  double_integer = 0x7C,
  real = 0x7D,
  text = 0x7E,
  place = 0x7F,    ///< position variable of a robot
  reset = 0x82,    ///< instance 1: alarms, 2: errors
  power = 0x83,    ///< instance 1: hold, 2: servo, 3: lock of the pendant
  cycle = 0x84,    ///< step, one cycle, continuous
  message = 0x85,  ///< a text on the pendant
  start = 0x86,
  select = 0x87,
  working_time = 0x88,
  system = 0x89,
  io_many = 0x300,
  double_many = 0x304,
};
/// `status` of an answer.
enum class HsesResult : std::uint8_t {
  done = 0,
  unknown_command = 0x08,
  wrong_element = 0x09,
  refused = 0x1F,  ///< see the added status
  no_instance = 0x28,
};

/// Instance of the system information that is about the first robot.
inline constexpr int kFirstRobot = 11;

struct HsesRequest {
  std::uint8_t division = 1;  ///< 1: robot, 2: files
  std::uint8_t id = 0;
  std::uint16_t command = 0, instance = 0;
  std::uint8_t attribute = 0, service = 0;
  std::vector<std::uint8_t> payload;
};
struct HsesReply {
  std::uint8_t division = 1, id = 0;
  std::uint32_t block = kLastBlock;
  std::uint8_t service = 0;  ///< of the request
  HsesResult result = HsesResult::done;
  std::uint16_t added = 0;  ///< added status
  std::vector<std::uint8_t> payload;
};
std::vector<std::uint8_t> encode(const HsesRequest& request);
std::vector<std::uint8_t> encode(const HsesReply& reply);
/// Nothing for what is no whole datagram of HSES.
std::optional<HsesRequest> decode_hses_request(Bytes bytes);
std::optional<HsesReply> decode_hses_reply(Bytes bytes);

struct HsesStatus {
  bool step = false, one_cycle = false, continuous = true, running = false, guarded = false, teach = false,
       play = true, remote = true;
  bool pendant_hold = false, external_hold = false, command_hold = false, alarm = false, error = false,
       servo = false;
  bool holds() const noexcept { return pendant_hold || external_hold || command_hold; }
};
struct HsesAlarm {
  std::uint32_t code = 0, data = 0, type = 0;
  std::string time;  ///< "2026/11/28 12:00"
  std::string name;
};
struct HsesPosition {
  std::uint32_t type = 0;  ///< 0: pulses, 16: base coordinates
  std::uint32_t form = 0, tool = 0, user = 0, extended = 0;
  std::array<std::int32_t, 8> values{};
};
std::vector<std::uint8_t> encode(const HsesStatus& status);
std::vector<std::uint8_t> encode(const HsesAlarm& alarm);
std::vector<std::uint8_t> encode(const HsesPosition& position);
std::optional<HsesStatus> decode_status(Bytes payload);
std::optional<HsesAlarm> decode_alarm(Bytes payload);
std::optional<HsesPosition> decode_position(Bytes payload);

/// The driver's end. Every call may wait; one thread at a time.
class Hses {
 public:
  Hses(std::string host, int port, Nanoseconds timeout)
      : host_(std::move(host)), port_(port), timeout_(timeout) {}
  /// Nothing is sent yet.
  bool open();
  void close() { socket_ = Descriptor(); }
  /// The payload of the answer; nothing: see failure(). A request without an answer is sent again twice
  /// within the timeout, with the same number.
  std::optional<std::vector<std::uint8_t>> ask(HsesCommand command, int instance, int attribute,
                                               HsesService service, Bytes payload = {});
  std::optional<HsesStatus> status();
  /// The newest active alarm; code 0: none.
  std::optional<HsesAlarm> alarm();
  /// Of the first robot, in base coordinates.
  std::optional<HsesPosition> pose();
  /// Of the first robot, 0.01 % of the rated torque of each axis.
  std::optional<std::array<std::int32_t, 8>> torque();
  /// Of the first robot, pulses of each axis.
  std::optional<HsesPosition> pulses();
  /// `count` D variables from `first` on; at most 100.
  std::optional<std::vector<std::int32_t>> doubles(int first, int count);
  bool set_double(int number, std::int32_t value);
  bool set_integer(int number, int value);
  bool set_place(int number, const HsesPosition& place);
  /// Eight signals; only network inputs may be written.
  std::optional<std::uint8_t> signals(int byte);
  bool set_signals(int byte, std::uint8_t value);
  bool hold(bool on);
  bool servo(bool on);
  /// The cycle mode: a job that is started does not stop after a line or after one pass.
  bool run_continuously();
  /// Its first line is the next one.
  bool select_job(const std::string& name);
  bool start_job();
  /// Name of the job that runs, or ran last.
  std::optional<std::string> job();
  /// Version, model or parameter version (attribute 1, 2, 3); "" if the controller does not say it.
  std::string system(int instance, int attribute);

  struct Failure {
    Cause cause = Cause::none;
    int detail = 0;
    std::string text;
  };
  const Failure& failure() const { return failure_; }

 private:
  bool set(HsesCommand command, int instance, int attribute, HsesService service, Bytes payload) {
    return ask(command, instance, attribute, service, payload).has_value();
  }
  std::optional<HsesPosition> position(int instance);
  std::nullopt_t fail(Cause cause, int detail = 0, const std::string& text = {});
  std::string host_;
  int port_;
  Nanoseconds timeout_;
  Descriptor socket_;
  std::uint8_t id_ = 0;
  Failure failure_;
};

}  // namespace polyarm::yaskawa
