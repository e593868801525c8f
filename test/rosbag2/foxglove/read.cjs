// Print every message of an MCAP file as a line of JSON, read as Foxglove reads it.
const { open } = require("fs/promises");
const { McapIndexedReader } = require("@mcap/core");
const { loadDecompressHandlers } = require("@mcap/support");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

async function main(path) {
  const file = await open(path);
  const readable = {
    size: async () => BigInt((await file.stat()).size),
    read: async (offset, length) => {
      const buffer = new Uint8Array(Number(length));
      await file.read(buffer, 0, Number(length), Number(offset));
      return buffer;
    },
  };
  const decompressHandlers = await loadDecompressHandlers();
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const decoders = new Map();
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    if (!decoders.has(schema.id)) {
      const text = new TextDecoder().decode(schema.data);
      decoders.set(schema.id, new MessageReader(parse(text, { ros2: true })));
    }
    const decoded = decoders.get(schema.id).readMessage(message.data);
    const line = {
      topic: channel.topic,
      type: schema.name,
      log_time: message.logTime.toString(),
      publish_time: message.publishTime.toString(),
      message: decoded,
    };
    console.log(JSON.stringify(line, (_, value) => (ArrayBuffer.isView(value) ? [...value] : value)));
  }
  await file.close();
}

main(process.argv[2]);
