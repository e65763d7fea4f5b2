#pragma once
/// Reads and writes objects of drives by SDO, expedited or in segments. Waits for answers; one thread.
/// Source: CiA 301, service data objects.
#include <functional>

#include "drivers/cia402/canopen.hpp"

namespace polyarm::cia402 {

enum class SdoResult : std::uint8_t {
  ok,
  silent,   ///< no answer in time
  aborted,  ///< see code
  wrong,    ///< answers that do not fit: another size, a wrong order
  bus       ///< the bus has failed; see state
};
struct SdoDone {
  SdoResult result = SdoResult::ok;
  std::uint32_t code = 0;  ///< why the drive aborted
  std::size_t size = 0;    ///< bytes read
  BusState state = BusState::ok;
  explicit operator bool() const noexcept { return result == SdoResult::ok; }
  /// True if the drive does not have the object.
  bool missing() const noexcept {
    return result == SdoResult::aborted && (code == kNoObject || code == kNoSubIndex);
  }
};

class SdoClient {
 public:
  /// `other` gets the frames that are not the awaited answer.
  SdoClient(CanBus& bus, Nanoseconds timeout, std::function<void(const CanFrame&)> other = {})
      : bus_(bus), timeout_(timeout), other_(std::move(other)) {}

  /// Reads an object of at most `into.size()` bytes.
  SdoDone upload(int node, Object object, std::span<std::uint8_t> into);
  SdoDone download(int node, Object object, std::span<const std::uint8_t> bytes);

  /// A number of `size` bytes.
  SdoDone read(int node, Object object, std::size_t size, std::uint64_t& value);
  SdoDone write(int node, Object object, std::size_t size, std::uint64_t value);

 private:
  SdoDone await(int node, SdoAnswer& answer, const Object* object);
  SdoDone upload_segments(int node, Object object, std::span<std::uint8_t> into, std::uint32_t announced);
  SdoDone give_up(int node, Object object, std::uint32_t code);

  CanBus& bus_;
  Nanoseconds timeout_;
  std::function<void(const CanFrame&)> other_;
};

}  // namespace polyarm::cia402
