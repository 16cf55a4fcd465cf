"""What the camera tells of the road ahead.

- egomotion: optical flow, the camera's own motion and pitch, depth from motion
- road: the edges of the carriageway, and what obstacles hide of it
- obstacles: standing, low and moving obstacles, tracked from frame to frame
- paper: time to contact and obstacle map, as printed in the paper and repaired

`obstacles` may import `egomotion` and `road`, `paper` only `egomotion`; `contrast` and `quantiles` help all of them.
"""
