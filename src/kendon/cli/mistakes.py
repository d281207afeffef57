"""What Typer finds wrong with a command line, in one sentence like kendon's own errors."""

from __future__ import annotations

from typing import Any

import typer
from typer.core import TyperGroup

from kendon.errors import UnknownNameError

#: The root of Typer's complaints about what was typed. It comes from Click, which newer versions
#: of Typer carry within them and older ones import: this is the class either way.
UsageError: type[Exception] = typer.BadParameter.__mro__[1]


class Commands(TyperGroup):
    """The commands of kendon; an unknown one is told as any unknown name is."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that the first word names.

        Raises:
            UnknownNameError: there is none; the message lists those that there are.
        """
        if args and args[0] not in self.commands and not args[0].startswith("-"):
            raise UnknownNameError("command", args[0], self.list_commands(ctx))
        return super().resolve_command(ctx, args)


def sentence(error: Any, command: str) -> str:
    """A complaint of Typer's as one sentence, with the option's name and where to look.

    Args:
        error: a `UsageError`.
        command: what was called, "kendon greet" or "kendon" alone.
    """
    if hasattr(error, "possibilities"):
        near = " or ".join(map(repr, error.possibilities or ()))
        hint = f"; did you mean {near}?" if near else ""
        return f"there is no option {error.option_name!r} ({command} --help lists them){hint}"
    if isinstance(error, typer.BadParameter) and error.message:
        text = f"{_place(error)}: {_plain(error.message)}{_value(error)}"
    else:
        text = _plain(error.format_message())
    return f"{text}; see {command} --help"


def _place(error: Any) -> str:
    """The option or argument that is wrong, as it is typed."""
    param = error.param
    if param is None:
        return "the command line"
    options = [name for name in param.opts if name.startswith("-")]
    return str(options[-1] if options else param.metavar or param.name)


def _plain(message: str) -> str:
    """A message without line breaks, capitals and full stops, as a part of a sentence."""
    message = " ".join(message.split()).rstrip(".").removeprefix("Value error, ")
    message = message.partition(", unable to parse")[0].replace(". ", "; ")
    return message[:1].lower() + message[1:]


def _value(error: Any) -> str:
    """What was given instead, where the message leaves it out.

    Newer versions of Typer have values checked by pydantic, which hands it on.
    """
    found: list[dict[str, Any]] = getattr(error.__cause__, "errors", list)()
    value = str(found[0].get("input", "")) if found else ""
    return f", not {value!r}" if value and repr(value) not in error.message else ""
