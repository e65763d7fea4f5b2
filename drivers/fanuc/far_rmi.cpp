/// The Remote Motion Interface of the simulated controller.
#include <algorithm>
#include <cmath>

#include "drivers/fanuc/far_services.hpp"

namespace polyarm::fanuc {

namespace {

constexpr int kMajor = 9, kMinor = 0;
using Pairs = std::vector<std::pair<const char*, double>>;

Pairs pose_group(const std::array<double, 6>& v, bool extra) {
  Pairs out{{"X", v[0]}, {"Y", v[1]}, {"Z", v[2]}, {"W", v[3]}, {"P", v[4]}, {"R", v[5]}};
  if (extra)
    for (const char* one : {"Ext1", "Ext2", "Ext3"}) out.emplace_back(one, 0);
  return out;
}

double rounded(double value) {
  return std::round(value * 1000) / 1000;  // the interface has three places
}

bool on(const RmiMessage& message) {
  return message.text("PortValue") == "ON" || message.number("PortValue") != 0;
}

}  // namespace

const FarRmi::Entry FarRmi::kCommands[] = {{"FRC_Initialize", &FarRmi::initialize},
                                           {"FRC_Abort", &FarRmi::abort_command},
                                           {"FRC_Pause", &FarRmi::pause_command},
                                           {"FRC_Continue", &FarRmi::resume},
                                           {"FRC_Reset", &FarRmi::reset},
                                           {"FRC_ReadError", &FarRmi::read_error},
                                           {"FRC_GetStatus", &FarRmi::get_status},
                                           {"FRC_GetExtStatus", &FarRmi::get_more_status},
                                           {"FRC_SetOverRide", &FarRmi::set_override},
                                           {"FRC_SetUFrameUTool", &FarRmi::set_frames},
                                           {"FRC_GetUFrameUTool", &FarRmi::get_frames},
                                           {"FRC_ReadUFrameData", &FarRmi::read_frame},
                                           {"FRC_WriteUFrameData", &FarRmi::write_frame},
                                           {"FRC_ReadUToolData", &FarRmi::read_frame},
                                           {"FRC_WriteUToolData", &FarRmi::write_frame},
                                           {"FRC_ReadJointAngles", &FarRmi::read_joints},
                                           {"FRC_ReadCartesianPosition", &FarRmi::read_pose},
                                           {"FRC_ReadTCPSpeed", &FarRmi::read_speed},
                                           {"FRC_ReadDIN", &FarRmi::read_port},
                                           {"FRC_ReadIOPort", &FarRmi::read_port},
                                           {"FRC_WriteDOUT", &FarRmi::write_port},
                                           {"FRC_WriteIOPort", &FarRmi::write_port},
                                           {"FRC_ReadRegister", &FarRmi::read_register},
                                           {"FRC_WriteRegister", &FarRmi::write_register},
                                           {"FRC_SetPayloadID", &FarRmi::accept},
                                           {"FRC_SetPayloadValue", &FarRmi::accept},
                                           {"FRC_SetPayloadComp", &FarRmi::accept},
                                           {nullptr, nullptr}};

FarRmi::FarRmi(Machine& machine, FarFaults& faults, FarStream& stream)
    : machine_(machine),
      faults_(faults),
      stream_(stream),
      motion_(machine, [this](const std::string& name, int sequence, int error) {
        answer(RmiLine("Instruction", name).number("ErrorID", error).number("SequenceID", sequence));
      }) {}

void FarRmi::listen(const std::string& address, int port, int session_port) {
  door_.listen(address, port);
  address_ = address;
  session_port_ = session_port;
}

void FarRmi::open_session() {
  if (session_ || listener_ || faults_.busy) return;  // the port is given all the same, as the real one does
  std::string why;
  listener_ = wire::listen_tcp(address_, session_port_, why);
  if (listener_) session_port_ = wire::local_port(listener_.number());
}

void FarRmi::take_greeting(Client& client, const RmiMessage& message) {
  if (faults_.mute) return;
  const bool greeting = message.kind == RmiMessage::Kind::communication &&
                        (message.name == "FRC_Connect" || message.name == "FRC_Connect_STMO");
  if (!greeting) {
    wire::send_frame(client.socket.number(),
                     RmiLine("Command", "Unknown").number("ErrorID", kRmiBadCommand).line());
    return;
  }
  open_session();
  const int port = session_port_ > 0 ? session_port_ : 16002;
  wire::send_frame(client.socket.number(), RmiLine("Communication", message.name)
                                               .number("ErrorID", 0)
                                               .number("PortNumber", port)
                                               .number("MajorVersion", kMajor)
                                               .number("MinorVersion", kMinor)
                                               .line());
}

void FarRmi::serve() {
  door_.serve([](Client&) {},
              [this](Client& client, Bytes bytes) {
                return client.lines.feed(bytes, [&](std::string_view line) {
                  if (const auto message = parse_rmi(line)) take_greeting(client, *message);
                });
              });
  if (listener_)
    if (Descriptor socket = wire::accept_tcp(listener_.number())) {
      session_ = std::make_unique<Client>();
      session_->socket = std::move(socket);
      listener_ = Descriptor();
    }
  if (!session_) return;
  std::array<std::uint8_t, 4096> bytes;
  while (session_ && !session_->gone) {
    const wire::Received got = wire::receive(session_->socket.number(), bytes);
    if (got.got == wire::Got::nothing) break;
    const bool whole = got.got == wire::Got::bytes &&
                       session_->lines.feed(Bytes(bytes).first(got.count), [&](std::string_view line) {
                         const auto message = parse_rmi(line);
                         take(message ? *message : RmiMessage{});
                       });
    if (!whole) session_->gone = true;
  }
  if (session_ && session_->gone) {  // without a remote program nothing goes on
    session_.reset();
    abort();
    motion_.begin_again();
  }
}

void FarRmi::descriptors(std::vector<int>& out) {
  out.push_back(door_.listener());
  for (const auto& client : door_.clients()) out.push_back(client->socket.number());
  if (listener_) out.push_back(listener_.number());
  if (session_) out.push_back(session_->socket.number());
}

void FarRmi::drop() {
  door_.drop_all();
  session_.reset();
  listener_ = Descriptor();
  abort();
  motion_.clear(true);
  motion_.begin_again();
}

void FarRmi::terminate() {
  answer(RmiLine("Communication", "FRC_Terminate"));
  if (session_) session_->gone = true;
  abort();
}

void FarRmi::abort() {
  motion_.clear();
  stream_.program(false);
  initialized_ = false;
}

void FarRmi::pause(bool on) {
  motion_.hold(on);
}

void FarRmi::cycle(double dt) {
  motion_.cycle(dt);
  report_fault();
}

void FarRmi::report_fault() {
  if (machine_.alarm_text() == reported_) return;
  reported_ = machine_.alarm_text();
  if (!reported_.empty() && initialized_)
    answer(RmiLine("Communication", "FRC_SystemFault").number("SequenceID", motion_.next_sequence()));
}

void FarRmi::answer(RmiLine line) {
  if (session_ && !faults_.mute && !wire::send_frame(session_->socket.number(), line.line()))
    session_->gone = true;
}

RmiLine FarRmi::reply(const RmiMessage& message, int error) const {
  const bool instruction = message.kind == RmiMessage::Kind::instruction;
  RmiLine out(instruction ? "Instruction" : "Command", message.name);
  out.number("ErrorID", error);
  if (instruction) out.number("SequenceID", message.number("SequenceID"));
  return out;
}

void FarRmi::answer(const RmiMessage& message, int error) {
  answer(reply(message, error));
}

void FarRmi::take(const RmiMessage& message) {
  if (message.kind == RmiMessage::Kind::communication && message.name == "FRC_Disconnect") {
    answer(RmiLine("Communication", "FRC_Disconnect").number("ErrorID", 0));
    session_->gone = true;
    return;
  }
  if (message.kind == RmiMessage::Kind::instruction) return take_instruction(message);
  if (message.kind == RmiMessage::Kind::command)
    for (const Entry* one = kCommands; one->name; ++one)
      if (message.name == one->name) return (this->*one->handler)(message);
  answer(RmiLine("Command", "Unknown").number("ErrorID", kRmiBadCommand));
}

void FarRmi::take_instruction(const RmiMessage& message) {
  if (!initialized_) return answer(message, kRmiNotRunning);
  if (message.name != "FRC_Call") {
    const int error = stream_.program_runs() ? kRmiWaitInstruction : motion_.add(message);
    if (error != 0) answer(message, error);
    return;
  }
  if (faults_.no_stream || message.text("ProgramName") != "STREAM_MOTN") return answer(message, kRmiProgram);
  stream_.program(true);
  answer(message, 0);
}

void FarRmi::initialize(const RmiMessage& message) {
  if (faults_.refuse) return answer(message, kRmiBadState);
  if (!machine_.servo_ready()) return answer(message, kRmiServoOff);
  if (!motion_.idle() || stream_.program_runs()) return answer(message, kRmiCannotRun);
  initialized_ = true;
  motion_.clear();
  motion_.begin_again();
  answer(reply(message).number("GroupMask", message.number("GroupMask", 1)));
}

void FarRmi::abort_command(const RmiMessage& message) {
  abort();
  answer(message, 0);
}

void FarRmi::pause_command(const RmiMessage& message) {
  if (!initialized_) return answer(message, kRmiNotRunning);
  motion_.hold(true);
  answer(message, 0);
}

void FarRmi::resume(const RmiMessage& message) {
  if (!motion_.held()) return answer(message, kRmiNotPaused);
  if (!machine_.servo_ready()) return answer(message, kRmiCannotResume);
  motion_.hold(false);
  answer(message, 0);
}

void FarRmi::reset(const RmiMessage& message) {
  machine_.reset();
  reported_ = machine_.alarm_text();
  answer(message, 0);
}

void FarRmi::read_error(const RmiMessage& message) {
  const std::string& text = machine_.alarm_text();
  answer(reply(message).number("Count", 1).text("ErrorData", text.empty() ? "No Error" : text));
}

void FarRmi::get_status(const RmiMessage& message) {
  answer(reply(message)
             .number("ServoReady", machine_.servo_ready())
             .number("TPMode", machine_.mode() != TeachMode::automatic)
             .number("RMIMotionStatus", initialized_)
             .number("ProgramStatus", !initialized_    ? 1
                                      : motion_.held() ? 2
                                                       : 0)
             .number("SingleStepMode", 0)
             .number("NumberUTool", machine_.tool)
             .number("NextSequenceID", motion_.next_sequence())
             .number("NumberUFrame", machine_.frame)
             .number("Override", machine_.override_percent));
}

void FarRmi::get_more_status(const RmiMessage& message) {
  constexpr const char* kModes[] = {"AUTO", "T1", "T2"};
  answer(reply(message)
             .text("ErrorCode", machine_.alarm_text().empty() ? "No Error" : machine_.alarm_text())
             .number("InMotion", machine_.moving())
             .text("ControlMode", kModes[static_cast<std::size_t>(machine_.mode())])
             .number("DrivesPowered", machine_.servo_ready())
             .number("GenOverride", machine_.override_percent)
             .number("SpeedClampLimit", 100));
}

void FarRmi::set_override(const RmiMessage& message) {
  const auto value = message.whole("Value", 1, 100);
  if (value) machine_.override_percent = *value;
  answer(message, value ? 0 : kRmiOverride);
}

void FarRmi::set_frames(const RmiMessage& message) {
  const auto frame = message.whole("UFrameNumber", 0, 20), tool = message.whole("UToolNumber", 0, 20);
  if (!frame || !tool) return answer(message, frame ? kRmiToolNumber : kRmiFrameNumber);
  machine_.frame = *frame;
  machine_.tool = *tool;
  answer(message, 0);
}

void FarRmi::get_frames(const RmiMessage& message) {
  answer(reply(message).number("UFrameNumber", machine_.frame).number("UToolNumber", machine_.tool));
}

/// Of frames and tools.
void FarRmi::read_frame(const RmiMessage& message) {
  const bool tool = message.name == "FRC_ReadUToolData";
  const char* key = tool ? "ToolNumber" : "FrameNumber";
  const auto number = message.whole(key, 0, 20);
  if (!number) return answer(message, tool ? kRmiToolNumber : kRmiFrameNumber);
  auto& all = tool ? machine_.tools : machine_.frames;
  answer(reply(message).number(key, *number).group("Frame", pose_group(all[*number], false)));
}

void FarRmi::write_frame(const RmiMessage& message) {
  const bool tool = message.name == "FRC_WriteUToolData";
  const auto number = message.whole(tool ? "ToolNumber" : "FrameNumber", 1, 20);
  if (!number) return answer(message, tool ? kRmiToolNumber : kRmiFrameNumber);
  std::array<double, 6> values{};
  constexpr const char* kKeys[] = {"Frame.X", "Frame.Y", "Frame.Z", "Frame.W", "Frame.P", "Frame.R"};
  for (std::size_t i = 0; i < 6; ++i) {
    values[i] = message.number(kKeys[i], NAN);
    if (!(std::abs(values[i]) < 1e5)) return answer(message, kRmiBadPosition);
  }
  (tool ? machine_.tools : machine_.frames)[*number] = values;
  answer(message, 0);
}

void FarRmi::read_joints(const RmiMessage& message) {
  Six q = machine_.q();
  q[2] -= q[1];  // this interface has joint 3 against the horizontal
  Pairs joints;
  constexpr const char* kKeys[] = {"J1", "J2", "J3", "J4", "J5", "J6", "J7", "J8", "J9"};
  for (std::size_t i = 0; i < 9; ++i) joints.emplace_back(kKeys[i], i < 6 ? rounded(q[i]) : 0);
  answer(reply(message).number("TimeTag", std::floor(machine_.time() * 1000)).group("JointAngle", joints));
}

void FarRmi::read_pose(const RmiMessage& message) {
  const auto part = [](auto& all, int number) {
    const auto found = all.find(number);
    return found == all.end() ? Pose{} : Machine::pose_of(found->second);
  };
  const Pose pose = inverse(part(machine_.frames, machine_.frame)) * machine_.flange(machine_.q()) *
                    part(machine_.tools, machine_.tool);
  std::array<double, 6> values = Machine::pose_values(pose);
  for (double& value : values) value = rounded(value);
  const Pairs configuration{{"UToolNumber", static_cast<double>(machine_.tool)},
                            {"UFrameNumber", static_cast<double>(machine_.frame)},
                            {"Front", 1},
                            {"Up", 1},
                            {"Left", 0},
                            {"Flip", 0},
                            {"Turn4", 0},
                            {"Turn5", 0},
                            {"Turn6", 0}};
  answer(reply(message)
             .number("TimeTag", std::floor(machine_.time() * 1000))
             .group("Configuration", configuration)
             .group("Position", pose_group(values, true)));
}

void FarRmi::read_speed(const RmiMessage& message) {
  answer(reply(message).number("TimeTag", std::floor(machine_.time() * 1000)).number("Speed", 0));
}

void FarRmi::read_port(const RmiMessage& message) {
  const auto port = message.whole("PortNumber", 1, Machine::kPorts);
  const std::string type = message.text("PortType");
  if (!port || (!type.empty() && type != "DI" && type != "DO")) return answer(message, kRmiPort);
  RmiLine out = reply(message);
  if (!type.empty()) out.text("PortType", type);
  out.number("PortNumber", *port);
  answer(out.number("PortValue", type == "DO" ? machine_.output(*port) : machine_.input(*port)));
}

void FarRmi::write_port(const RmiMessage& message) {
  const auto port = message.whole("PortNumber", 1, Machine::kPorts);
  const std::string type = message.text("PortType");
  if (!port || (!type.empty() && type != "DO")) return answer(message, kRmiPort);
  machine_.set_output(*port, on(message));
  answer(message, 0);
}

void FarRmi::read_register(const RmiMessage& message) {
  const auto number = message.whole("RegisterNumber", 1, 1000);
  if (!number) return answer(message, kRmiBadValue);
  const double value = machine_.registers[*number];
  answer(reply(message)
             .text("DataType", value == std::floor(value) ? "integer" : "float")
             .number("RegisterValue", value));
}

void FarRmi::write_register(const RmiMessage& message) {
  const auto number = message.whole("RegisterNumber", 1, 1000);
  const double value = message.number("RegisterValue", NAN);
  if (!number || !std::isfinite(value)) return answer(message, kRmiBadValue);
  machine_.registers[*number] = value;
  answer(message, 0);
}

void FarRmi::accept(const RmiMessage& message) {
  answer(message, 0);
}

}  // namespace polyarm::fanuc
