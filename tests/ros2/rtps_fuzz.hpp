#pragma once
/// RTPS packets as somebody who means ill sends them: well-formed messages of every submessage kind (RTPS
/// 2.3, OMG formal/2019-04-03, 8.3 and 9.4), with discovery's parameter lists and Fast DDS's statistics at
/// their end, and changed a little. The same seed gives the same packets.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace polyarm::ros2::test {

using Octets = std::vector<std::uint8_t>;

enum class Submessage : std::uint8_t {
  pad = 0x01,
  acknack = 0x06,
  heartbeat = 0x07,
  gap = 0x08,
  info_ts = 0x09,
  info_src = 0x0c,
  info_reply_ip4 = 0x0d,
  info_dst = 0x0e,
  info_reply = 0x0f,
  nack_frag = 0x12,
  heartbeat_frag = 0x13,
  data = 0x15,
  data_frag = 0x16,
  statistics = 0x80,  ///< Fast DDS's own
};
inline constexpr std::array kSubmessages{
    Submessage::pad,        Submessage::acknack,   Submessage::heartbeat,      Submessage::gap,
    Submessage::info_ts,    Submessage::info_src,  Submessage::info_reply_ip4, Submessage::info_dst,
    Submessage::info_reply, Submessage::nack_frag, Submessage::heartbeat_frag, Submessage::data,
    Submessage::data_frag,  Submessage::statistics};

class RtpsFuzz {
 public:
  using Prefix = std::array<std::uint8_t, 12>;
  using Entity = std::array<std::uint8_t, 4>;

  /// `known`: prefixes of participants that the one attacked knows, itself among them; `entities`: endpoints
  /// beside those of discovery.
  RtpsFuzz(std::uint32_t seed, std::vector<Prefix> known, std::vector<Entity> entities)
      : random_{seed}, prefixes_{std::move(known)} {
    for (int i = 0; i < 4; ++i) prefixes_.push_back(stranger());
    // Announcements of participants, writers, readers, liveliness; secure and type look-up services.
    writers_ = {{0, 1, 0, 0xc2}, {0, 0, 3, 0xc2}, {0, 0, 4, 0xc2}, {0, 2, 0, 0xc2}, {0, 3, 0, 0xc3}};
    readers_ = {{0, 1, 0, 0xc7}, {0, 0, 3, 0xc7}, {0, 0, 4, 0xc7}, {0, 2, 0, 0xc7}, {0, 3, 0, 0xc4}, {}};
    for (const Entity& entity : entities) {
      writers_.push_back(entity);
      readers_.push_back(entity);
    }
  }

  /// A packet that has a submessage of this kind; three of four are changed somewhere.
  Octets packet(Submessage kind) {
    Octets out;
    put(out, {'R', 'T', 'P', 'S', 2, 3, 1, 0x0f});
    append(out, prefix());
    if (one_in(2)) submessage(out, Submessage::info_dst);
    if (one_in(3)) submessage(out, Submessage::info_ts);
    submessage(out, kind);
    for (unsigned more = below(3); more > 0; --more)
      submessage(out, kSubmessages[below(kSubmessages.size())]);
    if (one_in(4)) submessage(out, Submessage::statistics);
    if (!one_in(4)) change(out);
    return out;
  }

 private:
  std::uint32_t below(std::size_t most) { return static_cast<std::uint32_t>(random_() % most); }
  bool one_in(unsigned n) { return below(n) == 0; }
  Prefix stranger() {
    Prefix out;
    for (auto& byte : out) byte = static_cast<std::uint8_t>(random_());
    out[0] = 1, out[1] = 0x0f;
    return out;
  }
  const Prefix& prefix() { return prefixes_[below(prefixes_.size())]; }

  static void put(Octets& out, std::initializer_list<std::uint8_t> bytes) {
    out.insert(out.end(), bytes.begin(), bytes.end());
  }
  template <std::size_t N>
  static void append(Octets& out, const std::array<std::uint8_t, N>& bytes) {
    out.insert(out.end(), bytes.begin(), bytes.end());
  }
  template <class T>
  static void number(Octets& out, T value) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
    out.insert(out.end(), bytes, bytes + sizeof value);
  }
  void noise(Octets& out, std::size_t count) {
    for (; count > 0; --count) out.push_back(static_cast<std::uint8_t>(random_()));
  }
  /// What lengths and counts are when somebody means ill.
  std::uint32_t odd() {
    static constexpr std::array<std::uint32_t, 12> values{
        0, 1, 2, 0x20, 0xff, 0x100, 0xffff, 0x7fff, 0x7fffffff, 0x80000000, 0xffffffff, 0xfffffffe};
    return values[below(values.size())];
  }
  std::uint32_t small() { return one_in(12) ? odd() : below(6); }

  void sequence(Octets& out) {
    number<std::uint32_t>(out, one_in(12) ? odd() : 0);
    number<std::uint32_t>(out, one_in(4) ? odd() : 1 + below(200));
  }
  void sequence_set(Octets& out) {
    sequence(out);
    const std::uint32_t bits = one_in(4) ? odd() : below(64);
    number(out, bits);
    for (std::uint32_t i = 0; i < std::min(8u, (bits + 31) / 32); ++i) noise(out, 4);
  }
  void locators(Octets& out) {
    const std::uint32_t count = small();
    number(out, count);
    for (std::uint32_t i = 0; i < std::min(4u, count); ++i) {
      number<std::uint32_t>(out, one_in(3) ? odd() : 1);
      number<std::uint32_t>(out, one_in(3) ? odd() : 7400 + below(1000));
      noise(out, 16);
    }
  }
  void parameter(Octets& out, std::uint16_t id, const Octets& value, bool honest) {
    number(out, id);
    number(out, honest ? static_cast<std::uint16_t>(value.size()) : static_cast<std::uint16_t>(odd()));
    out.insert(out.end(), value.begin(), value.end());
  }
  Octets text(const std::string& text) {
    Octets out;
    number<std::uint32_t>(out, one_in(10) ? odd() : static_cast<std::uint32_t>(text.size() + 1));
    out.insert(out.end(), text.begin(), text.end());
    do {
      out.push_back(0);
    } while (out.size() % 4 != 0);
    return out;
  }
  /// Parameters of announcements: versions, guids, locators, names, user data, partitions, properties, QoS.
  void parameter_list(Octets& out) {
    static constexpr std::array<std::uint16_t, 34> ids{
        0x15, 0x16, 0x50, 0x52, 0x5a, 0x70, 0x58, 0x43, 0x44,   0x31,  0x32, 0x33,
        0x30, 0x2f, 0x48, 0x02, 0x05, 0x07, 0x1d, 0x1a, 0x1b,   0x29,  0x2c, 0x2d,
        0x2e, 0x59, 0x62, 0x71, 0x75, 0x69, 0x72, 0x1f, 0x8000, 0x4014};
    number<std::uint16_t>(out, 0x0300);  // PL_CDR_LE
    number<std::uint16_t>(out, 0);
    for (unsigned count = 2 + below(14); count > 0; --count) {
      Octets value;
      const std::uint16_t id = ids[below(ids.size())];
      switch (below(5)) {
        case 0:
          append(value, prefix());
          append(value, writers_[below(writers_.size())]);
          break;
        case 1:
          value = text(one_in(2) ? "rt/joint_states" : "std_msgs::msg::dds_::String_");
          break;
        case 2:
          number<std::uint32_t>(value, small());
          for (unsigned i = below(4); i > 0; --i) {
            const Octets piece = text("name");
            value.insert(value.end(), piece.begin(), piece.end());
          }
          break;
        case 3:
          number<std::uint32_t>(value, 1);
          number<std::uint32_t>(value, 7400 + below(1000));
          noise(value, 16);
          break;
        default:
          noise(value, 4 * below(12));
      }
      parameter(out, id, value, !one_in(8));
    }
    if (!one_in(10)) parameter(out, 1, {}, true);  // its end
  }
  void content(Octets& out) {
    if (one_in(2)) return parameter_list(out);
    put(out, {0, static_cast<std::uint8_t>(below(2)), 0, 0});
    noise(out, below(120));
  }

  void submessage(Octets& out, Submessage kind) {
    Octets body;
    std::uint8_t flags = 1;  // little-endian
    const Entity reader = readers_[below(readers_.size())], writer = writers_[below(writers_.size())];
    switch (kind) {
      case Submessage::pad:
        noise(body, 4 * below(8));
        break;
      case Submessage::acknack:
        flags = one_in(2) ? 1 : 3;
        append(body, reader), append(body, writer);
        sequence_set(body);
        number<std::uint32_t>(body, below(1000));
        break;
      case Submessage::heartbeat:
        flags = static_cast<std::uint8_t>(1 | 2 * below(8));
        append(body, reader), append(body, writer);
        sequence(body), sequence(body);
        number<std::uint32_t>(body, below(1000));
        break;
      case Submessage::gap:
        append(body, reader), append(body, writer);
        sequence(body), sequence_set(body);
        break;
      case Submessage::info_ts:
        flags = one_in(4) ? 3 : 1;
        if (flags == 1) noise(body, 8);
        break;
      case Submessage::info_src:
        number<std::uint32_t>(body, 0), put(body, {2, 3, 1, 0x0f});
        append(body, prefix());
        break;
      case Submessage::info_reply:
        locators(body);
        if (one_in(2)) flags |= 2, locators(body);
        break;
      case Submessage::info_reply_ip4:
        noise(body, 8);
        if (one_in(2)) flags |= 2, noise(body, 8);
        break;
      case Submessage::info_dst:
        append(body, prefix());
        break;
      case Submessage::nack_frag:
        append(body, reader), append(body, writer);
        sequence(body);
        number<std::uint32_t>(body, 1 + small());
        number<std::uint32_t>(body, one_in(4) ? odd() : below(256)), noise(body, 4 * below(8));
        number<std::uint32_t>(body, below(1000));
        break;
      case Submessage::heartbeat_frag:
        append(body, reader), append(body, writer);
        sequence(body);
        number<std::uint32_t>(body, small()), number<std::uint32_t>(body, below(1000));
        break;
      case Submessage::data:
      case Submessage::data_frag:
        data(body, flags, kind, reader, writer);
        break;
      case Submessage::statistics:
        statistics(body);
        flags = 0;
        break;
    }
    out.push_back(static_cast<std::uint8_t>(kind));
    out.push_back(flags);
    const bool honest = !one_in(12);
    number(out, honest ? static_cast<std::uint16_t>(body.size()) : static_cast<std::uint16_t>(odd()));
    out.insert(out.end(), body.begin(), body.end());
  }

  void data(Octets& body, std::uint8_t& flags, Submessage kind, const Entity& reader, const Entity& writer) {
    const bool fragment = kind == Submessage::data_frag, qos = one_in(3);
    if (qos) flags |= 2;
    if (!fragment) flags |= static_cast<std::uint8_t>(one_in(6) ? 8 : 4);  // its key, or its data
    number<std::uint16_t>(body, 0);
    number<std::uint16_t>(body, one_in(12) ? static_cast<std::uint16_t>(odd()) : fragment ? 28 : 16);
    append(body, reader), append(body, writer);
    sequence(body);
    if (fragment) {
      number<std::uint32_t>(body, 1 + small());
      number<std::uint16_t>(body, one_in(6) ? static_cast<std::uint16_t>(odd()) : 1);
      number<std::uint16_t>(body, one_in(6) ? static_cast<std::uint16_t>(odd()) : 1024);
      number<std::uint32_t>(body, one_in(4) ? odd() : 4096);
    }
    if (qos) {  // inline: key hash, status (disposed, unregistered), who asked
      parameter(body, 0x70, Octets(16, static_cast<std::uint8_t>(below(256))), !one_in(8));
      parameter(body, 0x71, {0, 0, 0, static_cast<std::uint8_t>(below(4))}, !one_in(8));
      Octets asked;
      append(asked, prefix()), append(asked, writer), sequence(asked);
      parameter(body, one_in(2) ? 0x800f : 0x83, asked, !one_in(8));
      if (!one_in(8)) parameter(body, 1, {}, true);
    }
    content(body);
    if (fragment) noise(body, below(900));
  }
  /// Where to, when, the how manieth packet and byte: 56 bytes at the end of a packet.
  void statistics(Octets& body) {
    number<std::uint32_t>(body, 1), number<std::uint32_t>(body, 7400 + below(1000)), noise(body, 16);
    noise(body, 8);
    number<std::uint64_t>(body, below(1000)), number<std::uint64_t>(body, below(100'000));
    number<std::uint64_t>(body, one_in(4) ? odd() : 0);
  }

  void change(Octets& packet) {
    for (unsigned times = 1 + below(4); times > 0; --times) {
      const std::size_t at = below(packet.size());
      switch (below(6)) {
        case 0:
          packet[at] = static_cast<std::uint8_t>(random_());
          break;
        case 1:
          packet[at] ^= static_cast<std::uint8_t>(1u << below(8));
          break;
        case 2:
          if (at + 4 <= packet.size()) {
            const std::uint32_t value = odd();
            std::memcpy(packet.data() + at, &value, 4);
          }
          break;
        case 3:
          if (packet.size() > 24) packet.resize(20 + below(packet.size() - 20));
          break;
        case 4: {
          Octets more;
          noise(more, below(24));
          packet.insert(packet.begin() + static_cast<std::ptrdiff_t>(at), more.begin(), more.end());
          break;
        }
        default:
          packet.erase(packet.begin() + static_cast<std::ptrdiff_t>(at));
      }
      if (packet.empty()) packet.push_back(0);
    }
  }

  std::mt19937 random_;
  std::vector<Prefix> prefixes_;
  std::vector<Entity> writers_, readers_;
};

/// Sends datagrams to a port of this machine.
class Datagrams {
 public:
  explicit Datagrams(std::uint16_t port) : socket_{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)} {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(port);
    if (socket_ < 0 || ::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
      throw std::runtime_error("no socket");
  }
  ~Datagrams() { ::close(socket_); }
  Datagrams(const Datagrams&) = delete;
  Datagrams& operator=(const Datagrams&) = delete;
  /// False where nobody has the port, as is known from the one before.
  bool send(std::span<const std::uint8_t> bytes) const {
    return ::send(socket_, bytes.data(), bytes.size(), 0) >= 0;
  }

 private:
  int socket_;
};

}  // namespace polyarm::ros2::test
