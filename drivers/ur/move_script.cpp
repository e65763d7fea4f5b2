#include "drivers/ur/move_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "drivers/wire/bytes.hpp"

namespace polyarm::ur {

namespace {

// Two threads: the main one reads messages and never waits for the robot, the mover makes one move after the
// other. A move with a blend begins only when the next one is there, because the robot would stop at the
// beginning of the blend otherwise. A halt ends the mover; the new one stops the robot before it says so.
constexpr const char* kMoveProgram = R"(def polyarm():
  # Polyarm, moves 1: makes the moves of the computer that sent this program, and stops when it falls silent.
  write_output_integer_register({sequence_register}, 0)
  write_output_integer_register({state_register}, 0)
  write_output_integer_register({ended_register}, 0)
  write_output_integer_register({halt_register}, 0)
  global queue = [{zeros}]
  global first = 0
  global waiting = 0
  global halts = 0

  thread mover():
    stopj({deceleration})
    write_output_integer_register({halt_register}, halts)
    while True:
      enter_critical
      local at = first * {width}
      local ready = waiting > 1
      if waiting == 1:
        ready = queue[at + 17] == 0
      end
      exit_critical
      if ready:
        local work = queue[at]
        local number = queue[at + 1]
        local goal = [queue[at + 2] / {scale}, queue[at + 3] / {scale}, queue[at + 4] / {scale}, queue[at + 5] / {scale}, queue[at + 6] / {scale}, queue[at + 7] / {scale}]
        local by = [queue[at + 8] / {scale}, queue[at + 9] / {scale}, queue[at + 10] / {scale}, queue[at + 11] / {scale}, queue[at + 12] / {scale}, queue[at + 13] / {scale}]
        local rate = queue[at + 14] / {scale}
        local speed = queue[at + 15] / {scale}
        local duration = queue[at + 16] / {scale}
        local blend = queue[at + 17] / {scale}
        if work == 1:
          movej(goal, rate, speed, duration, blend)
        elif work == 2:
          movel(goal, rate, speed, duration, blend)
        elif work == 3:
          movec(by, goal, rate, speed, blend, 0)
        end
        enter_critical
        first = first + 1
        if first == {slots}:
          first = 0
        end
        waiting = waiting - 1
        exit_critical
        write_output_integer_register({ended_register}, number)
      else:
        sync()
      end
    end
  end

  if not socket_open("{host}", {port}, "{socket}"):
    textmsg("Polyarm: no connection to {host}:{port}")
    halt
  end
  write_output_integer_register({state_register}, 1)
  task = run mover()
  wait_s = 2.0
  state = 1
  while state == 1:
    m = socket_read_binary_integer({numbers}, "{socket}", wait_s)
    if m[0] != {numbers}:
      state = 3
    elif m[3] < 0:
      state = 2
    else:
      wait_s = m[2] / 1000.0
      if m[3] == 4:
        kill task
        first = 0
        waiting = 0
        halts = m[4]
        task = run mover()
      elif m[3] == 5:
        set_tcp(p[m[5] / {scale}, m[6] / {scale}, m[7] / {scale}, m[8] / {scale}, m[9] / {scale}, m[10] / {scale}])
      elif m[3] > 0:
        enter_critical
        slot = first + waiting
        if slot >= {slots}:
          slot = slot - {slots}
        end
        i = 0
        while i < {width}:
          queue[slot * {width} + i] = m[i + 3]
          i = i + 1
        end
        waiting = waiting + 1
        exit_critical
      end
      write_output_integer_register({sequence_register}, m[1])
    end
  end
  kill task
  stopj({deceleration})
  write_output_integer_register({state_register}, state)
  socket_close("{socket}")
end
)";

constexpr std::size_t kWidth = kMoveNumbers - 2;  // what the queue keeps of a message

std::string zeros(std::size_t count) {
  std::string out = "0";
  for (std::size_t i = 1; i < count; ++i) out += ", 0";
  return out;
}

std::int32_t scaled_of_move(double value) noexcept {
  if (!std::isfinite(value)) return 0;
  return static_cast<std::int32_t>(std::lround(std::clamp(value, -2100.0, 2100.0) * kMoveScale));
}

}  // namespace

std::array<std::uint8_t, kMoveBytes> encode(const MoveMessage& message) noexcept {
  std::array<std::int32_t, kMoveNumbers> numbers{message.sequence, message.timeout_ms,
                                                 static_cast<std::int32_t>(message.work), message.number};
  for (std::size_t i = 0; i < 6; ++i) {
    numbers[4 + i] = scaled_of_move(message.goal[i]);
    numbers[10 + i] = scaled_of_move(message.via[i]);
  }
  numbers[16] = scaled_of_move(message.acceleration);
  numbers[17] = scaled_of_move(message.speed);
  numbers[18] = scaled_of_move(message.time);
  numbers[19] = scaled_of_move(message.blend);
  std::array<std::uint8_t, kMoveBytes> out{};
  for (std::size_t i = 0; i < kMoveBytes; ++i)
    out[i] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(numbers[i / 4]) >> 8 * (3 - i % 4));
  return out;
}

MoveMessage decode_move(std::span<const std::uint8_t, kMoveBytes> bytes) noexcept {
  wire::Reader in(bytes);
  MoveMessage out;
  out.sequence = in.i32();
  out.timeout_ms = in.i32();
  out.work = static_cast<Work>(in.i32());
  out.number = in.i32();
  for (double& value : out.goal) value = in.i32() / kMoveScale;
  for (double& value : out.via) value = in.i32() / kMoveScale;
  for (double* value : {&out.acceleration, &out.speed, &out.time, &out.blend}) *value = in.i32() / kMoveScale;
  return out;
}

std::string move_program_text(const ScriptSettings& settings) {
  return filled(kMoveProgram, {{"host", settings.host},
                               {"port", std::to_string(settings.port)},
                               {"socket", kMoveSocketName},
                               {"deceleration", fmt::format("{:.3f}", settings.stop_deceleration)},
                               {"scale", fmt::format("{:.1f}", kMoveScale)},
                               {"numbers", std::to_string(kMoveNumbers)},
                               {"width", std::to_string(kWidth)},
                               {"slots", std::to_string(kMoveSlots)},
                               {"zeros", zeros(kWidth * kMoveSlots)},
                               {"sequence_register", std::to_string(kSequenceRegister)},
                               {"state_register", std::to_string(kStateRegister)},
                               {"ended_register", std::to_string(kEndedRegister)},
                               {"halt_register", std::to_string(kHaltRegister)}});
}

}  // namespace polyarm::ur
