#include "drivers/kuka/eki.hpp"

#include <fmt/format.h>

#include <array>

#include "drivers/wire/tcp.hpp"
#include "drivers/wire/xml.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::kuka {

namespace {

using wire::XmlDocument;

constexpr std::array<const char*, 6> kAxes{"A1", "A2", "A3", "A4", "A5", "A6"};
constexpr std::array<const char*, 6> kEnd{"P1", "P2", "P3", "P4", "P5", "P6"};
constexpr std::array<const char*, 6> kVia{"V1", "V2", "V3", "V4", "V5", "V6"};
constexpr std::array<const char*, 4> kNumbers{"Speed", "Rate", "Turn", "Blend"};
constexpr double kMostOfMove = 1e5;  // degrees, mm
constexpr int kHighestNumber = 1'000'000'000;

std::string six_in(const char* element, const Six& values) {
  std::string out = fmt::format("<{}", element);
  for (std::size_t i = 0; i < 6; ++i) out += fmt::format(" {}=\"{:.6f}\"", kAxes[i], values[i] + 0.0);
  return out + "/>";
}

std::string encode(const EkiMove& move) {
  std::string out = fmt::format("<Move Kind=\"{}\"", static_cast<int>(move.kind));
  for (std::size_t i = 0; i < 6; ++i) out += fmt::format(" {}=\"{:.6f}\"", kEnd[i], move.end[i] + 0.0);
  for (std::size_t i = 0; i < 6; ++i) out += fmt::format(" {}=\"{:.6f}\"", kVia[i], move.via[i] + 0.0);
  const double numbers[] = {move.speed, move.acceleration, move.turn, move.blend};
  for (std::size_t i = 0; i < 4; ++i) out += fmt::format(" {}=\"{:.6f}\"", kNumbers[i], numbers[i] + 0.0);
  return out + "></Move>";
}

/// Nothing if a value is missing or out of its range.
std::optional<EkiMove> decode_move(const XmlDocument& document,
                                   const XmlDocument::Element& element) noexcept {
  EkiMove out;
  bool fine = true;
  const auto number = [&](const char* name, double lowest) {
    const auto value = document.number(element, name);
    fine = fine && value && *value >= lowest && *value <= kMostOfMove;
    return value.value_or(0);
  };
  for (std::size_t i = 0; i < 6; ++i) out.end[i] = number(kEnd[i], -kMostOfMove);
  for (std::size_t i = 0; i < 6; ++i) out.via[i] = number(kVia[i], -kMostOfMove);
  double* const numbers[] = {&out.speed, &out.acceleration, &out.turn, &out.blend};
  for (std::size_t i = 0; i < 4; ++i) *numbers[i] = number(kNumbers[i], 0);
  const auto kind = document.integer(element, "Kind");
  if (!fine || !kind || *kind < EkiMove::none || *kind > EkiMove::circ) return std::nullopt;
  out.kind = static_cast<EkiMove::Kind>(*kind);
  return out;
}

/// Takes values out of the elements of a message. One that is missing or out of its range makes it useless.
class Fields {
 public:
  explicit Fields(const XmlDocument& document) : document_(document) {}
  bool ok() const { return ok_; }
  std::int64_t integer(const char* element, const char* name, std::int64_t lowest, std::int64_t highest) {
    const auto* found = document_.find(element);
    const auto value = found ? document_.integer(*found, name) : std::nullopt;
    if (value && *value >= lowest && *value <= highest) return *value;
    ok_ = false;
    return lowest;
  }
  bool flag(const char* element, const char* name) { return integer(element, name, 0, 1) == 1; }
  double number(const char* element, const char* name) {
    const auto* found = document_.find(element);
    const auto value = found ? document_.number(*found, name) : std::nullopt;
    if (!value) ok_ = false;
    return value.value_or(0);
  }
  Six six(const char* element) {
    Six out;
    for (std::size_t i = 0; i < 6; ++i) out[i] = number(element, kAxes[i]);
    return out;
  }
  std::string text(const char* element, const char* name) {
    const auto* found = document_.find(element);
    const auto value = found ? document_.attribute(*found, name) : std::nullopt;
    return value ? std::string(value->substr(0, 64)) : std::string();
  }

 private:
  const XmlDocument& document_;
  bool ok_ = true;
};

}  // namespace

std::string encode(const EkiRequest& request) {
  return fmt::format("<Polyarm Id=\"{}\" Do=\"{}\" Number=\"{}\" Value=\"{}\">{}</Polyarm>\n", request.id,
                     static_cast<int>(request.what), request.number, request.value,
                     request.move ? encode(*request.move) : std::string());
}

std::string encode(const EkiReply& reply) {
  const EkiState& s = reply.state;
  const EkiIdentity& i = reply.identity;
  return fmt::format(
             "<Robot><Answer Id=\"{}\" Result=\"{}\"/>"
             "<Panel Mode=\"{}\" EStop=\"{}\" Guard=\"{}\" Drives=\"{}\" Message=\"{}\" Program=\"{}\" "
             "Override=\"{}\" In=\"{}\" Out=\"{}\"/><Rsi On=\"{}\" Return=\"{}\"/>",
             reply.id, static_cast<int>(reply.result), static_cast<int>(s.mode), int{s.emergency_stop},
             int{s.guard_stop}, int{s.drives}, int{s.message}, static_cast<int>(s.program), s.speed_override,
             static_cast<std::int32_t>(s.inputs), static_cast<std::int32_t>(s.outputs), int{s.rsi},
             s.rsi_return) +
         six_in("Axes", s.axes) +
         fmt::format("<Moves On=\"{}\" Session=\"{}\" Ended=\"{}\" Halted=\"{}\" Time=\"{}\"/>", int{s.moves},
                     s.session, s.ended, s.halted, s.time_ms) +
         fmt::format(
             "<Init Version=\"{}\" NumAxes=\"{}\" Robot=\"{}\" Rsi=\"{}\" Cycle=\"{}\" Late=\"{}\" "
             "Limit=\"{:.6f}\" Relative=\"{}\"/>",
             i.version, i.axes, wire::xml_text(i.robot), i.rsi, i.cycle_ms, i.late_limit, i.correction_limit,
             int{i.relative}) +
         six_in("Low", i.lower) + six_in("High", i.upper) + "</Robot>\n";
}

bool EkiReader::find_end() {
  XmlDocument document;
  const auto result = document.read(buffer_);
  end_ = document.size();
  return result != XmlDocument::Result::bad &&
         (result == XmlDocument::Result::whole || buffer_.size() < bounds::kEkiMessageBytes);
}

bool EkiReader::feed(std::string_view bytes) {
  while (!bytes.empty()) {
    if (end_ == 0 && buffer_.empty())
      bytes.remove_prefix(std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size()));
    // Messages that nobody took are bounded too.
    if (buffer_.size() >= 2 * bounds::kEkiMessageBytes) return false;
    const std::size_t part = std::min(bytes.size(), bounds::kEkiMessageBytes);
    buffer_.append(bytes.substr(0, part));
    bytes.remove_prefix(part);
    if (end_ == 0 && !buffer_.empty() && !find_end()) return false;
  }
  return true;
}

std::string EkiReader::next() {
  if (end_ == 0) return {};
  std::string out = buffer_.substr(0, end_);
  const std::size_t begin = buffer_.find_first_not_of(" \t\r\n", end_);
  buffer_.erase(0, begin == std::string::npos ? buffer_.size() : begin);
  end_ = 0;
  if (!buffer_.empty() && !find_end()) end_ = 0;  // feed() says so with the next bytes
  return out;
}

std::optional<EkiRequest> decode_request(std::string_view text) noexcept {
  XmlDocument document;
  if (document.read(text) != XmlDocument::Result::whole || document.root().name != "Polyarm")
    return std::nullopt;
  const auto value = [&](const char* name) { return document.integer(document.root(), name); };
  const auto id = value("Id"), what = value("Do"), number = value("Number"), amount = value("Value");
  if (!id || !what || *what < 0 || *what > 255 || *id < 0 || *id > 1'000'000'000) return std::nullopt;
  const auto small = [](std::optional<std::int64_t> n) {
    return n && *n >= 0 && *n <= kHighestNumber ? static_cast<int>(*n) : 0;
  };
  EkiRequest out{static_cast<int>(*id), static_cast<EkiDo>(*what), small(number), small(amount), {}};
  if (const auto* move = document.find("Move")) {
    out.move = decode_move(document, *move);
    if (!out.move) return std::nullopt;
  }
  return out;
}

std::optional<EkiReply> decode_reply(std::string_view text) {
  XmlDocument document;
  if (document.read(text) != XmlDocument::Result::whole || document.root().name != "Robot")
    return std::nullopt;
  Fields f(document);
  EkiReply out;
  out.id = static_cast<int>(f.integer("Answer", "Id", 0, 1'000'000'000));
  out.result = static_cast<EkiResult>(f.integer("Answer", "Result", 0, 255));
  out.identity.version = static_cast<int>(f.integer("Init", "Version", 0, 1000));
  if (out.identity.version != kProgramVersion) return f.ok() ? std::optional(out) : std::nullopt;
  EkiState& s = out.state;
  s.mode = static_cast<OperatingMode>(f.integer("Panel", "Mode", 1, 4));
  s.emergency_stop = f.flag("Panel", "EStop");
  s.guard_stop = f.flag("Panel", "Guard");
  s.drives = f.flag("Panel", "Drives");
  s.message = f.flag("Panel", "Message");
  s.program = static_cast<ProgramState>(f.integer("Panel", "Program", 1, 5));
  s.speed_override = static_cast<int>(f.integer("Panel", "Override", 0, 100));
  s.inputs = static_cast<std::uint32_t>(f.integer("Panel", "In", -(1LL << 31), (1LL << 32) - 1));
  s.outputs = static_cast<std::uint32_t>(f.integer("Panel", "Out", -(1LL << 31), (1LL << 32) - 1));
  s.rsi = f.flag("Rsi", "On");
  s.rsi_return = static_cast<int>(f.integer("Rsi", "Return", -1'000'000, 1'000'000));
  s.axes = f.six("Axes");
  s.moves = f.flag("Moves", "On");
  s.session = static_cast<int>(f.integer("Moves", "Session", 0, kHighestNumber));
  s.ended = static_cast<int>(f.integer("Moves", "Ended", 0, kHighestNumber));
  s.halted = static_cast<int>(f.integer("Moves", "Halted", 0, kHighestNumber));
  s.time_ms = f.integer("Moves", "Time", -(1LL << 31), (1LL << 31) - 1);
  EkiIdentity& i = out.identity;
  i.axes = static_cast<int>(f.integer("Init", "NumAxes", 1, 12));
  i.robot = f.text("Init", "Robot");
  i.rsi = static_cast<int>(f.integer("Init", "Rsi", 0, 100));
  i.cycle_ms = static_cast<int>(f.integer("Init", "Cycle", 1, 100));
  i.late_limit = static_cast<int>(f.integer("Init", "Late", 1, 100'000));
  i.correction_limit = f.number("Init", "Limit");
  i.relative = f.flag("Init", "Relative");
  i.lower = f.six("Low");
  i.upper = f.six("High");
  return f.ok() ? std::optional(out) : std::nullopt;
}

std::optional<EkiReply> Eki::fail(Cause cause, const std::string& text) {
  failure_ = {cause, text};
  close();
  return std::nullopt;
}

bool Eki::open() {
  close();
  failure_ = {};
  std::string why;
  socket_ = wire::connect_tcp(host_, port_, timeout_, why);
  if (!socket_) fail(Cause::unreachable, why);
  answered_ = false;
  return static_cast<bool>(socket_);
}

void Eki::close() {
  socket_ = Descriptor();
  reader_ = EkiReader();
}

std::string Eki::own_address() const {
  return wire::local_address(socket_.number());
}

std::optional<EkiReply> Eki::await_answer(Nanoseconds deadline) {
  std::array<std::uint8_t, 4096> bytes;
  for (;;) {
    for (std::string text = reader_.next(); !text.empty(); text = reader_.next()) {
      const auto reply = decode_reply(text);
      if (!reply) return fail(Cause::eki_bad_data);
      if (reply->id != id_) continue;  // of a request that was given up
      answered_ = true;
      return reply;
    }
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0 || !wire::wait_readable(socket_.number(), left)) return fail(Cause::eki_silent);
    const wire::Received got = wire::receive(socket_.number(), bytes);
    if (got.got == wire::Got::nothing) continue;
    if (got.got != wire::Got::bytes) return fail(answered_ ? Cause::eki_closed : Cause::eki_busy);
    if (!reader_.feed({reinterpret_cast<const char*>(bytes.data()), got.count}))
      return fail(Cause::eki_bad_data);
  }
}

std::optional<EkiReply> Eki::ask(EkiDo what, int number, int value, const std::optional<EkiMove>& move) {
  if (!socket_) return std::nullopt;
  id_ = id_ % 1'000'000 + 1;
  if (!wire::send_frame(socket_.number(), encode(EkiRequest{id_, what, number, value, move})))
    return fail(answered_ ? Cause::eki_closed : Cause::eki_busy);
  return await_answer(realtime::monotonic_now() + timeout_);
}

}  // namespace polyarm::kuka
