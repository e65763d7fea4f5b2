#include "drivers/abb/far_side.hpp"

namespace polyarm::abb {

namespace {

constexpr wire::OrderKind kKinds[] = {
    {"e_stop", "somebody presses the emergency stop"},
    {"release", "it is released; the motors stay off"},
    {"guard_open", "somebody opens the guard (auto stop)"},
    {"guard_closed", "it is closed; the motors stay off"},
    {"manual", "somebody turns the key: manual, reduced speed"},
    {"manual_full", "the same: manual, full speed"},
    {"auto", "automatic; the motors stay off"},
    {"motors_off", "somebody switches the motors off"},
    {"stop", "somebody stops the program at the FlexPendant"},
    {"egm_stop", "EGM ends, the program goes on"},
    {"egm_error", "EGM reports an error"},
    {"collision", "motion supervision stops the robot"},
    {"range", "a joint reaches its limit"},
    {"singular", "the robot stops near a singularity"},
    {"speed", "a joint was too fast"},
    {"overload", "the motors are overloaded"},
    {"event", "the robot stops with this number in its event log (50063)"},
    {"system_failure", "system failure"},
    {"restart", "the controller restarts after it"},
    {"silent", "EGM sends nothing"},
    {"deaf", "EGM takes no commands"},
    {"late", "so many packets come late and together (10)"},
    {"duplicate", "so many packets come twice (10)"},
    {"reorder", "so many packets come after the next one (10)"},
    {"garbage", "one packet is broken"},
    {"again", "the sequence of the packets begins anew"},
    {"stranger", "the packets come from another sender"},
    {"old_egm", "EGM of before RobotWare 6.07"},
    {"old_software", "RobotWare 6.05"},
    {"seven", "the robot has seven joints"},
    {"slow", "packets come in twice their time"},
    {"mute", "Robot Web Services give no answers"},
    {"busy", "they have too many sessions"},
    {"login", "they refuse the user"},
    {"forbidden", "the user may change nothing"},
    {"mastership", "another program holds the mastership"},
    {"nonsense", "what they send is no HTTP"},
    {"close_rws", "they close their connections"},
    {"no_option", "Externally Guided Motion is not installed"},
    {"no_module", "the RAPID module is not loaded"},
    {"locked_signals", "signals cannot be written"},
    {"play", "somebody presses Start at the FlexPendant"},
    {"refuse_moves", "the program PolyarmMoves takes no moves"},
    {"failing_move", "it cannot make the next move"},
    {"mute_moves", "it gives no answers"},
    {"nonsense_moves", "its answers are broken"},
    {"close_moves", "it closes its connections"},
    {"silent_halts", "it never says that it stopped the robot"},
    {"slow_stop", "it answers nothing while the robot comes to rest"},
    {"other_program", "it has another version"},
    {"other_base", "the base of the robot is not its world frame"},
    {"refuse_start", "the program does not start"},
    {"refuse_motors", "the motors do not switch on"},
    {"power_off", "the controller loses its power"},
    {"healthy", "ends all of these that are not people's doing"},
};

}  // namespace

FarSide::FarSide(FarSideOptions options)
    : options_(std::move(options)),
      machine_(options_.machine),
      egm_(machine_, faults_),
      rws_(machine_, faults_, options_.rws_version),
      move_port_(machine_, move_faults_),
      clock_(options_.patience) {
  rws_.set_user(options_.user, options_.password);
  if (options_.request_time > 0) rws_.set_request_time(options_.request_time);
  rws_.listen(options_.address, options_.rws);
  egm_.open(options_.address);
  move_port_.listen(options_.address, options_.moves);
  if (options_.egm > 0) egm_.send_to(options_.egm_host, options_.egm);
  clock_.start(nanoseconds(period()),
               {[this](std::vector<int>& open) {
                  open.push_back(egm_.descriptor());
                  rws_.descriptors(open);
                  move_port_.descriptors(open);
                },
                [this] { serve(); }, [this] { return egm_.waits(); }, [this] { cycle(); }});
}

void FarSide::send_egm_to(const std::string& host, int port) {
  const auto lock = clock_.lock();
  egm_.send_to(host, port);
}

std::span<const wire::OrderKind> FarSide::order_kinds() {
  return kKinds;
}

void FarSide::order_by_hand(const wire::Order& order) {
  if (order.is("e_stop") || order.is("release")) machine_.emergency(order.is("e_stop"));
  if (order.is("guard_open") || order.is("guard_closed")) machine_.guard(order.is("guard_open"));
  if (order.is("manual")) machine_.set_mode(Machine::Mode::manual);
  if (order.is("manual_full")) machine_.set_mode(Machine::Mode::manual_full);
  if (order.is("auto")) machine_.set_mode(Machine::Mode::automatic);
  if (order.is("motors_off")) machine_.switch_motors(false);
  if (order.is("stop")) machine_.stop_program("stop at the FlexPendant");
  if (order.is("egm_stop")) machine_.stop_egm();
  if (order.is("collision")) machine_.collide();
  if (order.is("range")) machine_.stop_with(50027, "Joint Out of Range");
  if (order.is("singular")) machine_.stop_with(50026, "Close to singularity");
  if (order.is("speed")) machine_.stop_with(50024, "Joint speed error");
  if (order.is("overload")) machine_.stop_with(34316, "Motor current error");
  if (order.is("event")) machine_.stop_with(order.number_or(50063), "ordered");
  if (order.is("system_failure")) machine_.fail();
  if (order.is("restart")) machine_.restart();
  if (order.is("play")) machine_.press_start();
}

void FarSide::order_on_wires(const wire::Order& order) {
  faults_.take(order);
  order.switch_on({{"again", &faults_.restarted},
                   {"old_egm", &faults_.old},
                   {"seven", &faults_.seven},
                   {"slow", &faults_.slow},
                   {"mute", &faults_.mute},
                   {"busy", &faults_.busy},
                   {"login", &faults_.login},
                   {"forbidden", &faults_.forbidden},
                   {"mastership", &faults_.mastership},
                   {"nonsense", &faults_.nonsense},
                   {"no_option", &faults_.no_option},
                   {"egm_error", &faults_.egm_error},
                   {"refuse_moves", &move_faults_.refuse},
                   {"failing_move", &move_faults_.fails},
                   {"mute_moves", &move_faults_.mute},
                   {"nonsense_moves", &move_faults_.nonsense},
                   {"silent_halts", &move_faults_.confirms_not},
                   {"slow_stop", &move_faults_.slow_stop},
                   {"other_program", &move_faults_.other_version},
                   {"other_base", &move_faults_.other_base},
                   {"refuse_start", &faults_.refuse_start},
                   {"refuse_motors", &faults_.refuse_motors},
                   {"power_off", &faults_.power_off},
                   {"locked_signals", &machine_.locked_signals}});
  if (order.is("close_rws")) rws_.drop();
  if (order.is("close_moves") || order.is("power_off")) move_port_.drop();
  if (order.is("old_software")) machine_.options().software = "6.05.00.00";
  if (order.is("no_module")) machine_.options().modules.clear();
  if (order.is("power_off")) {
    machine_.switch_motors(false);
    rws_.drop();
  }
  if (!order.is("healthy")) return;
  faults_ = {};
  move_faults_ = {};
  machine_.locked_signals = false;
  machine_.options().software = options_.machine.software;
  machine_.options().modules = options_.machine.modules;
}

bool FarSide::step(Nanoseconds patience) {
  return clock_.step(patience, [this] {
    return faults_.silent || faults_.power_off || faults_.stranger || !egm_.unanswered();
  });
}

void FarSide::cycle() {
  move_port_.step(period());
  egm_.cycle();
}

void FarSide::serve() {
  egm_.serve();
  rws_.serve();
  move_port_.serve();
  report_change(machine_.program_runs(), "the program runs", "the program ended");
}

}  // namespace polyarm::abb
