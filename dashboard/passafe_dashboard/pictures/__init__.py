"""Draw runs, experiments and feasibility atlases as SVG files, without a browser."""
