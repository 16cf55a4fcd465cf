"""Episodes driven, scored, repeated and compared. Where to begin: `episode/episode.py`, the loop.

What all parts speak of lies here: `job` (what is to be driven), `steps` (what happened), `outcome` (how it went). Each
package imports only those above it:

- metrics: the scores of an episode, and the record that holds them
- truth: what the renderer and the road know and no driver is told
- rendering: what the picture is worth, seen along scripted drives without a driver
- weather: what a weather means, and does to the plain perception
- processes: workers of one thread each, that may hang or die
- episode: the loop, its log and its clock
- sweeps: many episodes, and the folder that keeps them
- analysis: what the records of a run say
- readings: a search over what the paper leaves open
- perception: perception alone, on the poses of stored drives
- gate: whether a run keeps the rules
- machine: whether this machine drives as it should, and how fast
"""
