"""The version of kendon."""

__version__ = "0.1.0"
