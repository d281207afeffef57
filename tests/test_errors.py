"""Messages that name what is there."""

from __future__ import annotations

import pytest

from kendon.errors import UnknownNameError


@pytest.mark.parametrize(
    ("name", "valid", "message"),
    [
        ("wawe", ["home", "wave"],
         "there is no gesture 'wawe'; valid: home, wave; did you mean 'wave'?"),
        ("jump", ["home", "wave"], "there is no gesture 'jump'; valid: home, wave"),
        ("wave", [], "there is no gesture 'wave'; valid: none"),
    ],
)  # fmt: skip
def test_an_unknown_name_is_answered_in_one_sentence(
    name: str, valid: list[str], message: str
) -> None:
    assert str(UnknownNameError("gesture", name, valid)) == message
