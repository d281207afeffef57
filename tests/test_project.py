"""The project's own rules: what imports what, how long a module is, what the lock may hold."""

from __future__ import annotations

import ast
import importlib.metadata
import re
import socket
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
import shared_data
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import kendon
from kendon import _version
from kendon.cli.information import EXTRAS

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src"
FILES = sorted((SOURCE / "kendon").rglob("*.py"))
LOCK = ROOT / "constraints.txt"

#: The packages and modules directly under `kendon`, from the inside out: each imports only its
#: own ring and those before it. What stands in no ring is outermost: nothing here may import it.
RINGS = {
    "ground floor": {"_version", "errors", "phases", "geometry", "outputs", "processes", "tables"},
    "understanding one person": {"person", "tracks", "observations", "features", "models"},
    "the world outside": {"trees", "robots", "sources", "simulation"},
    "main job": {"greeter"},
}


def _module(file: Path) -> str:
    parts = file.relative_to(SOURCE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {_module(file): file for file in FILES}


@cache
def _tree(module: str) -> ast.Module:
    return ast.parse(MODULES[module].read_text(encoding="utf-8"))


def _imported(module: str, node: ast.AST) -> Iterator[str]:
    """The modules of kendon that one statement imports."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names if alias.name in MODULES)
    elif isinstance(node, ast.ImportFrom):
        base = node.module or ""
        if node.level:
            is_package = MODULES[module].name == "__init__.py"
            parts = module.split(".")
            kept = parts[: len(parts) - node.level + is_package]
            base = ".".join([*kept, base] if base else kept)
        for alias in node.names:
            inner = f"{base}.{alias.name}"
            if inner in MODULES:
                yield inner
            elif base in MODULES:
                yield base


def _all_imports(module: str) -> set[str]:
    """Every import, those inside functions and for the type checker's eyes too."""
    return {name for node in ast.walk(_tree(module)) for name in _imported(module, node)}


def _imports_at_start(module: str) -> set[str]:
    """The imports that run when the module is imported."""
    found: set[str] = set()
    waiting: list[ast.AST] = [_tree(module)]
    while waiting:
        node = waiting.pop()
        found.update(_imported(module, node))
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            waiting.extend(node.orelse)
        elif not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
            waiting.extend(ast.iter_child_nodes(node))
    return found - {module}


def _ring(module: str) -> int:
    name = module.partition(".")[2].partition(".")[0]
    return next((i for i, names in enumerate(RINGS.values()) if name in names), len(RINGS))


# ---- the code


def test_the_version_is_that_of_the_installed_package() -> None:
    assert importlib.metadata.version("kendon") == _version.__version__


def test_the_package_offers_its_version() -> None:
    assert kendon.__version__ == _version.__version__


def test_importing_kendon_is_light() -> None:
    # These take seconds to import, and two are optional: whoever needs one imports it then.
    heavy = {"matplotlib", "cv2", "mediapipe", "mujoco"}
    code = "import kendon, sys; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert heavy.isdisjoint(run.stdout.split())


@pytest.mark.parametrize("module", MODULES)
def test_a_module_says_what_it_is_for_and_stays_short(module: str) -> None:
    assert ast.get_docstring(_tree(module)), f"{module} has no docstring"
    lines = len(MODULES[module].read_text(encoding="utf-8").splitlines())
    assert lines < 600, f"{module} has {lines} lines: split it"


def test_no_modules_import_each_other_in_a_circle() -> None:
    try:
        TopologicalSorter({module: _imports_at_start(module) for module in MODULES}).prepare()
    except CycleError as error:
        pytest.fail("import circle: " + " → ".join(error.args[1]))


@pytest.mark.parametrize("module", MODULES)
def test_a_module_imports_nothing_that_lies_further_out(module: str) -> None:
    outward = {name for name in _all_imports(module) if _ring(name) > _ring(module)}
    assert not outward, f"{module} lies further in than {sorted(outward)} (see RINGS)"


def test_every_ring_holds_what_exists() -> None:
    # A misspelt or removed name would silently guard nothing.
    existing = {name.split(".")[1] for name in MODULES if "." in name}
    assert set().union(*RINGS.values()) <= existing


# ---- what is installed


def _locked() -> set[str]:
    names = re.findall(r"^([A-Za-z0-9._-]+)==", LOCK.read_text(encoding="utf-8"), re.MULTILINE)
    return {canonicalize_name(name) for name in names}


def _requirements() -> list[str]:
    with (ROOT / "pyproject.toml").open("rb") as file:
        project = tomllib.load(file)["project"]
    extras = project["optional-dependencies"].values()
    return [text for group in (project["dependencies"], *extras) for text in group]


@pytest.mark.parametrize("requirement", _requirements())
def test_the_lock_pins_what_the_project_requires(requirement: str) -> None:
    name = canonicalize_name(Requirement(requirement).name)
    assert name in _locked(), f"{name} has no pin: make lock"


def test_the_lock_holds_pins_and_no_addresses() -> None:
    pin = re.compile(r"[a-z0-9.-]+==[a-z0-9.]+( ; [^/@]+)?")
    lines = LOCK.read_text(encoding="utf-8").splitlines()
    assert [x for x in lines if not x.lstrip().startswith("#") and not pin.fullmatch(x)] == []
    assert not re.search(r"https?:|file:|--|/", "\n".join(lines))


def test_the_doctor_looks_for_every_extra() -> None:
    with (ROOT / "pyproject.toml").open("rb") as file:
        extras = tomllib.load(file)["project"]["optional-dependencies"]
    del extras["dev"]

    def names(requirements: Iterable[str]) -> set[str]:
        return {canonicalize_name(Requirement(text).name) for text in requirements}

    looked_for = {extra: names(packages.values()) for extra, packages in EXTRAS.items()}
    assert looked_for == {extra: names(group) for extra, group in extras.items()}


# ---- what the tests themselves rely on


@pytest.mark.parametrize("host", ["192.0.2.1", "2001:db8::1", "kendon.invalid"])
def test_no_test_reaches_another_machine(host: str) -> None:
    with pytest.raises(RuntimeError, match=re.escape(host)):
        socket.create_connection((host, 80), timeout=1)


def test_this_machine_can_be_reached() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        socket.create_connection(server.getsockname(), timeout=5).close()


def test_lent_files_are_found_in_the_named_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("b.csv", "a.csv"):
        (tmp_path / name).touch()
    monkeypatch.setenv("KENDON_SHARED", str(tmp_path))
    assert shared_data.shared_file("a.csv") == tmp_path / "a.csv"
    assert shared_data.shared_files("*.csv") == [tmp_path / "a.csv", tmp_path / "b.csv"]


def test_a_test_whose_files_are_not_lent_is_skipped_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KENDON_SHARED", str(tmp_path))
    with pytest.raises(pytest.skip.Exception, match=r"a\.csv is not lent here"):
        shared_data.shared_file("a.csv")
    with pytest.raises(pytest.skip.Exception, match="KENDON_SHARED names another folder"):
        shared_data.shared_files("*.csv")
