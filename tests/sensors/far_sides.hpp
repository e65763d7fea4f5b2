#pragma once
/// The far side of sensors on a serial line: bytes composed here from the public protocol descriptions, by
/// functions of their own, and devices that talk over a pty.
#include <errno.h>
#include <fcntl.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "polyarm/realtime/periodic.hpp"
#include "tests/support/pty.hpp"

namespace polyarm::test {

using Bytes = std::vector<std::uint8_t>;

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// --- WIT
// ----------------------------------------------------------------------------------------------------

inline Bytes wit(std::uint8_t type, std::int16_t a, std::int16_t b, std::int16_t c, std::int16_t d) {
  Bytes out{0x55, type};
  for (const std::int16_t value : {a, b, c, d}) {
    out.push_back(static_cast<std::uint8_t>(value & 0xFF));
    out.push_back(static_cast<std::uint8_t>((value >> 8) & 0xFF));
  }
  unsigned sum = 0;
  for (const std::uint8_t byte : out) sum += byte;
  out.push_back(static_cast<std::uint8_t>(sum & 0xFF));
  return out;
}

/// At rest and level, turned by 90° about z, 25.00 °C, turning by 62.5 °/s about x.
inline Bytes wit_sample() {
  return wit(0x51, 0, 0, 2048, 2500) + wit(0x52, 1024, 0, 0, 2500) + wit(0x59, 23170, 0, 0, 23170);
}

// --- UBX
// ----------------------------------------------------------------------------------------------------

inline Bytes ubx(std::uint8_t group, std::uint8_t number, const Bytes& payload) {
  Bytes out{0xB5,
            0x62,
            group,
            number,
            static_cast<std::uint8_t>(payload.size() % 256),
            static_cast<std::uint8_t>(payload.size() / 256)};
  out = out + payload;
  unsigned a = 0, b = 0;
  for (std::size_t i = 2; i < out.size(); ++i) {
    a = (a + out[i]) % 256;
    b = (b + a) % 256;
  }
  out.push_back(static_cast<std::uint8_t>(a));
  out.push_back(static_cast<std::uint8_t>(b));
  return out;
}

struct Fix {
  std::uint8_t type = 3, flags = 0x01, satellites = 12, flags3 = 0;
  std::int32_t longitude = 85'200'000, latitude = 473'700'000;  // 1e-7 °
  std::int32_t height = 456'789;                                // mm
  std::uint32_t horizontal = 1500, vertical = 2500;             // mm
  std::int32_t north = 1000, east = -2000, down = 300;          // mm/s
  std::uint32_t speed_accuracy = 400;                           // mm/s
};

inline void set(Bytes& into, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) into[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

inline Bytes nav_pvt_payload(const Fix& fix, std::size_t size = 92) {
  Bytes p(size, 0);
  set(p, 0, 345'600'000);
  p[4] = 0xEA, p[5] = 0x07, p[6] = 11, p[7] = 21;  // 2026-11-21
  p[20] = fix.type, p[21] = fix.flags, p[23] = fix.satellites;
  set(p, 24, static_cast<std::uint32_t>(fix.longitude)), set(p, 28, static_cast<std::uint32_t>(fix.latitude));
  set(p, 32, static_cast<std::uint32_t>(fix.height)),
      set(p, 36, static_cast<std::uint32_t>(fix.height - 47'000));
  set(p, 40, fix.horizontal), set(p, 44, fix.vertical);
  set(p, 48, static_cast<std::uint32_t>(fix.north)), set(p, 52, static_cast<std::uint32_t>(fix.east));
  set(p, 56, static_cast<std::uint32_t>(fix.down)), set(p, 68, fix.speed_accuracy);
  p[78] = fix.flags3;
  return p;
}

inline Bytes nav_pvt(const Fix& fix = {}, std::size_t size = 92) {
  return ubx(0x01, 0x07, nav_pvt_payload(fix, size));
}

inline Bytes mon_ver(const std::string& protocol) {
  Bytes p(40 + 60, 0);
  std::memcpy(p.data(), "EXT CORE 1.00 (abc)", 19);
  std::memcpy(p.data() + 30, "00190000", 8);
  std::memcpy(p.data() + 40, "FWVER=HPG 1.32", 14);
  std::memcpy(p.data() + 70, ("PROTVER=" + protocol).c_str(), 8 + protocol.size());
  return ubx(0x0A, 0x04, p);
}

// --- devices
// ------------------------------------------------------------------------------------------------

/// A device on a pty that has a thread of its own: it answers what it hears, and says something by itself
/// every so often.
class TalkingDevice {
 public:
  explicit TalkingDevice(int period_ms) : period_ms_(period_ms) {
    ::fcntl(pty.master(), F_SETFL, O_NONBLOCK);  // what nobody reads is lost, as on a wire
  }
  virtual ~TalkingDevice() { stop(); }
  void start() {
    thread_ = std::thread([this] { talk(); });
  }
  void stop() {
    ending_ = true;
    if (thread_.joinable()) thread_.join();
  }
  const std::string& path() const { return pty.path(); }

  Pty pty;

 protected:
  virtual void hear(const Bytes& bytes) = 0;
  virtual void speak() = 0;
  void say(const Bytes& bytes) {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t count = ::write(pty.master(), bytes.data() + done, bytes.size() - done);
      if (count <= 0) return;
      done += static_cast<std::size_t>(count);
    }
  }

 private:
  void talk() {
    Nanoseconds next = realtime::monotonic_now();
    while (!ending_) {
      const Nanoseconds now = realtime::monotonic_now();
      if (now >= next) {
        speak();
        next = now + period_ms_ * 1'000'000ll;
      }
      if (const Bytes heard = pty.read(period_ms_); !heard.empty()) hear(heard);
    }
  }
  int period_ms_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

/// An inertial sensor that sends what its content says, and takes commands once it is unlocked.
class FakeImu : public TalkingDevice {
 public:
  FakeImu() : TalkingDevice(10) {}
  ~FakeImu() override { stop(); }
  std::atomic<bool> quaternions{true}, silent{false};
  Bytes commands() const {
    const std::lock_guard lock(mutex_);
    return heard_;
  }

 private:
  void hear(const Bytes& bytes) override {
    const std::lock_guard lock(mutex_);
    heard_ = heard_ + bytes;
    const Bytes unlock{0xFF, 0xAA, 0x69, 0x88, 0xB5}, content{0xFF, 0xAA, 0x02, 0x06, 0x02};
    const auto at = std::search(heard_.begin(), heard_.end(), unlock.begin(), unlock.end());
    if (std::search(at, heard_.end(), content.begin(), content.end()) != heard_.end()) quaternions = true;
  }
  void speak() override {
    if (silent) return;
    say(quaternions ? wit_sample() : wit(0x51, 0, 0, 2048, 2500) + wit(0x52, 1024, 0, 0, 2500));
  }
  mutable std::mutex mutex_;
  Bytes heard_;
};

/// A receiver that answers polls and commands as its generation does.
class FakeReceiver : public TalkingDevice {
 public:
  explicit FakeReceiver(std::string protocol = "27.31", int period_ms = 10)
      : TalkingDevice(period_ms), protocol_(std::move(protocol)) {}
  ~FakeReceiver() override { stop(); }
  std::atomic<bool> refuses{false}, deaf{false}, ignores_settings{false};
  std::atomic<bool> sends_fixes{true};
  std::vector<Bytes> commands() const {
    const std::lock_guard lock(mutex_);
    return commands_;
  }

 private:
  void hear(const Bytes& bytes) override {
    heard_ = heard_ + bytes;
    while (heard_.size() >= 8) {
      const std::size_t whole = 8 + heard_[4] + heard_[5] * 256u;
      if (heard_.size() < whole) return;
      const Bytes message(heard_.begin(), heard_.begin() + static_cast<std::ptrdiff_t>(whole));
      heard_.erase(heard_.begin(), heard_.begin() + static_cast<std::ptrdiff_t>(whole));
      const Bytes payload(message.begin() + 6, message.end() - 2);
      if (message != ubx(message[2], message[3], payload)) continue;  // a wrong sum is not heard
      answer(message);
    }
  }
  void answer(const Bytes& message) {
    {
      const std::lock_guard lock(mutex_);
      commands_.push_back(message);
    }
    if (deaf) return;
    if (message[2] == 0x0A) return say(mon_ver(protocol_));
    if (ignores_settings) return;
    const bool keys = message[3] == 0x8A;
    const bool known = keys == (std::stod(protocol_) >= 27) && !refuses;
    say(ubx(0x05, known ? 0x01 : 0x00, {message[2], message[3]}));
  }
  void speak() override {
    if (deaf) return;
    const std::string nmea = "$GNRMC,,V,,,,,,,,,,N*4D\r\n";
    say(Bytes(nmea.begin(), nmea.end()));
    if (sends_fixes) say(nav_pvt());
  }
  std::string protocol_;
  Bytes heard_;
  mutable std::mutex mutex_;
  std::vector<Bytes> commands_;
};

}  // namespace polyarm::test
