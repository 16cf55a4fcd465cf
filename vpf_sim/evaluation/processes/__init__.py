"""Single-threaded worker processes with timeouts and retries."""
