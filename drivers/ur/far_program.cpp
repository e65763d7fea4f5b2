/// Plays three programs as the controller would: the two of the driver, and External Control of the maker's
/// client library. Any other program only starts and ends: nothing here interprets URScript.
#include <algorithm>
#include <cmath>

#include "drivers/ur/far_services.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::ur {

namespace {

constexpr double kFirstMessage = 2;     // s that the driver's own program waits for its first message
constexpr double kExternalScale = 1e6;  // of External Control's numbers
constexpr std::size_t kExternalBytes = 32;
constexpr double kSpeedAcceleration = 15;  // rad/s², as in the program
constexpr Nanoseconds kConnect = 500'000'000;

std::string quoted_after(const std::string& text, std::size_t& at) {
  const std::size_t begin = text.find('"', at);
  if (begin == std::string::npos) return {};
  const std::size_t end = text.find('"', begin + 1);
  if (end == std::string::npos) return {};
  at = end + 1;
  return text.substr(begin + 1, end - begin - 1);
}

}  // namespace

std::vector<FarProgram::Opened> FarProgram::sockets_of(const std::string& text) {
  std::vector<Opened> out;
  const std::string calls[] = {"socket_open(", "connect_socket_with_retry("};
  for (const std::string& call : calls)
    for (std::size_t at = text.find(call); at != std::string::npos && out.size() < 16;
         at = text.find(call, at + 1)) {
      std::size_t here = at + call.size();
      if (here >= text.size() || text[here] != '"') continue;  // not with a constant host
      Opened one;
      one.host = quoted_after(text, here);
      const std::size_t comma = text.find(',', here), next = text.find(',', comma + 1);
      if (comma == std::string::npos || next == std::string::npos) continue;
      one.port = static_cast<int>(parse_number(text.substr(comma + 1, next - comma - 1)).value_or(0));
      here = next;
      one.name = quoted_after(text, here);
      if (one.port > 0 && one.port < 65536) out.push_back(one);
    }
  return out;
}

bool FarProgram::open(const std::string& name) {
  for (const Opened& one : opened_) {
    if (one.name != name) continue;
    std::string why;
    Descriptor socket =
        faults_.unreachable ? Descriptor() : wire::connect_tcp(one.host, one.port, kConnect, why);
    if (!socket) return false;
    (name == "trajectory_socket"       ? trajectory_
     : name == "script_command_socket" ? commands_
                                       : stream_) = std::move(socket);
    return true;
  }
  return false;
}

std::string FarProgram::start(const std::string& text) {
  stop();
  if (text.size() > bounds::kFarSideScriptBytes) return "the program is too long";
  text_ = text;
  opened_ = sockets_of(text);
  const std::size_t def = text.find("def ");
  name_ = def == std::string::npos ? "" : text.substr(def + 4, text.find('(', def) - def - 4);
  const auto opens = [this](const std::string& name) {
    return std::any_of(opened_.begin(), opened_.end(), [&](const Opened& one) { return one.name == name; });
  };
  kind_ = opens(kSocketName)        ? Kind::own
          : opens(kMoveSocketName)  ? Kind::moves
          : opens("reverse_socket") ? Kind::external_control
                                    : Kind::other;
  buffer_.clear();
  quiet_ = 0;
  sequence_ = 0;
  ended_ = kind_ == Kind::other;
  machine_.program(Machine::Program::playing);
  if (!faults_.exception.empty()) {
    ended_ = true;
    return std::exchange(faults_.exception, "");
  }
  machine_.set_register("output_int_register_24", 0);
  machine_.set_register("output_int_register_25", 0);
  wait_limit_ = is_ours() ? kFirstMessage : 0;
  if (kind_ == Kind::moves) moves_.begin();
  if (is_ours()) {
    if (open(kind_ == Kind::own ? kSocketName : kMoveSocketName))
      machine_.set_register("output_int_register_25", static_cast<int>(ScriptState::running));
    else
      ended_ = !faults_.unreachable;  // a blocked connection hangs in its attempt
  }
  if (kind_ == Kind::external_control)
    ended_ = !open("trajectory_socket") || !open("script_command_socket") || !open("reverse_socket");
  return {};
}

void FarProgram::stop() {
  for (Descriptor* one : {&stream_, &trajectory_, &commands_}) *one = Descriptor();
  if (kind_ == Kind::none) return;
  kind_ = Kind::none;
  moves_.forget();
  machine_.brake(kStop);
  machine_.program(Machine::Program::none);
}

void FarProgram::pause(bool on) {
  if (kind_ == Kind::none) return;
  machine_.program(on ? Machine::Program::paused : Machine::Program::playing);
  moves_.interrupt();
  if (on) machine_.brake(kStop);
}

/// What the program still has to move ends, as when its reading fails.
void FarProgram::close_stream() {
  stream_ = Descriptor();
  if (kind_ != Kind::moves) return;
  moves_.forget();
  machine_.brake(kStop);
}

void FarProgram::play() {
  if (runs())
    pause(false);
  else if (!text_.empty())
    start(std::string(text_));
}

void FarProgram::finish(ScriptState state) {
  if (is_ours()) machine_.set_register("output_int_register_25", static_cast<int>(state));
  moves_.forget();
  machine_.brake(kStop);
  ended_ = true;
}

void FarProgram::take_own(Bytes bytes) {
  const Message message =
      decode_message(std::span<const std::uint8_t, kMessageBytes>(bytes.data(), kMessageBytes));
  sequence_ = message.sequence;
  wait_limit_ = std::max(message.timeout_ms, 0) / 1000.0;
  machine_.set_register("output_int_register_24", sequence_);
  if (static_cast<int>(message.mode) < 0) return finish(ScriptState::ended);
  if (message.mode == Mode::velocity) return machine_.speed(message.values, kSpeedAcceleration);
  if (message.mode != Mode::position) return machine_.brake(kStop);
  for (std::size_t i = 0; i < 6; ++i)
    if (std::abs(message.values[i] - machine_.q()[i]) > 0.63) return finish(ScriptState::jumped);
  machine_.servo(message.values, lookahead_);
}

void FarProgram::take_moves(Bytes bytes) {
  const MoveMessage message =
      decode_move(std::span<const std::uint8_t, kMoveBytes>(bytes.data(), kMoveBytes));
  sequence_ = message.sequence;
  wait_limit_ = std::max(message.timeout_ms, 0) / 1000.0;
  machine_.set_register("output_int_register_24", sequence_);
  if (static_cast<int>(message.work) < 0 || !moves_.take(message)) finish(ScriptState::ended);
}

std::size_t FarProgram::message_bytes() const {
  return kind_ == Kind::own ? kMessageBytes : kind_ == Kind::moves ? kMoveBytes : kExternalBytes;
}

void FarProgram::take_external(Bytes bytes) {
  wire::Reader in(bytes);
  wait_limit_ = std::max(in.i32(), 0) / 1000.0;
  Six values{};
  for (double& value : values) value = in.i32() / kExternalScale;
  ++sequence_;
  switch (in.i32()) {
    case -2:
      return finish(ScriptState::ended);
    case 1:
      return machine_.servo(values, lookahead_);
    case 2:
      return machine_.speed(values, kSpeedAcceleration);
    default:
      return machine_.brake(kStop);
  }
}

void FarProgram::take(Bytes message) {
  quiet_ = 0;
  ++messages_;
  if (machine_.program() != Machine::Program::playing) return;
  if (kind_ == Kind::own) return take_own(message);
  kind_ == Kind::moves ? take_moves(message) : take_external(message);
}

bool FarProgram::serve() {
  if (kind_ == Kind::none) return false;
  const std::size_t size = message_bytes();
  std::array<std::uint8_t, 4096> bytes;
  while (stream_ && !ended_ && !faults_.deaf && machine_.program() == Machine::Program::playing) {
    const wire::Received got = wire::receive(stream_.number(), bytes);
    if (got.got == wire::Got::nothing) break;
    if (got.got != wire::Got::bytes) {
      finish(ScriptState::timed_out);
      break;
    }
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(got.count));
    while (buffer_.size() >= size && !ended_) {
      take(Bytes(buffer_).first(size));
      buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(size));
    }
  }
  for (Descriptor* other : {&trajectory_, &commands_})  // read, so that they do not fill up
    while (*other && wire::receive(other->number(), bytes).got == wire::Got::bytes) {
    }
  if (!ended_) return false;
  const bool standing = machine_.still();
  if (!standing) return false;
  ended_ = false;
  stop();
  return true;
}

void FarProgram::step(double dt) {
  if (kind_ == Kind::moves && !ended_ && machine_.program() == Machine::Program::playing) moves_.step(dt);
  if (!runs() || ended_ || !stream_ || faults_.deaf || machine_.program() != Machine::Program::playing)
    return;
  quiet_ += dt;
  if (wait_limit_ > 0 && quiet_ > wait_limit_ + dt) finish(ScriptState::timed_out);
}

void FarProgram::descriptors(std::vector<int>& out) const {
  if (stream_ && !faults_.deaf) out.push_back(stream_.number());
}

}  // namespace polyarm::ur
