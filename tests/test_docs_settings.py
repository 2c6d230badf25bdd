"""docs/settings.md tells every setting as it really is, and none that does not exist."""

from __future__ import annotations

import json
import os
import re
import tomllib
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import pytest
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from snapfit.models.cache import CACHE_VARIABLE
from snapfit.server.settings import Settings, load_settings

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "settings.md").read_text(encoding="utf-8")
UNITS = {
    "_per_s": "1/s",
    "_bytes": "bytes",
    "_s": "s",
    "_ms": "ms",
    "_m": "m",
    "_deg": "deg",
    "_hz": "Hz",
    "_px": "px",
}


def fields(model: type[BaseModel], prefix: str = "") -> dict[str, FieldInfo]:
    """Every setting by its key; a table of settings is told by its own keys."""
    found = {}
    for name, field in model.model_fields.items():
        kind = field.annotation
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            found.update(fields(kind, f"{prefix}{name}."))
        else:
            found[prefix + name] = field
    return found


def bounds(field: FieldInfo) -> str:
    """What may be set, from the same metadata that pydantic checks."""
    limits: dict[str, Any] = {}
    for entry in field.metadata:
        for name in ("gt", "ge", "lt", "le", "min_length", "max_length", "pattern"):
            if (value := getattr(entry, name, None)) is not None:
                limits[name] = value
    signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    told = [f"{signs[name]} {limits[name]}" for name in signs if name in limits]
    if choices := choices_of(field.annotation):
        return ", ".join(f"`{choice}`" for choice in choices)
    if "pattern" in limits:
        told.append(f"`{limits['pattern']}`")
    if "max_length" in limits:
        what = "tables" if get_origin(field.annotation) is tuple else "characters"
        told.append(f"at most {limits['max_length']} {what}")
    elif "min_length" in limits:
        told.append("not empty")
    return ", ".join(told) or "-"


def choices_of(kind: Any) -> tuple[str, ...]:
    """What a setting is chosen from, or each of its entries."""
    if get_origin(kind) is Literal:
        return get_args(kind)
    return choices_of(get_args(kind)[0]) if get_origin(kind) is tuple else ()


def row(key: str, field: FieldInfo) -> str:
    """The line of the table that a setting has to have."""
    unit = next((unit for suffix, unit in UNITS.items() if key.endswith(suffix)), "-")
    default = "none" if field.default is None else f"`{json.dumps(field.default)}`"
    variable = "SNAPFIT_" + key.upper().replace(".", "__")
    cells = (f"`{key}`", field.description, unit, bounds(field), default, f"`{variable}`")
    return f"| {' | '.join(str(cell) for cell in cells)} |"


SETTINGS = fields(Settings)


def documented_keys() -> list[str]:
    table = PAGE.partition("| key |")[2].partition("\n\n")[0]
    return re.findall(r"^\| `([\w.]+)` \|", table, flags=re.MULTILINE)


@pytest.mark.parametrize("key", SETTINGS)
def test_a_setting_is_documented_as_it_is(key: str) -> None:
    assert row(key, SETTINGS[key]) in PAGE.splitlines()


def test_no_documented_setting_is_missing() -> None:
    assert documented_keys() == list(SETTINGS)


@pytest.mark.parametrize("page", ["docs/settings.md", "README.md"])
def test_the_example_loads(page: str, tmp_path: Path) -> None:
    examples = re.findall(r"```toml\n(.*?)```", (ROOT / page).read_text("utf-8"), flags=re.DOTALL)
    assert len(examples) == 1
    (tmp_path / "snapfit.toml").write_text(examples[0])
    source = tomllib.loads(examples[0])["station"]["source"]
    (tmp_path / source).mkdir(parents=True)
    settings = load_settings(tmp_path / "snapfit.toml")
    assert settings.station.source == str(tmp_path / source)


def test_the_environment_variables_of_the_page_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in os.environ:
        if name.startswith("SNAPFIT_"):
            monkeypatch.delenv(name)
    values = {"host": "::1", "port": 9, "station.asset": "x", "station.stale_after_s": 2.5}
    for key, value in values.items():
        variable = "SNAPFIT_" + key.upper().replace(".", "__")
        assert f"`{variable}`" in PAGE
        monkeypatch.setenv(variable, str(value))
    settings = Settings()
    assert (settings.host, settings.port) == ("::1", 9)
    assert (settings.station.asset, settings.station.stale_after_s) == ("x", 2.5)


def test_variables_that_are_no_settings_are_named_too() -> None:
    assert f"`{CACHE_VARIABLE}`" in PAGE
    assert "`NUMBA_NUM_THREADS`" in PAGE
