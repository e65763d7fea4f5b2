#include "drivers/cia402/slcan.hpp"

#include <string>
#include <string_view>

#include "polyarm/base/error.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::cia402 {

namespace {
constexpr Nanoseconds kSendTime = 20'000'000, kAnswerTime = 100'000'000;
constexpr std::size_t kHead = 4;       // "t", identifier
constexpr std::size_t kTimestamp = 4;  // hexadecimal digits that some adapters append
constexpr char kDigits[] = "0123456789ABCDEF";

int digit(char c) noexcept {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}
}  // namespace

SlcanText slcan_text(const CanFrame& frame) noexcept {
  SlcanText out;
  const auto put = [&](int nibble) { out.text[out.size++] = kDigits[nibble & 15]; };
  out.text[out.size++] = 't';
  for (const int shift : {8, 4, 0}) put(frame.id >> shift);
  put(frame.size);
  for (std::size_t k = 0; k < frame.size && k < frame.data.size(); ++k) {
    put(frame.data[k] >> 4);
    put(frame.data[k]);
  }
  out.text[out.size++] = '\r';
  return out;
}

const char* slcan_rate(int bit_rate) noexcept {
  constexpr struct {
    int rate;
    const char* command;
  } kRates[] = {{10'000, "S0"},  {20'000, "S1"},  {50'000, "S2"},  {100'000, "S3"},  {125'000, "S4"},
                {250'000, "S5"}, {500'000, "S6"}, {800'000, "S7"}, {1'000'000, "S8"}};
  for (const auto& row : kRates)
    if (row.rate == bit_rate) return row.command;
  return nullptr;
}

SlcanParser::Token SlcanParser::take(std::uint8_t byte) noexcept {
  const char c = static_cast<char>(byte);
  if (c == '\a') {
    size_ = 0;
    overflow_ = false;
    return Token::refused;
  }
  if (c == '\r') {
    const Token token = overflow_ ? Token::garbage : line();
    size_ = 0;
    overflow_ = false;
    return token;
  }
  if (c == '\n') return Token::none;  // some adapters send both
  if (size_ == line_.size())
    overflow_ = true;
  else
    line_[size_++] = c;
  return Token::none;
}

SlcanParser::Token SlcanParser::line() noexcept {
  if (size_ == 0) return Token::accepted;
  // "z" accepts a frame that was sent; another line may follow it without a carriage return.
  std::size_t from = 0;
  while (from < size_ && (line_[from] == 'z' || line_[from] == 'Z')) ++from;
  if (from == size_) return Token::accepted;
  switch (line_[from]) {
    case 't':
      return data_frame(from) ? Token::frame : Token::garbage;
    case 'T':
    case 'r':
    case 'R':
    case 'F':
    case 'V':
    case 'v':
    case 'N':
      return Token::other;
    default:
      return Token::garbage;
  }
}

bool SlcanParser::data_frame(std::size_t from) noexcept {
  const std::size_t size = size_ - from;
  if (size < kHead + 1) return false;
  int id = 0;
  for (std::size_t k = 1; k < kHead; ++k) {
    const int d = digit(line_[from + k]);
    if (d < 0) return false;
    id = id << 4 | d;
  }
  const int length = digit(line_[from + kHead]);
  const std::size_t needed = kHead + 1 + 2 * static_cast<std::size_t>(length < 0 ? 0 : length);
  if (length < 0 || length > 8 || id > 0x7FF || (size != needed && size != needed + kTimestamp)) return false;
  CanFrame out;
  out.id = static_cast<std::uint16_t>(id);
  out.size = static_cast<std::uint8_t>(length);
  for (std::size_t k = 0; k < out.size; ++k) {
    const int high = digit(line_[from + kHead + 1 + 2 * k]), low = digit(line_[from + kHead + 2 + 2 * k]);
    if (high < 0 || low < 0) return false;
    out.data[k] = static_cast<std::uint8_t>(high << 4 | low);
  }
  frame_ = out;
  return true;
}

SlcanBus::SlcanBus(const BusOptions& options) {
  if (!slcan_rate(options.bit_rate))
    throw Error("bad-value", "SLCAN has no command for " + std::to_string(options.bit_rate) + " bit/s",
                "10000, 20000, 50000, 100000, 125000, 250000, 500000, 800000 or 1000000");
  port_ = serial::Port({options.bus, options.baud, options.holder});
  open_channel(options);
}

SlcanBus::~SlcanBus() {
  if (opened_) port_.write(std::array<std::uint8_t, 2>{'C', '\r'}, realtime::monotonic_now() + kSendTime);
}

void SlcanBus::command(const char* text) {
  const std::string line = std::string(text) + "\r";
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(line.data());
  const serial::Transfer done = port_.write({bytes, line.size()}, realtime::monotonic_now() + kAnswerTime);
  if (!done)
    throw Error("port-failed", "the CAN adapter at " + port_.path() + " takes nothing",
                serial::explain(done.status, done.error));
}

/// For the answer to a command. A bus that is never quiet does not prolong it.
void SlcanBus::listen_briefly() {
  const Nanoseconds end = realtime::monotonic_now() + kAnswerTime / 4;
  CanFrame ignored;
  while (receive(ignored, end) == BusState::ok && realtime::monotonic_now() < end) {
  }
}

/// Whatever an earlier session left is closed first; its answer does not count. Some adapters do not answer
/// at all: only a refusal ends it.
void SlcanBus::open_channel(const BusOptions& options) {
  command("");
  command("C");
  listen_briefly();
  refused_ = garbage_ = 0;
  for (const char* const one : {slcan_rate(options.bit_rate), "O"}) {
    command(one);
    listen_briefly();
    if (refused_ > 0)
      throw Error("port-failed",
                  "the CAN adapter at " + port_.path() + " refuses the command " + one + " of SLCAN",
                  "unplug it and plug it in again; check that it has SLCAN firmware and " +
                      std::to_string(options.bit_rate) + " bit/s");
  }
  opened_ = true;
}

BusState SlcanBus::send(const CanFrame& frame) noexcept {
  const SlcanText text = slcan_text(frame);
  const serial::Transfer done = port_.write(text.bytes(), realtime::monotonic_now() + kSendTime);
  if (done) return BusState::ok;
  return done.status == serial::Status::gone      ? BusState::gone
         : done.status == serial::Status::timeout ? BusState::full
                                                  : BusState::failed;
}

BusState SlcanBus::receive(CanFrame& frame, Nanoseconds deadline) noexcept {
  for (;;) {
    while (at_ < count_) {
      switch (parser_.take(in_[at_++])) {
        case SlcanParser::Token::frame:
          frame = parser_.frame();
          return BusState::ok;
        case SlcanParser::Token::refused:
          ++refused_;
          break;
        case SlcanParser::Token::garbage:
          ++garbage_;
          break;
        default:
          break;
      }
    }
    const serial::Transfer got = port_.read(in_, deadline);
    at_ = 0;
    count_ = got.count;
    if (got) continue;
    return got.status == serial::Status::timeout ? BusState::nothing
           : got.status == serial::Status::gone  ? BusState::gone
                                                 : BusState::failed;
  }
}

}  // namespace polyarm::cia402
