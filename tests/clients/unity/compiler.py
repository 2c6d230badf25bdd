"""Compiles the Unity package, its tests and the stand-ins for Unity with Debian's Mono."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
PACKAGE = HERE.parents[2] / "clients" / "unity" / "com.snapfit.client"
CORE_TESTS = PACKAGE / "Tests" / "Core"

HTTP = "System.Net.Http"
_LIMIT_S = 400
# The package promises C# 7.3, of which this compiler knows all but the smallest part.
_OPTIONS = ("-langversion:7.2", "-warnaserror", "-warn:4", f"-r:{HTTP}.dll")


def why_not() -> str | None:
    """What is missing to compile and run C#; None where nothing is."""
    missing = [program for program in ("mcs", "mono") if shutil.which(program) is None]
    if missing:
        return f"there is no {' and no '.join(missing)}: apt-get install mono-mcs mono-runtime"
    folders = (Path("/usr/lib/mono/4.5"), Path("/usr/local/lib/mono/4.5"))
    if not any((folder / f"{HTTP}.dll").exists() for folder in folders):
        return "there is no System.Net.Http: apt-get install libmono-system-net-http4.0-cil"
    return None


@dataclass(frozen=True)
class Assembly:
    """What is compiled into one file.

    Attributes:
        name: of the file.
        sources: folders, searched for C# at every depth.
        references: names of assemblies that it uses.
        is_documented: whether every public member must have a comment.
        more: further options.
    """

    name: str
    sources: tuple[Path, ...]
    references: tuple[str, ...] = ()
    is_documented: bool = False
    more: tuple[str, ...] = ()


CORE = "Snapfit.Core.dll"
UNITY = "UnityEngine.dll"
LAYER = "Snapfit.Unity.dll"
TESTS = "Snapfit.Tests.dll"
LAYER_TESTS = "Snapfit.LayerTests.dll"
RUNNER = "runner.exe"
LIVE = "live.exe"
ALL_OF_OURS = (CORE, LAYER, TESTS, UNITY)
# Fields that only Unity's inspector sets look as if nobody did.
_INSPECTOR = ("-nowarn:649",)

ASSEMBLIES = (
    Assembly(CORE, (PACKAGE / "Runtime" / "Core",), is_documented=True),
    Assembly(UNITY, (HERE / "stand_ins",), is_documented=True),
    Assembly(LAYER, (PACKAGE / "Runtime" / "Unity",), (CORE, UNITY), True, _INSPECTOR),
    Assembly(TESTS, (CORE_TESTS,), (CORE, UNITY), True),
    Assembly(
        "Snapfit.Samples.dll", (PACKAGE / "Samples~",), (CORE, LAYER, UNITY), True, _INSPECTOR
    ),
    Assembly(LAYER_TESTS, (HERE / "layer",), ALL_OF_OURS),
    Assembly(RUNNER, (HERE / "runner",), (TESTS,)),
    Assembly(LIVE, (HERE / "live",), ALL_OF_OURS),
)


def compile_all(folder: Path) -> None:
    """Compile everything into a folder, warnings as errors.

    Raises:
        AssertionError: with what the compiler says.
    """
    for assembly in ASSEMBLIES:
        done = compile_one(assembly, folder)
        assert done.returncode == 0, f"{assembly.name}\n{done.stdout}{done.stderr}"


def compile_one(assembly: Assembly, folder: Path) -> subprocess.CompletedProcess[str]:
    """Compile one of them; those that it uses lie in the folder already."""
    sources = [str(path) for root in assembly.sources for path in sorted(root.rglob("*.cs"))]
    assert sources, f"{assembly.name} has no sources"
    output = folder / assembly.name
    command = ["mcs", *_OPTIONS, *assembly.more, f"-out:{output}"]
    command += [f"-r:{folder / name}" for name in assembly.references]
    if assembly.name.endswith(".dll"):
        command.append("-target:library")
    if assembly.is_documented:
        command.append(f"-doc:{output.with_suffix('.xml')}")
    return subprocess.run(
        [*command, *sources], capture_output=True, text=True, timeout=_LIMIT_S, check=False
    )
