"""Tables on the terminal: text wraps where it is narrow, numbers never do."""

from __future__ import annotations

from rich.console import Console
from rich.measure import Measurement
from rich.table import Table

#: Wider than any table.
_UNBOUNDED = 100_000
#: A longer word of a text may go on in the next line [letters].
_LONGEST = 26


def print_table(table: Table, console: Console) -> None:
    """Print a table with its title above.

    Numbers, which are what is justified to the right, words that are not too long, and columns
    that do not wrap are never cut short: on a narrow terminal the table reaches beyond its rim.
    What is not printed on a terminal, but piped or written to a file, has one line a row.
    """
    unbounded = console.options.update(max_width=_UNBOUNDED)
    for column in table.columns:
        whole = column.justify == "right" or column.no_wrap
        cells = [Measurement.get(console, unbounded, cell) for cell in column.cells]
        head = Measurement.get(console, unbounded, column.header)
        column.min_width = max(
            head.maximum if column.no_wrap else head.minimum,
            *(cell.maximum if whole else min(cell.minimum, _LONGEST) for cell in cells),
        )
        if not whole:
            column.overflow = "fold"
    if table.title:
        # Not by the table, which would wrap it at its own width.
        console.print(table.title, style="table.title", soft_wrap=True, highlight=False)
        table.title = None
    needed = Measurement.get(console, unbounded, table)
    if not console.is_terminal:
        table.width = needed.maximum
    elif needed.minimum > console.width:
        table.width = needed.minimum
    console.print(table, crop=False)
