"""Faults of processes and of the machine: each begins and ends, as a context manager of a system."""

import os
import resource
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from pathlib import Path
from shutil import rmtree

import psutil
from fault_system import FaultSystem

Injection = Callable[[FaultSystem], AbstractContextManager[None]]

SPIN = "while True: pass"
HOGS = 4
"""Busy processes of a hog: two for each of two processors."""


def signalled(name: str, signum: signal.Signals) -> Injection:
    """Return the fault that a process gets a signal once."""

    @contextmanager
    def inject(system: FaultSystem) -> Iterator[None]:
        system.process(name).send_signal(signum)
        yield

    return inject


def suspended(name: str) -> Injection:
    """Return the fault that a process does not run for a while: SIGSTOP, then SIGCONT."""

    @contextmanager
    def inject(system: FaultSystem) -> Iterator[None]:
        process = system.process(name)
        process.suspend()
        try:
            yield
        finally:
            process.resume()

    return inject


def clock_jump(name: str, offset_s: float) -> Injection:
    """Return the fault that the wall clock of a process jumps, and later back."""

    @contextmanager
    def inject(system: FaultSystem) -> Iterator[None]:
        system.set_clock(name, offset_s)
        try:
            yield
        finally:
            system.set_clock(name, 0.0)

    return inject


def clock_set_back_restart(name: str, offset_s: float) -> Injection:
    """Return the fault that a process dies and starts again under another wall clock, which stays."""

    @contextmanager
    def inject(system: FaultSystem) -> Iterator[None]:
        system.set_clock(name, offset_s)
        system.process(name).kill()
        yield

    return inject


def no_descriptors(name: str) -> Injection:
    """Return the fault that a process can open no file and no connection."""

    @contextmanager
    def inject(system: FaultSystem) -> Iterator[None]:
        process = system.process(name)
        limited = resource.RLIMIT_NOFILE
        _, hard = process.rlimit(limited)
        process.rlimit(limited, (process.num_fds(), hard))
        try:
            yield
        finally:
            with suppress(psutil.NoSuchProcess):
                process.rlimit(limited, (hard, hard))

    return inject


def no_memory(name: str) -> Injection:
    """Return the fault that a process gets no more address space."""

    @contextmanager
    def inject(system: FaultSystem) -> Iterator[None]:
        process = system.process(name)
        process.rlimit(resource.RLIMIT_AS, (process.memory_info().vms, resource.RLIM_INFINITY))
        try:
            yield
        finally:
            with suppress(psutil.NoSuchProcess):
                process.rlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))

    return inject


@contextmanager
def hogged_processors(_system: FaultSystem) -> Iterator[None]:
    """Keep every processor busy with others' work."""
    with ExitStack() as stack:
        for _ in range(HOGS):
            hog = stack.enter_context(subprocess.Popen([sys.executable, "-S", "-c", SPIN]))
            stack.callback(hog.kill)
        yield


@contextmanager
def deleted_folder(system: FaultSystem) -> Iterator[None]:
    """Delete the folder into which the recorder writes."""
    rmtree(system.folder)
    yield


@contextmanager
def full_disk(system: FaultSystem) -> Iterator[None]:
    """Fill the rest of the disk: a small one of its own where we may mount, a limit of the file's size elsewhere."""
    if os.path.ismount(system.folder):
        with suppress(OSError), (system.folder / "filler").open("wb", buffering=0) as filler:
            while True:
                filler.write(bytes(4096))
    else:
        recorder = system.process("recorder")
        recorder.rlimit(resource.RLIMIT_FSIZE, (0, 0))
    yield


@contextmanager
def duplicate(system: FaultSystem, name: str) -> Iterator[None]:
    """Start another process of the same name beside the running one."""
    scenario = next(iter(Path(system.folder).glob("*.scenario.json")))
    command = [sys.executable, "-P", "-m", "passafe_services.cli.run", name, "--insecure", "--scenario", str(scenario)]
    with subprocess.Popen(
        [*command, "--router", system.demo.router], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as process:
        try:
            yield
        finally:
            process.send_signal(signal.SIGTERM)
            process.wait(20)
