"""kendon reads which phase of a greeting a person is in, and lets a social robot greet back.

import kendon

track = kendon.read_track("person.csv")
observations = kendon.observe(track)
model = kendon.load_model("kendon")
print(model.filter(observations.values))  # P(phase) after each observation

All that is offered is in `kendon.public`. It takes half a second to import, in which the command
line could answer no interrupt; so that is done when the first of it is asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from kendon._version import __version__ as __version__

if TYPE_CHECKING:
    from kendon.public import *  # noqa: F403
    from kendon.public import __all__ as __all__
else:

    def __getattr__(name):
        dunder = name.startswith("__") and name != "__all__"  # Python asks for some
        if not dunder and "__all__" not in globals():
            public = import_module("kendon.public")
            globals().update({offered: getattr(public, offered) for offered in public.__all__})
            globals()["__all__"] = public.__all__
            if name in globals():  # one of these, or a package of kendon's, now that it is imported
                return globals()[name]
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__():
        return sorted({*globals(), *import_module("kendon.public").__all__})
