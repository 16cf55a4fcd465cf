"""One episode: the closed loop, its step log, timing and scores."""
