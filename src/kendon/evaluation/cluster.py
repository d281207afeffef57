"""Computing on a Dask cluster instead of this machine (the extra ``cluster``)."""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Iterator
from typing import Any

from kendon._version import __version__
from kendon.errors import MissingExtraError, ParameterError

#: How long a scheduler has to answer [s].
PATIENCE = 10.0


def require_dask() -> Any:
    """The module `distributed`, or a refusal to go on without the extra.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        return importlib.import_module("distributed")
    except ImportError:
        raise MissingExtraError("computing on a Dask cluster", "cluster", "distributed") from None


@contextlib.contextmanager
def dask_cluster(address: str) -> Iterator[None]:
    """Let joblib compute on the workers of a cluster while the context lasts.

    Args:
        address: of the scheduler, as in ``tcp://10.0.0.1:8786`` or ``10.0.0.1:8786``.

    Raises:
        MissingExtraError: the extra is not installed.
        ParameterError: nothing answers there, it has no workers, or they have another kendon.
    """
    distributed = require_dask()
    from joblib import parallel_config

    try:
        # A client that cannot be made for its address complains of it again as the program ends.
        scheme, place = distributed.comm.addressing.parse_address(address)
        if scheme in ("tcp", "tls"):
            distributed.comm.addressing.parse_host_port(place)
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise ParameterError(f"no Dask scheduler answers at {address!r} ({reason})") from None
    with client:
        _check_workers(client, address)
        # n_jobs=-1: as many at once as the workers have threads.
        with parallel_config(backend="dask", client=client, n_jobs=-1):
            yield


def _check_workers(client: Any, address: str) -> None:
    """Refuse a cluster that would wait for ever, or compute something else than this machine."""
    workers = client.scheduler_info(n_workers=-1)["workers"]
    if not workers:
        raise ParameterError(f"the Dask cluster at {address!r} has no workers; start some first")
    versions = client.run(_version_of_kendon, on_error="return")
    other = {str(v) for v in versions.values() if v != __version__}
    if other:
        raise ParameterError(
            f"the workers of the Dask cluster at {address!r} need kendon {__version__},"
            f" as here; one of them says: {min(other)}"
        )


def _version_of_kendon() -> str:
    from kendon import __version__

    return __version__
