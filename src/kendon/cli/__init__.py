"""The command line: `kendon estimate`, `kendon greet` and what tells about them."""

from kendon.cli.entry import main

__all__ = ["main"]
