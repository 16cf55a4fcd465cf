"""Words painted on the road, drawn out along it so that a driver reads them from afar."""

from collections.abc import Iterator

Stroke = tuple[float, float, float, float]  # from (right, ahead) to (right, ahead), shares of a letter's box

WORDS = ("BUS", "SLOW", "STOP", "30", "50")
WORD_M, LETTER_M, SPACE_M = 2.4, 0.45, 0.2  # length along the road, width of a letter, space between two
STROKE_M, BAR_M = 0.11, 0.24  # of strokes along the road, and of those across it

LETTERS: dict[str, tuple[Stroke, ...]] = {
    "B": ((0, 0, 0, 1), (0, 0, 1, 0), (0, 0.5, 1, 0.5), (0, 1, 1, 1), (1, 0, 1, 0.45), (1, 0.55, 1, 1)),
    "L": ((0, 0, 0, 1), (0, 0, 1, 0)),
    "O": ((0, 0, 0, 1), (1, 0, 1, 1), (0, 0, 1, 0), (0, 1, 1, 1)),
    "P": ((0, 0, 0, 1), (0, 1, 1, 1), (1, 0.5, 1, 1), (0, 0.5, 1, 0.5)),
    "S": ((0, 0, 1, 0), (1, 0, 1, 0.5), (0, 0.5, 1, 0.5), (0, 0.5, 0, 1), (0, 1, 1, 1)),
    "T": ((0.5, 0, 0.5, 1), (0, 1, 1, 1)),
    "U": ((0, 0, 0, 1), (1, 0, 1, 1), (0, 0, 1, 0)),
    "W": ((0.25, 0, 0, 1), (0.25, 0, 0.5, 0.8), (0.75, 0, 0.5, 0.8), (0.75, 0, 1, 1)),
    "0": ((0, 0, 0, 1), (1, 0, 1, 1), (0, 0, 1, 0), (0, 1, 1, 1)),
    "3": ((1, 0, 1, 1), (0, 0, 1, 0), (0.3, 0.5, 1, 0.5), (0, 1, 1, 1)),
    "5": ((0, 0, 1, 0), (1, 0, 1, 0.5), (0, 0.5, 1, 0.5), (0, 0.5, 0, 1), (0, 1, 1, 1)),
}


def word(text: str) -> Iterator[list[tuple[float, float]]]:
    """The strokes of a word as quadrilaterals of (ahead, right) m, from the middle of its foot."""
    wide_m = len(text) * (LETTER_M + SPACE_M) - SPACE_M
    for number, letter in enumerate(text):
        left_m = number * (LETTER_M + SPACE_M) - 0.5 * wide_m
        for right_0, ahead_0, right_1, ahead_1 in LETTERS[letter]:
            start, end = ((WORD_M * a, left_m + LETTER_M * r) for a, r in ((ahead_0, right_0), (ahead_1, right_1)))
            along, across = (0.5 * BAR_M, 0.0) if ahead_0 == ahead_1 else (0.0, 0.5 * STROKE_M)
            yield [
                (start[0] - along, start[1] - across),
                (end[0] - along, end[1] - across),
                (end[0] + along, end[1] + across),
                (start[0] + along, start[1] + across),
            ]
