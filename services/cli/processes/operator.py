"""The operator as a process: a script, or a person at the keyboard of this terminal."""

import time
from contextlib import ExitStack

from services.cli.processes.live import run_node
from services.cli.processes.options import Device, ProcessOptions
from services.operator.node import OperatorNode
from services.operator.scenario_source import source_of
from services.operator.sources import build_source
from services.operator.terminal import Terminal
from services.scenarios.design import robot_of
from services.scenarios.source_schema import KeyboardSource


def start(options: ProcessOptions) -> None:
    """Drive until told to stop, or until the person quits."""
    epoch = time.time_ns()
    with ExitStack() as stack:
        if options.device is Device.KEYBOARD:
            terminal = stack.enter_context(Terminal())
            m = robot_of(options.scenario).system.m
            source = build_source(KeyboardSource(kind="keyboard"), m, keys=terminal.poll)
            node = OperatorNode(source, epoch=epoch, show=terminal.show)
        else:
            node = OperatorNode(source_of(options.scenario), epoch=epoch)
        run_node(node, options, epoch=epoch, finished=lambda: node.finished)
