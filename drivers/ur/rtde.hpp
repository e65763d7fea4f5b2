#pragma once
/// Frames of Universal Robots' Real-Time Data Exchange (RTDE), TCP 30004: u16 size (with this header), u8
/// type, payload; big-endian. Facts: the maker's RTDE guide and its public client libraries. Used by the
/// driver and by the simulated controller. Units are the controller's: rad, m, N, A, s.
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/wire/bytes.hpp"
#include "polyarm/base/bounds.hpp"

namespace polyarm::ur {

using wire::Bytes;

enum class PackageType : std::uint8_t {
  protocol_version = 86,     // V
  controller_version = 118,  // v
  text = 77,                 // M
  data = 85,                 // U
  setup_outputs = 79,        // O
  setup_inputs = 73,         // I
  start = 83,                // S
  pause = 80,                // P
};

inline constexpr std::size_t kHeader = 3;

/// A type of a value, with its number of elements and the bytes of each.
struct FieldType {
  std::string_view name;
  std::size_t elements, width;
  enum Kind : std::uint8_t { boolean, unsigned_number, signed_number, real } kind;
  std::size_t bytes() const noexcept { return elements * width; }
};
/// Null for a word that is not a type, for example NOT_FOUND and IN_USE.
const FieldType* find_type(std::string_view name) noexcept;

/// The type of a variable by name: outputs of the controller, or its inputs. Null: the controller has none.
const FieldType* find_output(std::string_view name) noexcept;
const FieldType* find_input(std::string_view name) noexcept;
/// The names of the tables without the register families, for tests and documents.
std::vector<std::string> output_names();

/// The layout of data packages: values in order, packed, as doubles.
struct Recipe {
  std::uint8_t id = 0;
  std::vector<const FieldType*> types;
  std::size_t bytes = 0, elements = 0;
  void add(const FieldType& type) {
    types.push_back(&type);
    bytes += type.bytes();
    elements += type.elements;
  }
};
/// Reads all elements of a recipe; false if the payload has another size. `out` has recipe.elements.
/// Real-time.
bool decode(const Recipe& recipe, Bytes values, std::span<double> out) noexcept;
/// Writes all elements. Integers are rounded and limited to their range; NaN is written as 0.
void encode(const Recipe& recipe, std::span<const double> values, wire::Writer& out);

/// One frame.
std::vector<std::uint8_t> frame(PackageType type, Bytes payload = {});
inline std::vector<std::uint8_t> frame(PackageType type, const wire::Writer& payload) {
  return frame(type, payload.bytes());
}

/// Finds frames in a stream of bytes. Bounded: it keeps at most one frame. Real-time.
class FrameStream {
 public:
  /// Calls `take(type, payload)` for each whole frame. False: the stream is broken (a size below the header),
  /// and stays so until reset().
  template <typename Take>
  bool feed(Bytes bytes, Take take) noexcept {
    while (!bytes.empty() && !broken_) {
      const std::size_t goal = used_ < kHeader ? kHeader : size();
      const std::size_t count = std::min(goal - used_, bytes.size());
      std::copy_n(bytes.begin(), count, buffer_.begin() + static_cast<std::ptrdiff_t>(used_));
      used_ += count;
      bytes = bytes.subspan(count);
      if (used_ < kHeader) break;
      if (size() < kHeader) {
        broken_ = true;
      } else if (used_ == size()) {
        const auto type = static_cast<PackageType>(buffer_[2]);
        const Bytes payload(buffer_.data() + kHeader, used_ - kHeader);
        used_ = 0;
        take(type, payload);
      }
    }
    return !broken_;
  }
  void reset() noexcept {
    used_ = 0;
    broken_ = false;
  }

 private:
  std::size_t size() const noexcept { return static_cast<std::size_t>(buffer_[0]) << 8 | buffer_[1]; }
  std::array<std::uint8_t, bounds::kRtdeFrameBytes> buffer_{};
  std::size_t used_ = 0;
  bool broken_ = false;
};

/// "a,b,c" into words; empty on more than bounds::kRtdeNames.
std::vector<std::string> split_names(std::string_view text);

/// A text message. Level: 0 exception, 1 error, 2 warning, 3 information.
struct RtdeText {
  std::string text, source;
  int level = 3;
};
std::optional<RtdeText> read_text(Bytes payload, int protocol);

}  // namespace polyarm::ur
