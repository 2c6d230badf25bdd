"""Assets on their way from one machine's cache to another's."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import redis
from fleet import needs_redis, redis_server
from harness import wait_for
from pydantic import ValidationError

from snapfit.models.cache import CACHE_VARIABLE
from snapfit.server.fleet.asset_download import AssetDownload
from snapfit.server.fleet.asset_files import (
    LARGEST_FILE_BYTES,
    PIECE_BYTES,
    StoredFile,
    asset_key,
    asset_name,
)
from snapfit.server.fleet.asset_upload import AssetUpload
from snapfit.server.fleet.link import connect


def answers(client: redis.Redis) -> bool:
    try:
        return bool(client.ping())
    except redis.ConnectionError:
        return False


@needs_redis
def test_films_travel_in_pieces_and_what_is_too_large_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "there"))
    exported = tmp_path / "here" / "clamp-0123456789abcdef"
    film = bytes(range(256)) * 4000
    for name, content in (
        ("asset.json", b"{}"),
        ("media/film%20.mp4", film),
        ("media/empty.txt", b""),
        ("media/large.mp4", bytes(LARGEST_FILE_BYTES + 1)),
    ):
        (exported / name).parent.mkdir(parents=True, exist_ok=True)
        (exported / name).write_bytes(content)
    upload, download = AssetUpload(), AssetDownload()
    upload.serve(str(exported))
    download.serve(str(exported))
    with redis_server() as server, connect(server.url) as client:
        wait_for(lambda: answers(client))
        assert not download.step(client)  # not handed over yet
        for _ in range(len(film) // PIECE_BYTES + 4):
            upload.step(client)
        assert "large.mp4: is larger than 32 MiB" in caplog.text
        wait_for(lambda: download.step(client))
        there = download.folder
        assert there == tmp_path / "there" / "assets" / exported.name
        assert (there / "media" / "film%20.mp4").read_bytes() == film
        assert (there / "media" / "empty.txt").read_bytes() == b""
        assert not (there / "media" / "large.mp4").exists()
        again = AssetDownload()
        again.serve(str(exported))
        assert again.step(client)  # it is in the cache
        shutil.rmtree(there)
        client.hset(asset_key(exported.name), "media/film%20.mp4\n1", b"another")
        damaged = AssetDownload()
        damaged.serve(str(exported))
        while "is not the file that was handed over" not in caplog.text:
            assert not damaged.step(client)
        assert list((tmp_path / "there" / "assets").iterdir()) == []


@pytest.mark.parametrize(
    "path", ["../x", "/x", "a/../x", "a/b/c", "..", "a/..", "a\\x", "a\nx", "", "parts/"]
)
def test_no_file_of_an_asset_leaves_its_folder(path: str) -> None:
    with pytest.raises(ValidationError, match="no file of an exported asset"):
        StoredFile(path=path, size_bytes=1, sha256="")
    assert StoredFile(path="media/..%2Fx", size_bytes=1, sha256="").path == "media/..%2Fx"


@pytest.mark.parametrize(
    ("folder", "name"),
    [
        ("/cache/assets/clamp-0123456789abcdef", "clamp-0123456789abcdef"),
        ("C:\\cache\\clamp-0123456789abcdef", "clamp-0123456789abcdef"),
        ("/cache/assets/..", None),
        ("/cache/assets/clamp", None),
        ("", None),
    ],
)
def test_an_asset_has_its_folders_name(folder: str, name: str | None) -> None:
    assert asset_name(folder) == name
