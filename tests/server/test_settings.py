"""Settings: where they come from, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from snapfit.server.errors import SettingsError
from snapfit.server.settings import Settings, StationSettings, load_settings, with_station


def written(folder: Path, text: str) -> Path:
    path = folder / "snapfit.toml"
    path.write_text(text)
    return path


def test_a_file_over_the_defaults(tmp_path: Path) -> None:
    (tmp_path / "recording").mkdir()
    path = written(
        tmp_path, 'port = 9000\n[station]\nname = "b.2"\nsource = "recording"\nasset = "clamp"\n'
    )
    settings = load_settings(path)
    assert (settings.host, settings.port) == ("127.0.0.1", 9000)
    assert settings.station.name == "b.2"
    assert settings.station.source == str(tmp_path / "recording")
    assert settings.station.asset == "clamp"
    assert settings.station.method == "auto"
    assert settings.station.detector == "auto"
    assert settings.station.providers == ("cpu",)


def test_the_environment_over_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = written(tmp_path, 'port = 9000\n[station]\nname = "one"\nmethod = "icg"\n')
    monkeypatch.setenv("SNAPFIT_PORT", "9001")
    monkeypatch.setenv("SNAPFIT_STATION__NAME", "two")
    settings = load_settings(path)
    assert (settings.port, settings.station.name, settings.station.method) == (9001, "two", "icg")


def test_providers_are_a_list_in_the_file_and_a_line_in_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path, '[station]\ndetector = "network"\nproviders = ["tensorrt", "cuda"]\n')
    assert load_settings(path).station.providers == ("tensorrt", "cuda")
    monkeypatch.setenv("SNAPFIT_STATION__PROVIDERS", "coreml, cpu")
    monkeypatch.setenv("SNAPFIT_STATION__DETECTOR", "geometric")
    station = load_settings(path).station
    assert (station.detector, station.providers) == ("geometric", ("coreml", "cpu"))


def test_the_command_line_over_all(tmp_path: Path) -> None:
    settings = load_settings(written(tmp_path, '[station]\nname = "one"\ndetector = "network"\n'))
    settings = with_station(settings, {"detector": "none", "providers": ["cuda"]})
    station = settings.station
    assert (station.name, station.detector, station.providers) == ("one", "none", ("cuda",))
    with pytest.raises(SettingsError, match="the command line: detector: Input should be 'auto'"):
        with_station(settings, {"detector": "magic"})


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("prot = 1", "prot: unknown key; there are host, port, gbot_port, "),
        ("[station]\nsorce = 'x'", "station.sorce: unknown key; there are name, source, asset"),
        ("port = 0", "port: Input should be greater than or equal to 1, this is 0"),
        ("port = 'x'", "port: Input should be a valid integer"),
        ("[station]\nname = 'a/b'", "station.name: String should match pattern"),
        ("[station]\nstale_after_s = 0", "station.stale_after_s: Input should be greater than 0"),
        ("station = 3", "station: "),
        ("[station]\ndetector = 'magic'", "station.detector: Input should be 'auto', 'none'"),
        ("[station]\nproviders = ['abacus']", "station.providers.0: Input should be 'cpu', 'cuda'"),
        ("port = ", "is no TOML"),
        ("[[stations]]\nsorce = 'x'", "stations.0.sorce: unknown key; there are name, source"),
        ("[[stations]]\n[[stations]]\nname = ''", "stations.1.name: String should match"),
        ("[[stations]]\n[[stations]]", "settings: stations have to differ in name: bench-1 is"),
        ("[station]\n[[stations]]", "settings: station and stations are both set"),
        ("stations = 3", "stations: Input should be a valid tuple"),
    ],
)
def test_what_is_refused_names_file_and_key(tmp_path: Path, text: str, problem: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(SettingsError) as caught:
        load_settings(path)
    assert f"{path}: {problem}" in str(caught.value)


def test_all_problems_are_told_at_once(tmp_path: Path) -> None:
    with pytest.raises(SettingsError) as caught:
        load_settings(written(tmp_path, "prot = 1\nport = 0\n"))
    assert len(caught.value.problems) == 2


def test_a_missing_or_unreadable_file_is_a_clear_error(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="no such file"):
        load_settings(tmp_path / "snapfit.toml")
    with pytest.raises(SettingsError, match="cannot be read"):
        load_settings(tmp_path)
    path = tmp_path / "latin.toml"
    path.write_bytes(b'host = "\xff"')
    with pytest.raises(SettingsError, match="cannot be read"):
        load_settings(path)


def test_several_stations_stand_in_a_list(tmp_path: Path) -> None:
    (tmp_path / "left").mkdir()
    text = '[[stations]]\nname = "a"\nsource = "left"\n[[stations]]\nname = "b"\n'
    settings = load_settings(written(tmp_path, text))
    assert [station.name for station in settings.all_stations] == ["a", "b"]
    assert settings.stations[0].source == str(tmp_path / "left")
    told = with_station(settings, {"detector": "none"}).all_stations
    assert [station.detector for station in told] == ["none", "none"]
    (only,) = load_settings(written(tmp_path, '[station]\nname = "c"\n')).all_stations
    assert only.name == "c"


@pytest.mark.parametrize("model", [Settings, StationSettings])
def test_every_setting_is_described(model: type[Settings] | type[StationSettings]) -> None:
    for name, field in model.model_fields.items():
        assert field.description, name
        assert field.description.endswith("."), name
