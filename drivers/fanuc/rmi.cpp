#include "drivers/fanuc/rmi.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::fanuc {

namespace {

using Json = nlohmann::json;

void flatten(const Json& object, const std::string& prefix, RmiMessage& out) {
  for (const auto& [key, value] : object.items()) {
    const std::string name = prefix + key;
    if (value.is_number()) out.numbers.insert_or_assign(name, value.get<double>());
    if (value.is_boolean()) out.numbers.insert_or_assign(name, value.get<bool>() ? 1 : 0);
    if (value.is_string()) out.texts.insert_or_assign(name, value.get<std::string>());
    if (value.is_object()) flatten(value, name + ".", out);
  }
}

std::string quoted(std::string_view text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

struct ErrorRow {
  int id;
  const char* words;
};
constexpr ErrorRow kErrors[] = {
    {2556929, "internal error of the controller"},
    {2556930, "no such tool number"},
    {2556931, "no such user frame number"},
    {2556932, "no such position register"},
    {2556933, "the speed override is out of range"},
    {2556934, "the program cannot be run"},
    {2556935, "the servos are off"},
    {2556936, "the program cannot be run"},
    {2556937, "remote motion is not running"},
    {2556938, "the program is not paused"},
    {2556939, "the program cannot be resumed"},
    {2556940, "the controller cannot be reset"},
    {2556941, "unknown command"},
    {2556942, "the command failed"},
    {2556943, "the controller's state does not allow it"},
    {2556944, "the controller must be switched off and on"},
    {2556945, "no such payload schedule"},
    {2556946, "wrong motion option"},
    {2556947, "no such vision register"},
    {2556948, "unknown instruction"},
    {2556949, "wrong value"},
    {2556950, "wrong text"},
    {2556951, "wrong position"},
    {2556952, "remote motion is on hold"},
    {2556953, "the other end disconnected"},
    {2556954, "another program is already connected"},
    {2556955, "the last command is not finished"},
    {2556956, "too many instructions wait"},
    {2556957, "wrong sequence number"},
    {2556958, "wrong speed type"},
    {2556959, "wrong speed"},
    {2556960, "wrong termination type"},
    {2556961, "wrong termination value"},
    {2556962, "wrong port type"},
    {2556963, "wrong acceleration"},
    {2556964, "the destination cannot be reached"},
    {2556965, "the via position cannot be reached"},
    {2556966, "no such port"},
    {2556967, "no such motion group"},
    {2556968, "wrong group mask"},
    {2556971, "single step mode is on"},
    {2556972, "wrong type of position"},
    {2556977, "the instruction is not complete"},
    {2556980, "wrong application tool"},
    {2556981, "there is no program of that name"},
    {7015, "RMI_MOVE is selected at the teach pendant; select another program there"},
    {7004, "the program is in use"},
};

}  // namespace

double RmiMessage::number(std::string_view key, double otherwise) const {
  const auto found = numbers.find(key);
  return found == numbers.end() ? otherwise : found->second;
}

std::string RmiMessage::text(std::string_view key) const {
  const auto found = texts.find(key);
  return found == texts.end() ? std::string() : found->second;
}

std::optional<int> RmiMessage::whole(std::string_view key, int low, int high) const {
  const auto found = numbers.find(key);
  if (found == numbers.end()) return std::nullopt;
  const double value = found->second;
  if (!(value >= low && value <= high) || value != std::floor(value)) return std::nullopt;
  return static_cast<int>(value);
}

std::optional<RmiMessage> parse_rmi(std::string_view line) {
  bool deep = false;
  const auto watch = [&](int depth, Json::parse_event_t, Json&) {
    deep = deep || depth > static_cast<int>(bounds::kRmiNesting);
    return !deep;
  };
  const Json json = Json::parse(line, watch, false);
  if (deep || !json.is_object()) return std::nullopt;
  RmiMessage out;
  flatten(json, "", out);
  using Kind = RmiMessage::Kind;
  for (const auto& [key, kind] :
       {std::pair{"Communication", Kind::communication}, std::pair{"Command", Kind::command},
        std::pair{"Instruction", Kind::instruction}})
    if (const auto found = out.texts.find(key); found != out.texts.end() && out.kind == Kind::unknown) {
      out.kind = kind;
      out.name = found->second;
    }
  return out;
}

RmiLine& RmiLine::put(std::string_view key, const std::string& value) {
  text_ += (text_.empty() ? "" : ",") + quoted(key) + ":" + value;
  return *this;
}

RmiLine& RmiLine::text(std::string_view key, std::string_view value) {
  return put(key, quoted(value));
}

RmiLine& RmiLine::number(std::string_view key, double value) {
  const bool whole = value == std::floor(value) && std::abs(value) < 1e15;
  return put(key, whole ? Json(static_cast<std::int64_t>(value)).dump() : Json(value).dump());
}

RmiLine& RmiLine::group(std::string_view key, Group values) {
  RmiLine inner("", "");
  inner.text_.clear();
  for (const auto& [name, value] : values) inner.number(name, value);
  return put(key, "{" + inner.text_ + "}");
}

const char* rmi_error(int id) {
  for (const ErrorRow& row : kErrors)
    if (row.id == id) return row.words;
  return "unknown error";
}

bool RmiSession::send(const RmiLine& line) {
  return socket_ && wire::send_frame(socket_.number(), line.line());
}

std::optional<RmiMessage> RmiSession::ask(std::string_view kind, std::string_view name, const RmiLine& line,
                                          Nanoseconds timeout) {
  if (!send(line)) return std::nullopt;
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  std::optional<RmiMessage> answer;
  const RmiMessage::Kind wanted = kind == "Command"         ? RmiMessage::Kind::command
                                  : kind == "Communication" ? RmiMessage::Kind::communication
                                                            : RmiMessage::Kind::instruction;
  while (!answer) {
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0 || !wire::wait_readable(socket_.number(), left)) return std::nullopt;
    const bool open = poll([&](const RmiMessage& message) {
      const bool ours = message.kind == wanted && message.name == name;
      if (!answer && (ours || message.name == "Unknown")) answer = message;
    });
    if (!open && !answer) return std::nullopt;
  }
  return answer;
}

bool RmiSession::open(const std::string& host, int port, const std::string& greeting, Nanoseconds timeout,
                      std::string& why, int& error) {
  error = 0;
  lines_.reset();
  socket_ = wire::connect_tcp(host, port, timeout, why);
  if (!socket_) return false;
  const auto answer = ask("Communication", greeting, RmiLine("Communication", greeting), timeout);
  socket_ = Descriptor();
  lines_.reset();
  if (!answer) {
    why = "port " + std::to_string(port) + " gives no answer";
    return false;
  }
  error = answer->error();
  const auto session = answer->whole("PortNumber", 1, 65535);
  if (error != 0 || !session) {
    if (error == 0) error = kRmiFailed;
    return false;
  }
  version_ = std::to_string(answer->whole("MajorVersion", 0, 1000).value_or(0)) + "." +
             std::to_string(answer->whole("MinorVersion", 0, 1000).value_or(0));
  socket_ = wire::connect_tcp(host, *session, timeout, why);
  if (!socket_) error = kRmiConnected;  // the controller gives the port also while another program uses it
  return static_cast<bool>(socket_);
}

void RmiSession::close(Nanoseconds timeout) {
  if (socket_) ask("Communication", "FRC_Disconnect", RmiLine("Communication", "FRC_Disconnect"), timeout);
  socket_ = Descriptor();
}

}  // namespace polyarm::fanuc
