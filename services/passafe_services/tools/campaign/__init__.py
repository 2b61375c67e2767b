"""Adversarial campaigns: many seeded closed loops of core filter and plant, and the worst that was seen."""
