"""`snapfit benchmark`: methods over a dataset with ground truth, as tables, plots and films."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from snapfit.server.cli.errors import clear_errors


def benchmark(
    out: Annotated[Path, typer.Option(help="Folder for results; finished runs are kept in it.")],
    data: Annotated[
        Path | None,
        typer.Option(
            help="Dataset (ASSET/test/CONDITION), or one recorded sequence. --quick has its own.",
            show_default=False,
        ),
    ] = None,
    mistakes: Annotated[
        Path | None,
        typer.Option(
            help="Instead of --data: a dataset with the split `mistakes`; are they noticed?",
            show_default=False,
        ),
    ] = None,
    recovery: Annotated[
        bool,
        typer.Option(
            "--recovery", help="How soon are all parts tracked from a cold start, or uncovered?"
        ),
    ] = False,
    clutter: Annotated[
        Path | None,
        typer.Option(
            help="Instead of --data: a dataset with the split `train`; what do detectors find?",
            show_default=False,
        ),
    ] = None,
    methods: Annotated[str, typer.Option(help="Tracking methods, with commas between.")] = "icg",
    asset: Annotated[
        list[str] | None, typer.Option(help="Only this asset; may be given again.")
    ] = None,
    condition: Annotated[
        list[str] | None, typer.Option(help="Only this condition; may be given again.")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="The first 100 frames of each sequence, no films.")
    ] = False,
    jobs: Annotated[
        int, typer.Option(min=1, help="Sequences side by side; times need 1 to be trusted.")
    ] = 1,
    films: Annotated[
        bool | None, typer.Option(help="Films of all methods side by side; not with --quick.")
    ] = None,
    any_commit: Annotated[
        bool, typer.Option("--any-commit", help="Keep finished runs of other versions of the code.")
    ] = False,
    report: Annotated[
        Path | None, typer.Option(help="Write the Markdown into this page, too.")
    ] = None,
) -> None:
    """Benchmark tracking methods: the paper's table, strict figures, plots and films."""
    with clear_errors():
        names = tuple(name.strip() for name in methods.split(",") if name.strip())
        # The tracker's libraries take seconds to load, and --help needs none of them.
        if mistakes is not None:
            given = {"data": data, "condition": condition, "quick": quick, "films": bool(films)}
            _refuse(
                {**given, "jobs": jobs > 1, "recovery": recovery, "clutter": clutter}, "--mistakes"
            )
            from snapfit.server.cli.benchmark_mistakes import run_mistakes

            run_mistakes(mistakes, out, tuple(dict.fromkeys(names)), tuple(asset or ()))
            return
        if clutter is not None:
            given = {"data": data, "condition": condition, "quick": quick, "films": bool(films)}
            _refuse({**given, "jobs": jobs > 1, "recovery": recovery}, "--clutter")
            from snapfit.server.cli.benchmark_clutter import run_clutter

            run_clutter(clutter, out, tuple(dict.fromkeys(names)), tuple(asset or ()), report)
            return
        if recovery:
            _refuse({"quick": quick, "films": bool(films), "any-commit": any_commit}, "--recovery")
            if data is None:
                raise typer.BadParameter("--recovery needs --data: a dataset or a sequence")
            from snapfit.server.cli.benchmark_recovery import RecoveryWishes, run_recovery

            run_recovery(
                RecoveryWishes(
                    data=data,
                    out=out,
                    methods=tuple(dict.fromkeys(names)),
                    assets=tuple(asset or ()),
                    conditions=tuple(condition or ()),
                    n_jobs=jobs,
                    page=report,
                )
            )
            return
        from snapfit.server.cli.benchmark_run import Wishes, run

        run(
            Wishes(
                data=data,
                out=out,
                methods=tuple(dict.fromkeys(names)),
                assets=tuple(asset or ()),
                conditions=tuple(condition or ()),
                quick=quick,
                n_jobs=jobs,
                films=not quick if films is None else films,
                any_commit=any_commit,
                page=report,
            )
        )


def _refuse(given: Mapping[str, object], other: str) -> None:
    """Options that do not go with another one are an error, not ignored."""
    for name, value in given.items():
        if value:
            raise typer.BadParameter(f"--{name} does not go with {other}")
