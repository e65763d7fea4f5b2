#include "drivers/cia402/far_side.hpp"

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "polyarm/base/error.hpp"

namespace polyarm::cia402 {

namespace {
constexpr std::size_t kLongestLine = 64, kMostHeard = 4096;
constexpr int kReadsInTurn = 64;

/// -1: not a hexadecimal number.
int hex(const std::string& text, std::size_t at, std::size_t count) {
  if (at + count > text.size()) return -1;
  int out = 0;
  for (std::size_t k = at; k < at + count; ++k) {
    const char c = text[k];
    const int digit = c >= '0' && c <= '9'   ? c - '0'
                      : c >= 'A' && c <= 'F' ? c - 'A' + 10
                      : c >= 'a' && c <= 'f' ? c - 'a' + 10
                                             : -1;
    if (digit < 0) return -1;
    out = out * 16 + digit;
  }
  return out;
}

std::string line_of(const CanFrame& frame) {
  char text[16];
  std::snprintf(text, sizeof text, "t%03X%d", frame.id, frame.size);
  std::string out = text;
  for (int k = 0; k < frame.size; ++k) {
    std::snprintf(text, sizeof text, "%02X", frame.data[static_cast<std::size_t>(k)]);
    out += text;
  }
  return out + "\r";
}
}  // namespace

FarSide::FarSide(FarSideOptions options)
    : options_(std::move(options)), machine_(options_.machine), clock_(0) {
  open_terminal();
  make_link();
  clock_.start(options_.machine.tick, {[this](std::vector<int>& open) {
                                         if (master_ >= 0) open.push_back(master_);
                                       },
                                       [this] { serve(); }, [] { return false; }, [this] { tick(); }});
}

FarSide::~FarSide() {
  const auto lock = clock_.lock();
  unplug();
  std::error_code ignored;
  if (!options_.link.empty()) std::filesystem::remove(options_.link, ignored);
}

void FarSide::open_terminal() {
  char name[128] = {};
  termios raw{};
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  const bool made = master_ >= 0 && ::grantpt(master_) == 0 && ::unlockpt(master_) == 0 &&
                    ::ptsname_r(master_, name, sizeof name) == 0;
  if (made) slave_ = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);  // it stays when the driver closes it
  if (slave_ < 0 || ::tcgetattr(slave_, &raw) != 0)
    throw Error("fake-failed", "this machine gives no pseudo-terminal for the simulated adapter",
                "end programs that use many of them");
  ::cfmakeraw(&raw);
  ::tcsetattr(slave_, TCSANOW, &raw);
  path_ = name;
}

void FarSide::make_link() {
  if (options_.link.empty()) return;
  std::error_code error;
  if (std::filesystem::is_symlink(options_.link, error)) std::filesystem::remove(options_.link, error);
  std::filesystem::create_symlink(path_, options_.link, error);
  if (error)
    throw Error("fake-failed", "cannot make the link " + options_.link + ": " + error.message(),
                "choose a path that does not exist");
}

void FarSide::unplug() {
  if (master_ >= 0) ::close(std::exchange(master_, -1));
  if (slave_ >= 0) ::close(std::exchange(slave_, -1));
}

bool FarSide::step(Nanoseconds) {
  return clock_.step(0, [] { return true; });
}

void FarSide::serve() {
  char bytes[512];
  for (int turn = 0; turn < kReadsInTurn && master_ >= 0; ++turn) {
    const ssize_t count = ::read(master_, bytes, sizeof bytes);
    if (count <= 0) return;
    for (ssize_t k = 0; k < count && master_ >= 0; ++k) {
      if (bytes[k] != '\r') {
        if (line_.size() < kLongestLine) line_ += bytes[k];
        continue;
      }
      take_line();
      line_.clear();
    }
  }
}

/// The commands of an adapter. BEL refuses.
void FarSide::take_line() {
  const char kind = line_.empty() ? '\0' : line_[0];
  const auto say = [&](bool fine) { put(fine ? "\r" : "\a"); };
  switch (kind) {
    case '\0':
      return say(true);
    case 'S':
      rate_set_ = line_.size() == 2 && line_[1] >= '0' && line_[1] <= '8' && !channel_open_;
      return say(rate_set_);
    case 'O':
      channel_open_ = rate_set_;
      return say(channel_open_);
    case 'C':
      say(channel_open_);
      channel_open_ = false;
      return;
    case 'V':
      return put("V1013\r");
    case 'N':
      return put("NA123\r");
    case 'F':
      return put(bus_off_ ? "F80\r" : "F00\r");
    case 't':
      return take_frame();
    default:
      return say(false);
  }
}

void FarSide::take_frame() {
  const int id = hex(line_, 1, 3), size = hex(line_, 4, 1);
  CanFrame frame;
  if (!channel_open_ || bus_off_ || id < 0 || id > 0x7FF || size < 0 || size > 8 ||
      line_.size() != 5 + 2 * static_cast<std::size_t>(size))
    return put("\a");
  frame.id = static_cast<std::uint16_t>(id);
  frame.size = static_cast<std::uint8_t>(size);
  for (std::size_t k = 0; k < frame.size; ++k) {
    const int byte = hex(line_, 5 + 2 * k, 2);
    if (byte < 0) return put("\a");
    frame.data[k] = static_cast<std::uint8_t>(byte);
  }
  put("z\r");
  if (heard_.size() >= kMostHeard) heard_.erase(heard_.begin(), heard_.begin() + kMostHeard / 2);
  heard_.push_back(frame);
  if (cut_) return;
  FarDrive::Frames answers;
  machine_.take(frame, answers);
  send_all(answers);
}

void FarSide::tick() {
  FarDrive::Frames frames;
  machine_.tick(frames);
  if (other_master_) frames.push_back(frame_of(0x80, {}));
  send_all(frames);
}

void FarSide::send_all(const FarDrive::Frames& frames) {
  if (bus_off_ || cut_ || !channel_open_) return;
  for (const CanFrame& frame : frames) {
    if (garbage_ > 0) {
      --garbage_;
      put(garbage_ % 2 == 0 ? "t18g7" + line_of(frame) : std::string("\x80tZ\r"));
    }
    put(line_of(frame));
    ++sent_;
  }
}

/// What nobody reads is lost, as on a bus.
void FarSide::put(std::string text) {
  if (master_ >= 0 && ::write(master_, text.data(), text.size()) < 0) return;
}

void FarSide::order_by_hand(const wire::Order& order) {
  from_orders_.clear();
  machine_.order(order, from_orders_);
}

void FarSide::order_on_wires(const wire::Order& order) {
  order.switch_on({{"bus_off", &bus_off_}, {"cut", &cut_}, {"other_master", &other_master_}});
  order.set_count({{"garbage", &garbage_, 20}});
  if (order.is("healthy")) {
    bus_off_ = cut_ = other_master_ = false;
    garbage_ = 0;
  }
  if (order.is("unplug")) unplug();
  send_all(from_orders_);
  from_orders_.clear();
}

}  // namespace polyarm::cia402
