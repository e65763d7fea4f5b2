// Reads a recording with the readers of others, whole and by its index, and says what is in it:
//   node check.mjs FILE.mcap
// One JSON object on stdout; an error ends it with code 1.
import { open } from "node:fs/promises";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import lz4 from "lz4js";

const file = await open(process.argv[2], "r");
const size = (await file.stat()).size;
const readAt = async (offset, length) => {
  const bytes = new Uint8Array(Number(length));
  const { bytesRead } = await file.read(bytes, 0, bytes.length, Number(offset));
  if (bytesRead !== bytes.length) throw new Error(`only ${bytesRead} of ${length} bytes at ${offset}`);
  return bytes;
};
const decompressHandlers = { lz4: (data) => lz4.decompress(data) };

// A decoder for every channel, by nothing but what the file says of it.
const decoders = new Map();
function decoder(channel, schema) {
  if (decoders.has(channel.id)) return decoders.get(channel.id);
  const text = new TextDecoder().decode(schema.data);
  let decode;
  if (channel.messageEncoding === "cdr" && schema.encoding === "ros2msg") {
    const reader = new MessageReader(parse(text, { ros2: true }));
    decode = (data) => reader.readMessage(data);
  } else if (channel.messageEncoding === "json" && schema.encoding === "jsonschema") {
    if (JSON.parse(text).type !== "object") throw new Error(`${channel.topic}: no schema of an object`);
    decode = (data) => JSON.parse(new TextDecoder().decode(data));
  } else {
    throw new Error(`${channel.topic}: ${channel.messageEncoding} with ${schema.encoding}`);
  }
  decoders.set(channel.id, decode);
  return decode;
}

const out = { topics: {}, schemas: {}, messages: 0 };

// From its first byte to its last, as one reads what is cut off.
const stream = new McapStreamReader({ validateCrcs: true, includeChunks: false, decompressHandlers });
const channels = new Map(), schemas = new Map();
const attachments = {};
const joints = [];
for (let at = 0; at < size; at += 1 << 20) {
  stream.append(await readAt(at, Math.min(1 << 20, size - at)));
  for (let record; (record = stream.nextRecord()); ) {
    if (record.type === "Schema") schemas.set(record.id, record);
    if (record.type === "Channel") channels.set(record.id, record);
    if (record.type === "Attachment") attachments[record.name] = record.data.length;
    if (record.type !== "Message") continue;
    const channel = channels.get(record.channelId);
    const schema = schemas.get(channel.schemaId);
    const message = decoder(channel, schema)(record.data);
    out.topics[channel.topic] = (out.topics[channel.topic] ?? 0) + 1;
    out.schemas[channel.topic] = schema.name;
    out.messages += 1;
    if (channel.topic === "/joint_states") {
      if (joints.length === 0) out.joint_names = message.name;
      joints.push([Number(record.logTime), Array.from(message.position)]);
    }
    if (channel.topic === "/robot_description") out.description = message.data.length;
  }
}
out.done = stream.done();
out.left = stream.bytesRemaining();
out.attachments = attachments;
out.first_joints = joints[0];
out.last_joints = joints[joints.length - 1];

// By its index: all, the newest first, and from a time on. Only a whole file has one.
if (out.done) {
  const readable = { size: async () => BigInt(size), read: readAt };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  out.profile = reader.header.profile;
  out.statistics = Number(reader.statistics.messageCount);
  const times = async (args) => {
    const seen = [];
    for await (const message of reader.readMessages({ validateCrcs: true, ...args })) seen.push(message.logTime);
    return seen;
  };
  const forwards = await times({});
  const backwards = await times({ reverse: true });
  out.indexed = forwards.length;
  out.ordered = forwards.every((time, i) => i === 0 || forwards[i - 1] <= time);
  out.reversed = backwards.length === forwards.length && backwards.every((time, i) => i === 0 || backwards[i - 1] >= time);
  const middle = (forwards[0] + forwards[forwards.length - 1]) / 2n;
  const late = await times({ startTime: middle });
  out.sought = late.length === forwards.filter((time) => time >= middle).length && late.every((time) => time >= middle);
  const one = await times({ topics: ["/joint_states"] });
  out.by_topic = one.length === joints.length;
  for await (const attachment of reader.readAttachments()) {
    if (attachments[attachment.name] !== attachment.data.length) throw new Error(`attachment ${attachment.name}`);
  }
}
await file.close();
console.log(JSON.stringify(out));
