"""What stands before FastAPI: a fast lane in the connections; the clock of requests, the old port.

Around the app, and not among its middlewares: those run inside FastAPI's own layers, which take as
much time as a poll.
"""

from __future__ import annotations

from fastapi import FastAPI
from starlette.types import ASGIApp

from snapfit.server.fast_lane import FastLane
from snapfit.server.gbot_port import GbotPort
from snapfit.server.quick_protocol import QuickProtocol, protocol_with
from snapfit.server.request_clock import RequestClock


def with_front(app: FastAPI, gbot_port: int | None) -> ASGIApp:
    """The app as it is served.

    Args:
        app: made by `create_app`.
        gbot_port: on which only the old resource is served; None: there is no such port.
    """
    state = app.state
    # The outermost is the first to see a request.
    return RequestClock(
        GbotPort(app, port=gbot_port), clock=state.stations.clock, metrics=state.metrics
    )


def connections_of(app: FastAPI, gbot_port: int | None) -> type[QuickProtocol]:
    """The connections that it is served by; their fast lane answers ahead of it."""
    state = app.state
    return protocol_with(FastLane(state.stations, state.access, state.metrics, gbot_port))
