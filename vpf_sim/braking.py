"""Speed references that ask the controller for comfortable and for hard braking."""


def comfortable_speed(speed_mps: float) -> float:
    """m/s, the lowest reference at a speed that needs comfortable braking alone."""
    return speed_mps - max(min(2.5, 0.6 * speed_mps), 1.0)


def hard_excess(speed_mps: float, most_mps: float = 3.0) -> float:
    """m/s below the speed, from which the brake goes beyond comfort, to its full 1 m/s later; at most `most_mps`."""
    return max(min(most_mps, 0.7 * speed_mps), 1.2)
