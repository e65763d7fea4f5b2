// Watches a running cell as Foxglove does: node watch.mjs ws://127.0.0.1:8765/?token=… SUBPROTOCOL
// Subscribes to joint states, frames, tags and the description, reads a parameter, and says what came.
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const [, , address, subprotocol = "foxglove.sdk.v1", origin] = process.argv;
const socket = new WebSocket(address, [subprotocol], origin ? { origin } : {});
socket.on("unexpected-response", (_, response) => {
  console.log(JSON.stringify({ refused: response.statusCode }));
  process.exit(0);
});
const client = new protocol.FoxgloveClient({ ws: socket });
const out = { topics: {}, messages: {}, parameters: {} };
const readers = new Map(), topics = new Map();
const wanted = 50;

function finish(code) {
  out.subprotocol = socket.protocol;
  console.log(JSON.stringify(out));
  client.close();
  process.exit(code);
}
setTimeout(() => finish(1), 20000).unref();

client.on("error", (error) => {
  out.error = String(error);
  finish(1);
});
client.on("serverInfo", (info) => (out.server = info));
client.on("status", (status) => (out.status = status));
client.on("advertise", (channels) => {
  for (const channel of channels) {
    out.topics[channel.topic] = channel.schemaName;
    if (channel.encoding !== "cdr") continue;
    if (!/^\/(joint_states|tf|tf_static|robot_description|tags\/.*)$/.test(channel.topic)) continue;
    const subscription = client.subscribe(channel.id);
    topics.set(subscription, channel.topic);
    readers.set(subscription, new MessageReader(parse(channel.schema, { ros2: true })));
  }
  client.getParameters(["robot_description"], "1");
});
client.on("parameterValues", ({ parameters }) => {
  for (const { name, value } of parameters) out.parameters[name] = String(value).length;
});
client.on("message", ({ subscriptionId, data, timestamp }) => {
  const topic = topics.get(subscriptionId);
  const message = readers.get(subscriptionId).readMessage(data);
  const seen = (out.messages[topic] ??= { count: 0 });
  seen.count += 1;
  seen.timestamp = Number(timestamp);
  if (topic === "/joint_states") seen.position = Array.from(message.position);
  if (seen.count >= wanted && out.parameters.robot_description && topic === "/joint_states") finish(0);
});
