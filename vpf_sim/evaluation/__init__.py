"""Episodes driven, scored, repeated and compared. Where to begin: `episode/episode.py`, the loop.

What all parts speak of lies here: `job` (what is to be driven), `steps` (what happened), `outcome` (how it went). The
packages, each importing only those above it: `metrics`, `truth`, `rendering`, `weather`, `processes`, `episode`,
`sweeps`, `analysis`, `gate`, `machine`.
"""
