"""Prints the tables of a replay."""

from collections.abc import Sequence
from textwrap import fill

from vpf_sim.cli.tables import print_table
from vpf_sim.replay.tables import Table

WIDTH = 120  # of a note


def print_all(tables: Sequence[Table]) -> None:
    """Print all tables with their notes."""
    for number, table in enumerate(tables):
        print(("\n" if number else "") + table.title + "\n")
        print_table(table.header, table.rows, table.words)
        if table.notes:
            print()
        for note in table.notes:
            print(fill(note, WIDTH, subsequent_indent="  ", break_long_words=False))
