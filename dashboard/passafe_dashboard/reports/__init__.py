"""Make the HTML reports of a run and of an experiment."""
