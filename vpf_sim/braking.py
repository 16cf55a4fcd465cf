"""The speed reference that asks the controller for comfortable braking."""


def comfortable_speed(speed_mps: float) -> float:
    """m/s, the lowest reference at a speed that needs comfortable braking alone."""
    return speed_mps - max(min(2.5, 0.6 * speed_mps), 1.0)
