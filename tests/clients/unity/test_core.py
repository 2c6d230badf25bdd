"""The package compiles without a warning, and its tests in C# pass under Mono."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from compiler import CORE, CORE_TESTS, LAYER_TESTS, RUNNER, TESTS, Assembly, compile_one

LEAST_TESTS = 70
UNDOCUMENTED = "namespace Snapfit { public class A { } }"


def run_tests(
    folder: Path, golden: Path = CORE_TESTS, only: str = "."
) -> subprocess.CompletedProcess[str]:
    assemblies = [str(folder / name) for name in (TESTS, LAYER_TESTS)]
    return subprocess.run(
        ["mono", str(folder / RUNNER), str(golden), only, *assemblies],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def test_all_tests_in_c_sharp_pass(compiled: Path) -> None:
    done = run_tests(compiled)
    failed = re.findall(r"^FAIL .*", done.stdout, re.MULTILINE)
    assert (failed, done.stderr) == ([], "")
    assert done.returncode == 0
    passed = re.findall(r"^ok (\S+)", done.stdout, re.MULTILINE)
    assert len(set(passed)) >= LEAST_TESTS
    assert {name.partition(".")[0] for name in passed} >= {
        "ClockTests",
        "ConventionTests",
        "HandOverTests",
        "JsonTests",
        "MarkerAlignmentTests",
        "PlaybackTests",
        "PoseDriverTests",
        "SnapshotTests",
        "SpatialTests",
        "WireTests",
    }


def test_wrong_golden_vectors_are_noticed(compiled: Path, tmp_path: Path) -> None:
    """Of the tests that fail then, each compares with the file."""
    text = (CORE_TESTS / "conventions.json").read_text(encoding="utf-8")
    wrong = text.replace('"vertex_in_frame": [ 0.03, 0.02, 1.05 ]', '"vertex_in_frame": [0, 0, 1]')
    assert wrong != text
    (tmp_path / "conventions.json").write_text(wrong, encoding="utf-8")
    done = run_tests(compiled, tmp_path, "Convention|PoseDriver")
    assert done.returncode == 1
    failed = set(re.findall(r"^FAIL (\S+):", done.stdout, re.MULTILINE))
    assert failed == {
        "ConventionTests.APoseBringsTheVertexThere",
        "ConventionTests.MapsEveryGoldenVector",
        "PoseDriverTests.AnImportedGltfMeshFits",
        "PoseDriverTests.PutsTheObjectWhereTheGoldenPoseIs",
    }


def test_an_undocumented_member_is_an_error(compiled: Path, tmp_path: Path) -> None:
    (tmp_path / "A.cs").write_text(UNDOCUMENTED)
    done = compile_one(Assembly("A.dll", (tmp_path,), (), True), compiled)
    assert done.returncode != 0
    assert "CS1591" in done.stderr


def test_the_core_uses_neither_the_engine_nor_reflection(compiled: Path) -> None:
    """What IL2CPP cannot do ahead of time, and what an engine-free assembly cannot name."""
    content = (compiled / CORE).read_bytes()
    for name in (b"UnityEngine", b"System.Reflection.Emit", b"System.Linq.Expressions"):
        assert name not in content
    for path in sorted((CORE_TESTS.parents[1] / "Runtime" / "Core").rglob("*.cs")):
        text = path.read_text(encoding="utf-8")
        for word in ("UnityEngine", "System.Reflection", "dynamic ", "DllImport", "unsafe"):
            assert word not in text, f"{path.name} uses {word}"
