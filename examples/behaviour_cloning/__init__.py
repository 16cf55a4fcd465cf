"""Behaviour cloning with DAgger: a small network learns to drive from a driver with privilege.

    scenes -> collect (teacher and learner take turns, the teacher labels) -> fit -> export -> again

DAgger: S. Ross, G. Gordon, J. A. Bagnell, A Reduction of Imitation Learning and Structured Prediction to No-Regret
Online Learning, AISTATS 2011. The teacher labels what the network's own mistakes lead to, so it learns to recover.
"""
