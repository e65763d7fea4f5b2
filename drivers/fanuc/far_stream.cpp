/// Stream Motion of the simulated controller.
#include <algorithm>
#include <cmath>

#include "drivers/fanuc/far_services.hpp"

namespace polyarm::fanuc {

namespace {
constexpr int kMostMissed = 10;  // cycles without a command; measured on a CRX: 9 to 15
constexpr std::size_t kMostBuffered = 32;
constexpr double kFarStart = 0.1;    // degrees between the first command and the robot
constexpr double kRounding = 1.001;  // of a limit
constexpr const char* kKinds[] = {"velocity", "acceleration", "jerk"};
}  // namespace

FarStream::FarStream(Machine& machine, FarFaults& faults, double period)
    : machine_(machine), faults_(faults), period_(period) {
  for (int axis = 1; axis <= 6; ++axis)
    for (std::size_t kind = 0; kind < 3; ++kind)
      tables_[3 * static_cast<std::size_t>(axis - 1) + kind] =
          machine.limits(axis, static_cast<LimitKind>(kind));
}

void FarStream::listen(const std::string& address, int port) {
  std::string why;
  socket_ = wire::bind_udp(address, port, why);
  if (!socket_) throw Error("no-port", why, "choose another port, or end the program that uses it");
}

void FarStream::serve() {
  std::array<std::uint8_t, bounds::kStreamPacketBytes> bytes;
  wire::UdpAddress from;
  for (int i = 0; i < 256; ++i) {
    const wire::Received got = wire::receive_datagram(socket_.number(), bytes, &from);
    if (got.got != wire::Got::bytes) return;
    if (!faults_.silent) take(Bytes(bytes).first(got.count), from);
  }
}

void FarStream::take(Bytes packet, const wire::UdpAddress& from) {
  const auto type = static_cast<PacketType>(type_of(packet));
  const bool bare = packet.size() == 8;  // start and stop: type and version
  wire::Reader in(packet);
  in.u32();
  if (type == PacketType::stop && bare) {
    started_ = client_answers_ = false;
    buffer_.clear();
    return;
  }
  const auto reply = [&](const std::vector<std::uint8_t>& out) {
    wire::send_datagram(socket_.number(), out, from);
  };
  if (const auto asked = decode_capability(packet)) {
    if (asked->set) start_move_ = std::min(asked->start_move, 9u);
    const auto sampling = static_cast<std::uint32_t>(std::lround(period_ * 1000));
    return reply(encode(Capability{asked->set, version(), sampling, start_move_, version(), 0}));
  }
  if (const auto asked = decode_limit_request(packet))
    return reply(encode(machine_.limits(static_cast<int>(asked->axis), asked->kind), asked->version));
  if (const auto setup = decode_io_setup(packet)) {
    std::size_t states = 0, commands = 0;
    bool valid = true;
    for (const IoRow& row : *setup) {
      if (row.direction == IoDirection::none) continue;
      const bool state = row.direction == IoDirection::state || row.direction == IoDirection::register_state;
      (state ? states : commands) += row.bytes();
      valid = valid && row.bytes() > 0 && row.first + row.count - 1 <= Machine::kPorts;
    }
    valid = valid && states <= sizeof(IoArea) && commands <= sizeof(IoArea);
    if (valid) io_ = *setup;
    return reply(encode_io_result(valid ? 0 : 1));
  }
  if (type == PacketType::start && bare) {
    client_ = from;
    return take_start(in.u32());
  }
  if (faults_.deaf || !started_ || !client_ || !(from == *client_)) return;
  if (const auto command = decode_command(packet)) take_command(*command);
}

void FarStream::take_start(std::uint32_t version) {
  if (version != this->version()) return machine_.alarm("MOTN-607 ST: Version mismatch");
  if (started_) return;
  negotiated_ = version;
  started_ = true;
  client_answers_ = false;
  sequence_ = sent_ = answered_ = due_ = 0;
  buffer_.clear();
  packets_.clear();
}

void FarStream::take_command(const Command& command) {
  ++commands_;
  client_answers_ = true;
  if (command.sequence > sequence_ || command.sequence + 64 < sequence_) return;  // of no packet of ours
  answered_ = std::max(answered_, command.sequence);
  if (command.version != negotiated_) return machine_.alarm("MOTN-607 ST: Version mismatch");
  if (command.style != 0xFFFF) return machine_.alarm("MOTN-625 ST: Position data is abnormal");
  apply_outputs(command.io);
  const bool next = buffer_.empty() ? command.sequence >= due_ : command.sequence > buffer_.back().sequence;
  if (command.motion && next && buffer_.size() < kMostBuffered) buffer_.push_back(command);
}

void FarStream::apply_outputs(const IoArea& io) {
  std::size_t offset = 0;
  for (const IoRow& row : io_) {
    if (row.direction != IoDirection::command && row.direction != IoDirection::register_command) continue;
    const bool digital_row =
        row.direction == IoDirection::command && row.kind == static_cast<std::uint32_t>(IoKind::digital_out);
    for (std::uint32_t i = 0; digital_row && i < row.count; ++i)
      machine_.set_output(static_cast<int>(row.first + i), digital(io, offset, i));
    offset += row.bytes();
  }
}

bool FarStream::ready() const {
  return program_ && started_ && !faults_.stuck && machine_.may_move();
}

void FarStream::program(bool on) {
  program_ = on;
  moving_ = false;
  buffer_.clear();
  missed_ = 0;
  velocity_ = acceleration_ = {};
}

/// The controller judges differences between commands. One beyond a limit raises an alarm and is not driven.
bool FarStream::judge(const Six& next) {
  const Six& at = machine_.commanded();
  const double steps = kLimitSteps - 1;
  bool good = true;
  for (std::size_t i = 0; i < 6; ++i) {
    const double velocity = (next[i] - at[i]) / period_;
    const double acceleration = (velocity - velocity_[i]) / period_;
    const double values[] = {velocity, acceleration, (acceleration - acceleration_[i]) / period_};
    for (std::size_t kind = 0; kind < 3; ++kind) {
      const LimitTable& table = tables_[3 * i + kind];
      const auto step = static_cast<std::size_t>(std::clamp(speed_ / table.max_speed * steps, 0.0, steps));
      if (std::abs(values[kind]) <= table.empty[step] * kRounding) continue;
      good = false;
      machine_.alarm("MOTN-61" + std::to_string(kind) + " ST: " + kKinds[kind] + " limit over (axis " +
                     std::to_string(i + 1) + ")");
    }
    velocity_[i] = velocity;
    acceleration_[i] = acceleration;
  }
  return good;
}

void FarStream::follow() {
  if (!ready()) {
    if (!machine_.may_move()) {
      if (program_ && machine_.robot_bits() != 0) program_ = false;
      machine_.stop();
    }
    moving_ = false;
    buffer_.clear();
    return;
  }
  if (!moving_ && buffer_.size() <= start_move_) return;  // it buffers some commands first
  Six next = machine_.commanded();
  bool last = false;
  if (!buffer_.empty()) {
    const Command command = buffer_.front();
    buffer_.pop_front();
    due_ = command.sequence + 1;
    last = command.last;
    missed_ = 0;
    std::copy_n(command.joints.begin(), 6, next.begin());
    if (!moving_)
      for (std::size_t i = 0; i < 6; ++i)
        if (std::abs(next[i] - machine_.q()[i]) > kFarStart)
          return machine_.alarm("MOTN-609 ST: First position is away from the robot");
    if (!judge(next)) return machine_.stop();
    moving_ = true;
  } else if (++missed_ > kMostMissed) {
    program(false);  // measured on a CRX: no alarm
    machine_.stop();
    return;
  } else {  // goes on; the command of this cycle is not taken any more
    ++due_;
    for (std::size_t i = 0; i < 6; ++i) next[i] += velocity_[i] * period_;
  }
  machine_.drive(next);
  if (last) program(false);
}

void FarStream::cycle() {
  follow();
  machine_.step(period_);
  const auto before = pose_;
  pose_ = Machine::pose_values(machine_.flange(machine_.q()));
  speed_ = std::hypot(pose_[0] - before[0], pose_[1] - before[1], pose_[2] - before[2]) / period_;
  if (started_) send();
}

Status FarStream::status() const {
  Status out;
  out.version = negotiated_;
  out.with_force = negotiated_ >= 4;
  out.sequence = sequence_;
  out.status = static_cast<std::uint8_t>((ready() ? ready_bit : 0) | (client_answers_ ? received_bit : 0) |
                                         system_ready_bit | (machine_.moving() ? moving_bit : 0));
  out.robot = machine_.robot_bits();
  out.contact_stop = static_cast<std::uint8_t>(machine_.contact());
  out.time_ms =
      static_cast<std::uint32_t>(std::llround(machine_.time() * 1000) / 2 * 2);  // it has 2 ms steps
  for (std::size_t i = 0; i < 6; ++i) {
    out.joints[i] = static_cast<float>(machine_.q()[i]);
    out.pose[i] = static_cast<float>(pose_[i]);
  }
  std::size_t offset = 0;
  for (const IoRow& row : io_) {
    if (row.direction != IoDirection::state && row.direction != IoDirection::register_state) continue;
    const bool input = row.kind == static_cast<std::uint32_t>(IoKind::digital_in);
    const bool output = row.kind == static_cast<std::uint32_t>(IoKind::digital_out);
    for (std::uint32_t i = 0; (input || output) && i < row.count; ++i) {
      const int port = static_cast<int>(row.first + i);
      set_digital(out.io, offset, i, input ? machine_.input(port) : machine_.output(port));
    }
    offset += row.bytes();
  }
  return out;
}

void FarStream::send() {
  ++sequence_;
  std::vector<std::uint8_t> packet = encode(status());
  if (faults_.silent) return;
  if (std::exchange(faults_.garbage, false)) packet.resize(packet.size() / 2);
  const auto send = [this](const std::vector<std::uint8_t>& one) {
    if (client_) wire::send_datagram(socket_.number(), one, *client_);
  };
  if (packets_.pass(std::move(packet), faults_, send, send) != wire::PacketQueue::Went::nowhere)
    sent_ = sequence_;
}

}  // namespace polyarm::fanuc
