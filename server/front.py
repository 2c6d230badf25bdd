"""What stands before FastAPI: the clock of requests, the old port, the fast lane.

Around the app, and not among its middlewares: those run inside FastAPI's own layers, which take as
much time as a poll.
"""

from __future__ import annotations

from fastapi import FastAPI
from starlette.types import ASGIApp

from snapfit.server.fast_lane import FastLane
from snapfit.server.gbot_port import GbotPort
from snapfit.server.request_clock import RequestClock


def with_front(app: FastAPI, gbot_port: int | None) -> ASGIApp:
    """The app as it is served.

    Args:
        app: made by `create_app`.
        gbot_port: on which only the old resource is served; None: there is no such port.
    """
    state = app.state
    fast_lane = FastLane(app, stations=state.stations, access=state.access)
    # The outermost is the first to see a request.
    return RequestClock(
        GbotPort(fast_lane, port=gbot_port), clock=state.stations.clock, metrics=state.metrics
    )
