"""Operator process: a script, or a person at the keyboard of this terminal."""

from contextlib import ExitStack

from passafe_services.loop.node_process import run_node
from passafe_services.loop.process_options import Device, ProcessOptions
from passafe_services.operator.build import operator_node
from passafe_services.operator.keyboard.terminal import Terminal
from passafe_services.operator.node import OperatorNode
from passafe_services.operator.sources.script_source import build_source
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.source_schema import KeyboardSource


def start(options: ProcessOptions) -> None:
    """Drive until stopped, or until the person quits."""
    with ExitStack() as stack:
        if options.device is Device.KEYBOARD:
            terminal = stack.enter_context(Terminal())
            m = robot_of(options.scenario).commands
            source = build_source(KeyboardSource(kind="keyboard"), m, keys=terminal.poll)
            node = OperatorNode(source, epoch=options.epoch, takes_over=options.take_over, show=terminal.show)
        else:
            node = operator_node(options.scenario, options.epoch, takes_over=options.take_over, follows_page=True)
        run_node(node, options, finished=lambda: node.finished)
