// Reads messages that Polyarm wrote and writes them anew: node peer.mjs IN OUT, both a JSON object to a line.
// In: {name, schema, payload (hex)}. Out: {name, read (the message), written (hex), kind (of the encapsulation)}.
import { readFileSync, writeFileSync } from "node:fs";
import { CdrReader } from "@foxglove/cdr";
import { parse } from "@foxglove/rosmsg";
import { MessageReader, MessageWriter } from "@foxglove/rosmsg2-serialization";

const plain = (key, value) => {
  if (typeof value === "bigint") return Number(value);
  if (typeof value === "number" && !Number.isFinite(value)) return null;
  return ArrayBuffer.isView(value) ? Array.from(value) : value;
};

const lines = readFileSync(process.argv[2], "utf8").trim().split("\n");
const answers = lines.map((line) => {
  const { name, schema, payload } = JSON.parse(line);
  try {
    const definitions = parse(schema, { ros2: true });
    const bytes = Buffer.from(payload, "hex");
    const kind = new CdrReader(bytes).kind;
    const read = new MessageReader(definitions).readMessage(bytes);
    const written = Buffer.from(new MessageWriter(definitions).writeMessage(read)).toString("hex");
    return JSON.stringify({ name, kind, read, written }, plain);
  } catch (error) {
    return JSON.stringify({ name, error: String(error) });
  }
});
writeFileSync(process.argv[3], answers.join("\n") + "\n");
