"""Reads a recording with the MCAP library for Python, which shares no code with Tactus, and prints what it found as JSON.

Every message is decoded by the schema in the file, and nothing here knows the channels but by their topics. A recording that
breaks off is read as far as it goes.
"""

import json
import struct
import sys

from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Footer, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory


class Reader:
    """What was found so far."""

    def __init__(self):
        self.schemas = {}
        self.channels = {}
        self.protobuf = DecoderFactory()
        self.counts = {}
        self.last = {}
        self.all = {"/controller/phase": [], "/controller/touch": [], "/controller/contact": [], "/log": []}
        self.frames = set()
        self.entities = {}
        self.points = {}
        self.metadata = {}
        self.attachments = {}
        self.last_time_s = 0.0

    def take(self, record):
        if isinstance(record, Schema):
            self.schemas[record.id] = record
        elif isinstance(record, Channel):
            self.channels[record.id] = record
        elif isinstance(record, Message):
            self.take_message(record)
        elif isinstance(record, Metadata):
            self.metadata[record.name] = record.metadata
        elif isinstance(record, Attachment):
            self.attachments[record.name] = json.loads(record.data)

    def take_message(self, message):
        channel = self.channels[message.channel_id]
        schema = self.schemas[channel.schema_id]
        topic = channel.topic
        self.counts[topic] = self.counts.get(topic, 0) + 1
        assert message.log_time >= self.last_time_s * 1e9 - 1, f"{topic}: time runs backwards"
        self.last_time_s = message.log_time * 1e-9
        if channel.message_encoding == "json":
            content = decode_json(schema, topic, message)
            self.last[topic] = content
            if topic in self.all:
                self.all[topic].append(content)
        else:
            self.take_picture(topic, self.protobuf.decoder_for(channel.message_encoding, schema)(message.data))

    def take_picture(self, topic, content):
        if topic == "/tf":
            self.frames.update(transform.child_frame_id for transform in content.transforms)
            self.last[topic] = {
                transform.child_frame_id: [getattr(transform.translation, axis) for axis in "xyz"]
                for transform in content.transforms
            }
        elif topic.startswith("/scene/"):
            for entity in content.entities:
                shapes = sum(len(getattr(entity, kind)) for kind in ("cubes", "spheres", "cylinders", "triangles"))
                self.entities[entity.id] = [entity.frame_id, shapes]
        elif topic.startswith("/points/"):
            assert topic == f"/points/{content.frame_id}", f"{topic}: frame {content.frame_id}"
            assert len(content.data) % content.point_stride == 0, f"{topic}: a point is cut off"
            self.points[content.frame_id] = len(content.data) // content.point_stride
        elif topic == "/log":
            self.all[topic].append(content.message)


def decode_json(schema, topic, message):
    """A message has the fields of its schema, all of them and no others."""
    content = json.loads(message.data)
    expected = json.loads(schema.data)["properties"]
    assert set(content) == set(expected), f"{topic}: {sorted(content)} instead of {sorted(expected)}"
    assert content["tick"] * 2_000_000 == message.log_time, f"{topic}: tick {content['tick']} at {message.log_time} ns"
    return content


def next_record(records, file):
    """The next record; None where the file ends within one. The library says that in several ways, by what was cut."""
    try:
        return next(records)
    except (EndOfFile, struct.error, RuntimeError):
        if file.read(1):
            raise
        return None


def read(path):
    reader = Reader()
    with open(path, "rb") as file:
        records = iter(StreamReader(file).records)
        whole = False
        while not whole and (record := next_record(records, file)):
            reader.take(record)
            whole = isinstance(record, Footer)
    found = {name: value for name, value in vars(reader).items() if name not in ("schemas", "channels", "protobuf")}
    found["frames"] = sorted(reader.frames)
    found["topics"] = [channel.topic for channel in reader.channels.values()]
    found["whole"] = whole
    if whole:
        with open(path, "rb") as file:
            summary = make_reader(file).get_summary()
        found["indexed_messages"] = summary.statistics.message_count
        found["empty_chunks"] = sum(not chunk.message_index_offsets for chunk in summary.chunk_indexes)
    return found


if __name__ == "__main__":
    json.dump(read(sys.argv[1]), sys.stdout)
