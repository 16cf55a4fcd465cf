"""The robust variant: a lateral cost in lane coordinates, the path to its minimum, and recovery."""
