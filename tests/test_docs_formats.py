"""The examples of docs/ load: a page that shows a format cannot go stale."""

import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh

from snapfit.models.asset import load_asset
from snapfit.models.detector.card import DetectorCard
from snapfit.models.manifest import Table, tables
from snapfit.models.sequence import BodyRecord, DepthRecord, SequenceRecord
from snapfit.tracking.sources import open_source

DOCS = Path(__file__).parents[1] / "docs"


def examples(page: str, language: str) -> list[str]:
    text = (DOCS / page).read_text()
    return re.findall(rf"```{language}\n(.*?)```", text, flags=re.DOTALL)


def test_the_asset_in_the_docs_loads(tmp_path: Path) -> None:
    (example,) = examples("asset-format.md", "toml")
    (tmp_path / "asset.toml").write_text(example)
    for name in ("base", "bolt"):
        trimesh.creation.box((40, 50, 60)).export(tmp_path / f"{name}.ply")
    asset = load_asset(tmp_path)
    assert [part.name for part in asset.parts] == ["base", "bolt"]
    assert asset.parts[1].symmetry.kind == "axis"
    assert asset.states[1].links[0].joint.pitch_m == 0.0015


def test_the_detector_in_the_docs_is_one() -> None:
    (example,) = examples("detector.md", "json")
    card = DetectorCard.model_validate_json(example)
    assert card.n_rows == 4 + 1 + 3 * 4


@pytest.mark.parametrize("table", tables())
def test_every_key_of_a_manifest_is_in_the_docs(table: type[Table]) -> None:
    page = (DOCS / "asset-format.md").read_text()
    for name in table.model_fields:
        assert re.search(rf"\b{name}\b", page), f"{table.__name__}.{name}"


def test_the_sequence_in_the_docs_plays(tmp_path: Path) -> None:
    sequence, truth = examples("sequence-format.md", "json")
    (tmp_path / "sequence.json").write_text(sequence)
    (tmp_path / "gt.jsonl").write_text(truth)
    for folder in ("color", "depth", "meshes"):
        (tmp_path / folder).mkdir()
    trimesh.creation.box((40, 50, 60)).export(tmp_path / "meshes" / "box.ply")
    for name in json.loads(sequence)["frames"]:
        cv2.imwrite(str(tmp_path / "color" / f"{name}.png"), np.zeros((48, 64, 3), np.uint8))
        cv2.imwrite(str(tmp_path / "depth" / f"{name}.png"), np.ones((48, 64), np.uint16))
    source = open_source(tmp_path)
    frames = [source.read(), source.read()]
    assert source.read() is None
    source.close()
    assert [frame.name for frame in frames if frame] == ["000000", "000001"]
    assert source.parts[0].mesh.vertices[:, 2].max() == pytest.approx(0.0)
    assert source.truth["000000"].state == "apart"


@pytest.mark.parametrize("record", [SequenceRecord, DepthRecord, BodyRecord])
def test_every_key_of_a_sequence_is_in_the_docs(record: type[SequenceRecord]) -> None:
    page = (DOCS / "sequence-format.md").read_text()
    for name, field in record.model_fields.items():
        assert name in page
        assert field.description
