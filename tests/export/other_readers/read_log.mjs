// Read a log with packages that are not ours, and print what is in it as JSON: messages of each topic, and the newest one.
// The test puts this file beside the packages that package.json names.
import { open } from "node:fs/promises";
import { McapIndexedReader } from "@mcap/core";
import { decompress } from "fzstd";
import protobuf from "protobufjs";
import descriptor from "protobufjs/ext/descriptor/index.js";

const file = await open(process.argv[2]);
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, length) => {
    const buffer = new Uint8Array(Number(length));
    await file.read(buffer, 0, Number(length), Number(offset));
    return buffer;
  },
};
const decompressHandlers = { zstd: (data) => decompress(data) };
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });

const types = new Map();
function typeOf(channel) {
  if (!types.has(channel.id)) {
    const schema = reader.schemasById.get(channel.schemaId);
    const root = protobuf.Root.fromDescriptor(descriptor.FileDescriptorSet.decode(schema.data));
    types.set(channel.id, root.lookupType(schema.name));
  }
  return types.get(channel.id);
}

const topics = {};
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  const type = typeOf(channel);
  const body = type.toObject(type.decode(message.data), { longs: String, enums: String });
  const before = topics[channel.topic]?.count ?? 0;
  topics[channel.topic] = { count: before + 1, schema: type.fullName.replace(/^\./, ""), newest: body };
}
await file.close();
process.stdout.write(JSON.stringify(topics));
