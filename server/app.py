"""The API: a FastAPI app that owns its stations while it runs.

This process never imports Numba, OpenCV, Open3D or ONNX Runtime: it starts in about a second,
stays small, and keeps answering when a worker dies.
"""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib.metadata import version

from fastapi import Depends, FastAPI

from snapfit.server.clock import Clock
from snapfit.server.fleet.keepers import backing_for
from snapfit.server.metrics import Metrics
from snapfit.server.openapi import install_openapi
from snapfit.server.problems import install_problem_handlers
from snapfit.server.routes import (
    anchors,
    arlem,
    assembly,
    assets,
    commands,
    events,
    pictures,
    poses,
    session,
    stations,
    stream,
    system,
)
from snapfit.server.routes.dependencies import named_station
from snapfit.server.routes.page import page_paths, page_router
from snapfit.server.security.first_key import key_file
from snapfit.server.security.install import install_security
from snapfit.server.settings import Settings
from snapfit.server.stations import Stations
from snapfit.server.worker_spec import DEFAULT_PIPELINE

_DESCRIPTION = """\
Metres, radians, seconds; time stamps are integer microseconds of Unix time; quaternions are unit,
in the order x, y, z, w. Poses map a part's frame into the colour camera's: x right, y down,
z forward. `docs/conventions.md` in the repository tells all conventions on one page."""


def create_app(settings: Settings, pipeline: str = DEFAULT_PIPELINE) -> FastAPI:
    """The app; its stations open when it starts and close when it ends. See `with_front`, too.

    Args:
        settings: what is served.
        pipeline: "module:function" that opens source and tracker in the workers.
    """
    back = backing_for(settings.store, key_file(settings.security).parent)
    all_stations = Stations(list(settings.all_stations), Clock.started_now(), pipeline, back)

    @asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        try:
            all_stations.open()
            async with all_stations.watched():
                yield
        finally:
            all_stations.close()

    app = FastAPI(
        title="snapfit",
        summary="6D poses of parts on a workbench.",
        description=_DESCRIPTION,
        version=version("snapfit"),
        lifespan=lifespan,
        redirect_slashes=False,  # a path that is not documented is 404, not an answer of its own
        docs_url=None,  # FastAPI's page is fetched from the internet; ours is among the files
        redoc_url=None,
        openapi_url=None,  # ours is written once (`install_openapi`)
    )
    app.state.stations = all_stations
    app.state.metrics = Metrics(all_stations)
    install_problem_handlers(app)
    for router in (stations.router, assets.router, arlem.router, session.router):
        app.include_router(router, prefix="/v1")
    # Of one station: at /v1/stations/NAME/..., and short where there is only one.
    for router in (
        poses.router,
        assembly.router,
        commands.router,
        anchors.router,
        events.router,
        pictures.router,
    ):
        named = [Depends(named_station)]
        app.include_router(router, prefix="/v1/stations/{station}", dependencies=named)
        app.include_router(router, prefix="/v1")
    for prefix in ("/v1/stations/{station}", "/v1"):
        app.include_router(stream.router, prefix=prefix)
    app.include_router(system.router)
    page = page_router()
    app.include_router(page)
    install_security(app, settings.security, settings.host, page_paths(page))
    install_openapi(app)
    return app
