"""Whether this machine has all that is needed, drives as it should, and how fast."""
