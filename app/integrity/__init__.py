"""Can the answer be trusted: fault detection and protection levels."""
