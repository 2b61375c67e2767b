"""Valid settings of a link with every field filled."""

from passafe_protocol.messages import LinkOutage, LinkParameters

PARAMETERS = LinkParameters(
    delay_s=0.2,
    jitter_s=0.05,
    distribution="pareto",
    quantiles_s=(0.0, 0.25),
    correlation=0.5,
    reorder=True,
    loss=0.1,
    burst_enter=0.01,
    burst_leave=0.25,
    burst_loss_good=0.125,
    burst_loss_bad=0.75,
    duplicate=0.02,
    corrupt=0.03,
    rate_hz=500.0,
    queue=20,
    outages=(LinkOutage(1.0, 1.5), LinkOutage(2.0, 3.0)),
    seed=7,
)
