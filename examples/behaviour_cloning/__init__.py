"""Behaviour cloning with DAgger: a small network learns to drive from drivers with privilege.

    scenes -> collect (expert and learner take turns, the expert labels) -> fit -> export -> again

DAgger: S. Ross, G. Gordon, J. A. Bagnell, A Reduction of Imitation Learning and Structured Prediction to No-Regret
Online Learning, AISTATS 2011. The driver labels what the network's own mistakes lead to, so it learns to recover.
"""
