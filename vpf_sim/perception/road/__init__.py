"""The edges of the carriageway from painted lines, and what obstacles hide of the road."""
