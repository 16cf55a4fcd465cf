"""Ground truth from renderer and road that drivers never receive."""
