#pragma once
/// Writes MCAP version 0 files: messages of many channels, in chunks with an index. Source: the format's
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

/// Receives the bytes of a file, in order.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Writes whole records. Returns false if they could not be written; nothing is written after that.
  virtual bool write(std::span<const std::byte> bytes) = 0;
};

/// The checksum of MCAP chunks and sections: CRC-32 of ISO 3309, as in zlib. `before`: the checksum of the
/// preceding bytes.
std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);

/// Builds records. Numbers are little-endian; texts and bytes follow their length.
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
  /// Appends a record; `fill` writes its content.
  template <class Fill>
  void record(std::uint8_t opcode, Fill fill) {
    u8(opcode);
    const std::size_t at = bytes_.size();
    u64(0);
    fill();
    patch(at, bytes_.size() - at - 8, 8);
  }
  /// The same with a 32-bit length and no opcode.
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
  std::size_t chunk_bytes = 1 << 20;  ///< a chunk ends when its uncompressed records reach this size
  bool compress = true;               ///< compress chunks with LZ4
};

/// Writes one file from first to last byte. It adds no data of its own: equal calls give equal bytes. One
/// thread at a time. After a failed write, all further data is dropped.
class McapWriter {
 public:
  McapWriter(ByteSink& sink, McapOptions options);

  /// Returns the channel's number, counted from 0. Its record is written with its first message.
  std::size_t add_channel(const Channel& channel);
  /// `time` in ns. The sequence of a channel's messages counts from 1.
  void message(std::size_t channel, std::uint64_t time, std::span<const std::byte> payload);
  /// Ends the chunk; all its messages are in the sink when this returns.
  void end_chunk();
  void attachment(const std::string& name, const std::string& media_type, std::uint64_t time,
                  std::string_view data);
  void metadata(const std::string& name, const std::map<std::string, std::string>& values);
  /// Writes the last chunk and the summary with the indexes.
  void finish();

  bool failed() const { return failed_; }
  std::uint64_t messages() const { return messages_; }
  std::uint64_t bytes() const { return at_; }
  /// True if all messages are in the sink.
  bool chunk_is_empty() const { return chunk_.size() == 0; }

 private:
  struct ChunkIndex {
    std::uint64_t first, last, at, length, index_length, compressed, uncompressed;
    std::map<std::uint16_t, std::uint64_t> indexes;  ///< by channel: file position of its message index
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
  std::vector<std::size_t> schemas_;  ///< by id - 1: a channel that uses the schema
  RecordBuffer chunk_, record_;
  std::vector<std::byte> compressed_;
  std::uint64_t chunk_first_ = 0, chunk_last_ = 0, first_ = 0, last_ = 0, messages_ = 0, at_ = 0;
  std::vector<ChunkIndex> chunks_;
  std::vector<Indexed> attachments_, metadata_;
  std::uint32_t crc_ = 0;
  bool failed_ = false, finished_ = false;
};

}  // namespace polyarm::recording
