"""Data sets of stored runs, for imitation learning and offline reinforcement learning.

`export` draws a run's episodes again and writes them in a format's layout: `lerobot` or `minari_format`, each of which
turns one `Episode` into files and describes the whole set. `contents` says what a frame holds.
"""
