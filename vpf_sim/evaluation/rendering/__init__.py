"""What the rendered picture is worth, seen along scripted drives without a driver: steady, and like recorded ones."""
