"""Measures what it takes to log a message: ``python benchmarks/log_rate.py``.

The recorder's own way from wire bytes to the disk: header read and counted, handed to the thread, digest, manifest,
chunk compressed by zstd, checkpoint signed, flushed every 0.15 s of messages at 20,000 a second. Processor time over
all threads of the process, by turns with a log that has no checkpoints, with one whose checkpoints are not signed, and
with the 50 µs that are to be had for a message at 20,000 a second on one processor.
"""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import typer
from passafe_protocol.codec import encode
from passafe_protocol.identity import Identity
from passafe_protocol.messages import Header, Message
from passafe_protocol.topics import Topic
from passafe_services.keys.credentials import load_credentials
from passafe_services.keys.deployment import Deployment
from passafe_services.keys.signing import Signer
from passafe_services.log.chain import Chain
from passafe_services.log.log_file import LogFile
from passafe_services.log.segmented_log import SegmentedLog
from passafe_services.recorder.background_log import BackgroundLog
from passafe_services.recorder.message_recorder import MessageRecorder
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop
from report import AsJson, Ratio, Report, Smallest
from timing import in_turn

RATE_HZ = 20_000
FLUSHED = round(0.15 * RATE_HZ)
DRAINED = RATE_HZ // 50
"""Messages of a drain at 50 Hz."""

SIGNED, PLAIN = "signed checkpoints", "no checkpoints"

Sample = tuple[str, bytes]


def messages_of_a_run(steps: int) -> list[Sample]:
    """Return the messages of the shipped scenario, as on the bus."""
    samples: list[Sample] = []

    def observe(topic: Topic, header: Header, body: Message) -> None:
        if topic.recorded:
            samples.append((topic.key(header.source), encode(header, body)))

    loop = lockstep_loop(load_scenario("notomista-cai-2020"), observer=observe)
    loop.run(steps)
    loop.finish()
    return samples


def recorded_us(samples: Sequence[Sample], path: Path, signer: Signer | None) -> float:
    """Return the processor time of the recorder for a message, µs."""
    with BackgroundLog(SegmentedLog(path, {}, Chain("benchmark", signer))) as log:
        recorder = MessageRecorder(log)
        begun = time.process_time()
        for start in range(0, len(samples), DRAINED):
            recorder.record(samples[start : start + DRAINED], start + 1, start)
            log.hand_over()
            if start % FLUSHED < DRAINED:
                log.flush(recorder.gaps())
                log.wait_until_idle()  # the disk of a recorder has the time between
        log.flush(recorder.gaps())
        log.wait_until_idle()
        return (time.process_time() - begun) / len(samples) * 1e6


class _PlainLog:
    """Log without checkpoints."""

    def __init__(self, file: LogFile) -> None:
        self.file = file
        self._channels: dict[str, int] = {}

    def write(self, key: str, data: bytes, *, sequence: int, wall_ns: int) -> None:
        """Log one message."""
        channel = self._channels.get(key)
        if channel is None:
            channel = self._channels[key] = self.file.mcap.register_channel(key, "protobuf", 0)
        self.file.mcap.add_message(channel, wall_ns, data, wall_ns, sequence % 2**32)


def plain_us(samples: Sequence[Sample], path: Path) -> float:
    """Return the processor time for a message in a log without checkpoints, by one thread, µs."""
    with LogFile(path) as file:
        recorder = MessageRecorder(_PlainLog(file))
        begun = time.process_time()
        for start in range(0, len(samples), DRAINED):
            recorder.record(samples[start : start + DRAINED], start + 1, start)
            if start % FLUSHED < DRAINED:
                file.flush()
        file.flush()
        return (time.process_time() - begun) / len(samples) * 1e6


def signer_in(folder: Path) -> Signer:
    """Return a recorder's signer with keys of its own."""
    Deployment.create(folder / "keys").issue([Identity(role="recorder", robot="robot")])
    return Signer.of(load_credentials(folder / "keys", "recorder", "robot"))


def main(rounds: int = 5, smallest: Smallest = False, as_json: AsJson = False) -> None:
    """Report the processor time of a message, and what checkpoints and signatures add to it."""
    samples = messages_of_a_run(200 if smallest else 10_000)
    with TemporaryDirectory() as name:
        folder = Path(name)
        signer = signer_in(folder)
        ways: dict[str, Callable[[], float]] = {
            SIGNED: lambda: recorded_us(samples, folder / "signed.mcap", signer),
            "checkpoints without keys": lambda: recorded_us(samples, folder / "chained.mcap", None),
            PLAIN: lambda: plain_us(samples, folder / "plain.mcap"),
        }
        times = dict(zip(ways, in_turn(list(ways.values()), 1 if smallest else rounds), strict=True))
        sizes = {name: (folder / file).stat().st_size for name, file in zip(ways, FILES, strict=True)}
    report = Report(
        title=f"{len(samples)} messages of {sum(len(data) for _, data in samples) / len(samples):.0f} bytes on average",
        columns=("log", "µs a message", "bytes a message", "messages a second on one processor"),
    )
    for way, each in times.items():
        best = min(each)
        report.rows.append((way, f"{best:.1f}", f"{sizes[way] / len(samples):.0f}", f"{1e6 / best:,.0f}"))
    signed, chained, plain = times.values()
    budget = [1e6 / RATE_HZ] * len(signed)
    report.ratios += [
        Ratio.of_rounds("signed log", signed, "no checkpoints", plain),
        Ratio.of_rounds("signed log", signed, "not signed", chained),
        Ratio.of_rounds(f"{RATE_HZ:,} messages a second, signed", signed, "one processor", budget),
        Ratio.of_rounds("size of a signed log", [sizes[SIGNED]], "no checkpoints", [sizes[PLAIN]]),
    ]
    report.finish(as_json=as_json)


FILES = ("signed.mcap", "chained.mcap", "plain.mcap")

if __name__ == "__main__":
    typer.run(main)
