#include "polyarm/messages/cdr.hpp"

namespace polyarm::messages {

const char* name(CdrError error) {
  switch (error) {
    case CdrError::none:
      return "none";
    case CdrError::header:
      return "the header is not that of plain CDR";
    case CdrError::short_:
      return "it ends within a field";
    case CdrError::text:
      return "a text does not end with NUL";
    case CdrError::boolean:
      return "a truth value is neither 0 nor 1";
    case CdrError::too_many:
      return "a sequence is longer than its bound";
    case CdrError::trailing:
      return "bytes follow the last field";
  }
  return "";
}

CdrReader::CdrReader(std::span<const std::byte> payload) : bytes_{payload} {
  if (payload.size() < kCdrHeader || payload[0] != std::byte{0} || payload[1] > std::byte{1}) {
    bytes_ = {};
    error_ = CdrError::header;
    return;
  }
  swapped_ = payload[1] == std::byte{0};  // big-endian; this machine is not
  at_ = kCdrHeader;
}

bool CdrReader::need(std::size_t alignment, std::size_t count) {
  if (error_ != CdrError::none) return false;
  const std::size_t padding = (alignment - (at_ - kCdrHeader) % alignment) % alignment;
  if (left() < padding || left() - padding < count) {
    fail(CdrError::short_);
    return false;
  }
  at_ += padding;
  return true;
}

void CdrReader::read(std::string& text) {
  std::uint32_t length = 0;
  read(length);
  if (!need(1, length)) return;
  if (length == 0) return text.clear();  // some writers omit the NUL of an empty text
  const auto* begin = reinterpret_cast<const char*>(bytes_.data() + at_);
  if (begin[length - 1] != '\0') return fail(CdrError::text);
  text.assign(begin, length - 1);
  at_ += length;
}

std::size_t CdrReader::read_length(std::size_t least, std::size_t most) {
  std::uint32_t count = 0;
  read(count);
  if (error_ != CdrError::none) return 0;
  if (count > most) return fail(CdrError::too_many), 0;
  if (count > left() / (least > 0 ? least : 1)) return fail(CdrError::short_), 0;
  return count;
}

}  // namespace polyarm::messages
