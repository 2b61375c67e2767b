"""The filter process: prediction, decision, input sequences and telemetry."""
