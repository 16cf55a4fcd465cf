"""The paper's potential fields, and the heading by their total force."""
