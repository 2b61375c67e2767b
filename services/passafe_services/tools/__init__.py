"""Tools over logs and loops: review, replay, experiment, campaign, feasibility, recover."""
