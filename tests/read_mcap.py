#!/usr/bin/env python3
"""Opens a log of oxplow with the PyPI packages `mcap` and `mcap-protobuf-support`, as a stranger would.

    python3 tests/read_mcap.py RUN.mcap [--cut]

Decodes every protobuf message and checks topics, schemas, times, attachments and metadata; prints what it
counted. `--cut`: the file may lack its end (the coordinator was killed). Exit code 0: all is well; 1: something
is wrong with the log; 2: usage; 77: the packages are not installed.
"""

import argparse
import collections
import io
import struct
import sys

try:
    from google.protobuf.message import DecodeError
    from mcap.exceptions import EndOfFile, McapError
    from mcap.reader import make_reader
    from mcap.records import Attachment, Channel, DataEnd, Message, Metadata, Schema
    from mcap.stream_reader import StreamReader
    from mcap_protobuf.decoder import DecoderFactory
except ImportError as missing:
    print(f"skipped: {missing} (pip install mcap mcap-protobuf-support)", file=sys.stderr)
    sys.exit(77)

SCHEMA_OF_TOPIC = {
    "/tf": "foxglove.FrameTransforms",
    "/map": "foxglove.Grid",
    "/map/occupancy": "nav_msgs/msg/OccupancyGrid",
    "/coverage/grid": "foxglove.Grid",
    "/coverage/occupancy": "nav_msgs/msg/OccupancyGrid",
    "/coverage/delta": "oxplow.v1.CoverageDelta",
    "/coverage/progress": "oxplow.v1.CoverageProgress",
    "/fleet/decisions": "oxplow.v1.Decision",
    "/fleet/events": "oxplow.v1.Event",
    "/fleet/faults": "oxplow.v1.FaultInjected",
    "/fleet/operator": "oxplow.v1.OperatorCommand",
    "/fleet/reservations": "oxplow.v1.Reservations",
    "/fleet/result": "oxplow.v1.MissionResult",
    "/fleet/scene": "foxglove.SceneUpdate",
    "/fleet/status": "oxplow.v1.FleetStatus",
    "/fleet/zones": "oxplow.v1.Zones",
    "/log": "foxglove.Log",
    "/sim/contacts": "oxplow.v1.Contact",
    "/sim/truth": "oxplow.v1.GroundTruth",
    "/transport/stats": "oxplow.v1.TransportStats",
}
SCHEMA_OF_ROBOT_TOPIC = {
    "factsheet": "oxplow.v1.Factsheet",
    "connection": "oxplow.v1.Connection",
    "state": "oxplow.v1.State",
    "order": "oxplow.v1.Order",
    "grant": "oxplow.v1.Grant",
    "instantActions": "oxplow.v1.InstantActions",
    "pose": "foxglove.PoseInFrame",
    "path": "foxglove.PosesInFrame",
    "scan": "foxglove.LaserScan",
}
ATTACHMENTS = {"scenario.toml", "floor.pgm", "layout.json"}
RUN_KEYS = {"mission_id", "seed", "cell_m", "body_radius_m", "tool_width_m", "coverage_tolerance_m", "map_origin_x_m", "map_resolution_m"}


class Log:
    """What a log holds, and what is wrong with it."""

    def __init__(self):
        self.schemas, self.channels = {}, {}
        self.counts = collections.Counter()
        self.attachments, self.metadata = {}, {}
        self.latest = {}
        self.first_topic = None
        self.whole = False
        self.wrong = []
        self.decoders = {}
        self.factory = DecoderFactory()

    def take(self, record):
        if isinstance(record, Schema):
            self.schemas[record.id] = record
        elif isinstance(record, Channel):
            self.channels[record.id] = record
        elif isinstance(record, Message):
            self.message(record)
        elif isinstance(record, Attachment):
            self.attachments[record.name] = record.data
        elif isinstance(record, Metadata):
            self.metadata[record.name] = record.metadata
        elif isinstance(record, DataEnd):
            self.whole = True

    def message(self, message):
        channel = self.channels[message.channel_id]
        schema = self.schemas[channel.schema_id]
        self.first_topic = self.first_topic or channel.topic
        self.counts[channel.topic] += 1
        if schema.name != expected_schema(channel.topic):
            self.wrong.append(f"{channel.topic}: schema {schema.name}, not {expected_schema(channel.topic)}")
        for clock in ("log_time", "publish_time"):
            time, before = getattr(message, clock), self.latest.get((channel.topic, clock), 0)
            if time < before:
                self.wrong.append(f"{channel.topic}: {clock} {time} after {before}")
            self.latest[channel.topic, clock] = time
        if message.sequence != self.counts[channel.topic]:
            self.wrong.append(f"{channel.topic}: message {self.counts[channel.topic]} is numbered {message.sequence}")
        try:
            self.decode(channel, schema, message.data)
        except (DecodeError, ValueError, struct.error) as error:
            self.wrong.append(f"{channel.topic}: {error}")

    def decode(self, channel, schema, data):
        if channel.message_encoding == "cdr":
            return check_occupancy_grid(data)
        if channel.id not in self.decoders:
            self.decoders[channel.id] = self.factory.decoder_for(channel.message_encoding, schema)
        decoder = self.decoders[channel.id]
        if decoder is None:
            raise ValueError(f"no decoder for {channel.message_encoding}/{schema.encoding}")
        return decoder(data)


def expected_schema(topic):
    if topic.startswith("/robots/"):
        return SCHEMA_OF_ROBOT_TOPIC.get(topic.rsplit("/", 1)[1])
    return SCHEMA_OF_TOPIC.get(topic)


def check_occupancy_grid(data):
    """Walks through the CDR of a nav_msgs/msg/OccupancyGrid and checks that its lengths agree."""
    if data[:4] != b"\x00\x01\x00\x00":
        raise ValueError("not little-endian CDR")
    body = data[4:]
    length = struct.unpack_from("<I", body, 8)[0]
    at = (12 + length + 3) // 4 * 4 + 8
    _resolution, width, height = struct.unpack_from("<fII", body, at)
    at = (at + 12 + 7) // 8 * 8 + 7 * 8
    cells = struct.unpack_from("<I", body, at)[0]
    if cells != width * height or at + 4 + cells != len(body):
        raise ValueError(f"{width} x {height} cells, {cells} said, {len(body) - at - 4} there")


def read(path, cut):
    log = Log()
    with open(path, "rb") as stream:
        try:
            for record in StreamReader(stream, validate_crcs=True).records:
                log.take(record)
        except (EndOfFile, struct.error):  # the package says either when a record stops short
            if not cut or stream.read(1):
                log.wrong.append("the file ends in the middle of a record")
        except McapError as error:
            log.wrong.append(f"{type(error).__name__}: {error}")
    return log


def check(log, cut):
    if log.first_topic != "/tf":
        log.wrong.append(f"the first message is on {log.first_topic}, not /tf: viewers would hide what comes before")
    for name in sorted(ATTACHMENTS - log.attachments.keys()):
        log.wrong.append(f"attachment {name} is missing")
    for key in sorted(RUN_KEYS - log.metadata.get("fleet.run", {}).keys()):
        log.wrong.append(f"metadata fleet.run has no {key}")
    if cut:
        return
    if not log.whole:
        log.wrong.append("the file has no end")
    if log.counts["/fleet/result"] and "fleet.result" not in log.metadata:
        log.wrong.append("metadata fleet.result is missing")


def check_index(path, log):
    """The seeking reader must find the same messages by the index at the end of the file."""
    with open(path, "rb") as stream:
        summary = make_reader(io.BytesIO(stream.read())).get_summary()
    if summary is None or summary.statistics is None:
        log.wrong.append("the file has no summary")
    elif summary.statistics.message_count != log.counts.total():
        log.wrong.append(f"summary: {summary.statistics.message_count} messages, read: {log.counts.total()}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("log")
    parser.add_argument("--cut", action="store_true", help="the file may lack its end")
    arguments = parser.parse_args()
    try:
        log = read(arguments.log, arguments.cut)
        check(log, arguments.cut)
        if not arguments.cut:
            check_index(arguments.log, log)
    except OSError as error:
        print(f"{arguments.log}: {error.strerror}", file=sys.stderr)
        return 2
    for topic, count in sorted(log.counts.items()):
        print(f"{count:8}  {topic}")
    print(f"{log.counts.total():8}  messages, {len(log.attachments)} attachments, {len(log.metadata)} metadata records")
    for wrong in log.wrong[:20]:
        print(f"WRONG  {wrong}", file=sys.stderr)
    return 1 if log.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
