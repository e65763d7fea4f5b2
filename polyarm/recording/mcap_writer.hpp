#pragma once
/// MCAP version 0: messages of many channels in one file, in chunks with an index. Source: the format's
/// public specification (mcap.dev/spec).
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/recording/channel.hpp"
#include "polyarm/recording/lz4.hpp"

namespace polyarm::recording {

/// Where the bytes of a file go, in order.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Whole records; false when they could not be written, after which nothing more comes.
  virtual bool write(std::span<const std::byte> bytes) = 0;
};

/// CRC-32 (ISO 3309) of chunks and sections. `before`: the result for the bytes before these.
std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);

/// Grows a record; numbers little-endian, texts and bytes with their length before them.
class RecordBuffer {
 public:
  void number(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) bytes_.push_back(static_cast<std::byte>(value >> (8 * i)));
  }
  void u8(std::uint8_t value) { number(value, 1); }
  void u16(std::uint16_t value) { number(value, 2); }
  void u32(std::uint32_t value) { number(value, 4); }
  void u64(std::uint64_t value) { number(value, 8); }
  void raw(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  void text(std::string_view text) {
    u32(static_cast<std::uint32_t>(text.size()));
    raw(std::as_bytes(std::span(text.data(), text.size())));
  }
  void texts(const std::map<std::string, std::string>& map);
  /// A record with what `fill` puts into it.
  template <class Fill>
  void record(std::uint8_t opcode, Fill fill) {
    u8(opcode);
    const std::size_t at = bytes_.size();
    u64(0);
    fill();
    patch(at, bytes_.size() - at - 8, 8);
  }
  /// The same behind a length of 32 bits.
  template <class Fill>
  void sized(Fill fill) {
    const std::size_t at = bytes_.size();
    u32(0);
    fill();
    patch(at, bytes_.size() - at - 4, 4);
  }
  void clear() { bytes_.clear(); }
  std::size_t size() const { return bytes_.size(); }
  std::span<const std::byte> bytes() const { return bytes_; }
  std::vector<std::byte>& store() { return bytes_; }

 private:
  void patch(std::size_t at, std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i)
      bytes_[at + static_cast<std::size_t>(i)] = static_cast<std::byte>(value >> (8 * i));
  }
  std::vector<std::byte> bytes_;
};

struct McapOptions {
  std::string profile = "ros2", library = "polyarm";
  std::size_t chunk_bytes = 1 << 20;  ///< a chunk ends when its records, not compressed, are so many
  bool compress = true;               ///< chunks with LZ4
};

/// One file from its first byte to its last. Nothing but what it is given goes into it: the same calls give
/// the same bytes. One thread at a time. After a write that failed, what is given is dropped.
class McapWriter {
 public:
  McapWriter(ByteSink& sink, McapOptions options);

  /// From 0 on, in order; written where it is first used.
  std::size_t add_channel(const Channel& channel);
  /// `time` in ns; the sequence of a channel's messages counts from 1.
  void message(std::size_t channel, std::uint64_t time, std::span<const std::byte> payload);
  /// Ends the chunk, whose messages are in the sink when this returns.
  void end_chunk();
  void attachment(const std::string& name, const std::string& media_type, std::uint64_t time,
                  std::string_view data);
  void metadata(const std::string& name, const std::map<std::string, std::string>& values);
  /// The last chunk, and what tells readers where everything is.
  void finish();

  bool failed() const { return failed_; }
  std::uint64_t messages() const { return messages_; }
  std::uint64_t bytes() const { return at_; }
  /// Of the messages that are not in the sink yet.
  bool chunk_is_empty() const { return chunk_.size() == 0; }

 private:
  struct ChunkIndex {
    std::uint64_t first, last, at, length, index_length, compressed, uncompressed;
    std::map<std::uint16_t, std::uint64_t> indexes;  ///< by channel: where its message index begins
  };
  struct Open {
    Channel channel;
    std::uint16_t schema = 0;
    bool written = false;
    std::uint32_t sequence = 0;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> index;  ///< of this chunk: time, offset
  };
  struct Indexed {
    std::uint64_t at, length, log_time, data_size;
    std::string name, media_type;
  };
  void put(std::span<const std::byte> bytes);
  void put_schema(RecordBuffer& out, std::uint16_t id, const Channel& channel) const;
  void put_channel(RecordBuffer& out, std::size_t channel) const;
  void put_message_indexes(ChunkIndex& chunk);
  void put_summary(RecordBuffer& out) const;
  void put_statistics(RecordBuffer& out) const;
  void put_chunk_index(RecordBuffer& out, const ChunkIndex& chunk) const;

  ByteSink& sink_;
  McapOptions options_;
  std::vector<Open> channels_;
  std::vector<std::size_t> schemas_;  ///< by id - 1: a channel that has it
  RecordBuffer chunk_, record_;
  std::vector<std::byte> compressed_;
  std::uint64_t chunk_first_ = 0, chunk_last_ = 0, first_ = 0, last_ = 0, messages_ = 0, at_ = 0;
  std::vector<ChunkIndex> chunks_;
  std::vector<Indexed> attachments_, metadata_;
  std::uint32_t crc_ = 0;
  bool failed_ = false, finished_ = false;
};

}  // namespace polyarm::recording
