"""The scores of an episode, each a function of its step table, and the record that holds them all."""
