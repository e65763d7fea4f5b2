#include "drivers/servo_bus/fake_bus.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <utility>

#include "drivers/dynamixel/family.hpp"
#include "drivers/feetech/family.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::servo_bus {

namespace {
using Frame = std::vector<std::uint8_t>;
// Of a Dynamixel's bus watchdog: the value of its register after it has tripped, and its unit.
constexpr std::uint8_t kBitten = 0xFF;
constexpr int kWatchdogUnit_ms = 20;
constexpr std::chrono::seconds kLongestWait{60};

/// Bit by bit, independent of the driver's table.
std::uint16_t slow_crc(const Frame& bytes) {
  unsigned crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc ^= static_cast<unsigned>(byte) << 8;
    for (int i = 0; i < 8; ++i) crc = (crc << 1 ^ (crc & 0x8000 ? 0x8005u : 0u)) & 0xFFFF;
  }
  return static_cast<std::uint16_t>(crc);
}

void add_crc(Frame& frame) {
  const std::uint16_t crc = slow_crc(frame);
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8));
}

Frame feetech_answer(std::uint8_t id, std::uint8_t error, const Frame& data) {
  Frame frame;
  frame.reserve(data.size() + 6);
  for (const int byte : {0xFF, 0xFF, int{id}, static_cast<int>(data.size()) + 2, int{error}})
    frame.push_back(static_cast<std::uint8_t>(byte));
  for (const std::uint8_t byte : data) frame.push_back(byte);
  unsigned sum = 0;
  for (std::size_t i = 2; i < frame.size(); ++i) sum += frame[i];
  frame.push_back(static_cast<std::uint8_t>(255 - (sum & 0xFF)));
  return frame;
}

Frame dynamixel_answer(std::uint8_t id, std::uint8_t error, const Frame& data) {
  Frame body{0x55, error};
  for (const std::uint8_t byte : data) {
    body.push_back(byte);
    const std::size_t n = body.size();
    if (n >= 3 && body[n - 3] == 0xFF && body[n - 2] == 0xFF && body[n - 1] == 0xFD) body.push_back(0xFD);
  }
  const std::size_t length = body.size() + 2;
  Frame frame{0xFF,
              0xFF,
              0xFD,
              0x00,
              id,
              static_cast<std::uint8_t>(length & 0xFF),
              static_cast<std::uint8_t>(length >> 8)};
  frame.insert(frame.end(), body.begin(), body.end());
  add_crc(frame);
  return frame;
}
}  // namespace

FakeBus::FakeBus(Wire wire, std::vector<int> ids, const std::string& link)
    : wire_(wire),
      family_(wire == Wire::feetech ? feetech::sts_family() : dynamixel::x_family()),
      link_(link) {
  for (const int id : ids) servos_[id] = fresh(id);
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  char name[128] = {};
  if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0 ||
      ::ptsname_r(master_, name, sizeof name) != 0 || ::pipe2(wake_, O_CLOEXEC) != 0)
    throw Error("fake-failed", "no pty for the fake bus");
  path_ = name;
  slave_ = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios raw{};
  if (slave_ < 0 || ::tcgetattr(slave_, &raw) != 0) throw Error("fake-failed", "no pty for the fake bus");
  ::cfmakeraw(&raw);
  if (::tcsetattr(slave_, TCSANOW, &raw) != 0) throw Error("fake-failed", "no pty for the fake bus");
  if (!link_.empty()) {
    std::error_code error;
    std::filesystem::remove(link_, error);
    std::filesystem::create_symlink(path_, link_, error);
    if (error) throw Error("fake-failed", "cannot make " + link_ + ": " + error.message());
  }
  thread_ = std::thread([this] { serve(); });
}

FakeBus::~FakeBus() {
  close_connection();
  ::close(slave_);
  ::close(wake_[0]);
  ::close(wake_[1]);
  std::error_code ignored;
  if (!link_.empty()) std::filesystem::remove(link_, ignored);
}

void FakeBus::close_connection() {
  if (!thread_.joinable()) return;
  const char end = 0;
  if (::write(wake_[1], &end, 1) != 1) std::abort();
  thread_.join();
  ::close(std::exchange(master_, -1));
}

FakeBus::Servo FakeBus::fresh(int id) const {
  Servo servo;
  const auto put = [&](const Register& reg, std::int32_t value) {
    if (reg) encode(reg, value, std::span(servo.table).subspan(reg.address));
  };
  const bool feetech = wire_ == Wire::feetech;
  put(family_.model, feetech ? 777 : 1020);
  put(family_.firmware, feetech ? 3 | 10 << 8 : 45);
  put(family_.id, id);
  put(family_.baud, feetech ? 0 : 1);
  put(family_.max_limit, 4095);
  put(family_.max_temperature, feetech ? 70 : 72);
  put(family_.max_voltage, feetech ? 140 : 160);
  put(family_.min_voltage, feetech ? 40 : 60);
  put(family_.phase, 12);
  put(family_.mode, family_.mode_position);
  put(family_.soft_limit, static_cast<std::int32_t>(family_.soft_limit_full));
  put(family_.lock, 1);
  put(family_.goal_position, 2048);
  put(family_.present_position, 2048);
  put(family_.present_voltage, feetech ? 74 : 118);
  put(family_.present_temperature, 31);
  if (feetech) servo.table[8] = 1;  // answers all instructions
  if (!feetech) servo.table[68] = 2;
  return servo;
}

void FakeBus::set(int id, const Register& reg, std::int32_t value) {
  const std::lock_guard lock(mutex_);
  encode(reg, value, std::span(servos_.at(id).table).subspan(reg.address));
}

std::int32_t FakeBus::get(int id, const Register& reg) {
  const std::lock_guard lock(mutex_);
  return decode(reg, servo_bus::Bytes(servos_.at(id).table).subspan(reg.address));
}

bool FakeBus::wait(int id, const Register& reg, const std::function<bool(std::int32_t)>& is) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kLongestWait, [&] {
    return is(decode(reg, servo_bus::Bytes(servos_.at(id).table).subspan(reg.address)));
  });
}

bool FakeBus::wait_for_instructions(std::uint64_t count) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kLongestWait, [&] { return instructions_ >= count; });
}

std::vector<std::int32_t> FakeBus::written(int id, const Register& reg) {
  const std::lock_guard lock(mutex_);
  return servos_.at(id).log[reg.address];
}

void FakeBus::mischief(const Mischief& what) {
  const std::lock_guard lock(mutex_);
  mischief_ = what;
}

void FakeBus::on_instruction(std::function<void(std::uint64_t)> call) {
  const std::lock_guard lock(mutex_);
  call_ = std::move(call);
}

void FakeBus::set_step(int step) {
  const std::lock_guard lock(mutex_);
  step_ = step;
}

void FakeBus::block(int id, bool blocked) {
  const std::lock_guard lock(mutex_);
  servos_.at(id).blocked = blocked;
}

void FakeBus::plug_in(int id) {
  const std::lock_guard lock(mutex_);
  servos_[id] = fresh(id);
}

void FakeBus::unplug(int id) {
  const std::lock_guard lock(mutex_);
  servos_.erase(id);
}

std::vector<int> FakeBus::ids() {
  const std::lock_guard lock(mutex_);
  std::vector<int> out;
  for (const auto& [id, servo] : servos_) out.push_back(id);
  return out;
}

void FakeBus::set_bit_rate(int bits_per_second, Nanoseconds return_delay) {
  const std::lock_guard lock(mutex_);
  bits_per_second_ = bits_per_second;
  return_delay_ = return_delay;
}

std::vector<std::vector<std::uint8_t>> FakeBus::heard() {
  const std::lock_guard lock(mutex_);
  return {heard_.begin(), heard_.end()};
}

void FakeBus::cut_off(bool cut) {
  const std::lock_guard lock(mutex_);
  cut_off_ = cut;
}

/// Time until the first servo's own watchdog trips; -1: none is set.
int FakeBus::silence_left_ms() {
  const std::lock_guard lock(mutex_);
  int least = -1;
  for (const auto& [id, servo] : servos_) {
    const int set = family_.watchdog ? servo.table[family_.watchdog.address] : 0;
    if (set > 0 && set < kBitten && (least < 0 || set * kWatchdogUnit_ms < least))
      least = set * kWatchdogUnit_ms;
  }
  if (least < 0) return -1;
  const Nanoseconds end = last_received_ + Nanoseconds{least} * 1'000'000;
  return static_cast<int>(std::max<Nanoseconds>(0, (end - realtime::monotonic_now()) / 1'000'000 + 1));
}

void FakeBus::timeout_at() {
  const std::lock_guard lock(mutex_);
  const Nanoseconds silent = realtime::monotonic_now() - last_received_;
  for (auto& [id, servo] : servos_) {
    std::uint8_t& set = servo.table[family_.watchdog.address];
    if (set == 0 || set >= kBitten || silent < Nanoseconds{set} * kWatchdogUnit_ms * 1'000'000) continue;
    set = kBitten;
    for (const Register& goal : {family_.goal_velocity, family_.goal_current})
      if (goal) encode(goal, 0, std::span(servo.table).subspan(goal.address));
  }
  changed_.notify_all();
}

void FakeBus::serve() {
  ::prctl(PR_SET_TIMERSLACK, 1);  // ns: for accurate line times
  for (;;) {
    pollfd watched[2] = {{master_, POLLIN, 0}, {wake_[0], POLLIN, 0}};
    const int ready = ::poll(watched, 2, silence_left_ms());
    if (ready == 0) timeout_at();
    if (ready <= 0) continue;
    if (watched[1].revents) return;
    std::uint8_t bytes[512];
    const ssize_t count = ::read(master_, bytes, sizeof bytes);
    if (count <= 0) return;
    in_.insert(in_.end(), bytes, bytes + count);
    while (take_instruction()) {
      std::uint64_t number = 0;
      std::function<void(std::uint64_t)> call;
      {
        const std::lock_guard lock(mutex_);
        number = ++instructions_;
        call = call_;
      }
      changed_.notify_all();
      if (call) call(number);
    }
  }
}

/// Takes one complete instruction from the front of the input; servos ignore broken ones.
bool FakeBus::take_instruction() {
  const bool feetech = wire_ == Wire::feetech;
  const std::size_t head = feetech ? 4 : 7;
  const auto begins = [&] {
    return feetech ? in_[0] == 0xFF && in_[1] == 0xFF && in_[2] != 0xFF
                   : in_[0] == 0xFF && in_[1] == 0xFF && in_[2] == 0xFD && in_[3] == 0;
  };
  while (in_.size() >= head && !begins()) in_.erase(in_.begin());
  if (in_.size() < head) return false;
  const std::size_t size = feetech ? in_[3] + 4u : (in_[5] | in_[6] << 8) + 7u;
  if (in_.size() < size) return false;
  Frame frame(in_.begin(), in_.begin() + static_cast<std::ptrdiff_t>(size));
  in_.erase(in_.begin(), in_.begin() + static_cast<std::ptrdiff_t>(size));
  const std::lock_guard lock(mutex_);
  if (cut_off_) return true;
  last_received_ = realtime::monotonic_now();
  bytes_in_ += size;
  heard_.push_back(frame);
  if (heard_.size() > 4096) heard_.pop_front();
  line_free_ = std::max(line_free_, last_received_);
  take_time(size, 0);
  if (mischief_.echo) put_at_once(frame);
  Frame parameters;
  if (feetech) {
    unsigned sum = 0;
    for (std::size_t i = 2; i < size; ++i) sum += frame[i];
    if ((sum & 0xFF) != 0xFF) return true;
    parameters.assign(frame.begin() + 5, frame.end() - 1);
  } else {
    Frame covered(frame.begin(), frame.end() - 2);
    const std::uint16_t crc = slow_crc(covered);
    if (frame[size - 2] != (crc & 0xFF) || frame[size - 1] != crc >> 8) return true;
    for (std::size_t i = 8; i < size - 2; ++i) {
      parameters.push_back(frame[i]);
      const std::size_t n = parameters.size();
      if (n >= 3 && parameters[n - 3] == 0xFF && parameters[n - 2] == 0xFF && parameters[n - 1] == 0xFD) ++i;
    }
  }
  for (; !late_.empty(); late_.pop_front()) put(late_.front());
  execute(frame[feetech ? 2 : 4], frame[feetech ? 4 : 7], parameters);
  for (auto& [id, servo] : servos_) move(servo);
  return true;
}

void FakeBus::execute(std::uint8_t id, std::uint8_t instruction, const Bytes& p) {
  const std::size_t wide = wire_ == Wire::feetech ? 1 : 2;
  const auto number = [&](std::size_t at) {
    return static_cast<std::uint16_t>(wide == 1 ? p[at] : p[at] | p[at + 1] << 8);
  };
  const auto data_of = [&](Servo& servo, std::size_t address, std::size_t length) {
    return Bytes(servo.table.begin() + static_cast<std::ptrdiff_t>(address),
                 servo.table.begin() + static_cast<std::ptrdiff_t>(address + length));
  };
  const auto in_table = [&](std::size_t address, std::size_t length) { return address + length <= 256; };
  if (instruction == 0x82 || instruction == 0x8A) {
    if (p.size() < 2 * wide || !in_table(number(0), number(wide))) return;
    const std::vector<std::uint8_t> who(p.begin() + static_cast<std::ptrdiff_t>(2 * wide), p.end());
    if (instruction == 0x8A) return answer_fast(who, number(0), number(wide));
    for (const std::uint8_t asked : who)
      if (const auto found = servos_.find(asked); found != servos_.end())
        answer(asked, found->second, data_of(found->second, number(0), number(wide)));
    return;
  }
  if (instruction == 0x83) {
    if (p.size() < 2 * wide || !in_table(number(0), number(wide))) return;
    const std::size_t length = number(wide);
    for (std::size_t at = 2 * wide; at + 1 + length <= p.size(); at += 1 + length)
      if (const auto found = servos_.find(p[at]); found != servos_.end())
        write(found->second, number(0), p.data() + at + 1, length);
    return;
  }
  for (auto& [own, servo] : servos_) {
    if (id != own && id != kBroadcast) continue;
    const auto own_id = static_cast<std::uint8_t>(own);
    if (instruction == 0x01) {
      const Bytes facts =
          wire_ == Wire::feetech ? Bytes{} : Bytes{servo.table[0], servo.table[1], servo.table[6]};
      answer(own_id, servo, facts);
    } else if (instruction == 0x02 && p.size() == 2 * wide && in_table(number(0), number(wide))) {
      if (id != kBroadcast) answer(own_id, servo, data_of(servo, number(0), number(wide)));
    } else if (instruction == 0x03 && p.size() > wide && in_table(number(0), p.size() - wide)) {
      const std::uint16_t address = number(0);
      const bool lasting = address < 64 && wire_ == Wire::dynamixel;
      if (lasting && servo.table[64]) {  // persistent registers are write-protected while torque is on
        if (id != kBroadcast) answer(own_id, servo, {}, 7);
        continue;
      }
      if (id != kBroadcast) answer(own_id, servo, {});
      write(servo, address, p.data() + wide, p.size() - wide);
    } else if (instruction == 0x08) {
      encode(family_.torque, 0, std::span(servo.table).subspan(family_.torque.address));
      encode(family_.status, 0, std::span(servo.table).subspan(family_.status.address));
      if (wire_ == Wire::dynamixel) answer(own_id, servo, {});
    }
  }
  // A new id is used from the next instruction on.
  std::map<int, Servo> renamed;
  for (auto& [own, servo] : servos_) renamed[servo.table[family_.id.address]] = std::move(servo);
  servos_ = std::move(renamed);
}

void FakeBus::write(Servo& servo, std::uint16_t address, const std::uint8_t* from, std::size_t size) {
  const bool goal = address > family_.watchdog.address && address <= family_.goal_position.address;
  if (family_.watchdog && goal && servo.table[family_.watchdog.address] == kBitten) return;
  std::copy(from, from + size, servo.table.begin() + address);
  const Register whole{address, static_cast<std::uint8_t>(size)};
  // Stored according to the register of that size, with its sign.
  for (const Register& reg :
       {family_.goal_position, family_.goal_velocity, family_.goal_current, family_.homing})
    if (reg && reg.address == address && reg.size == size) {
      servo.log[address].push_back(decode(reg, servo_bus::Bytes(servo.table).subspan(address)));
      return;
    }
  if (size <= 4) servo.log[address].push_back(decode(whole, servo_bus::Bytes(servo.table).subspan(address)));
}

void FakeBus::move(Servo& servo) {
  const auto at = [&](const Register& reg) {
    return decode(reg, servo_bus::Bytes(servo.table).subspan(reg.address));
  };
  const auto put = [&](const Register& reg, std::int32_t value) {
    encode(reg, value, std::span(servo.table).subspan(reg.address));
  };
  const std::int32_t position = at(family_.present_position);
  std::int32_t moved = 0;
  const std::int32_t wanted = at(family_.goal_position) - position;
  if (at(family_.torque)) {
    if (at(family_.mode) == family_.mode_position)
      moved = std::clamp(wanted, -step_, step_);
    else if (at(family_.mode) == family_.mode_velocity)
      moved = std::clamp(at(family_.goal_velocity), -step_, step_);
  }
  const bool pressed = servo.blocked && moved != 0;
  if (pressed) moved = 0;
  put(family_.present_position, position + moved);
  put(family_.present_velocity, moved);
  if (family_.present_load) put(family_.present_load, pressed ? (wanted > 0 ? 1000 : -1000) : moved);
  put(family_.present_current, pressed ? 400 : moved);
}

std::uint8_t FakeBus::status(Servo& servo) const {
  const std::uint8_t bits = servo.table[family_.status.address];
  if (wire_ == Wire::feetech) return bits;
  return bits ? 0x80 : 0;
}

void FakeBus::answer(std::uint8_t id, Servo& servo, const Bytes& data, std::uint8_t error) {
  std::uint8_t sender = id;
  if (mischief_.next_wrong_id > 0) {
    --mischief_.next_wrong_id;
    sender = static_cast<std::uint8_t>(id + 100);
  }
  const auto said = static_cast<std::uint8_t>(error | status(servo));
  misbehave_and_send(
      id, wire_ == Wire::feetech ? feetech_answer(sender, said, data) : dynamixel_answer(sender, said, data));
}

void FakeBus::answer_fast(const std::vector<std::uint8_t>& ids, std::uint16_t address, std::uint16_t length) {
  const std::size_t size = ids.size() * (length + 4u) + 1;
  Bytes frame{0xFF,
              0xFF,
              0xFD,
              0x00,
              kBroadcast,
              static_cast<std::uint8_t>(size & 0xFF),
              static_cast<std::uint8_t>(size >> 8),
              0x55};
  for (const std::uint8_t id : ids) {
    const auto found = servos_.find(id);
    if (found == servos_.end() || mischief_.silent.contains(id)) break;  // the servos after it never get
                                                                         // their turn
    frame.push_back(status(found->second));
    frame.push_back(id);
    frame.insert(frame.end(), found->second.table.begin() + address,
                 found->second.table.begin() + address + length);
    add_crc(frame);
  }
  misbehave_and_send(-1, frame);
}

void FakeBus::misbehave_and_send(int id, Bytes frame) {
  if (mischief_.silent.contains(id)) return;
  const auto middle = frame.begin() + static_cast<std::ptrdiff_t>(frame.size() / 2);
  if (mischief_.next_lose_byte > 0) {
    --mischief_.next_lose_byte;
    frame.erase(middle);
  } else if (mischief_.next_extra_byte > 0) {
    --mischief_.next_extra_byte;
    frame.insert(middle, 0x42);
  } else if (mischief_.next_wrong_checksum > 0) {
    --mischief_.next_wrong_checksum;
    frame.back() ^= 0x5A;
  }
  frame.insert(frame.begin(), mischief_.garbage.begin(), mischief_.garbage.end());
  if (mischief_.next_late > 0) {
    --mischief_.next_late;
    late_.push_back(frame);
    return;
  }
  if (mischief_.next_pieces > 0) {
    --mischief_.next_pieces;
    for (const std::uint8_t byte : frame) put({byte});
    return;
  }
  put(frame);
}

/// Occupies the line for this many bytes.
void FakeBus::take_time(std::size_t bytes, Nanoseconds before) {
  if (bits_per_second_ > 0)
    line_free_ += before + static_cast<Nanoseconds>(bytes) * 10'000'000'000 / bits_per_second_;
}

/// An answer; it arrives with its last byte.
void FakeBus::put(const Bytes& bytes) {
  bytes_out_ += bytes.size();
  take_time(bytes.size(), return_delay_);
  if (bits_per_second_ > 0) {
    const timespec end{static_cast<time_t>(line_free_ / 1'000'000'000),
                       static_cast<long>(line_free_ % 1'000'000'000)};
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &end, nullptr) == EINTR) {
    }
  }
  put_at_once(bytes);
}

void FakeBus::put_at_once(const Bytes& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count = ::write(master_, bytes.data() + done, bytes.size() - done);
    if (count <= 0) return;
    done += static_cast<std::size_t>(count);
  }
}

}  // namespace polyarm::servo_bus
