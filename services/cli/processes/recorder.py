"""The recorder as a process."""

from services.cli.processes.options import ProcessOptions
from services.recorder.log_writer import run_metadata
from services.recorder.main import run_recorder
from services.scenarios.info import versions


def start(options: ProcessOptions) -> None:
    """Record until told to stop."""
    metadata = run_metadata(scenario_json=options.scenario.model_dump_json(), versions=versions(), driver="live")
    run_recorder(options.endpoint, options.out, metadata, lifeline=options.lifeline)
