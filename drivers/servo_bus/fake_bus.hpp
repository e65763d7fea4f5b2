#pragma once
/// A simulated far side for tests and for trying an arm without hardware: servos with register tables behind
/// a pty, with the same answers as a real bus. It implements the protocols independently of the driver, so
/// that an error of the driver cannot hide.
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "drivers/servo_bus/registers.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::servo_bus {

enum class Wire { feetech, dynamixel };

/// Line faults. `next_…` count down with each answer.
struct Mischief {
  bool echo = false;                  ///< the adapter echoes its input
  std::vector<std::uint8_t> garbage;  ///< before each answer
  std::set<int> silent;               ///< these servos do not answer
  int next_lose_byte = 0;             ///< number of answers that lack a byte in the middle
  int next_extra_byte = 0;            ///< number of answers with an additional byte in the middle
  int next_wrong_checksum = 0;        ///< number of answers with a wrong checksum
  int next_wrong_id = 0;              ///< number of answers from id + 100
  int next_late = 0;                  ///< number of answers that come only after the next instruction
  int next_pieces = 0;                ///< number of answers that come byte by byte
};

/// Number of bytes in each direction.
struct Traffic {
  std::uint64_t instructions = 0, answers = 0;
};

/// Servos on a pty, served by a thread. With each instruction on the bus, servos move towards their goals by
/// `step`. So the result depends on the traffic, not on the clock.
class FakeBus {
 public:
  /// `link`: a path to link to the pty; may be empty. Throws Error("fake-failed").
  FakeBus(Wire wire, std::vector<int> ids, const std::string& link = {});
  ~FakeBus();
  FakeBus(const FakeBus&) = delete;
  FakeBus& operator=(const FakeBus&) = delete;

  const std::string& path() const { return path_; }
  void set(int id, const Register& reg, std::int32_t value);
  std::int32_t get(int id, const Register& reg);
  /// Waits until `is` accepts the value of the register, which traffic or the servos' watchdogs may change.
  /// Returns false after a minute.
  bool wait(int id, const Register& reg, const std::function<bool(std::int32_t)>& is);
  /// Waits for this total number of instructions; false after a minute.
  bool wait_for_instructions(std::uint64_t count);
  /// Every value written to the register of that servo, in order.
  std::vector<std::int32_t> written(int id, const Register& reg);
  void mischief(const Mischief& what);
  /// Moves the servo as by hand, with or without torque.
  void move_by_hand(int id, std::int32_t position) { set(id, family_.present_position, position); }
  /// Calls `call` with the number of each accepted instruction, on the bus's thread.
  void on_instruction(std::function<void(std::uint64_t)> call);
  void set_step(int step);
  /// Blocks a servo: it stays in place at full load.
  void block(int id, bool blocked);
  /// Simulates transmission times: 10 bits per byte, one frame after the other, and `return_delay` before
  /// each answer. 0: no delay, the default.
  void set_bit_rate(int bits_per_second, Nanoseconds return_delay);
  Traffic traffic() const { return {bytes_in_, bytes_out_}; }
  /// The last instructions as complete frames; at most 4096.
  std::vector<std::vector<std::uint8_t>> heard();
  /// Cuts the line between adapter and servos, or restores it: the port stays, and neither side receives
  /// anything meanwhile.
  void cut_off(bool cut = true);
  /// Unplugs the adapter.
  void close_connection();
  std::uint64_t instructions() const { return instructions_; }
  /// Connects and disconnects servos.
  void plug_in(int id);
  void unplug(int id);
  std::vector<int> ids();

 private:
  struct Servo {
    std::vector<std::uint8_t> table = std::vector<std::uint8_t>(256);
    std::map<std::uint16_t, std::vector<std::int32_t>> log;
    bool blocked = false;
  };
  using Bytes = std::vector<std::uint8_t>;
  void serve();
  bool take_instruction();
  void execute(std::uint8_t id, std::uint8_t instruction, const Bytes& parameters);
  void write(Servo& servo, std::uint16_t address, const std::uint8_t* from, std::size_t size);
  void move(Servo& servo);
  void answer(std::uint8_t id, Servo& servo, const Bytes& data, std::uint8_t error = 0);
  void answer_fast(const std::vector<std::uint8_t>& ids, std::uint16_t address, std::uint16_t length);
  void misbehave_and_send(int id, Bytes frame);
  void put(const Bytes& bytes);
  void put_at_once(const Bytes& bytes);
  void take_time(std::size_t bytes, Nanoseconds before);
  int silence_left_ms();
  void timeout_at();
  std::uint8_t status(Servo& servo) const;
  Servo fresh(int id) const;

  Wire wire_;
  const Family& family_;
  std::string path_, link_;
  int master_ = -1, slave_ = -1, wake_[2] = {-1, -1};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<int, Servo> servos_;
  Mischief mischief_;
  Bytes in_;
  std::deque<Bytes> late_;
  std::deque<Bytes> heard_;
  int step_ = 40;
  int bits_per_second_ = 0;
  bool cut_off_ = false;
  Nanoseconds return_delay_ = 0, line_free_ = 0, last_received_ = 0;
  std::atomic<std::uint64_t> bytes_in_{0}, bytes_out_{0};
  std::function<void(std::uint64_t)> call_;
  std::atomic<std::uint64_t> instructions_{0};
  std::thread thread_;
};

}  // namespace polyarm::servo_bus
