"""Where model files are looked for, and what is said when they are not there."""

from __future__ import annotations

import hashlib
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from shared_data import shared_file

from kendon.errors import MissingExtraError, ModelFileError, UnknownNameError
from kendon.sources import model_files
from kendon.sources.model_files import (
    ENVIRONMENT_VARIABLE,
    FACE_LANDMARKER,
    ModelFile,
    ModelFileState,
    find_model_file,
    model_file_reports,
)

CONTENT = b"a small network"


@pytest.fixture
def network(monkeypatch: pytest.MonkeyPatch) -> ModelFile:
    """A model file of known content, the only one there is; no folder is named."""
    file = ModelFile(
        name="net.task",
        purpose="tests",
        sha256=hashlib.sha256(CONTENT).hexdigest(),
        licence="Apache-2.0",
        origin="https://example.invalid/net.task",
    )
    monkeypatch.setattr(model_files, "MODEL_FILES", {file.name: file})
    monkeypatch.delenv(ENVIRONMENT_VARIABLE, raising=False)
    return file


def fake_pooch(monkeypatch: pytest.MonkeyPatch, cache: Path, retrieve: Any) -> None:
    pooch = SimpleNamespace(os_cache=lambda project: cache / project, retrieve=retrieve)
    monkeypatch.setitem(sys.modules, "pooch", pooch)


def no_download(**_: Any) -> str:
    raise AssertionError("nothing may be downloaded here")


def test_a_whole_file_in_the_named_folder_is_found(network: ModelFile, tmp_path: Path) -> None:
    (tmp_path / network.name).write_bytes(CONTENT)
    assert find_model_file(network.name, tmp_path) == tmp_path / network.name
    assert find_model_file(network.name, str(tmp_path)) == tmp_path / network.name


def test_the_environment_names_the_folder(
    network: ModelFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path))
    with pytest.raises(ModelFileError, match=f"{ENVIRONMENT_VARIABLE} names, .*it is empty"):
        find_model_file(network.name)
    (tmp_path / network.name).write_bytes(CONTENT)
    assert find_model_file(network.name) == tmp_path / network.name


def test_the_users_folder_comes_before_the_environments(
    network: ModelFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / network.name).write_bytes(CONTENT)
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path / "elsewhere"))
    assert find_model_file(network.name, tmp_path) == tmp_path / network.name


def test_a_missing_file_lists_what_is_there_and_where_to_get_it(
    network: ModelFile, tmp_path: Path
) -> None:
    (tmp_path / "other.onnx").write_bytes(b"")
    with pytest.raises(ModelFileError) as caught:
        find_model_file(network.name, tmp_path)
    message = str(caught.value)
    assert f"{tmp_path} holds no net.task; it holds other.onnx" in message
    assert network.origin in message
    assert "--model-files" in message


def test_a_full_folder_is_not_listed_to_its_end(network: ModelFile, tmp_path: Path) -> None:
    for i in range(14):
        (tmp_path / f"{i:02}.csv").touch()
    with pytest.raises(ModelFileError, match=r"09\.csv and 4 more"):
        find_model_file(network.name, tmp_path)


def test_a_folder_that_is_none_says_so(network: ModelFile, tmp_path: Path) -> None:
    with pytest.raises(ModelFileError, match="there is no such folder"):
        find_model_file(network.name, tmp_path / "nowhere")
    (tmp_path / "file").touch()
    with pytest.raises(ModelFileError, match="it is a file, not a folder"):
        find_model_file(network.name, tmp_path / "file")


def test_a_torn_file_names_both_checksums(network: ModelFile, tmp_path: Path) -> None:
    (tmp_path / network.name).write_bytes(CONTENT[:-1])
    with pytest.raises(ModelFileError, match=rf"14 bytes.*expected is {network.sha256}"):
        find_model_file(network.name, tmp_path)


def test_an_unknown_file_lists_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=FACE_LANDMARKER.name):
        find_model_file("face_landmarks.task", tmp_path)


def test_a_cached_file_is_used_without_a_download(
    network: ModelFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake_pooch(monkeypatch, tmp_path, no_download)
    (tmp_path / "kendon").mkdir()
    (tmp_path / "kendon" / network.name).write_bytes(CONTENT)
    assert find_model_file(network.name) == tmp_path / "kendon" / network.name


def test_a_download_is_checked_and_goes_to_the_cache(
    network: ModelFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: dict[str, Any] = {}

    def retrieve(**options: Any) -> str:
        asked.update(options)
        return str(options["path"] / options["fname"])

    fake_pooch(monkeypatch, tmp_path, retrieve)
    assert find_model_file(network.name) == tmp_path / "kendon" / network.name
    assert asked["url"] == network.origin
    assert asked["known_hash"] == f"sha256:{network.sha256}"


def test_without_network_the_message_says_how_to_do_without(
    network: ModelFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def retrieve(**_: Any) -> str:
        raise ConnectionError("Name or service not known")

    fake_pooch(monkeypatch, tmp_path, retrieve)
    with pytest.raises(ModelFileError) as caught:
        find_model_file(network.name)
    message = str(caught.value)
    assert "could not be downloaded" in message
    assert "Name or service not known" in message
    assert network.origin in message
    assert ENVIRONMENT_VARIABLE in message


def test_a_download_of_something_else_is_refused(
    network: ModelFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def retrieve(**_: Any) -> str:
        raise ValueError("SHA256 hash of downloaded file does not match")

    fake_pooch(monkeypatch, tmp_path, retrieve)
    with pytest.raises(ModelFileError, match=r"sent something else than net\.task"):
        find_model_file(network.name)


def test_without_pooch_the_extra_is_named(
    network: ModelFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pooch", None)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with pytest.raises(MissingExtraError, match=r"'pooch'.*kendon\[camera\]"):
        find_model_file(network.name)


def test_reports_tell_each_state_without_a_download(
    network: ModelFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake_pooch(monkeypatch, tmp_path, no_download)
    (report,) = model_file_reports()
    assert report.state is ModelFileState.MISSING
    assert "downloaded at the first use" in report.advice
    (report,) = model_file_reports(tmp_path)
    assert report.state is ModelFileState.MISSING
    assert "first use" not in report.advice
    path = tmp_path / network.name
    path.write_bytes(b"torn")
    (report,) = model_file_reports(tmp_path)
    assert (report.state, report.path) == (ModelFileState.DAMAGED, path)
    path.write_bytes(CONTENT)
    (report,) = model_file_reports(tmp_path)
    assert (report.state, report.advice) == (ModelFileState.READY, "")


def test_the_listed_checksum_is_that_of_the_makers_file() -> None:
    path = shared_file(f"models/{FACE_LANDMARKER.name}")
    assert find_model_file(FACE_LANDMARKER.name, path.parent) == path
