#include "drivers/ur/script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "drivers/wire/bytes.hpp"

namespace polyarm::ur {

namespace {

// Two threads: the main one reads messages and keeps the newest, the mover calls the robot once in each of
// its steps. So a message that comes late by less than its timeout costs no step, and two that come together
// are one motion.
constexpr const char* kProgram = R"(def polyarm():
  # Polyarm, stream 1: follows joint targets from the computer that sent this program, and stops without them.
  write_output_integer_register({sequence_register}, 0)
  write_output_integer_register({state_register}, 0)
  step = get_steptime()
  global mode = 0
  global target = get_actual_joint_positions()
  global speed = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
  global running = True
  global jumped = False

  def too_far(goal):
    local from = get_target_joint_positions()
    local i = 0
    while i < 6:
      if norm(goal[i] - from[i]) > {speed_limit} * 0.1:
        return True
      end
      i = i + 1
    end
    return False
  end

  thread mover():
    local moved = False
    while running:
      enter_critical
      local how = mode
      local goal = target
      local rate = speed
      exit_critical
      if how == 1:
        if too_far(goal):
          jumped = True
          mode = 0
        else:
          servoj(goal, t=step, lookahead_time={lookahead}, gain={gain})
          moved = True
        end
      elif how == 2:
        speedj(rate, {acceleration}, step)
        moved = True
      else:
        if moved:
          stopj({deceleration})
          moved = False
        end
        sync()
      end
    end
    stopj({deceleration})
  end

  if not socket_open("{host}", {port}, "{socket}"):
    textmsg("Polyarm: no connection to {host}:{port}")
    halt
  end
  write_output_integer_register({state_register}, 1)
  work = run mover()
  wait_s = 2.0
  state = 1
  while state == 1:
    m = socket_read_binary_integer({numbers}, "{socket}", wait_s)
    if m[0] != {numbers}:
      state = 3
    elif m[3] < 0:
      state = 2
    elif jumped:
      state = 4
    else:
      wait_s = m[2] / 1000.0
      values = [m[4] / {scale}, m[5] / {scale}, m[6] / {scale}, m[7] / {scale}, m[8] / {scale}, m[9] / {scale}]
      enter_critical
      if m[3] == 1:
        target = values
      elif m[3] == 2:
        speed = values
      end
      mode = m[3]
      exit_critical
      write_output_integer_register({sequence_register}, m[1])
    end
  end
  mode = 0
  running = False
  join work
  write_output_integer_register({state_register}, state)
  socket_close("{socket}")
end
)";

std::int32_t scaled(double value) noexcept {
  if (!std::isfinite(value)) return 0;
  return static_cast<std::int32_t>(std::lround(std::clamp(value * kScale, -2.1e9, 2.1e9)));
}

}  // namespace

std::array<std::uint8_t, kMessageBytes> encode(const Message& message) noexcept {
  std::array<std::int32_t, kMessageNumbers> numbers{message.sequence, message.timeout_ms,
                                                    static_cast<std::int32_t>(message.mode)};
  for (std::size_t i = 0; i < 6; ++i) numbers[3 + i] = scaled(message.values[i]);
  std::array<std::uint8_t, kMessageBytes> out{};
  for (std::size_t i = 0; i < kMessageBytes; ++i)
    out[i] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(numbers[i / 4]) >> 8 * (3 - i % 4));
  return out;
}

Message decode_message(std::span<const std::uint8_t, kMessageBytes> bytes) noexcept {
  wire::Reader in(bytes);
  Message out;
  out.sequence = in.i32();
  out.timeout_ms = in.i32();
  out.mode = static_cast<Mode>(in.i32());
  for (double& value : out.values) value = in.i32() / kScale;
  return out;
}

std::string filled(std::string program, std::initializer_list<std::pair<const char*, std::string>> values) {
  for (const auto& [name, value] : values) {
    const std::string mark = "{" + std::string(name) + "}";
    for (std::size_t at = program.find(mark); at != std::string::npos;
         at = program.find(mark, at + value.size()))
      program.replace(at, mark.size(), value);
  }
  return program;
}

std::string program_text(const ScriptSettings& settings) {
  return filled(kProgram, {{"host", settings.host},
                           {"port", std::to_string(settings.port)},
                           {"socket", kSocketName},
                           {"lookahead", fmt::format("{:.4f}", settings.lookahead)},
                           {"gain", fmt::format("{:.0f}", settings.gain)},
                           {"deceleration", fmt::format("{:.3f}", settings.stop_deceleration)},
                           {"acceleration", fmt::format("{:.3f}", settings.acceleration)},
                           {"speed_limit", fmt::format("{:.3f}", settings.speed_limit)},
                           {"scale", fmt::format("{:.1f}", kScale)},
                           {"numbers", std::to_string(kMessageNumbers)},
                           {"sequence_register", std::to_string(kSequenceRegister)},
                           {"state_register", std::to_string(kStateRegister)}});
}

}  // namespace polyarm::ur
