#include "drivers/franka/far_side.hpp"

#include <algorithm>

namespace polyarm::franka {

namespace {

constexpr wire::OrderKind kKinds[] = {
    {"user_stop", "somebody presses the user stop"},
    {"release", "it is released"},
    {"guide", "somebody guides the robot by hand"},
    {"let_go", "the guiding ends"},
    {"brakes", "somebody closes the brakes in Desk"},
    {"open_brakes", "the brakes are opened"},
    {"safety", "a safety function becomes active"},
    {"safety_off", "it becomes inactive"},
    {"collision", "a joint feels a collision (joint_reflex)"},
    {"error", "the error with this number in the list of flags, from 0 (7: cartesian_reflex)"},
    {"force", "a force of so many N pushes the hand up (10); 0 ends it"},
    {"push", "somebody moves the first joint by so many degrees (5)"},
    {"sag", "the second joint hangs so many milliradians below its command (2)"},
    {"recover", "somebody recovers the robot in Desk"},
    {"refuse_motion", "motions are not possible"},
    {"refuse_settings", "settings have an invalid argument"},
    {"refuse_recovery", "a person must recover it"},
    {"singular", "motions would start at a singular pose"},
    {"low_success", "so many percent of the commands count as in time (60)"},
    {"silent", "no states"},
    {"deaf", "commands are not taken"},
    {"drop", "so many commands get lost (5)"},
    {"late", "so many states come late and together (10)"},
    {"duplicate", "so many states come twice (10)"},
    {"reorder", "so many states come behind the next one (10)"},
    {"garbage", "one state has another length"},
    {"not_a_number", "one state has a position that is NaN"},
    {"stranger", "states come from another address"},
    {"mute", "no replies"},
    {"bad_reply", "one reply is no frame"},
    {"close", "the connection closes"},
    {"busy", "another client has the robot, or FCI is off"},
    {"other_version", "it speaks this version (11)"},
    {"part", "a part so many mm wide is between the fingers (30)"},
    {"hand_silent", "the hand sends no states"},
    {"hand_mute", "the hand gives no replies"},
    {"hand_fails", "the hand carries out no orders"},
    {"hand_close", "the connection of the hand closes"},
    {"hand_version", "the hand speaks this version (4)"},
    {"power_off", "the robot loses its power"},
    {"healthy", "ends all of these, except what people do at the robot"},
};

}  // namespace

FarSide::FarSide(FarSideOptions options)
    : options_(std::move(options)),
      machine_(options_.machine),
      fci_(machine_, faults_),
      hand_(fingers_, faults_),
      clock_(options_.patience) {
  fci_.listen(options_.address, options_.port);
  hand_.listen(options_.address, options_.hand_port);
  clock_.start(nanoseconds(machine_.period()), {[this](std::vector<int>& open) {
                                                  fci_.descriptors(open);
                                                  hand_.descriptors(open);
                                                },
                                                [this] { serve(); }, [this] { return fci_.waits(); },
                                                [this] {
                                                  fci_.cycle();
                                                  hand_.cycle();
                                                }});
}

std::span<const wire::OrderKind> FarSide::order_kinds() {
  return kKinds;
}

void FarSide::order_by_hand(const wire::Order& order) {
  if (order.is("user_stop") || order.is("release")) machine_.press_user_stop(order.is("user_stop"));
  if (order.is("guide") || order.is("let_go")) machine_.guide(order.is("guide"));
  if (order.is("brakes") || order.is("open_brakes")) machine_.close_brakes(order.is("brakes"));
  if (order.is("safety") || order.is("safety_off")) machine_.safety_function(order.is("safety"));
  if (order.is("collision")) machine_.raise(ErrorFlag::joint_reflex);
  if (order.is("error"))
    machine_.raise(static_cast<ErrorFlag>(std::min(order.number_or(7), static_cast<int>(kErrors) - 1)));
  if (order.is("force")) machine_.set_force(order.number_or(10));
  if (order.is("push")) machine_.push_by_hand(order.number_or(5) * 0.017453292519943295);
  if (order.is("sag")) machine_.sag(order.number_or(2) * 1e-3);
  if (order.is("recover")) machine_.answer(Request::recover, {}, 0);
  if (order.is("part")) fingers_.put_part(order.number_or(30) * 1e-3);
}

void FarSide::order_on_wires(const wire::Order& order) {
  faults_.take(order);
  order.switch_on({{"refuse_motion", &machine_.refuse_motion},
                   {"refuse_settings", &machine_.refuse_settings},
                   {"refuse_recovery", &machine_.refuse_recovery},
                   {"singular", &machine_.singular},
                   {"not_a_number", &faults_.not_a_number},
                   {"mute", &faults_.mute},
                   {"bad_reply", &faults_.bad_reply},
                   {"busy", &faults_.busy},
                   {"hand_silent", &faults_.hand_silent},
                   {"hand_mute", &faults_.hand_mute},
                   {"hand_fails", &faults_.hand_fails},
                   {"power_off", &faults_.power_off}});
  order.set_count({{"drop", &faults_.drop, 5},
                   {"other_version", &faults_.other_version, 11},
                   {"hand_version", &faults_.hand_version, 4}});
  if (order.is("low_success")) machine_.success_share = std::min(order.number_or(60), 100) / 100.0;
  if (order.is("busy") || order.is("close") || order.is("power_off")) fci_.drop();
  if (order.is("hand_close") || order.is("power_off")) hand_.drop();
  if (order.is("power_off")) machine_.close_brakes(true);
  if (order.is("healthy")) make_healthy();
}

void FarSide::make_healthy() {
  if (faults_.power_off) machine_.close_brakes(false);
  faults_ = {};
  machine_.refuse_motion = machine_.refuse_settings = machine_.refuse_recovery = machine_.singular = false;
  machine_.success_share = 1;
  machine_.set_force(0);
}

bool FarSide::step(Nanoseconds patience) {
  return clock_.step(patience, [this] {
    return faults_.silent || faults_.power_off || faults_.stranger || !fci_.unanswered();
  });
}

void FarSide::serve() {
  fci_.serve();
  hand_.serve();
  if (machine_.mode() == mode_) return;
  mode_ = machine_.mode();
  report(std::string("mode: ") + name(mode_));
}

}  // namespace polyarm::franka
