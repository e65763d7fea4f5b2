#include "polyarm/recording/mcap_writer.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace polyarm::recording {

namespace {

enum Opcode : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kAttachment,
  kAttachmentIndex,
  kStatistics,
  kMetadata,
  kMetadataIndex,
  kSummaryOffset,
  kDataEnd,
};

constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

}  // namespace

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before) {
  return static_cast<std::uint32_t>(
      ::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

void RecordBuffer::texts(const std::map<std::string, std::string>& map) {
  sized([&] {
    for (const auto& [key, value] : map) text(key), text(value);
  });
}

McapWriter::McapWriter(ByteSink& sink, McapOptions options) : sink_(sink), options_(std::move(options)) {
  record_.raw(std::as_bytes(std::span(kMagic)));
  record_.record(kHeader, [&] {
    record_.text(options_.profile);
    record_.text(options_.library);
  });
  put(record_.bytes());
}

void McapWriter::put(std::span<const std::byte> bytes) {
  if (failed_) return;
  crc_ = crc32(bytes, crc_);
  failed_ = !sink_.write(bytes);
  at_ += bytes.size();
}

std::size_t McapWriter::add_channel(const Channel& channel) {
  Open open;
  open.channel = channel;
  const auto same = std::find_if(schemas_.begin(), schemas_.end(), [&](std::size_t other) {
    const Channel& there = channels_[other].channel;
    return there.schema_name == channel.schema_name && there.schema_encoding == channel.schema_encoding &&
           there.schema == channel.schema;
  });
  open.schema = static_cast<std::uint16_t>(same - schemas_.begin() + 1);
  if (same == schemas_.end()) schemas_.push_back(channels_.size());
  channels_.push_back(std::move(open));
  return channels_.size() - 1;
}

void McapWriter::put_schema(RecordBuffer& out, std::uint16_t id, const Channel& channel) const {
  out.record(kSchema, [&] {
    out.u16(id);
    out.text(channel.schema_name);
    out.text(channel.schema_encoding);
    out.text(channel.schema);
  });
}

void McapWriter::put_channel(RecordBuffer& out, std::size_t channel) const {
  const Open& open = channels_[channel];
  out.record(kChannel, [&] {
    out.u16(static_cast<std::uint16_t>(channel));
    out.u16(open.schema);
    out.text(open.channel.topic);
    out.text(open.channel.encoding);
    out.texts({});
  });
}

void McapWriter::message(std::size_t channel, std::uint64_t time, std::span<const std::byte> payload) {
  if (failed_ || finished_) return;
  Open& open = channels_[channel];
  const bool first = chunk_.size() == 0;
  if (!open.written) {
    const bool schema_written = std::any_of(channels_.begin(), channels_.end(), [&](const Open& other) {
      return other.written && other.schema == open.schema;
    });
    if (!schema_written) put_schema(chunk_, open.schema, open.channel);
    put_channel(chunk_, channel);
    open.written = true;
  }
  chunk_first_ = first ? time : std::min(chunk_first_, time);
  chunk_last_ = first ? time : std::max(chunk_last_, time);
  open.index.emplace_back(time, chunk_.size());
  chunk_.record(kMessage, [&] {
    chunk_.u16(static_cast<std::uint16_t>(channel));
    chunk_.u32(++open.sequence);
    chunk_.u64(time);
    chunk_.u64(time);
    chunk_.raw(payload);
  });
  first_ = messages_ == 0 ? time : std::min(first_, time);
  last_ = messages_ == 0 ? time : std::max(last_, time);
  ++messages_;
  if (chunk_.size() >= options_.chunk_bytes) end_chunk();
}

void McapWriter::end_chunk() {
  if (chunk_.size() == 0 || failed_ || finished_) return;
  ChunkIndex chunk{};
  chunk.first = chunk_first_;
  chunk.last = chunk_last_;
  chunk.at = at_;
  chunk.uncompressed = chunk_.size();
  std::span<const std::byte> records = chunk_.bytes();
  if (options_.compress) {
    compressed_.clear();
    add_lz4_frame(chunk_.bytes(), compressed_);
    records = compressed_;
  }
  chunk.compressed = records.size();
  record_.clear();
  record_.record(kChunk, [&] {
    record_.u64(chunk.first);
    record_.u64(chunk.last);
    record_.u64(chunk.uncompressed);
    record_.u32(crc32(chunk_.bytes()));
    record_.text(options_.compress ? "lz4" : "");
    record_.u64(records.size());
    record_.raw(records);
  });
  chunk.length = record_.size();
  put_message_indexes(chunk);
  put(record_.bytes());
  chunks_.push_back(std::move(chunk));
  chunk_.clear();
}

void McapWriter::put_message_indexes(ChunkIndex& chunk) {
  const std::size_t begin = record_.size();
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    Open& open = channels_[i];
    if (open.index.empty()) continue;
    chunk.indexes[static_cast<std::uint16_t>(i)] = at_ + record_.size();
    std::stable_sort(open.index.begin(), open.index.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    record_.record(kMessageIndex, [&] {
      record_.u16(static_cast<std::uint16_t>(i));
      record_.sized([&] {
        for (const auto& [time, offset] : open.index) record_.u64(time), record_.u64(offset);
      });
    });
    open.index.clear();
  }
  chunk.index_length = record_.size() - begin;
}

void McapWriter::attachment(const std::string& name, const std::string& media_type, std::uint64_t time,
                            std::string_view data) {
  end_chunk();
  if (failed_ || finished_) return;
  record_.clear();
  record_.record(kAttachment, [&] {
    const std::size_t begin = record_.size();
    record_.u64(time);
    record_.u64(time);
    record_.text(name);
    record_.text(media_type);
    record_.u64(data.size());
    record_.raw(std::as_bytes(std::span(data.data(), data.size())));
    record_.u32(crc32(record_.bytes().subspan(begin)));
  });
  attachments_.push_back({at_, record_.size(), time, data.size(), name, media_type});
  put(record_.bytes());
}

void McapWriter::metadata(const std::string& name, const std::map<std::string, std::string>& values) {
  end_chunk();
  if (failed_ || finished_) return;
  record_.clear();
  record_.record(kMetadata, [&] {
    record_.text(name);
    record_.texts(values);
  });
  metadata_.push_back({at_, record_.size(), 0, 0, name, {}});
  put(record_.bytes());
}

void McapWriter::finish() {
  end_chunk();
  if (failed_ || finished_) return;
  record_.clear();
  record_.record(kDataEnd, [&] { record_.u32(crc_); });
  put(record_.bytes());
  record_.clear();
  put_summary(record_);
  record_.raw(std::as_bytes(std::span(kMagic)));
  put(record_.bytes());
  finished_ = true;
}

/// Writes the summary section (records grouped by kind), the summary offsets and the footer.
void McapWriter::put_summary(RecordBuffer& out) const {
  std::vector<std::array<std::uint64_t, 3>> groups;
  const auto group = [&](std::uint8_t opcode, auto fill) {
    const std::size_t begin = out.size();
    fill();
    if (out.size() > begin) groups.push_back({opcode, at_ + begin, out.size() - begin});
  };
  group(kSchema, [&] {
    for (std::size_t i = 0; i < schemas_.size(); ++i)
      put_schema(out, static_cast<std::uint16_t>(i + 1), channels_[schemas_[i]].channel);
  });
  group(kChannel, [&] {
    for (std::size_t i = 0; i < channels_.size(); ++i) put_channel(out, i);
  });
  group(kStatistics, [&] { put_statistics(out); });
  group(kChunkIndex, [&] {
    for (const ChunkIndex& chunk : chunks_) put_chunk_index(out, chunk);
  });
  group(kAttachmentIndex, [&] {
    for (const Indexed& each : attachments_)
      out.record(kAttachmentIndex, [&] {
        for (const std::uint64_t value : {each.at, each.length, each.log_time, each.log_time, each.data_size})
          out.u64(value);
        out.text(each.name);
        out.text(each.media_type);
      });
  });
  group(kMetadataIndex, [&] {
    for (const Indexed& each : metadata_)
      out.record(kMetadataIndex, [&] {
        out.u64(each.at);
        out.u64(each.length);
        out.text(each.name);
      });
  });
  const std::uint64_t offsets = at_ + out.size();
  for (const auto& [opcode, at, length] : groups)
    out.record(kSummaryOffset, [&, o = opcode, a = at, l = length] {
      out.u8(static_cast<std::uint8_t>(o));
      out.u64(a);
      out.u64(l);
    });
  // The CRC covers the footer up to the CRC itself, so the footer is built here.
  out.u8(kFooter);
  out.u64(20);
  out.u64(at_);
  out.u64(offsets);
  out.u32(crc32(out.bytes()));
}

void McapWriter::put_statistics(RecordBuffer& out) const {
  out.record(kStatistics, [&] {
    out.u64(messages_);
    out.u16(static_cast<std::uint16_t>(schemas_.size()));
    out.u32(static_cast<std::uint32_t>(channels_.size()));
    out.u32(static_cast<std::uint32_t>(attachments_.size()));
    out.u32(static_cast<std::uint32_t>(metadata_.size()));
    out.u32(static_cast<std::uint32_t>(chunks_.size()));
    out.u64(first_);
    out.u64(last_);
    out.sized([&] {
      for (std::size_t i = 0; i < channels_.size(); ++i) {
        out.u16(static_cast<std::uint16_t>(i));
        out.u64(channels_[i].sequence);
      }
    });
  });
}

void McapWriter::put_chunk_index(RecordBuffer& out, const ChunkIndex& chunk) const {
  out.record(kChunkIndex, [&] {
    for (const std::uint64_t value : {chunk.first, chunk.last, chunk.at, chunk.length}) out.u64(value);
    out.sized([&] {
      for (const auto& [channel, at] : chunk.indexes) out.u16(channel), out.u64(at);
    });
    out.u64(chunk.index_length);
    out.text(options_.compress ? "lz4" : "");
    out.u64(chunk.compressed);
    out.u64(chunk.uncompressed);
  });
}

}  // namespace polyarm::recording
