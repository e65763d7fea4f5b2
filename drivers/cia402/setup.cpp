#include "drivers/cia402/setup.hpp"

#include <fmt/format.h>

#include "drivers/cia402/preparation.hpp"

namespace polyarm::cia402 {

namespace {

constexpr Nanoseconds kLongAnswer = 500'000'000;  // of a node that is known to answer

class Setup {
 public:
  explicit Setup(const SetupOptions& options)
      : o_(options),
        bus_(open_bus(options.bus)),
        sdo_(*bus_, options.answer),
        long_sdo_(*bus_, kLongAnswer) {}

  bool run() {
    o_.say(fmt::format("Asking the nodes {} to {} on {} …", o_.first, o_.last, o_.bus.bus));
    for (int node = o_.first; node <= o_.last && !lost_; ++node) ask(node);
    if (found_ == 0 && !lost_) say_nobody();
    return usable_ > 0 && !lost_;
  }

 private:
  void say(const Refusal& no) {
    o_.say("  " + sentence(no.cause, no.detail, "the drives on " + o_.bus.bus, no.text));
  }
  void say_nobody() {
    o_.say("  no node answers: check power, bit rate, the 120 Ω at both ends, CAN_H and CAN_L");
    if (bus_->refused() > 0)
      o_.say("  the adapter could not send: no device on the bus acknowledges at this bit rate");
  }
  void ask(int node) {
    std::uint64_t type = 0;
    const SdoDone done = sdo_.read(node, object::kDeviceType, 4, type);
    if (done.result == SdoResult::silent) return;
    if (done.result == SdoResult::bus && done.state != BusState::full) {
      lost_ = true;
      return say(refusal_of(done, object::kDeviceType, ""));
    }
    if (done.result == SdoResult::bus) return;
    ++found_;
    const std::string whose = fmt::format("node {}", node);
    DriveIdentity drive;
    if (const Refusal no = identify(long_sdo_, node, whose, drive)) return say(no);
    o_.say(fmt::format("  {}: {}vendor 0x{:08X}, product 0x{:08X}, revision 0x{:08X}", whose,
                       drive.name.empty() ? std::string() : drive.name + ", ", drive.vendor, drive.product,
                       drive.revision));
    if (drive.profile() != kServoProfile)
      return o_.say(fmt::format("    no CiA 402 drive: profile {}", drive.profile()));
    if (!drive.has_position_mode())
      return o_.say("    a drive without cyclic synchronous position (mode 8): this driver cannot use it");
    say_state(node);
    ++usable_;
  }
  void say_state(int node) {
    std::uint64_t word = 0, position = 0, code = 0;
    if (!long_sdo_.read(node, object::kStatusword, 2, word) ||
        !long_sdo_.read(node, object::kPosition, 4, position))
      return o_.say("    its state or its position cannot be read");
    o_.say(fmt::format("    state \"{}\", position {} counts",
                       name(state_of(static_cast<std::uint16_t>(word))),
                       static_cast<std::int32_t>(position)));
    if (long_sdo_.read(node, object::kErrorCode, 2, code) && code != 0)
      o_.say("    last error: " + emergency_words(static_cast<std::uint16_t>(code)));
  }

  const SetupOptions& o_;
  std::unique_ptr<CanBus> bus_;
  SdoClient sdo_, long_sdo_;
  int found_ = 0, usable_ = 0;
  bool lost_ = false;
};

}  // namespace

bool set_up(const SetupOptions& options) {
  return Setup(options).run();
}

}  // namespace polyarm::cia402
