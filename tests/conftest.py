"""Settings of every test."""

from hypothesis import HealthCheck, settings

# A busy machine makes no test fail: what a test may take is bounded by its number of examples.
settings.register_profile("passafe", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("passafe")
