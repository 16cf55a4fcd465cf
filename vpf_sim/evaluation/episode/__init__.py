"""The loop: one episode, driven, noted step by step, timed and scored."""
