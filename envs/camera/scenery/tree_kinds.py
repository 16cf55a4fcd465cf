"""The kinds of trees and bushes: their crowns, stems and colours."""

from dataclasses import dataclass

Blob = tuple[float, float, float, float]  # centre x, y and radii, in heights; y from the top down


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of tree or bush."""

    height_m: float
    crown: tuple[Blob, ...]
    stems: tuple[tuple[float, float], ...]  # (x, half width) of each, in heights
    hue: tuple[float, float, float]  # RGB of a lit leaf
    gaps: float  # raggedness of the crown


KINDS = (
    Kind(
        9.5,
        ((0.37, 0.30, 0.25, 0.24), (0.2, 0.44, 0.17, 0.16), (0.54, 0.43, 0.18, 0.18)),
        ((0.37, 0.022),),
        (78, 100, 48),
        0.3,
    ),
    Kind(
        8.0,
        ((0.37, 0.25, 0.19, 0.22), (0.33, 0.5, 0.25, 0.22), (0.45, 0.4, 0.22, 0.2)),
        ((0.38, 0.02),),
        (92, 106, 50),
        0.36,
    ),
    Kind(12.5, ((0.37, 0.36, 0.1, 0.35), (0.38, 0.62, 0.12, 0.25)), ((0.37, 0.016),), (66, 90, 46), 0.22),  # poplar
    Kind(
        11.0,
        ((0.37, 0.2, 0.1, 0.2), (0.37, 0.42, 0.17, 0.2), (0.37, 0.68, 0.24, 0.22)),
        ((0.37, 0.016),),
        (46, 70, 48),
        0.3,
    ),
    Kind(  # a clump of three
        10.0,
        ((0.2, 0.42, 0.17, 0.24), (0.42, 0.3, 0.18, 0.26), (0.58, 0.5, 0.15, 0.22), (0.4, 0.62, 0.2, 0.16)),
        ((0.2, 0.014), (0.42, 0.018), (0.58, 0.013)),
        (74, 94, 46),
        0.32,
    ),
    Kind(
        7.0, ((0.3, 0.32, 0.2, 0.26), (0.47, 0.4, 0.2, 0.24)), ((0.33, 0.012), (0.41, 0.012)), (104, 114, 58), 0.42
    ),  # birches
    Kind(2.4, ((0.37, 0.62, 0.33, 0.36), (0.2, 0.76, 0.18, 0.23), (0.56, 0.74, 0.17, 0.24)), (), (76, 96, 46), 0.3),
    Kind(1.6, ((0.2, 0.7, 0.2, 0.28), (0.48, 0.62, 0.24, 0.36), (0.6, 0.8, 0.14, 0.18)), (), (98, 104, 56), 0.4),
)
